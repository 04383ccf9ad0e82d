"""Entries with other keys, outlines or boxes than COCO's, put into COCO's form before frames and classes are read."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any

from corsmal.detection.coco_entry import Box, CocoEntry
from corsmal.detection.coco_results import Results
from corsmal.detection.rle import Size, mask_box
from corsmal.errors import ArgumentError

LISTS = ("annotations", "results", "predictions", "detections")
"""Under which of these keys a dictionary has its entries."""

PERCENT, PERCENT_MIN = 100.0, 10.0
"""The largest score in percent, and one that most reach where scores are in percent."""

ROUNDED_UP = 1.001
"""Scores up to here are 1: single precision rounds."""

BOXES_COMPARED = 200
AGREEING = 0.5
"""Intersection over union from which on a box and the box around its mask agree."""


def entries_of(content: object) -> Results:
    """The entries of a file's content: of a list, of one list per frame, or of a dictionary that holds a list.

    Raises:
        ArgumentError: it is none of these.
    """
    found = content
    if isinstance(content, dict):
        found = next((content[key] for key in LISTS if isinstance(content.get(key), list)), None)
    if not isinstance(found, list):
        lacks = " without 'annotations'" if isinstance(content, dict) else ""
        raise ArgumentError(f"is not a list of COCO results entries but a JSON {type(content).__name__}{lacks}")
    if not found or not all(isinstance(each, list) for each in found):
        return Results(list(found))
    flat = [{**entry, "image_id": place} for place, each in enumerate(found) for entry in each if _is_entry(entry)]
    results = Results(flat)
    results.note(f"it has {len(found)} lists, each of which was read as the detections of one frame, in order")
    return results


def rename_keys(results: Results) -> None:
    """Give entries with Ultralytics' own keys COCO's, and let the name of a class stand where its number is missing."""
    renamed = 0
    for place, entry in results.mappings():
        if "category_id" in entry:
            continue
        if "confidence" in entry and ("class" in entry or "name" in entry):
            results.entries[place] = _from_ultralytics(entry)
            renamed += 1
        elif isinstance(entry.get("category_name"), str):
            results.entries[place] = {**entry, "category_id": entry["category_name"]}
    if renamed:
        results.note("entries have Ultralytics' keys (name, confidence, box, segments), which were read as COCO's")


def flatten_outlines(results: Results, size: Size) -> None:
    """Make polygons of pairs of numbers flat, and those that are shares of the image's size pixels."""
    paired = 0
    for place, entry in results.mappings():
        polygons = entry.get("segmentation")
        if isinstance(polygons, list) and any(map(_is_paired, polygons)):
            flat = [[value for point in part for value in point] if _is_paired(part) else part for part in polygons]
            results.entries[place] = {**entry, "segmentation": flat}
            paired += 1
    if paired:
        results.note("points of outlines are written as pairs")
    values = [value for polygon in _polygons(results) for value in polygon if type(value) in (int, float)]
    if not values or min(values) < 0 or not 0 < max(values) <= 1:
        return
    results.is_relative = True
    results.note("outlines are written as shares of the image's width and height")
    for place, entry in results.mappings():
        results.entries[place] = scaled(entry, (float(size[1]), float(size[0])), is_relative=True)


def read_scores(results: Results) -> None:
    """Make scores numbers from 0 to 1; 1 where a file of ground truth has none at all."""
    entries = [entry for _, entry in results.mappings()]
    scores = [number for entry in entries if (number := _score(entry.get("score"))) is not None]
    if entries and all(entry.get("score") is None for entry in entries):
        results.note("there are no scores: the file was read as ground truth, each with a score of 1")
        _each_score(results, lambda _score: 1.0)
        return
    if any(isinstance(score := entry.get("score"), str) and _score(score) is not None for entry in entries):
        results.note("scores are written as text, and were read as numbers")
    usual = sorted(scores)[len(scores) // 2] if scores else 0.0
    is_percent = usual >= PERCENT_MIN and min(scores) >= 0 and max(scores) <= PERCENT
    if is_percent:
        results.note("scores are written in percent")
    _each_score(results, lambda score: _of_one(score, PERCENT if is_percent else 1.0))


def corner_boxes(by_frame: Mapping[int, Sequence[CocoEntry]], size: Size) -> bool:
    """Whether the third and fourth number of boxes are the other corner and not width and height, as the masks say."""
    compared = corners = 0
    for entry in (entry for entries in by_frame.values() for entry in entries):
        around = mask_box(entry.counts, size)
        if around is None:
            continue
        x, y, width, height = around
        tight = (x, y, x + width, y + height)
        compared += 1
        corners += _overlap(entry.box, tight) < AGREEING <= _overlap(with_corners(entry).box, tight)
        if compared == BOXES_COMPARED:
            break
    return 2 * corners > compared


def with_corners(entry: CocoEntry) -> CocoEntry:
    """An entry whose width and height were those of a corner."""
    x, y, x_max, y_max = entry.box
    return entry._replace(box=(x, y, max(x, x_max - x), max(y, y_max - y)))


def scaled(entry: Mapping[str, Any], scale: tuple[float, float], *, is_relative: bool = False) -> dict[str, Any]:
    """The entry with its polygons and its box scaled; run lengths are for one size and stay.

    Args:
        entry: the entry.
        scale: (x, y).
        is_relative: whether a box is scaled only where it is a share of the image, too.
    """
    result = dict(entry)
    polygons, box = entry.get("segmentation"), entry.get("bbox")
    if isinstance(polygons, list):
        result["segmentation"] = [_times(part, scale) if isinstance(part, list) else part for part in polygons]
    if isinstance(box, list) and not (is_relative and any(type(each) in (int, float) and each > 1 for each in box)):
        result["bbox"] = _times(box, scale)
    return result


def _is_entry(entry: object) -> bool:
    return isinstance(entry, dict)


def _from_ultralytics(entry: Mapping[str, Any]) -> dict[str, Any]:
    found: dict[str, Any] = {
        "image_id": next((entry[key] for key in ("image_id", "frame", "frame_id") if key in entry), None),
        "category_id": entry["name"] if isinstance(entry.get("name"), str) else entry.get("class"),
        "score": entry["confidence"],
    }
    segments, box = entry.get("segments"), entry.get("box")
    if isinstance(segments, dict) and isinstance(segments.get("x"), list) and isinstance(segments.get("y"), list):
        found["segmentation"] = [
            [value for point in zip(segments["x"], segments["y"], strict=False) for value in point]
        ]
    corners: list[Any] = [box.get(key) for key in ("x1", "y1", "x2", "y2")] if isinstance(box, dict) else []
    if corners and all(type(value) in (int, float) for value in corners):
        found["bbox"] = [corners[0], corners[1], corners[2] - corners[0], corners[3] - corners[1]]
    return found


def _is_paired(polygon: object) -> bool:
    return (
        isinstance(polygon, list)
        and bool(polygon)
        and all(isinstance(each, list) and len(each) == 2 for each in polygon)
    )


def _polygons(results: Results) -> Iterator[list[Any]]:
    for _, entry in results.mappings():
        polygons = entry.get("segmentation")
        yield from (each for each in polygons if isinstance(each, list)) if isinstance(polygons, list) else ()


def _score(value: object) -> float | None:
    """A score as a number, however it is written; None for anything else, a number beyond all floats too."""
    try:
        if isinstance(value, str):
            return float(value.strip().replace(",", "."))
        return float(value) if isinstance(value, int | float) and not isinstance(value, bool) else None
    except (ValueError, OverflowError):
        return None


def _of_one(value: object, whole: float) -> object:
    number = _score(value)
    if number is None:
        return value
    share = number / whole
    return 1.0 if 1 < share <= ROUNDED_UP else share


def _each_score(results: Results, change: Callable[[object], object]) -> None:
    for place, entry in results.mappings():
        score = change(entry.get("score"))
        if score is not entry.get("score"):
            results.entries[place] = {**entry, "score": score}


def _overlap(box: Box, other: Box) -> float:
    """Intersection over union of two boxes."""
    width = min(box[2], other[2]) - max(box[0], other[0])
    height = min(box[3], other[3]) - max(box[1], other[1])
    if width <= 0 or height <= 0:
        return 0.0
    areas = [(each[2] - each[0]) * (each[3] - each[1]) for each in (box, other)]
    return width * height / (sum(areas) - width * height)


def _times(values: Sequence[Any], scale: tuple[float, float]) -> list[Any]:
    return [
        value * scale[place % 2] if type(value) in (int, float) and abs(value) < 1e9 else value
        for place, value in enumerate(values)
    ]
