"""What masks by hand change in an estimate, and where one would tell most."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pandas as pd

from corsmal.dataset import Recording
from corsmal.detection import ViewDetections
from corsmal.estimation import Fit, RecordingMasks, choose_frames, counted_frames, estimate
from corsmal.estimation.detected import container_mask
from corsmal.parameters import CentreRule, Pair, SelectionParameters, ShapeParameters, selection_of
from corsmal.quantities import GEOMETRY
from corsmal.shape import agreement, silhouettes
from corsmal.stages.by_hand import views_by_hand
from corsmal.stages.detections import DetectionSet, load_detections
from corsmal.stages.fits import load_fit
from corsmal.store import Store

Views = Mapping[str, ViewDetections]

CANDIDATES = 24
"""Frames that are fitted to find those in which the views disagree most."""

ANY_PLACE: CentreRule = "none"
"""A mask that was corrected is compared with the detection wherever it is in the picture."""


@dataclass(frozen=True)
class Candidate:
    """A frame whose mask is worth correcting.

    Args:
        frame: of the recording.
        view: whose mask disagrees most with the hull.
        overlap: IoU of the hull's silhouette with that mask, 0 to 1.
        is_used: whether the estimate uses the frame.
    """

    frame: int
    view: str
    overlap: float
    is_used: bool

    def __str__(self) -> str:
        """For people."""
        used = "the estimate uses it; " if self.is_used else ""
        return f"frame {self.frame}, {self.view}: {used}hull and mask overlap by {100 * self.overlap:.0f} %"


def compare_masks(recording: Recording, *, shapes: Mapping[str, ShapeParameters], store: Store) -> pd.DataFrame:
    """The geometry of a recording from its detected masks and from those by hand, in the same frames and views.

    Args:
        recording: the recording.
        shapes: parameters of the fit by name; each selects by its own rules.
        store: holds detections and masks by hand.

    Returns:
        A row per name and ``detected`` or ``by hand``, which index it: the four quantities, NaN where nothing was
        fitted, ``frame`` (that was fitted, or fitted best), ``pair`` and ``notes``. Empty without masks by hand.
    """
    hand = views_by_hand(recording, store=store)
    found = load_detections(replace(recording, masks="detected"), store=store).views
    same = {name: _only(found[name], hand[name]) for name in hand if name in found}
    rows: dict[tuple[str, str], dict[str, Any]] = {}
    for name, shape in shapes.items() if hand else ():
        for masks, views in (("detected", same), ("by hand", hand)):
            result = estimate(recording, detections=views, shape=shape, selection=selection_of(shape))
            row = result.row()
            rows[name, masks] = {quantity: row[quantity] for quantity in GEOMETRY}
            rows[name, masks] |= {"frame": row["best_frame"], "pair": row["pair"], "notes": row["notes"]}
    table = pd.DataFrame.from_dict(rows, orient="index", columns=[*GEOMETRY, "frame", "pair", "notes"])
    table.index = pd.MultiIndex.from_tuples(rows, names=["preset", "masks"])
    return table.astype(dict.fromkeys(GEOMETRY, "float64"))


def compare_outlines(recording: Recording, *, store: Store) -> pd.DataFrame:
    """How well the detected masks agree with those by hand.

    Returns:
        A row per ``view`` and ``frame`` of the recording with a mask by hand: ``overlap`` (IoU, NaN where nothing was
        detected), and the pixels that were ``missing`` and ``beyond`` it.
    """
    found = load_detections(replace(recording, masks="detected"), store=store).views
    rows = []
    for name, view in views_by_hand(recording, store=store).items():
        for frame, drawn in view.items():
            true = drawn.mask(0) if len(drawn) else np.zeros(view.size, dtype=bool)
            row: dict[str, Any] = {
                "view": name,
                "frame": frame,
                "overlap": np.nan,
                "missing": int(true.sum()),
                "beyond": 0,
            }
            if frame in found.get(name, ()):
                parameters = SelectionParameters()
                detected = container_mask(found[name][frame], centre_rule=ANY_PLACE, parameters=parameters)
                union = int(np.count_nonzero(detected | true))
                both = int(np.count_nonzero(detected & true))
                row |= {"overlap": both / union if union and detected.any() else np.nan}
                row |= {"missing": int(true.sum()) - both, "beyond": int(detected.sum()) - both}
            rows.append(row)
    return pd.DataFrame(rows, columns=["view", "frame", "overlap", "missing", "beyond"])


def mask_sentence(table: pd.DataFrame, truth: Mapping[str, float], *, preset: str) -> str:
    """What the masks and what the geometry are to blame for in one recording, in a sentence.

    Args:
        table: from ``compare_masks``.
        truth: the annotated quantities.
        preset: whose rows count.
    """
    known = [name for name in GEOMETRY if truth.get(name)]
    own = table[table.index.get_level_values("preset") == preset].droplevel("preset")[known]
    rows = {str(masks): row for masks, row in own.to_dict("index").items()}
    if len(rows) < 2 or not known:
        return "There is nothing to compare: it takes masks by hand in two views of a frame, and an annotation."
    errors = {masks: [100 * abs(row[name] / truth[name] - 1) for name in known] for masks, row in rows.items()}
    before, after = (float(np.mean(errors[masks])) for masks in ("detected", "by hand"))
    if not np.isfinite([before, after]).all():
        failed = " and ".join(f"the masks {masks}" for masks, each in errors.items() if not np.isfinite(each).all())
        return f"`{preset}`: with {failed} nothing was fitted."
    share = (before - after) / before if before else 0.0
    change = "falls" if after < before else "grows"
    blame = f"{100 * share:.0f} % of it is due to the masks" if share > 0 else "the masks are not to blame"
    quantities = f"the mean error of the {len(known)} quantities"
    return f"`{preset}`: {quantities} {change} from {before:.1f} to {after:.1f} %; {blame}."


def frames_to_correct(
    recording: Recording,
    detections: DetectionSet,
    *,
    pair: Pair,
    shape: ShapeParameters,
    selection: SelectionParameters | None = None,
    store: Store,
) -> list[Candidate]:
    """Frames whose masks are worth correcting: first those that the estimate uses, then where the views disagree most.

    The views disagree where the silhouettes of the hull that is fitted to both agree little with their masks. Frames
    with masks by hand in both views are left out.

    Args:
        recording: the recording.
        detections: of it.
        pair: the two views.
        shape: parameters of the fit.
        selection: rules for the best frame; default: those of the preset.
        store: keeps the fits.
    """
    selection = selection or selection_of(shape)
    hand, views = views_by_hand(recording, store=store), detections.views
    counted = counted_frames(recording, selection)
    best, used = choose_frames(views, pair=pair, shape=shape, selection=selection, counted=counted)
    done = set(hand.get(pair[0], ())) & set(hand.get(pair[1], ()))
    scored = [score.frame for score in best.scores if score.total is not None]
    masks = RecordingMasks(recording, views, selection)
    found = []
    for frame in dict.fromkeys([*used, *_spread([frame for frame in scored if frame not in done])]):
        if frame in done:
            continue
        fit = load_fit(
            recording,
            detections,
            pair=pair,
            frame=frame,
            centre_rule=best.centre_rule,
            shape=shape,
            selection=selection,
            store=store,
        )
        overlaps = _overlaps(fit, masks, best.centre_rule)
        open_views = [view for view in overlaps if frame not in hand.get(view, ())]
        if open_views:
            worst = min(open_views, key=lambda view: overlaps[view])
            found.append(Candidate(frame, worst, overlaps[worst], frame in used))
    return sorted(found, key=lambda each: (not each.is_used, each.overlap))


def _overlaps(fit: Fit, masks: RecordingMasks, centre_rule: CentreRule) -> dict[str, float]:
    """IoU of the hull's silhouette with the mask, by view of its pair; empty where nothing was fitted."""
    if not fit.hull.ok or fit.frame is None:
        return {}
    seen = silhouettes(fit.hull, [masks.camera(view) for view in fit.pair])
    return {
        view: agreement(each, masks.mask(view, fit.frame, centre_rule)).overlap
        for view, each in zip(fit.pair, seen, strict=True)
    }


def _only(view: ViewDetections, frames: Iterable[int]) -> ViewDetections:
    return replace(view, by_frame={frame: view[frame] for frame in frames if frame in view})


def _spread(frames: Sequence[int]) -> list[int]:
    """At most ``CANDIDATES`` of the frames, equally spaced."""
    places = np.unique(np.linspace(0, len(frames) - 1, min(CANDIDATES, len(frames))).round().astype(int))
    return [frames[place] for place in places]
