"""What is marked on the time line."""

from typing import Any

from corsmal.selection import BestFrame


def marks(best: BestFrame, *, crop_s: tuple[float, float] | None, fps: float, frames: int) -> dict[str, Any]:
    """The marks of a recording, in frames.

    Args:
        best: the best frame of a pair, and the frames that were inspected in both of its views.
        crop_s: start and end of the filling network's input, s.
        fps: frames per second; 0: unknown, and the crop is not marked.
        frames: how many frames there are; what lies beyond is left out.

    Returns:
        ``best``: a frame or None; ``best_name``: what the star stands for; ``inspected``: frames, ascending; ``crop``:
        start and end, which may lie between frames, or None.
    """
    crop = None
    if crop_s is not None and fps > 0:
        start, end = (min(moment_s * fps, frames - 1.0) for moment_s in crop_s)
        crop = [start, end] if start < end else None
    return {
        "best": best.frame if best.frame is not None and best.frame < frames else None,
        "best_name": "Fallback" if best.is_fallback else "Best fit" if best.is_by_fit else "Best",
        "inspected": [score.frame for score in best.scores if score.frame < frames],
        "crop": crop,
    }
