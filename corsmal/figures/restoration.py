"""A mask before and after restoration, against the truth, and as the mass network sees it."""

from dataclasses import dataclass, field

import cv2
import numpy as np
from numpy.typing import NDArray

from corsmal.figures.drawing import Drawing, Drawn
from corsmal.figures.overlay import Image, jpeg_uri, paint_mask
from corsmal.figures.style import (
    ADDED,
    AXIS,
    CONTAINER,
    OUTSIDE,
    TRUTH,
    Part,
    heatmap,
    note,
    pixels_below,
    plain_layout,
    rgb,
    scatter,
    side_by_side,
)
from corsmal.mass import Axis, RestoredMask
from corsmal.mass.axis import Mask
from corsmal.mass.judging import mask_iou

Box = tuple[int, int, int, int]

PICTURE_PX = 480
"""Pictures are enlarged by a whole number to about this, so that the pixels of masks keep their edges."""

TINT, TINT_SEEN, DIM = 0.55, 0.3, 0.5
NOTES = {"stretch": "stretched", "letterbox": "to scale"}
GAP = 0.025
"""Between panels, as a share of the figure's width."""

SEEN, GAINED, MISSING, EXCESS = "seen", "added", "still missing", "too much"
COLOURS = {SEEN: CONTAINER, GAINED: ADDED, MISSING: TRUTH, EXCESS: OUTSIDE}


@dataclass(frozen=True, eq=False)
class Panel:
    """One of the pictures side by side.

    Args:
        title: what it shows.
        note: the number to read off it.
        box: (x0, y0, x1, y1) pixels that it spans, x1 and y1 excluded.
        traces: what is drawn.
        picture: what lies below, over the whole box.
    """

    title: str
    note: str
    box: Box
    traces: list[Part] = field(default_factory=list)
    picture: Image | None = None


@Drawing
def restoration_figure(
    image: Image,
    mask: Mask,
    restored: RestoredMask,
    *,
    network_input: NDArray[np.float32],
    resize: str,
    amodal: Mask | None = None,
) -> Drawn:
    """What was seen, what restoring made of it, how far that is from the truth, and what the network is given.

    Panels side by side; those of the frame span the padded box, in the frame's pixels, and zoom together.

    Args:
        image: (H, W, 3) uint8 RGB, the frame.
        mask: (H, W) bool, the container's visible pixels.
        restored: the restored mask, with pixels.
        network_input: (112, 112) float32, 0..1.
        resize: how it was made square: ``stretch`` or ``letterbox``.
        amodal: (H, W) bool, the container's whole silhouette where it is known; without it that panel is left out.
    """
    added = restored.added
    seen = _frame_panel("Seen", f"{mask.sum():,} px", image, restored.crop, {SEEN: mask})
    panels = [seen, _restored_panel(image, mask, restored)]
    if amodal is not None:
        layers = {
            SEEN: mask & amodal,
            GAINED: added & amodal,
            MISSING: amodal & ~restored.mask,
            EXCESS: restored.mask & ~amodal,
        }
        note = f"IoU {mask_iou(mask, amodal):.3f} before, {mask_iou(restored.mask, amodal):.3f} after"
        panels.append(_frame_panel("Against the truth", note, image, restored.crop, layers, is_dim=True))
    panels.append(_input_panel(network_input, resize))
    return _drawn(panels)


@Drawing
def restored_figure(image: Image, mask: Mask, restored: RestoredMask) -> Drawn:
    """What restoring made of a mask: of ``restoration_figure`` the panel that says most.

    Args:
        image: (H, W, 3) uint8 RGB, the frame.
        mask: (H, W) bool, the container's visible pixels.
        restored: the restored mask, with pixels.
    """
    return _drawn([_restored_panel(image, mask, restored)])


def mask_png(image: NDArray[np.bool_] | NDArray[np.float32]) -> bytes:
    """An (H, W) mask, bool or 0..1, as a grey PNG: 255 where it is whole."""
    return bytes(cv2.imencode(".png", np.rint(255 * image.astype(np.float32)).astype(np.uint8))[1])


def _restored_panel(image: Image, mask: Mask, restored: RestoredMask) -> Panel:
    """The mask with what was added, and the axis, where there is one."""
    layers = {SEEN: mask, GAINED: restored.added}
    panel = _frame_panel("Restored", _restored_note(mask, restored), image, restored.crop, layers, is_dim=True)
    if restored.axis is not None:
        panel.traces.append(_axis_line(restored.axis, restored.crop))
    return panel


def _restored_note(mask: Mask, restored: RestoredMask) -> str:
    if restored.axis is None:
        return "no axis: nothing added"
    pixels, tilt_deg = int(restored.added.sum()), restored.axis.tilt_deg
    side = "upright" if abs(tilt_deg) < 0.05 else f"leans {abs(tilt_deg):.1f}° {'right' if tilt_deg > 0 else 'left'}"
    return f"{pixels:,} px added (+{100 * pixels / mask.sum():.1f} %), axis {side}"


def _frame_panel(
    title: str, note: str, image: Image, box: Box, layers: dict[str, Mask], *, is_dim: bool = False
) -> Panel:
    """The frame within a box, enlarged, with masks on it in the colours of what they are."""
    x0, y0, x1, y1 = box
    part = image[y0:y1, x0:x1]
    if is_dim:
        part = np.repeat((DIM * cv2.cvtColor(part, cv2.COLOR_RGB2GRAY))[..., None], 3, axis=2).astype(np.uint8)
    factor = max(1, round(PICTURE_PX / max(part.shape)))
    picture = np.asarray(cv2.resize(part, None, fx=factor, fy=factor), np.uint8)
    for name, mask in layers.items():
        inside = mask[y0:y1, x0:x1]
        if inside.any():
            large = np.kron(inside, np.ones((factor, factor), bool))
            paint_mask(picture, large, rgb_colour=rgb(COLOURS[name]), opacity=TINT if is_dim else TINT_SEEN)
    traces = [_legend_entry(name) for name, mask in layers.items() if mask.any()]
    return Panel(title, note, box, traces, picture)


def _legend_entry(name: str) -> Part:
    marker = {"color": COLOURS[name], "size": 12, "symbol": "square"}
    return scatter([None], [None], mode="markers", marker=marker, name=name)


def _axis_line(axis: Axis, box: Box) -> Part:
    """The axis from one side of a box to the other."""
    x0, y0, x1, y1 = box
    corners = np.array([(x0, y0), (x1, y0), (x0, y1), (x1, y1)])
    point, direction = np.array(axis.point), np.array(axis.direction)
    along = (corners - point) @ direction
    ends = point + np.array([[along.min()], [along.max()]]) * direction
    line = {"color": AXIS, "width": 3, "dash": "dash"}
    return scatter(ends[:, 0], ends[:, 1], mode="lines", line=line, name="axis")


def _input_panel(network_input: NDArray[np.float32], resize: str) -> Panel:
    height, width = network_input.shape
    trace = heatmap(
        np.rint(100 * network_input).astype(np.uint8),
        colours=[[0, "#000000"], [1, "#FFFFFF"]],
        zmin=0,
        zmax=100,
        hovertemplate="covered: %{z} %<extra></extra>",
    )
    return Panel("Network input", f"{width} × {height} px, {NOTES.get(resize, resize)}", (0, 0, width, height), [trace])


def _drawn(panels: list[Panel]) -> Drawn:
    """All panels in one figure, each to scale; a legend that names every kind of pixel once."""
    layout = plain_layout(
        margin={"l": 0, "r": 0, "t": 50, "b": 34},
        legend={"orientation": "h", "x": 0.5, "xanchor": "center", "y": -0.02, "yanchor": "top"},
        showlegend=True,
        hovermode="closest",
        images=[],
        annotations=[],
    )
    traces, named = [], set()
    for index, (panel, (left, right)) in enumerate(zip(panels, side_by_side(len(panels), gap=GAP), strict=True)):
        number = str(index + 1) if index else ""
        x0, y0, x1, y1 = panel.box
        hidden = {"visible": False, "constrain": "domain"}
        layout[f"xaxis{number}"] = {"range": [x0 - 0.5, x1 - 0.5], "domain": [left, right], **hidden}
        layout[f"yaxis{number}"] = {
            "range": [y1 - 0.5, y0 - 0.5],
            "anchor": f"x{number}",
            "scaleanchor": f"x{number}",
            "constraintoward": "top",
            **hidden,
        }
        place = {"xref": "paper", "yref": "paper", "x": (left + right) / 2, "xanchor": "center", "y": 1}
        layout["annotations"].append(note(f"<b>{panel.title}</b><br>{panel.note}", yanchor="bottom", **place))
        if panel.picture is not None:
            if index:
                layout[f"xaxis{number}"]["matches"], layout[f"yaxis{number}"]["matches"] = "x", "y"
            layout["images"].append(pixels_below(jpeg_uri(panel.picture), panel.box, axes=number))
        for trace in panel.traces:
            name = trace.get("name", "")
            shown = {"showlegend": bool(name) and name not in named, "legendgroup": name}
            traces.append(trace | shown | {"xaxis": f"x{number}", "yaxis": f"y{number}"})
            named.add(name)
    return traces, layout
