"""``export detections`` and ``export rerun``: results of recordings for other programs."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from corsmal.commands import PRESET_HELP, Root, complain, say, shape_preset
from corsmal.errors import CorsmalError

if TYPE_CHECKING:
    from corsmal.dataset import Recording
    from corsmal.filling import FillingPrediction

OneId = Annotated[str, typer.Argument(metavar="ID", help="Recording, such as 000618.")]
WINDOW_S, HOP_S = 1.0, 0.25


def detections(
    root: Root,
    name: OneId,
    folder: Annotated[Path, typer.Argument(metavar="OUT", help="Folder; the views' folders are written in it.")],
    *,
    form: Annotated[
        Literal["coco", "cvat", "label-studio"],
        typer.Option("--as", help="coco: results, as beside videos; cvat: COCO instances; label-studio: tasks."),
    ] = "coco",
    frames: Annotated[bool, typer.Option("--frames", help="Write the inspected frames as pictures, too.")] = False,
) -> None:
    """Write a recording's detections for annotation tools; what they correct is read again beside the videos."""
    from corsmal.dataset import open_dataset
    from corsmal.exchange import export_detections
    from corsmal.stages.detections import load_detections
    from corsmal.store import Store

    recording = open_dataset(root)[name]
    found = load_detections(recording, store=Store())
    for note in found.notes:
        say(note)
    for path in export_detections(recording, found.views, folder, form=form, with_frames=frames):
        say(str(path))


def rerun(
    root: Root,
    name: OneId,
    out: Annotated[Path, typer.Argument(metavar="OUT", help="File to write, .rrd.")],
    *,
    preset: Annotated[str, typer.Option(help=PRESET_HELP)] = "paper",
    every: Annotated[int, typer.Option(help="Write every N-th of the inspected frames.", min=1)] = 1,
) -> None:
    """Write a recording for the Rerun viewer: cameras, pictures, masks, a hull in each frame, what was heard."""
    from corsmal.dataset import open_dataset
    from corsmal.exchange import write_rerun
    from corsmal.stages.detections import load_detections
    from corsmal.store import Store

    dataset, shape = open_dataset(root), shape_preset(preset)
    recording = dataset[name]
    found = load_detections(recording, store=Store())
    write_rerun(recording, found.views, out, shape=shape, heard=_heard(recording), every=every)
    say(f"Recording: {out}, {out.stat().st_size / 1e6:.1f} MB")


def _heard(recording: "Recording") -> "tuple[FillingPrediction, ...]":
    """What the filling network says of each second; nothing where none can, or none is meant for the recording."""
    from corsmal.filling import FillingPredictor, open_filling
    from corsmal.filling.features import recording_features
    from corsmal.weights import find_weights

    weights = find_weights("filling")
    if recording.audio_path is None or (weights.origin == "bundled" and not recording.is_synthetic):
        return ()
    predictor = open_filling(weights.path)
    if not isinstance(predictor, FillingPredictor):  # one of sound and sight has no answer to a second of sound
        return ()
    try:
        features = recording_features(recording, parameters=predictor.front_end)
        window, hop = (max(1, round(length_s / features.row_s)) for length_s in (WINDOW_S, HOP_S))
        return tuple(predictor.predict_windows(features.values, window=window, hop=hop, steps_s=features.row_s))
    except CorsmalError as error:
        complain("sound", error)
        return ()
