"""COCO results files: a JSON list of detections, ``image_id`` being the number of the frame."""

import json
from collections import Counter, defaultdict
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from corsmal.detection.coco_entry import CocoEntry, parse_entry
from corsmal.detection.record import Detections
from corsmal.detection.rle import Size, checked_size, whole_counts
from corsmal.detection.view import ViewDetections
from corsmal.errors import ArgumentError, FileError


def read_coco_results(path: str | Path, *, size: Size, frame_count: int | None = None) -> ViewDetections:
    """Read one view's detections from a COCO results file.

    Entries that cannot be used are skipped, counted and reported in ``problems``.

    Args:
        path: the file; masks may be polygons, plain or compressed run lengths; a missing box is taken from the mask.
        size: (H, W) of the view's images in pixels.
        frame_count: frames of the video: each counts as inspected. Without it only frames with an entry do.

    Returns:
        The detections of every inspected frame, in the file's order.

    Raises:
        FileError: the file is absent, no JSON or no list, or it has entries and none can be used.
    """
    path, size = Path(path), checked_size(size)
    entries = _read_list(path)
    by_frame: dict[int, list[CocoEntry]] = defaultdict(list)
    skipped: Counter[str] = Counter()
    whole = whole_counts(_compressed(entries), size)
    for entry in entries:
        try:
            by_frame[_frame(entry, frame_count)].append(parse_entry(entry, size, whole=whole))
        except ArgumentError as error:
            skipped[str(error)] += 1
    problems = tuple(f"{count} {_entries(count)} skipped: {reason}" for reason, count in skipped.items())
    if entries and skipped.total() == len(entries):
        raise FileError(path, f"no detection in it can be used ({'; '.join(problems)})")
    frames = {frame for frame in by_frame if by_frame[frame]} if frame_count is None else range(frame_count)
    return ViewDetections(
        {frame: Detections.from_entries(by_frame.get(frame, []), size=size) for frame in frames},
        size=size,
        source=f"file {path.parent.name}/{path.name}",
        problems=problems,
    )


def write_coco_results(view_detections: ViewDetections, path: str | Path) -> None:
    """Write one view's detections as a COCO results file, masks as compressed run lengths.

    Such a file lists detections: that a frame was inspected and nothing found is not kept in it.

    Raises:
        FileError: the file cannot be written.
    """
    entries = [entry for frame, detections in view_detections.items() for entry in detections.to_coco(frame)]
    try:
        Path(path).write_text(json.dumps(entries), encoding="utf-8")
    except OSError as error:
        raise FileError(path, f"cannot be written ({error.strerror}); choose another folder") from error


def _read_list(path: Path) -> Sequence[Any]:
    try:
        entries = json.loads(path.read_bytes())
    except OSError as error:
        raise FileError(path, f"cannot be read ({error.strerror})") from error
    except (ValueError, RecursionError) as error:
        raise FileError(path, f"is not JSON ({error}); expected a list of COCO results entries") from error
    if not isinstance(entries, list):
        raise FileError(path, f"is not a list of COCO results entries but a JSON {type(entries).__name__}")
    return entries


def _compressed(entries: Sequence[Any]) -> Iterator[bytes]:
    """All compressed run lengths, whatever the entries are."""
    for entry in entries:
        segmentation = entry.get("segmentation") if isinstance(entry, dict) else None
        counts = segmentation.get("counts") if isinstance(segmentation, dict) else None
        if isinstance(counts, str) and counts.isascii():
            yield counts.encode("ascii")


def _frame(entry: Any, frame_count: int | None) -> int:
    frame = entry.get("image_id") if isinstance(entry, dict) else 0
    if frame is None:
        raise ArgumentError('the key "image_id" is missing')
    if type(frame) is not int or frame < 0 or (frame_count is not None and frame >= frame_count):
        expected = "a number from 0" if frame_count is None else f"from 0 to {frame_count - 1}"
        raise ArgumentError(f"frame (image_id) out of range, expected {expected}")
    return frame


def _entries(count: int) -> str:
    return "entry" if count == 1 else "entries"
