"""Detecting in a recording, from coarse to fine, with what was found kept in the store."""

from collections.abc import Callable, Collection, Sequence

from corsmal.dataset import Recording
from corsmal.detection import Detector
from corsmal.errors import ArgumentError, FileError
from corsmal.parameters import METHOD_VIEWS, PAIRS
from corsmal.selection import select_best_frame
from corsmal.stages.detections import DetectionSet, load_detections
from corsmal.stages.inspection import InProcess, Inspection, Inspector, ViewWork
from corsmal.store import Store

COARSEST = 40
"""The first frames to be inspected are about so far apart: results are spread over the video from the start."""


def detect_recording(
    recording: Recording,
    detector: Detector | Inspector,
    *,
    store: Store,
    every: int = 1,
    frames: Sequence[int] | None = None,
    progress: Callable[[int, int], None] | None = None,
    kept: Callable[[], None] | None = None,
    cancelled: Callable[[], bool] | None = None,
) -> None:
    """Detect in the method's views and keep the results; frames that were inspected before are not inspected again.

    The frames are gone through from coarse to fine: every fortieth or so, then those between. With ``every`` above 1
    that ends early, and only the frames beside each pair's best one so far are inspected more closely.

    Args:
        recording: views that lack a video, or have a detections file, are skipped.
        detector: such as ``MaskRCNNDetector``, or an inspector that has it elsewhere.
        store: where the results are kept.
        every: step of the search for the best frame; 1 inspects all frames.
        frames: inspect these, and search nothing.
        progress: called with the numbers of frames done and wanted, over all views.
        kept: called when more results can be read from the store.
        cancelled: checked between batches; true stops the work and keeps what was done.

    Raises:
        ArgumentError: ``every`` is not positive.
        FileError: a video cannot be opened, raised after the other views are done; or the results cannot be written.
        CorsmalError: an inspector's processes failed.
    """
    if every < 1:
        raise ArgumentError(f"every must be at least 1, got {every}")
    inspector = detector if callable(detector) else InProcess(detector)
    works, broken = _openable(recording, inspector.digest, store)
    search = Inspection(works, inspector, progress=progress, kept=kept, cancelled=cancelled)
    if frames is not None:
        search.begin(len(frames) * len(works))
        search.inspect(frames, counted=len(frames))
    else:
        _search(search, every, lambda: load_detections(recording, store=store))
    search.end()
    if broken is not None:
        raise broken


def search_frames(frame_counts: Collection[int], every: int) -> int:
    """How many frames a search inspects at most, given the number of frames of the views."""
    return sum(len(range(0, count, every)) + _levels(every) * 2 * len(PAIRS) for count in frame_counts)


def _search(search: Inspection, every: int, detections: Callable[[], DetectionSet]) -> None:
    """Inspect from coarse to fine, then beside the best frames so far."""
    counts = [work.frame_count for work in search.works]
    search.begin(search_frames(counts, every))
    seen: set[int] = set()
    passes = []
    for step in _strides(every):
        passes.append(set(range(0, max(counts, default=0), step)) - seen)
        seen |= passes[-1]
    search.inspect(*passes)
    for level in range(_levels(every)):
        if search.is_stopped:
            return
        frames = set(_beside_the_best(detections(), seen, -(-every // 2 ** (level + 1))))
        search.inspect(frames, counted=2 * len(PAIRS))
        seen |= frames


def _openable(recording: Recording, detector_digest: str, store: Store) -> tuple[list[ViewWork], FileError | None]:
    """The views to detect in, and the error of one whose video cannot be opened."""
    works, broken = [], None
    for name in METHOD_VIEWS:
        view = recording.views.get(name)
        if view is None or view.detections_path is not None:
            continue
        try:
            works.append(ViewWork(view, detector_digest, store, clock=recording.clock()))
        except FileError as error:
            broken = error
    return works, broken


def _levels(every: int) -> int:
    """How many times a step is halved until it is 1."""
    return (every - 1).bit_length()


def _strides(every: int) -> list[int]:
    """Steps between frames, each half of the one before, from about ``COARSEST`` down to ``every``."""
    doublings = max(0, (COARSEST // every).bit_length() - 1)
    return [every * 2**power for power in range(doublings, -1, -1)]


def _beside_the_best(detections: DetectionSet, seen: set[int], step: int) -> list[int]:
    """The frames a step before and after the best frame of each pair.

    Only frames of this search count, not others in the store: a repeated search then takes the same steps and
    finds them kept.
    """
    views = {name: {frame: view[frame] for frame in seen.intersection(view)} for name, view in detections.views.items()}
    found = [select_best_frame(views, pair=pair).frame for pair in PAIRS]
    return sorted({frame + side for frame in found if frame is not None for side in (-step, step)})
