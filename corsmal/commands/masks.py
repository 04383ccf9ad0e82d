"""``masks``: masks by hand of a recording: what they change, which to draw next, to a file and back."""

from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from corsmal.commands import PRESET_HELP, Root, say, shape_preset
from corsmal.commands import show as show_table
from corsmal.errors import ArgumentError, NotFoundError
from corsmal.parameters import SHAPE_PRESETS

if TYPE_CHECKING:
    from corsmal.dataset import Recording, View
    from corsmal.store import Store

OneId = Annotated[str, typer.Argument(metavar="ID", help="Recording, such as 000618.")]
ViewName = Annotated[str, typer.Argument(metavar="VIEW", help="View, such as view3.")]
SHOWN = 10


def show(root: Root, name: OneId) -> None:
    """Show the masks by hand of a recording, and what they change in the estimates of all presets."""
    from corsmal.dataset import open_dataset
    from corsmal.quantities import GEOMETRY
    from corsmal.stages.by_hand import masks_by_view
    from corsmal.stages.hand_comparison import compare_masks, compare_outlines, mask_sentence
    from corsmal.store import Store

    recording, store = open_dataset(root)[name], Store()
    counts = {view: len(masks) for view, masks in masks_by_view(recording, store=store).items() if masks}
    if not counts:
        say(f"Recording {recording.id} has no masks by hand: draw them on the Frames page, or import a COCO file.")
        return
    outlines = compare_outlines(recording, store=store)
    in_percent = outlines.assign(overlap=100 * outlines["overlap"]).rename(columns={"overlap": "IoU, %"})
    show_table("Detected masks against those by hand: IoU, pixels missed and added by the detector", in_percent)
    table = compare_masks(recording, shapes=SHAPE_PRESETS, store=store)
    show_table("The same frames with detected masks and with those by hand", table.drop(columns="notes"))
    truth = {quantity: getattr(recording.annotation, quantity, None) or 0.0 for quantity in GEOMETRY}
    for preset in SHAPE_PRESETS:
        typer.echo(mask_sentence(table, truth, preset=preset))


def following(
    root: Root,
    name: Annotated[
        str | None,
        typer.Argument(metavar="ID", help="Recording, such as 000618; default: those whose estimates are least sure."),
    ] = None,
    *,
    preset: Annotated[str, typer.Option(help=f"{PRESET_HELP} Of the one recording that is named.")] = "paper",
    run: Annotated[
        str | None,
        typer.Option(
            metavar="NAME", help="Run that says how sure the estimates are; default: the newest of `tuned` on ROOT."
        ),
    ] = None,
) -> None:
    """Name the frames whose masks are worth correcting next, in one recording or in those that are least sure.

    First come the frames that the estimate uses, then those where the views disagree.
    """
    from corsmal.dataset import open_dataset
    from corsmal.store import Store

    if name is None:
        _following_recordings(root, run)
    elif run is not None:
        raise ArgumentError(f"--run orders recordings: leave out {name} or --run")
    else:
        _following_frames(open_dataset(root)[name], preset, Store())


def _following_recordings(root: Path, name: str | None) -> None:
    from corsmal.commands.runs import open_run
    from corsmal.dataset import open_dataset
    from corsmal.runs.correcting import NO_RUN, masks_to_correct, run_to_correct
    from corsmal.store import Store

    store = Store()
    if name is None:
        dataset = open_dataset(root)
        run = run_to_correct(dataset, store=store)
    else:
        dataset, run = open_run(root, name)
    if run is None:
        raise NotFoundError(f"{NO_RUN} Make it with `estimate ROOT --preset tuned --run NAME`, or name a recording.")
    say(f"Run {run.name}: the recordings whose estimates are least sure, and the frame to correct first in each")
    is_any = False
    for each in islice(masks_to_correct(run, dataset, store=store), SHOWN):
        typer.echo(str(each))
        is_any = True
    if not is_any:
        say("There is no recording to correct: the run's rows have no 90 % intervals, or all have masks by hand.")


def _following_frames(recording: "Recording", preset: str, store: "Store") -> None:
    from corsmal.stages.detections import load_detections
    from corsmal.stages.hand_comparison import frames_to_correct

    shape = shape_preset(preset)
    detections = load_detections(recording, store=store)
    for note in detections.notes:
        say(note)
    found = frames_to_correct(recording, detections, pair=shape.pairs[0], shape=shape, store=store)
    if not found:
        say("There is no frame to correct: no detections in both views, or all of them have masks by hand.")
    for candidate in found[:SHOWN]:
        typer.echo(str(candidate))


def export(
    root: Root,
    name: OneId,
    folder: Annotated[Path, typer.Argument(metavar="OUT", help="Folder; VIEW/by-hand/ID.json are written in it.")],
) -> None:
    """Write the masks by hand of a recording as COCO results, a file for each view that has some."""
    from corsmal.by_hand import MaskHistory, export_masks
    from corsmal.dataset import open_dataset
    from corsmal.store import Store

    recording, store = open_dataset(root)[name], Store()
    for view in recording.views.values():
        history = MaskHistory(recording.id, view, store=store)
        masks = history.masks(accepted_only=False)
        for sentence in history.problems():
            say(sentence)
        if masks:
            path = folder / view.name / "by-hand" / f"{recording.id}.json"
            export_masks(masks, path, video=history.video)
            say(f"{path}: {len(masks)} masks")


def read(
    root: Root,
    name: OneId,
    view: ViewName,
    file: Annotated[Path, typer.Argument(metavar="FILE", help="COCO file; image_id is the frame.")],
    *,
    who: Annotated[str, typer.Option(help="Whose masks they are, where the file does not say.")] = "",
) -> None:
    """Read masks of a COCO file, such as a labelling tool writes, as masks by hand of one view."""
    from corsmal.by_hand import import_masks
    from corsmal.dataset import open_dataset
    from corsmal.store import Store

    recording = open_dataset(root)[name]
    count, said = import_masks(recording.id, _view(recording, view), file, store=Store(), who=who)
    for sentence in said:
        say(sentence)
    say(f"{recording.id}, {view}: {count} masks by hand")


def _view(recording: "Recording", name: str) -> "View":
    if name not in recording.views:
        views = ", ".join(recording.views) or "none"
        raise NotFoundError(f"recording {recording.id} has no video of {name!r}; views: {views}")
    return recording.views[name]
