"""The files of one synthetic recording: videos, calibrations, sound and truth."""

import json
import pickle
from fractions import Fraction
from pathlib import Path
from typing import Any

import av
import numpy as np
import soundfile
from numpy.typing import NDArray

from corsmal.detection import Detections, ViewDetections
from corsmal.detection.parquet import write_parquet
from corsmal.geometry import Camera
from corsmal.synthetic.render.frame import render_frame
from corsmal.synthetic.scene.scene import FPS, Scene, sound_events
from corsmal.synthetic.sound.events import SAMPLE_RATE_HZ
from corsmal.synthetic.writing.parts import SOUND, part_files, writing

TRUTH_SOURCE = "truth of the synthetic recording"
_QUALITY = {"preset": "ultrafast", "crf": "21", "g": "15", "threads": "1"}
_COMPACT_QUALITY = {"preset": "slow", "crf": "25", "g": "15", "threads": "1"}
_INFRARED_FOCAL_PX = 638.0
_INFRARED_SHIFTS_M = {"ir1": 0.015, "ir2": -0.035}
_MARKS_M = ((0.45, 0.2, 0.0), (0.05, 0.2, 0.0))


def write_part(
    root: Path,
    recording_id: str,
    scene: Scene,
    part: str,
    *,
    size: tuple[int, int],
    frame_step: int = 1,
    compact: bool = False,
) -> None:
    """Make one of ``PARTS`` of a recording under ``root``, in the dataset's layout.

    Videos have ``size`` (width, height) and every ``frame_step``-th frame of the scene; where the recording is to be
    ``compact`` they take more time and less room, and the sound is a FLAC file.

    Raises:
        FileError: a file cannot be written.
    """
    files = [root / file for file in part_files(recording_id, part, compact=compact)]
    if part == SOUND:
        _write_sound(files[0], scene, compression=1.0 if compact else None)
        with writing(files[1]) as path:
            path.write_text(json.dumps(scene_truth(scene, frame_step=frame_step), allow_nan=False), encoding="utf-8")
        return
    with writing(files[0]) as path:
        path.write_bytes(calibration_bytes(scene.cameras[part]))
    masks = {"amodal": files[1], "visible": files[2]}
    quality = _COMPACT_QUALITY if compact else _QUALITY
    _write_view(files[3], scene, part, size=size, masks=masks, frame_step=frame_step, quality=quality)


def calibration_bytes(camera: Camera) -> bytes:
    """A calibration file in the dataset's form: a pickle (protocol 0) of a list of dicts of arrays.

    As in the real files it also describes two infrared sensors, beside the colour camera, and two marks on the table.
    """
    intrinsics, extrinsics = {"rgb": camera.intrinsic}, {"rgb": _extrinsic(camera)}
    width, height = camera.size
    infrared = np.array([[_INFRARED_FOCAL_PX, 0, width / 2], [0, _INFRARED_FOCAL_PX, height / 2], [0, 0, 1]])
    for name, shift in _INFRARED_SHIFTS_M.items():
        beside = Camera(infrared, camera.rotation, camera.translation + np.array([shift, 0, 0]), camera.size)
        intrinsics[name], extrinsics[name] = infrared, _extrinsic(beside)
    marks = [np.rint(mark).astype(np.int64) for mark in camera.project(np.array(_MARKS_M))]
    content = [{name: np.array(matrix) for name, matrix in intrinsics.items()}, extrinsics, *marks]
    return pickle.dumps(content, protocol=0).replace(b"numpy._core.", b"numpy.core.")


def scene_truth(scene: Scene, *, frame_step: int = 1) -> dict[str, Any]:
    """What was drawn, as JSON can hold it; the poses are those of every ``frame_step``-th frame."""
    container, motion, kept = scene.container, scene.motion, np.s_[::frame_step]
    profile = None
    if container.outer is not None and container.inner is not None:
        profile = {
            "outer_heights_mm": container.outer.heights_mm.tolist(),
            "outer_radii_mm": container.outer.radii_mm.tolist(),
            "inner_heights_mm": container.inner.heights_mm.tolist(),
            "inner_radii_mm": container.inner.radii_mm.tolist(),
        }
    return {
        "seed": scene.seed,
        "container_id": container.container_id,
        "capacity_ml": container.capacity_ml,
        "width_top_mm": container.width_top_mm,
        "width_bottom_mm": container.width_bottom_mm,
        "height_mm": container.height_mm,
        "depth_mm": container.depth_mm,
        "profile": profile,
        "frames": len(motion.fill[kept]),
        "fps": FPS if frame_step == 1 else FPS / frame_step,
        "action": scene.timing.action,
        "events_s": {name: value for name, value in vars(scene.timing).items() if name != "action"},
        "base_m": np.round(motion.base_m[kept], 6).tolist(),
        "rotation": np.round(motion.rotation[kept], 6).tolist(),
        "fill": np.round(motion.fill[kept], 4).tolist(),
    }


def _extrinsic(camera: Camera) -> dict[str, NDArray[np.float64]]:
    translation = np.array(camera.translation)[:, None]
    return {"rvec": np.array(camera.rotation), "tvec": translation, "projMatrix": np.array(camera.projection)}


def _write_view(
    path: Path,
    scene: Scene,
    view: str,
    *,
    size: tuple[int, int],
    masks: dict[str, Path],
    frame_step: int,
    quality: dict[str, str],
) -> None:
    found: dict[str, dict[int, Detections]] = {kind: {} for kind in masks}
    with (
        writing(path, errors=(av.FFmpegError,)) as part,
        av.open(str(part), "w", options={"movflags": "faststart"}) as container,
    ):
        stream = container.add_stream("libx264", rate=Fraction(FPS, frame_step), options=quality)
        stream.width, stream.height = size
        stream.pix_fmt = "yuv420p"
        for frame, drawn in enumerate(range(0, scene.frames, frame_step)):
            truth = render_frame(scene, view, drawn, size=size)
            container.mux(stream.encode(av.VideoFrame.from_ndarray(truth.image, format="rgb24")))
            for kind, mask in (("amodal", truth.amodal), ("visible", truth.visible)):
                found[kind][frame] = detection_of(mask, scene.container.label)
        container.mux(stream.encode(None))
    for kind, file in masks.items():
        record = ViewDetections(found[kind], size=(size[1], size[0]), source=f"{TRUTH_SOURCE}, {kind} mask")
        with writing(file) as part:
            write_parquet(record, part)


def detection_of(mask: NDArray[np.bool_], label: int) -> Detections:
    """A mask as a detection with score 1; none where nothing is seen."""
    columns, rows = np.flatnonzero(mask.any(axis=0)), np.flatnonzero(mask.any(axis=1))
    if not len(columns):
        return Detections(np.empty((0, 4)), [], [], mask[None][:0])
    box = [float(columns[0]), float(rows[0]), float(columns[-1] + 1), float(rows[-1] + 1)]
    return Detections([box], [1.0], [label], mask[None])


def _write_sound(path: Path, scene: Scene, *, compression: float | None) -> None:
    from corsmal.synthetic.sound.recording import recording_sound  # noqa: PLC0415 - loads SciPy, a second

    samples = recording_sound(sound_events(scene), rng=np.random.default_rng([scene.seed, 3]))
    with writing(path, errors=(soundfile.SoundFileError,)) as part:
        soundfile.write(part, samples.T, SAMPLE_RATE_HZ, subtype="PCM_16", compression_level=compression)
