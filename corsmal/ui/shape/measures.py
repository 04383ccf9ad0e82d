"""What was measured of a container, beside the truth, and its downloads."""

from collections.abc import Callable, Mapping, Sequence
from functools import partial

import streamlit as st

from corsmal.dataset import Recording
from corsmal.estimation import Estimate, Fit, frame_intervals
from corsmal.quantities import BY_NAME, GEOMETRY
from corsmal.shape import MESH_FORMATS, Agreement, export_mesh, profile_table
from corsmal.ui.amounts import amount, measure, percent_error
from corsmal.ui.download_buttons import download_buttons
from corsmal.ui.messages import plain

POOR_OVERLAP = 0.8
"""Of the fits of ``tuned`` in 26 frames of 000618, the ten that agree less than this with the masks are off by 14 % on
average (mean of the four quantities), the others by 7 %."""

ODDS_SHOWN_MAX = 1000


def annotated(recording: Recording) -> dict[str, float]:
    """The annotated capacity (mL), widths and height (mm) of a recording, as far as they are known."""
    values = {name: getattr(recording.annotation, name, None) for name in GEOMETRY}
    return {name: value for name, value in values.items() if value is not None}


def measures(found: Estimate, *, name: str, fits: Sequence[tuple[str, Fit]], truth: Mapping[str, float]) -> None:
    """The four quantities of the whole recording, below each those of single frames; errors refer to the annotation.

    Args:
        found: the estimate over the whole recording.
        name: of its parameters.
        fits: fits of the shown frame with the names of their parameters; those that failed are left out.
        truth: from ``annotated``.
    """
    for column, quantity in zip(st.columns(4), GEOMETRY, strict=True):
        value, true = getattr(found, quantity), truth.get(quantity)
        shown = "–" if value is None else amount(quantity, value)
        measure(column, BY_NAME[quantity].label, shown, _sureness(found, quantity, name))
        error = "" if value is None or not true else f", error {percent_error(value, true)}"
        lines = ["no annotation" if true is None else f"annotated {BY_NAME[quantity].text(true)}{error}"]
        for parameters, fit in fits:
            single: float | None = getattr(fit.dimensions, quantity)
            if single is not None:
                lines.append(
                    f"this frame, `{parameters}`: **{amount(quantity, single)}**{_deviation(single, true, value)}"
                )
                if interval := frame_intervals(fit).get(quantity):
                    lines.append(f"90 % interval {_range(interval)} {BY_NAME[quantity].unit}")
            elif fit.ok:
                lines.append(f"this frame, `{parameters}`: none, {fit.dimensions.unmeasured[quantity]}")
        column.caption("  \n".join(lines))
    if found.fit is None:
        st.caption(f":material/search_off: Whole recording: {plain('; '.join(found.notes)) or 'nothing was fitted'}")


def measured_numbers(found: Estimate, *, name: str, fits: Sequence[tuple[str, Fit]]) -> dict[str, str]:
    """What ``measures`` shows, as a pin holds it: of the shown frame, then of the whole recording."""
    numbers = {}
    for parameters, fit in fits:
        if fit.ok:
            for quantity in GEOMETRY:
                label = f"{BY_NAME[quantity].label}, frame {fit.frame}, {parameters}"
                single = getattr(fit.dimensions, quantity)
                numbers[label] = "not measured" if single is None else amount(quantity, single)
    for quantity in GEOMETRY:
        if (value := getattr(found, quantity)) is not None:
            sure = _sureness(found, quantity, name).removeprefix(f"{name}: ")
            numbers[f"{BY_NAME[quantity].label}, whole recording, {name}"] = f"{amount(quantity, value)}; {sure}"
    return numbers


def _sureness(found: Estimate, quantity: str, name: str) -> str:
    """What the number of the whole recording is from, and its interval."""
    if found.fit is None:
        return "not fitted" if getattr(found, quantity) is None else "training mean"
    if quantity in found.fit.dimensions.unmeasured and quantity not in found.intervals:
        return f"{name}: " + ("not measured" if getattr(found, quantity) is None else "not measured, training mean")
    if quantity not in found.intervals:
        return f"{name}: frame {found.fit.frame}"
    return f"{name}: {_range(found.intervals[quantity])} {BY_NAME[quantity].unit} (90 %)"


def _deviation(single: float, true: float | None, whole: float | None) -> str:
    """How far a frame's number is from the annotation or, without one, from the number of the whole recording."""
    if true:
        return f", {percent_error(single, true)}"
    return f", {percent_error(single, whole)} from the recording's" if whole else ""


def _range(interval: tuple[float, float]) -> str:
    return "{:.0f}–{:.0f}".format(*interval)


def frame_problems(
    fit: Fit, agreements: Mapping[str, Agreement], *, is_inspected: bool, box_odds: float | None
) -> None:
    """Why there is no fit of the shown frame, or how far to trust it.

    Args:
        fit: of the shown frame.
        agreements: of its silhouettes with the masks, by view; empty while something is dragged.
        is_inspected: whether a detector has inspected the frame in both views.
        box_odds: of a box over the whole recording, see ``Estimate``.
    """
    where = f"{' + '.join(fit.pair)} in frame {fit.frame}"
    if not is_inspected:
        st.info(
            f"No detections of {where} yet: there is nothing to fit. Inspect the frame, or choose an inspected one.",
            icon=":material/search:",
        )
    elif not fit.ok:
        st.warning(
            f"The fit of {where} failed: {plain(fit.dimensions.reason)}. Try another frame or the other pair.",
            icon=":material/search_off:",
        )
    elif agreements:
        overlap = sum(each.overlap for each in agreements.values()) / len(agreements)
        if overlap < POOR_OVERLAP:
            shares = ", ".join(f"{100 * each.explained:.0f} % of {view}'s" for view, each in agreements.items())
            beyond = ", ".join(f"{100 * each.beyond:.0f} %" for each in agreements.values())
            st.caption(
                f":material/warning: **A poor fit**: the hull explains {shares} mask pixels and covers {beyond} beyond "
                f"the masks (overlap {100 * overlap:.0f} %). The whole recording counts more than this frame."
            )
    if fit.ok and (said := " ".join(filter(None, [_predicted(fit), _kind(fit, box_odds)]))):
        st.caption(said)


def _predicted(fit: Fit) -> str:
    """The error that is predicted of a frame's fit, and how much its views count; empty where nothing predicts it."""
    if fit.hull.error_pct is None:
        return ""
    weights = ", ".join(
        f"{view} {weight:.2f}" if weight else f"{view} 0 (it contradicts the others)"
        for view, weight in fit.view_weights.items()
    )
    return (
        f"Predicted error of the fit: **{fit.hull.error_pct:.0f} %** (mean of the four quantities). "
        f"Weights of the views: {weights}."
    )


def _kind(fit: Fit, box_odds: float | None) -> str:
    """Whether it is a box, in this frame and over the recording; empty where no box was tried."""
    if fit.hull.box_gain is None:
        return ""
    text = "A round container explains the masks better than a box here."
    if fit.hull.depth_mm is not None:
        depth = amount("height_mm", fit.hull.depth_mm)
        text = f"A box: the silhouettes agree better with one than with a round container; {depth} deep."
    if box_odds is None:
        return text
    kind, odds = ("a box", box_odds) if box_odds >= 1 else ("a round container", 1 / max(box_odds, 1e-9))
    more = " or more" if odds > ODDS_SHOWN_MAX else ""
    return f"{text} Over the whole recording: {kind}, odds {min(odds, ODDS_SHOWN_MAX):.0f} to 1{more}."


def hull_downloads(recording_id: str, fit: Fit) -> None:
    """Buttons for the hull as a mesh and as a table."""
    if not fit.hull.ok:
        return
    name, has_surface = f"{recording_id}_{'-'.join(fit.pair)}_frame{fit.frame}", fit.hull.converged.sum() > 1
    meshes: dict[str, tuple[str, Callable[[], bytes] | None]] = {
        f"Download hull ({ending.upper()})": (
            f"{name}.{ending}",
            partial(export_mesh, fit.hull, file_format=ending) if has_surface else None,
        )
        for ending in MESH_FORMATS
    }
    profile = partial(profile_table, fit.hull, fit.dimensions)
    download_buttons(
        meshes | {"Download profile (CSV)": (f"{name}_profile.csv", lambda: profile().to_csv(index=False).encode())}
    )
