"""Masks as COCO run lengths: column by column, runs of background and mask in turn, compressed to a short string.

A mask is held as its ``counts``, the compressed run lengths. pycocotools compresses and measures, but trusts what it
is given: run lengths that do not add up read foreign memory. Counts from outside therefore pass ``run_lengths`` first.
"""

from collections.abc import Container, Iterable, Mapping, Sequence
from itertools import compress, groupby
from operator import itemgetter
from typing import Any, TypedDict

import cv2
import numpy as np
import pycocotools.mask as coco_mask
from numpy.typing import NDArray

from corsmal.errors import ArgumentError

Size = tuple[int, int]
"""(H, W) of an image in pixels."""

FIRST_CHARACTER = 48
CONTINUES, NEGATIVE, VALUE = 0x20, 0x10, 0x1F
CHARACTERS_MAX = 6
"""Of one run length: 30 bits, more than the pixels of any image."""

BROKEN = "the mask's run lengths (RLE) are broken"

CHARACTERS_AT_ONCE = 32_768
"""What ``whole_counts`` parses together stays in the processor's cache."""


def checked_size(size: Sequence[int]) -> Size:
    """The size (H, W) as two Python integers.

    Raises:
        ArgumentError: it is not two positive numbers.
    """
    if len(size) != 2 or not all(1 <= side < np.inf for side in size):
        raise ArgumentError(f"size must be two positive numbers of pixels (H, W), got {tuple(size)}")
    return int(size[0]), int(size[1])


class Rle(TypedDict):
    """A compressed mask as pycocotools takes it."""

    size: list[int]
    counts: bytes


def as_rle(counts: bytes, size: Size) -> Rle:
    """Counts in the form that pycocotools and COCO files use."""
    return {"size": [size[0], size[1]], "counts": counts}


def encode_masks(masks: NDArray[np.bool_]) -> tuple[bytes, ...]:
    """Compress (n, H, W) bool masks to n counts."""
    columns_first = np.asfortranarray(np.moveaxis(masks, 0, 2).astype(np.uint8))
    return tuple(rle["counts"] for rle in coco_mask.encode(columns_first))


def decode_mask(counts: bytes, size: Size) -> NDArray[np.bool_]:
    """Expand counts to an (H, W) bool mask.

    Raises:
        ArgumentError: as ``run_lengths``.
    """
    runs = run_lengths(counts, size)
    is_mask = np.arange(len(runs)) % 2 == 1
    columns = np.repeat(is_mask, runs).reshape(size[1], size[0])  # (W, H)
    return cv2.transpose(columns.view(np.uint8)).view(np.bool_)  # several times as fast as NumPy's copy


def mask_areas(counts: Sequence[bytes], size: Size) -> NDArray[np.int64]:
    """Pixels of each mask, (n,), from checked counts, nothing decoded."""
    return np.array(coco_mask.area([as_rle(item, size) for item in counts]), dtype=np.int64)


def rightmost_columns(counts: Iterable[bytes], size: Size) -> NDArray[np.int64]:
    """(n,) the column of each mask's rightmost pixel, −1 of an empty mask; nothing is decoded."""
    boxes = [coco_mask.toBbox(as_rle(item, size)) for item in counts]
    return np.array([round(x + width) - 1 for x, _, width, _ in boxes], dtype=np.int64)


def mask_box(counts: bytes, size: Size) -> tuple[float, float, float, float] | None:
    """The box (x, y, width, height) around a mask's pixels from checked counts; None where the mask is empty."""
    rle = as_rle(counts, size)
    if not coco_mask.area(rle):
        return None
    x, y, width, height = map(float, coco_mask.toBbox(rle))
    return x, y, width, height


def run_lengths(counts: bytes, size: Size) -> NDArray[np.int32]:
    """The plain run lengths that counts stand for: background, mask, background, ...

    Raises:
        ArgumentError: the counts hold a character that cannot be, end in the middle of a number, hold a negative run,
            or do not add up to H x W pixels.
    """
    if counts:
        runs, is_whole = _parsed([counts], size[0] * size[1])
        if is_whole[0]:
            return runs
    raise ArgumentError(BROKEN)


def whole_counts(counts: Iterable[bytes], size: Size) -> set[bytes]:
    """Those of many counts that ``run_lengths`` finds no fault with, found many times faster than one by one.

    A file of detections is read in half of the time.
    """
    items = list(filter(None, counts))
    part_of = np.cumsum([len(item) for item in items], dtype=np.int64) // CHARACTERS_AT_ONCE
    found: set[bytes] = set()
    for _, members in groupby(zip(part_of.tolist(), items, strict=True), key=itemgetter(0)):
        part = [item for _, item in members]
        found.update(compress(part, _parsed(part, size[0] * size[1])[1]))
    return found


def _parsed(counts: Sequence[bytes], pixels: int) -> tuple[NDArray[np.int32], NDArray[np.bool_]]:
    """The runs of counts, of which none is empty, one behind the other, and which counts are whole.

    Those that are broken leave runs without a meaning.
    """
    characters = np.frombuffer(b"".join(counts), dtype=np.uint8) - np.uint8(FIRST_CHARACTER)  # below it: over 200
    after = np.cumsum([len(item) for item in counts])
    is_last = (characters & CONTINUES) == 0
    is_whole = is_last[after - 1]
    is_last[after - 1] = True
    ends = np.flatnonzero(is_last)
    first = np.searchsorted(ends, np.append(0, after[:-1]))  # each mask's first run
    runs = _numbers(characters, ends)
    _undo_differences(runs, first)
    is_right = (runs >= 0) & (runs <= pixels)  # each by itself: sums of many could overflow
    is_right &= np.diff(ends, prepend=-1) <= CHARACTERS_MAX
    if not is_right.all():
        is_whole &= np.logical_and.reduceat(is_right, first)
    if characters.max() > (CONTINUES | VALUE):
        is_whole &= np.maximum.reduceat(characters, np.append(0, after[:-1])) <= (CONTINUES | VALUE)
    return runs, is_whole & (np.add.reduceat(runs, first, dtype=np.int64) == pixels)


def _numbers(characters: NDArray[np.uint8], ends: NDArray[np.int64]) -> NDArray[np.int32]:
    """The numbers whose last characters are at ``ends``: five bits a character, the lowest first, with a sign."""
    starts = np.append(0, ends[:-1] + 1)
    lengths = np.minimum(ends - starts + 1, CHARACTERS_MAX).astype(np.int32)
    values = (characters & VALUE).astype(np.int32)
    found = values[starts]
    longer = np.flatnonzero(lengths > 1)
    for place in range(1, CHARACTERS_MAX):
        if not len(longer):
            break
        found[longer] |= values[starts[longer] + place] << 5 * place
        longer = longer[lengths[longer] > place + 1]
    beyond = np.int32(32) - 5 * lengths
    return (found << beyond) >> beyond


def _undo_differences(runs: NDArray[np.int32], first: NDArray[np.int64]) -> None:
    """From a mask's fourth run on, each is written as its difference to the run two before it."""
    of_first = runs[first]
    runs[first] = 0
    for odd in (0, 1):
        every_second = runs[odd::2]
        sums = np.cumsum(every_second, dtype=np.int32)
        begins = (first + 1 - odd) // 2  # each mask's first among these
        before = np.append(np.int32(0), sums)[begins]
        every_second[:] = sums - np.repeat(before, np.diff(np.append(begins, len(sums))))
    runs[first] = of_first


def counts_from_rle(rle: Mapping[str, Any], size: Size, *, whole: Container[bytes] = ()) -> bytes:
    """Checked counts of run lengths, plain (a list) or compressed (a string or bytes).

    Raises:
        ArgumentError: they are broken, or of another size.
    """
    found = rle.get("size")
    if not isinstance(found, list | tuple) or len(found) != 2 or not all(type(side) is int for side in found):
        raise ArgumentError("the mask has no size [height, width]")
    if tuple(found) != size:
        raise ArgumentError(f"mask size {found[1]}x{found[0]}, expected {size[1]}x{size[0]}")
    counts = rle.get("counts")
    if isinstance(counts, list):
        if not all(type(run) is int and run >= 0 for run in counts) or sum(counts) != size[0] * size[1]:
            raise ArgumentError(BROKEN)
        return coco_mask.frPyObjects({"size": list(size), "counts": counts}, *size)["counts"]
    if isinstance(counts, str) and counts.isascii():
        counts = counts.encode("ascii")
    if not isinstance(counts, bytes):
        raise ArgumentError(BROKEN)
    if counts not in whole:
        run_lengths(counts, size)
    return counts


def numbers(values: Any) -> NDArray[np.float64]:
    """A flat list of numbers as a float array; empty where it is anything else."""
    if not isinstance(values, list | tuple) or not all(type(value) in (int, float) for value in values):
        return np.empty(0)
    try:
        return np.array(values, dtype=np.float64)
    except OverflowError:
        return np.empty(0)
