"""The record of one frame's detections."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from corsmal.detection.coco_classes import CLASS_MAX, CLASS_MIN
from corsmal.detection.coco_entry import CocoEntry, format_entry, parse_entry
from corsmal.detection.rle import Size, checked_size, decode_mask, encode_masks, mask_areas
from corsmal.errors import ArgumentError


@dataclass(frozen=True, init=False, eq=False, repr=False)
class Detections:
    """What was detected in one frame of one view; n may be 0.

    Masks are kept as COCO run lengths, so that a whole video's detections fit in memory: ``masks`` and ``mask``
    decode on each access, ``mask_areas`` decodes nothing. ``detections[indices]`` selects by an array of integers or
    bools or by a slice.

    Args:
        boxes: (n, 4) x_min, y_min, x_max, y_max, pixels; a box may leave the image.
        scores: (n,) from 0 to 1.
        labels: (n,) integers, COCO category numbers from 1 to 90.
        masks: (n, H, W) bool; (0, H, W) where nothing was detected, to carry the image's size.

    Raises:
        ArgumentError: a shape, type or range is wrong.

    Example:
        >>> mask = np.zeros((1, 720, 1280), dtype=bool)
        >>> Detections(boxes=[[10, 20, 30, 60]], scores=[0.9], labels=[47], masks=mask)
        Detections(n=1, size=(720, 1280))
    """

    boxes: NDArray[np.float64]
    scores: NDArray[np.float64]
    labels: NDArray[np.int64]
    counts: tuple[bytes, ...]
    size: Size

    def __init__(self, boxes: ArrayLike, scores: ArrayLike, labels: ArrayLike, masks: ArrayLike) -> None:
        masks = np.asarray(masks)
        if masks.ndim != 3 or masks.dtype != np.bool_:
            raise ArgumentError(f"masks must be (n, H, W) bool, got shape {masks.shape} of {masks.dtype}")
        size = checked_size(masks.shape[1:])
        self._set(boxes, scores, labels, encode_masks(masks), size)

    @classmethod
    def from_counts(
        cls, boxes: ArrayLike, scores: ArrayLike, labels: ArrayLike, counts: Sequence[bytes], *, size: Size
    ) -> "Detections":
        """Detections in images of ``size`` (H, W) whose masks are compressed run lengths that were checked before.

        Raises:
            ArgumentError: as in the class.
        """
        record = cls.__new__(cls)
        record._set(boxes, scores, labels, tuple(counts), checked_size(size))
        return record

    @classmethod
    def from_coco(cls, entries: Sequence[Mapping[str, Any]], *, size: Size) -> "Detections":
        """Detections in an image of ``size`` (H, W) from one frame's entries of a COCO results file.

        Raises:
            ArgumentError: an entry cannot be used; ``read_coco_results`` skips such entries instead.
        """
        parsed = []
        for index, entry in enumerate(entries):
            try:
                parsed.append(parse_entry(entry, checked_size(size)))
            except ArgumentError as error:
                raise ArgumentError(f"entries[{index}]: {error}") from error
        return cls.from_entries(parsed, size=size)

    @classmethod
    def from_entries(cls, entries: Sequence[CocoEntry], *, size: Size) -> "Detections":
        """Detections from entries that were parsed, hence checked, before."""
        boxes, scores, labels, counts = zip(*entries, strict=True) if entries else ((), (), (), ())
        return cls.from_counts(boxes, scores, labels, counts, size=size)

    def to_coco(self, image_id: int) -> list[dict[str, Any]]:
        """Entries of a COCO results file, masks as compressed run lengths, ``image_id`` the number of the frame."""
        columns = zip(self.boxes.tolist(), self.scores.tolist(), self.labels.tolist(), self.counts, strict=True)
        return [format_entry(CocoEntry(*row), image_id=image_id, size=self.size) for row in columns]

    @property
    def masks(self) -> NDArray[np.bool_]:
        """(n, H, W) bool, decoded on each access: keep it in a variable when it is used twice."""
        masks = np.empty((len(self), *self.size), dtype=np.bool_)
        for index in range(len(self)):
            masks[index] = self.mask(index)
        return masks

    def mask(self, index: int) -> NDArray[np.bool_]:
        """Decode one detection's (H, W) bool mask."""
        if not -len(self) <= index < len(self):
            raise ArgumentError(f"index must name one of {len(self)} detections, got {index}")
        return decode_mask(self.counts[index], self.size)

    @property
    def mask_areas(self) -> NDArray[np.int64]:
        """(n,) pixels of each mask."""
        return mask_areas(self.counts, self.size)

    def __len__(self) -> int:
        return len(self.scores)

    def __getitem__(self, index: ArrayLike | slice) -> "Detections":
        if isinstance(index, slice):
            return self._part(index, self.counts[index])
        index = np.asarray(index)
        if index.ndim != 1 or (index.size and index.dtype.kind not in "iub"):
            raise ArgumentError("index must be a slice or a one-dimensional array of integers or bools")
        try:
            chosen = np.arange(len(self))[index if index.size else index.astype(np.int64)]
        except IndexError as error:
            raise ArgumentError(f"index does not fit {len(self)} detections: {error}") from error
        return self._part(chosen, tuple(self.counts[i] for i in chosen.tolist()))

    def __repr__(self) -> str:
        return f"Detections(n={len(self)}, size={self.size})"

    def _part(self, rows: slice | NDArray[np.int64], counts: tuple[bytes, ...]) -> "Detections":
        part = Detections.__new__(Detections)  # of a record that was checked when it was made
        columns = {"boxes": self.boxes[rows], "scores": self.scores[rows], "labels": self.labels[rows]}
        part._keep(columns, counts, self.size)
        return part

    def _set(
        self, boxes: ArrayLike, scores: ArrayLike, labels: ArrayLike, counts: tuple[bytes, ...], size: Size
    ) -> None:
        n = len(counts)
        columns = {
            "boxes": _checked_boxes(boxes, n),
            "scores": _checked_scores(scores, n),
            "labels": _checked_labels(labels, n),
        }
        self._keep(columns, counts, size)

    def _keep(self, columns: Mapping[str, NDArray[Any]], counts: tuple[bytes, ...], size: Size) -> None:
        for name, array in columns.items():
            array.flags.writeable = False
            object.__setattr__(self, name, array)
        object.__setattr__(self, "counts", counts)
        object.__setattr__(self, "size", size)


def _checked_boxes(values: ArrayLike, n: int) -> NDArray[np.float64]:
    boxes = _floats(values, name="boxes")
    if n == 0 and boxes.size == 0:
        return np.empty((0, 4))
    if boxes.shape != (n, 4):
        raise ArgumentError(f"boxes must have shape ({n}, 4), one row per mask, got {boxes.shape}")
    if not np.isfinite(boxes).all() or (boxes[:, :2] > boxes[:, 2:]).any():
        raise ArgumentError("boxes must be finite with x_min <= x_max and y_min <= y_max")
    return boxes


def _checked_scores(values: ArrayLike, n: int) -> NDArray[np.float64]:
    scores = _floats(values, name="scores")
    if scores.shape != (n,):
        raise ArgumentError(f"scores must have shape ({n},), one per mask, got {scores.shape}")
    if not ((scores >= 0) & (scores <= 1)).all():
        raise ArgumentError(f"scores must lie in 0..1, got {scores.tolist()}")
    return scores


def _checked_labels(values: ArrayLike, n: int) -> NDArray[np.int64]:
    labels = np.asarray(values)
    if labels.shape != (n,):
        raise ArgumentError(f"labels must have shape ({n},), one per mask, got {labels.shape}")
    if n and labels.dtype.kind not in "iu":
        raise ArgumentError(f"labels must be integers, got {labels.dtype}")
    if n and not (labels.min() >= CLASS_MIN and labels.max() <= CLASS_MAX):
        raise ArgumentError(f"labels must be COCO category numbers {CLASS_MIN} to {CLASS_MAX}, got {labels.tolist()}")
    return labels.astype(np.int64)


def _floats(values: ArrayLike, *, name: str) -> NDArray[np.float64]:
    try:
        return np.array(values, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise ArgumentError(f"{name} must be an array of numbers: {error}") from error
