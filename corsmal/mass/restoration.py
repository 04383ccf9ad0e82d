"""Restoring what a hand hides of a container's mask, from the mask's symmetry (paper 3.3)."""

import cv2
import numpy as np

from corsmal.errors import ArgumentError, check_choice
from corsmal.mass.axis import (
    AXIS_RULES,
    Axis,
    AxisRule,
    Mask,
    Outline,
    agreement,
    base_axis,
    outline,
    top_axis,
    whole_axis,
)
from corsmal.mass.records import RestoredMask

Box = tuple[int, int, int, int]

PADDING_PX = 15
"""Around the mask's box (paper 3.3)."""

DOUBT_SHARE = 0.5
"""An axis of the base that agrees with the outline by less than this share of what the best axis does is doubted."""


def restore_mask(mask: Mask, *, padding_px: int = PADDING_PX, axis: AxisRule = "base") -> RestoredMask:
    """Fill in what is hidden on one side of a container by what is seen on the other.

    The mask's box with ``padding_px`` around it is considered, without what would lie beyond the image's border. A
    pixel joins the mask when the pixel nearest to its mirror image about the axis is in the mask; nothing is taken
    away, and nothing is added outside the box.

    Args:
        mask: (H, W) bool, the container's visible pixels.
        padding_px: pixels added on each side of the mask's box, not negative.
        axis: ``base``, the perpendicular bisector of the segment between the base's ends (the paper's), for containers
            that lean less than about 40 degrees and whose base is seen; ``whole``, the line about which most of the
            outline is symmetric; ``top``, the vertical through the middle of the topmost row, about which the rows
            below are widened and filled instead of mirrored (the authors' program).

    Returns:
        The restored mask. Where no axis is found ``ok`` is false, with a reason, and the mask is as it was. ``notes``
        says what may have spoilt an axis that was found.

    Raises:
        ArgumentError: the mask is not a bool image, the padding is negative, or there is no such rule.

    Example:
        >>> mask = np.zeros((60, 80), dtype=bool)
        >>> mask[20:50, 30:50] = True  # a straight cup
        >>> mask[30:36, 44:50] = False  # of which a hand hides a part
        >>> restored = restore_mask(mask)
        >>> int(restored.added.sum()), abs(round(restored.axis.tilt_deg, 1))
        (36, 0.0)
    """
    _check(mask, padding_px, axis)
    x, y, width, height = cv2.boundingRect(mask.view(np.uint8))
    if not width:
        return RestoredMask.failed(mask, (0, 0, 0, 0), "the mask is empty")
    crop = _padded((x, y, width, height), mask.shape, padding_px)
    if min(width, height) < 2:
        row = "row" if height < 2 else "column"
        return RestoredMask.failed(mask, crop, f"the mask is a single {row} of pixels")
    part = mask[crop[1] : crop[3], crop[0] : crop[2]]
    lines = outline(part)
    found = _axis(part, lines, axis)
    if found is None:
        return RestoredMask.failed(mask, crop, "the mask has no base: no lower edge rises by less than 40 degrees")
    notes = _border_notes((x, y, width, height), mask.shape) + _outline_notes(lines)
    if axis == "base" and agreement(lines.points, found) < DOUBT_SHARE * agreement(
        lines.points, whole_axis(lines.points)
    ):
        notes += ("another axis fits the outline much better: the base may be hidden",)
    added = np.zeros_like(mask)
    filled = _widened(part, int(found.point[0])) if axis == "top" else _mirrored(part, found)
    added[crop[1] : crop[3], crop[0] : crop[2]] = filled & ~part
    moved = Axis((found.point[0] + crop[0], found.point[1] + crop[1]), found.direction)
    return RestoredMask(mask | added, crop, moved, added, notes=notes)


def _axis(part: Mask, lines: Outline, rule: AxisRule) -> Axis | None:
    if rule == "top":
        return top_axis(part)
    return base_axis(lines.points) if rule == "base" else whole_axis(lines.points)


def _check(mask: Mask, padding_px: int, axis: AxisRule) -> None:
    if not isinstance(mask, np.ndarray) or mask.ndim != 2 or mask.dtype != np.bool_ or mask.size == 0:
        found = f"{mask.dtype} {mask.shape}" if isinstance(mask, np.ndarray) else type(mask).__name__
        raise ArgumentError(f"mask must be an image (H, W) of bool, got {found}")
    if isinstance(padding_px, bool) or not isinstance(padding_px, int | np.integer) or padding_px < 0:
        raise ArgumentError(f"padding_px must be a whole number of pixels, 0 or more, got {padding_px!r}")
    check_choice("axis", axis, AXIS_RULES)


def _padded(box: Box, shape: tuple[int, ...], padding_px: int) -> Box:
    x, y, width, height = box
    return (
        max(x - padding_px, 0),
        max(y - padding_px, 0),
        min(x + width + padding_px, shape[1]),
        min(y + height + padding_px, shape[0]),
    )


def _mirrored(part: Mask, axis: Axis) -> Mask:
    """Which pixels' mirror images, to the nearest pixel, are in the mask."""
    height, width = part.shape
    across = np.array((-axis.direction[1], axis.direction[0]), np.float32)
    columns, rows = np.arange(width, dtype=np.float32), np.arange(height, dtype=np.float32)[:, None]
    twice = 2 * ((columns - axis.point[0]) * across[0] + (rows - axis.point[1]) * across[1])  # of the distance
    images = columns - twice * across[0], rows - twice * across[1]
    return cv2.remap(part.view(np.uint8), *images, cv2.INTER_NEAREST, borderMode=cv2.BORDER_CONSTANT).view(np.bool_)


def _widened(part: Mask, middle: int) -> Mask:
    """The rows below the topmost one, filled from their first to their last pixel after their shorter side was widened.

    Both sides of the column ``middle`` become equally long. A row that lies beside that column is widened to one pixel
    beyond its mirror image. Nothing reaches beyond the crop.
    """
    rows = np.flatnonzero(part.any(axis=1))[1:]
    left, right = part[rows].argmax(axis=1), part.shape[1] - 1 - part[rows, ::-1].argmax(axis=1)
    mirrored_left, mirrored_right = 2 * middle - right, 2 * middle - left
    first = np.where(middle < left, mirrored_left - 1, np.minimum(left, mirrored_left))
    last = np.where(right < middle, mirrored_right + 1, np.maximum(right, mirrored_right))
    columns = np.arange(part.shape[1])
    widened = np.zeros_like(part)
    widened[rows] = (first[:, None] <= columns) & (columns <= last[:, None])
    return widened


def _border_notes(box: Box, shape: tuple[int, ...]) -> tuple[str, ...]:
    x, y, width, height = box
    cut = {"left": x == 0, "upper": y == 0, "right": x + width == shape[1], "lower": y + height == shape[0]}
    sides = " and ".join(name for name, is_cut in cut.items() if is_cut)
    return (f"the image's {sides} border cuts the mask: nothing is restored beyond it",) if sides else ()


def _outline_notes(lines: Outline) -> tuple[str, ...]:
    notes = []
    if lines.parts > 1:
        notes.append(f"the mask has {lines.parts} separate parts; all are used as the container")
    if lines.holes:
        number = "a hole" if lines.holes == 1 else f"{lines.holes} holes"
        notes.append(f"the mask has {number}; only pixels mirrored from the mask are filled")
    return tuple(notes)
