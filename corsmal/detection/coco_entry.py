"""One entry of a COCO results file: a detection with its class, score, box and mask."""

import math
from collections.abc import Container, Mapping
from typing import Any, NamedTuple

from corsmal.detection.coco_classes import CLASS_MAX, CLASS_MIN
from corsmal.detection.polygons import Outlines
from corsmal.detection.rle import Size, counts_from_rle, mask_box, numbers
from corsmal.errors import ArgumentError

Box = tuple[float, float, float, float]


class CocoEntry(NamedTuple):
    """What an entry says; ``box`` is (x_min, y_min, x_max, y_max) in pixels."""

    box: Box
    score: float
    label: int
    counts: bytes


def parse_entry(entry: Any, size: Size, *, whole: Container[bytes] = (), outlines: Outlines | None = None) -> CocoEntry:
    """Read one entry of a COCO results file.

    Args:
        entry: a mapping with ``category_id``, ``score``, ``segmentation`` and, unless it is to be taken from the
            mask, ``bbox`` (x, y, width, height).
        size: (H, W) of the image in pixels.
        whole: compressed run lengths that were checked before, from ``rle.whole_counts``.
        outlines: draws polygons, and keeps what is said about those of a file; default: of this entry only.

    Raises:
        ArgumentError: the entry cannot be used. The text says why without numbers that differ from entry to entry, so
            that equal problems can be counted.
    """
    if not isinstance(entry, Mapping):
        raise ArgumentError("not a mapping of keys to values")
    for key in ("category_id", "score"):
        if key not in entry:
            raise ArgumentError(f'the key "{key}" is missing')
    label, score = entry["category_id"], entry["score"]
    if isinstance(label, str):
        raise ArgumentError(f"the class {label[:40]!r} is none of COCO's")
    if type(label) is not int or not CLASS_MIN <= label <= CLASS_MAX:
        raise ArgumentError(f"unknown class, COCO's numbers are {CLASS_MIN} to {CLASS_MAX}")
    if type(score) not in (int, float) or not 0 <= score <= 1:
        raise ArgumentError("the score is no number from 0 to 1")
    counts = counts_from_segmentation(entry.get("segmentation"), size, whole=whole, outlines=outlines or Outlines(size))
    x, y, width, height = _box(entry, counts, size)
    return CocoEntry((x, y, x + width, y + height), float(score), label, counts)


def counts_from_segmentation(
    segmentation: Any, size: Size, *, whole: Container[bytes] = (), outlines: Outlines | None = None
) -> bytes:
    """Checked counts of a COCO ``segmentation``: polygons, plain or compressed run lengths.

    Args:
        segmentation: a list of polygons ``[x0, y0, x1, y1, ...]`` in pixels, or a mapping with ``size`` (H, W) and
            ``counts`` (a list of numbers, a string or bytes).
        size: (H, W) of the image.
        whole: compressed run lengths that were checked before, from ``rle.whole_counts``.
        outlines: as for ``parse_entry``.

    Raises:
        ArgumentError: it is none of these, or of another size.
    """
    if isinstance(segmentation, Mapping):
        return counts_from_rle(segmentation, size, whole=whole)
    if isinstance(segmentation, list) and segmentation:
        return (outlines or Outlines(size)).counts(segmentation)
    raise ArgumentError("the mask (segmentation) is missing or neither polygons nor run lengths")


def format_entry(entry: CocoEntry, *, image_id: int, size: Size) -> dict[str, Any]:
    """An entry of a COCO results file, the mask as compressed run lengths, ready for JSON."""
    x, y, x_max, y_max = entry.box
    return {
        "image_id": image_id,
        "category_id": entry.label,
        "bbox": [x, y, x_max - x, y_max - y],
        "score": entry.score,
        "segmentation": {"size": list(size), "counts": entry.counts.decode("ascii")},
    }


def _box(entry: Mapping[str, Any], counts: bytes, size: Size) -> Box:
    values = entry.get("bbox")
    if values is None:
        around_mask = mask_box(counts, size)
        if around_mask is None:
            raise ArgumentError("no box, and the mask is empty")
        return around_mask
    box = numbers(values).tolist()
    if len(box) != 4 or min(box[2:]) < 0 or not all(map(math.isfinite, (*box, box[0] + box[2], box[1] + box[3]))):
        raise ArgumentError("the box is not four finite numbers x, y, width, height")
    x, y, width, height = box
    return x, y, width, height
