"""Masks of containers that are drawn at any tilt."""

import cv2
import numpy as np

CUP = ((40, 0), (44, 40), (60, 150))
"""Half widths and heights above the base, pixels."""

GLASS = ((34, 0), (34, 5), (5, 12), (5, 70), (45, 90), (40, 150))
BOX = ((45, 0), (45, 150))


def container(profile=CUP, *, base=(320, 260), tilt_deg=0.0, sag=0.15, size=(400, 640)):
    """An (H, W) mask: the profile about an axis through ``base`` that leans to the right by ``tilt_deg``.

    Base and rim are arcs, as a camera sees circles from above; ``sag`` is their depth by their half width.
    """
    heights = np.linspace(profile[0][1], profile[-1][1], 200)
    widths = np.interp(heights, [height for _, height in profile], [width for width, _ in profile])
    angles = np.linspace(0, np.pi, 60)
    base_arc = np.column_stack([-widths[0] * np.cos(angles), -sag * widths[0] * np.sin(angles)])
    rim_arc = np.column_stack([widths[-1] * np.cos(angles), heights[-1] + sag * widths[-1] * np.sin(angles)])
    right, left = np.column_stack([widths, heights]), np.column_stack([-widths, heights])[::-1]
    flat = np.vstack([base_arc, right, rim_arc, left])
    tilt = np.radians(tilt_deg)
    x = base[0] + flat[:, 0] * np.cos(tilt) + flat[:, 1] * np.sin(tilt)
    y = base[1] + flat[:, 0] * np.sin(tilt) - flat[:, 1] * np.cos(tilt)
    mask = np.zeros(size, np.uint8)
    # 16ths of a pixel, so that a tilted outline is not rounded twice
    cv2.fillPoly(mask, [np.rint(np.column_stack([x, y]) * 16).astype(np.int32)], 1, shift=4)
    return mask.astype(bool)


def along_and_across(mask, *, base=(320, 260), tilt_deg=0.0):
    """How far each pixel is above the base and to the right of the axis, two (H, W) arrays in pixels."""
    y, x = np.mgrid[: mask.shape[0], : mask.shape[1]]
    tilt = np.radians(tilt_deg)
    along = (x - base[0]) * np.sin(tilt) - (y - base[1]) * np.cos(tilt)
    return along, (x - base[0]) * np.cos(tilt) + (y - base[1]) * np.sin(tilt)


def gripped(mask, *, low=40, high=110, reach=5, **pose):
    """The mask without what a hand on the right hides: from ``reach`` px right of the axis, between two heights."""
    along, across = along_and_across(mask, **pose)
    return mask & ~((along > low) & (along < high) & (across > reach))


def iou(first, second):
    return (first & second).sum() / (first | second).sum()
