"""A recording for the Rerun viewer: cameras, pictures, masks, the hull of each frame, and the sound's probabilities."""

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from corsmal.dataset import Recording
from corsmal.detection import ViewDetections
from corsmal.errors import ArgumentError, CorsmalError, FileError
from corsmal.estimation import fit_frame
from corsmal.exchange.annotations import frame_jpeg
from corsmal.filling import LEVEL_NAMES, TYPE_NAMES, FillingPrediction
from corsmal.parameters import PAIRS, ShapeParameters
from corsmal.selection import select_best_frame
from corsmal.shape import hull_mesh

if TYPE_CHECKING:
    import rerun as rr

TIME = "recording"
"""The viewer's time line, in seconds of the recording."""


def write_rerun(
    recording: Recording,
    detections: Mapping[str, ViewDetections],
    path: Path,
    *,
    shape: ShapeParameters | None = None,
    heard: tuple[FillingPrediction, ...] = (),
    every: int = 1,
) -> None:
    """Write an ``.rrd`` file, which ``rerun FILE`` plays in 2D and 3D. Needs the extra ``exchange``.

    World coordinates are metres, z up, as in the cameras' calibration.

    Args:
        recording: the recording; views without a calibration are shown in 2D only.
        detections: by view, such as ``load_detections`` gives; their frames are written.
        path: the file.
        shape: of the hulls, which are fitted in every frame that qualifies; default: the paper's.
        heard: predictions from windows that slide over the sound, see ``FillingPredictor.predict_windows``.
        every: write every N-th of the inspected frames.

    Raises:
        ArgumentError: ``every`` is not positive, or there are no detections.
        FileError: a video cannot be read, or the file not be written.
    """
    import rerun as rr  # noqa: PLC0415 - of the extra exchange

    if every < 1 or not any(detections.values()):
        raise ArgumentError(f"every must be positive and there must be inspected frames, got {every} and {detections}")
    stream = rr.RecordingStream("corsmal", recording_id=recording.id)
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        stream.save(path)
    except (OSError, RuntimeError) as error:
        raise FileError(path, f"cannot be written ({error}); choose another file") from error
    stream.log("world", rr.ViewCoordinates.RIGHT_HAND_Z_UP, static=True)
    times_s = recording.clock().times_s
    for name, view in detections.items():
        _log_camera(stream, recording, name)
        with recording.video(name) as video:
            for frame in view.frames[::every]:
                stream.set_time(TIME, duration=float(times_s[frame]))
                stream.log(
                    f"world/{name}/picture", rr.EncodedImage(contents=frame_jpeg(video[frame]), media_type="image/jpeg")
                )
                masks = view[frame].masks
                stream.log(f"world/{name}/picture/masks", rr.SegmentationImage(masks.any(axis=0).astype(np.uint8)))
    _log_hulls(stream, recording, detections, shape=shape or ShapeParameters.paper(), every=every)
    for prediction in heard:
        _log_heard(stream, prediction)
    stream.disconnect()


def _log_camera(stream: "rr.RecordingStream", recording: Recording, name: str) -> None:
    import rerun as rr  # noqa: PLC0415 - as above

    try:
        camera = recording.views[name].camera()
    except CorsmalError:
        return
    stream.log(
        f"world/{name}",
        rr.Transform3D(
            translation=camera.translation, mat3x3=camera.rotation, relation=rr.TransformRelation.ChildFromParent
        ),
        static=True,
    )
    pinhole = rr.Pinhole(image_from_camera=camera.intrinsic, resolution=camera.size)
    stream.log(f"world/{name}/picture", pinhole, static=True)


def _log_hulls(
    stream: "rr.RecordingStream",
    recording: Recording,
    detections: Mapping[str, ViewDetections],
    *,
    shape: ShapeParameters,
    every: int,
) -> None:
    """The hull and the View Score of each frame of the first pair that qualifies."""
    import rerun as rr  # noqa: PLC0415 - as above

    best = next((found for pair in PAIRS if (found := select_best_frame(detections, pair=pair)).ok), None)
    if best is None:
        return
    times_s = recording.clock().times_s
    for score in best.scores[::every]:
        if score.total is None:
            continue
        stream.set_time(TIME, duration=float(times_s[score.frame]))
        stream.log("score", rr.Scalars(score.total))
        fit = fit_frame(
            recording, detections, pair=best.pair, frame=score.frame, centre_rule=best.centre_rule, shape=shape
        )
        vertices_mm, faces = hull_mesh(fit.hull)
        stream.log("world/hull", rr.Mesh3D(vertex_positions=vertices_mm / 1000, triangle_indices=faces))
        if fit.dimensions.capacity_ml is not None:
            stream.log("capacity_ml", rr.Scalars(fit.dimensions.capacity_ml))


def _log_heard(stream: "rr.RecordingStream", prediction: FillingPrediction) -> None:
    """Probabilities at the middle of the window that they were predicted from."""
    import rerun as rr  # noqa: PLC0415 - as above

    if prediction.rows is None or prediction.steps_s is None:
        return
    stream.set_time(TIME, duration=sum(prediction.rows) / 2 * prediction.steps_s)
    probabilities = prediction.probabilities
    for kind, names in (("type", TYPE_NAMES), ("level", LEVEL_NAMES)):
        for name in names:
            if name in probabilities:
                stream.log(f"sound/{kind}/{name}", rr.Scalars(probabilities[name]))
