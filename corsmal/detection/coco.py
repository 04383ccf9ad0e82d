"""COCO files: a list of detections, ``image_id`` being the number of the frame, or what other programs write."""

import json
from collections import Counter, defaultdict
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from corsmal.detection.coco_classes import class_text, no_container_hint
from corsmal.detection.coco_entry import CocoEntry, parse_entry
from corsmal.detection.coco_foreign import corner_boxes, with_corners
from corsmal.detection.coco_forms import as_results
from corsmal.detection.coco_results import Results
from corsmal.detection.polygons import Outlines
from corsmal.detection.record import Detections
from corsmal.detection.rle import Size, checked_size, whole_counts
from corsmal.detection.view import ViewDetections
from corsmal.errors import ArgumentError, FileError
from corsmal.files import writing
from corsmal.notes import Note
from corsmal.parameters import CONTAINER_CLASSES

BYTES_MAX = 200_000_000
SIGNS_MAX = {b"{": 1_000_000, b"[": 5_000_000, b",": 20_000_000}
"""How many JSON objects, lists and values a file may have: reading them takes the memory. A detection has one or two
objects and a list for its box and each polygon."""

FRAME_ENTRIES_MAX = 1_000
"""Detections in one frame that are read; detectors report a hundred at most."""

FLAG = "detections-incomplete"


def read_coco_results(path: str | Path, *, size: Size, frame_count: int | None = None) -> ViewDetections:
    """Read one view's detections from a COCO results file.

    Entries that cannot be used are skipped, counted and reported in ``problems``, as is how a file was read that is
    not in this form: exports of CVAT, Label Studio, FiftyOne, Roboflow, Detectron2 and Ultralytics are, see
    ``coco_forms``.

    Args:
        path: the file; masks may be polygons, plain or compressed run lengths; a missing box is taken from the mask.
        size: (H, W) of the view's images in pixels.
        frame_count: frames of the video: each counts as inspected. Without it only frames with an entry do.

    Returns:
        The detections of every inspected frame, in the file's order.

    Raises:
        FileError: the file is absent, too large, no JSON or of another form, or it has entries and none can be used.
    """
    path, size = Path(path), checked_size(size)
    results = _read(path, size, frame_count)
    by_frame, skipped, outlines = _parsed(results.entries, size, frame_count)
    if corner_boxes(by_frame, size):
        results.note("boxes were written as two corners, as the masks say")
        by_frame = {frame: [with_corners(entry) for entry in entries] for frame, entries in by_frame.items()}
    problems = [f"{count} {_entries(count)} skipped: {reason}" for reason, count in skipped.items()]
    if results.entries and skipped.total() == len(results.entries):
        raise FileError(path, f"no detection in it can be used ({'; '.join(problems)})")
    problems += [f"{count} of the polygons left out: {reason}" for reason, count in outlines.dropped.items()]
    problems += _without_container(by_frame)
    frames = {frame for frame in by_frame if by_frame[frame]} if frame_count is None else range(frame_count)
    return ViewDetections(
        {frame: Detections.from_entries(by_frame.get(frame, []), size=size) for frame in frames},
        size=size,
        source=f"file {path.parent.name}/{path.name}",
        problems=(*results.notes, *(Note(problem, flag=FLAG) for problem in problems)),
    )


def write_coco_results(view_detections: ViewDetections, path: str | Path) -> None:
    """Write one view's detections as a COCO results file, masks as compressed run lengths.

    Such a file lists detections: that a frame was inspected and nothing found is not kept in it.

    Raises:
        FileError: the file cannot be written.
    """
    entries = [entry for frame, detections in view_detections.items() for entry in detections.to_coco(frame)]
    with writing(Path(path), advice="choose another folder") as part:
        part.write_text(json.dumps(entries), encoding="utf-8")


def _read(path: Path, size: Size, frame_count: int | None) -> Results:
    try:
        with path.open("rb") as file:
            text = file.read(BYTES_MAX + 1)
    except OSError as error:
        raise FileError(path, f"cannot be read ({error.strerror})") from error
    if len(text) > BYTES_MAX or any(text.count(sign) > most for sign, most in SIGNS_MAX.items()):
        limits = f"{BYTES_MAX // 10**6} MB, {SIGNS_MAX[b'{']} objects and {SIGNS_MAX[b',']} values"
        raise FileError(path, f"is larger than {limits}, too large for the detections of one view; it was not read")
    try:
        return as_results(json.loads(text), size=size, frame_count=frame_count)
    except ArgumentError as error:
        raise FileError(path, str(error)) from error
    except (ValueError, RecursionError) as error:
        raise FileError(path, f"is not JSON ({error}); expected a list of COCO results entries") from error


def _parsed(
    entries: Sequence[Any], size: Size, frame_count: int | None
) -> tuple[dict[int, list[CocoEntry]], Counter[str], Outlines]:
    """The entries by frame, how many were skipped by the reason, and what drew their polygons."""
    by_frame: dict[int, list[CocoEntry]] = defaultdict(list)
    skipped: Counter[str] = Counter()
    whole, outlines = whole_counts(_compressed(entries), size), Outlines(size)
    for entry in entries:
        try:
            frame = _frame(entry, frame_count)
            if len(by_frame[frame]) >= FRAME_ENTRIES_MAX:
                raise ArgumentError(f"a frame has more than {FRAME_ENTRIES_MAX} detections, the first were read")
            by_frame[frame].append(parse_entry(entry, size, whole=whole, outlines=outlines))
        except ArgumentError as error:
            skipped[str(error)] += 1
    return by_frame, skipped, outlines


def _without_container(by_frame: dict[int, list[CocoEntry]]) -> list[str]:
    """That a file has entries, none of them of a container's class."""
    counts = Counter(entry.label for entries in by_frame.values() for entry in entries)
    if not counts or CONTAINER_CLASSES.keys() & counts:
        return []
    held = ", ".join(f"{class_text(label)} {count} times" for label, count in counts.most_common(5))
    wanted = ", ".join(map(class_text, CONTAINER_CLASSES))
    return [f"no class in it is a container ({wanted}): it holds class {held}{no_container_hint(set(counts))}"]


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
    if type(frame) is not int:
        raise ArgumentError(f"the frame (image_id) is {str(frame)[:40]!r}, expected a whole number")
    if frame < 0 or (frame_count is not None and frame >= frame_count):
        expected = "a number from 0" if frame_count is None else f"from 0 to {frame_count - 1}"
        raise ArgumentError(f"frame (image_id) out of range, expected {expected}")
    return frame


def _entries(count: int) -> str:
    return "entry" if count == 1 else "entries"
