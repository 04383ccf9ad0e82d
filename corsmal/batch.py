"""The stages of recordings, with what they computed kept in the store."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from corsmal.dataset import Recording, View
from corsmal.detection import Detector, ViewDetections, detect_view
from corsmal.errors import FileError
from corsmal.estimation import Fit, fit_frame, read_view_detections
from corsmal.parameters import PAIRS, CentreRule, SelectionParameters, ShapeParameters
from corsmal.selection import Pair
from corsmal.shape import Hull, measure_hull
from corsmal.store import Store, digest, file_fingerprint

METHOD_VIEWS = tuple(dict.fromkeys(view for pair in PAIRS for view in pair))
"""The views that the method looks at, in the order of its pairs."""


@dataclass(frozen=True, eq=False)
class DetectionSet:
    """The detections of one recording, wherever they came from.

    Args:
        views: by view.
        key: digest of what they are: two sets with the same key are the same.
        notes: one sentence for each view whose file could not be used, and for what was skipped in one.
    """

    views: Mapping[str, ViewDetections]
    key: str
    notes: tuple[str, ...] = ()

    @property
    def missing(self) -> tuple[str, ...]:
        """The method's views without detections."""
        return tuple(name for name in METHOD_VIEWS if name not in self.views)


def load_detections(recording: Recording, *, store: Store) -> DetectionSet:
    """The detections of a recording: the file beside the video, else what the store holds of the last detector run."""
    views: dict[str, ViewDetections] = {}
    origins: list[str] = []
    notes: list[str] = []
    for name, view in recording.views.items():
        try:
            found = read_view_detections(view)
            origin = "" if view.detections_path is None else file_fingerprint(view.detections_path)
        except FileError as error:
            notes.append(str(error))
            found = None
        if found is None:
            origin, found = _stored(view, store)
        if found is not None:
            views[name] = found
            origins += [name, origin]
            notes += [f"{name}: {problem}" for problem in found.problems]
    return DetectionSet(views, digest("detections", *origins), tuple(notes))


def detect_recording(
    recording: Recording,
    detector: Detector,
    *,
    store: Store,
    progress: Callable[[int, int], None] | None = None,
    cancelled: Callable[[], bool] | None = None,
) -> None:
    """Detect in all frames of the method's views and keep the results; frames that were inspected before are not again.

    Args:
        recording: views that lack a video, or have a detections file, are passed over.
        detector: such as ``MaskRCNNDetector``.
        store: where the results go, and where earlier ones are.
        progress: called with the numbers of frames done and wanted, over all views.
        cancelled: asked between batches; true stops the work and keeps what was done.

    Raises:
        FileError: a video cannot be opened, or the results cannot be written.
    """
    views = [recording.views[name] for name in METHOD_VIEWS if name in recording.views]
    views = [view for view in views if view.detections_path is None]
    counts = []
    for view in views:
        with view.video() as video:
            counts.append(video.frame_count)
    before = 0
    for view, count in zip(views, counts, strict=True):
        key = digest("detections", file_fingerprint(view.video_path), detector.digest)
        earlier = store.detections(key)
        wanted = [frame for frame in range(count) if earlier is None or frame not in earlier]
        offset = before + count - len(wanted)

        def report(done: int, _total: int, offset: int = offset) -> None:
            if progress is not None:
                progress(offset + done, sum(counts))

        report(0, count)
        if wanted:
            with view.video() as video:
                found = detect_view(video, detector, frames=wanted, progress=report, cancelled=cancelled)
            by_frame = {**(earlier or {}), **found}
            problems = found.problems if len(by_frame) < count else ()
            found = ViewDetections(by_frame, size=found.size, source=found.source, problems=problems)
            if not store.save_detections(key, found):
                raise FileError(store.root, f"the detections could not be kept: {store.problems[-1]}")
        store.save_json("latest", _latest_key(view), {"detections": key})
        before += count
        if cancelled is not None and cancelled():
            return


def load_fit(
    recording: Recording,
    detections: DetectionSet,
    *,
    pair: Pair,
    frame: int,
    centre_rule: CentreRule,
    shape: ShapeParameters,
    store: Store,
) -> Fit:
    """The hull of one pair in one frame, from the store if it was fitted before."""
    paths = [recording.views[name].calibration_path for name in pair if name in recording.views]
    calibrations = [file_fingerprint(path) for path in paths if path is not None]
    key = digest("fit", detections.key, calibrations, pair, frame, centre_rule, SelectionParameters(), shape)
    kept = store.arrays("fits", key)
    if kept is not None and {"heights_mm", "radii_mm", "converged", "centroid_m"} <= set(kept):
        hull = Hull(kept["heights_mm"], kept["radii_mm"], kept["converged"], kept["centroid_m"])
        return Fit(pair, frame, hull, measure_hull(hull, shape))
    fit = fit_frame(recording, detections.views, pair=pair, frame=frame, centre_rule=centre_rule, shape=shape)
    hull = fit.hull
    if hull.ok and hull.centroid_m is not None:
        store.save_arrays(
            "fits",
            key,
            heights_mm=hull.heights_mm,
            radii_mm=hull.radii_mm,
            converged=np.asarray(hull.converged),
            centroid_m=hull.centroid_m,
        )
    return fit


def _stored(view: View, store: Store) -> tuple[str, ViewDetections | None]:
    latest = store.json("latest", _latest_key(view))
    key = latest.get("detections") if latest else None
    return (key, store.detections(key)) if isinstance(key, str) else ("", None)


def _latest_key(view: View) -> str:
    return digest("latest detections", file_fingerprint(view.video_path))
