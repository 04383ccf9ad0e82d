"""``estimate``, ``submit``, and of ``runs``: ``list``, ``show``, ``export`` and ``delete``."""

import json
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from corsmal.commands import (
    PAIRS_HELP,
    PRESET_HELP,
    SELECTION_HELP,
    DetectFirst,
    FeatureOptions,
    Ids,
    MatchViews,
    Offsets,
    Root,
    UsedMasks,
    complain,
    complain_of,
    say,
    selection_preset,
    shape_preset,
    view_matching,
    with_pairs,
)
from corsmal.commands.engines import EngineName, Scheduler, Workers, choose_engine, resumable_progress
from corsmal.errors import CorsmalError, NotFoundError

if TYPE_CHECKING:
    from corsmal.dataset import Dataset
    from corsmal.runs import Run
    from corsmal.store import Store

Name = Annotated[str, typer.Argument(metavar="NAME", help="Name of the run.")]
AsJson = Annotated[bool, typer.Option("--json", help="Print JSON.")]

TABLE_ENDINGS = (".csv", ".tsv", ".txt", ".json", ".parquet")


def _weights_option(kind: str) -> Any:
    return typer.Option(
        help=f"Weights of the {kind} network, or demo for the bundled ones; default: CORSMAL_{kind.upper()}_WEIGHTS, "
        "else the bundled ones, on synthetic recordings only."
    )


def estimate(
    root: Root,
    ids: Ids = None,
    *,
    name: Annotated[
        str | None,
        typer.Option("--run", help="Name of the run; an existing one is resumed. Default: a name after the preset."),
    ] = None,
    out: Annotated[Path, typer.Option(help="File to write: .csv, .json or .parquet.")] = Path("estimates.csv"),
    preset: Annotated[str | None, typer.Option(help=PRESET_HELP, show_default="paper")] = None,
    selection: Annotated[str | None, typer.Option(help=SELECTION_HELP)] = None,
    pairs: Annotated[str | None, typer.Option(help=PAIRS_HELP, show_default="the preset's")] = None,
    wall: Annotated[
        float | None, typer.Option(help="Wall thickness of round containers in mm; default: the preset's.")
    ] = None,
    means: Annotated[
        Path | None,
        typer.Option(help="Training set whose means stand in for failed fits; default: those kept with the weights."),
    ] = None,
    filling: Annotated[Path | None, _weights_option("filling")] = None,
    mass: Annotated[Path | None, _weights_option("mass")] = None,
    features: FeatureOptions = None,
    detector: DetectFirst = None,
    match: MatchViews = None,
    offset: Offsets = None,
    masks: UsedMasks = None,
    engine: EngineName = "local",
    workers: Workers = None,
    scheduler: Scheduler = None,
) -> None:
    """Estimate capacity, dimensions, filling and mass of recordings.

    The estimates are kept as a run, which the app shows too. An interrupted run resumes.
    """
    from corsmal.dataset import open_dataset
    from corsmal.estimation import TrainingMeans
    from corsmal.evaluation import write_estimates
    from corsmal.filling.sight import FeatureFolders
    from corsmal.runs import load_run, make_run
    from corsmal.stages.settings import default_settings, find_detector, left_out_note
    from corsmal.store import Store

    chosen_shape = with_pairs(shape_preset(preset or "paper"), pairs)
    chosen_selection = selection_preset(selection, preset=preset or "paper")
    dataset, store = open_dataset(root), Store()
    is_kept = _is_writable(store)
    earlier = None if name is None else load_run(name, dataset=dataset.root, store=store)
    options = (ids, preset, selection, pairs, wall, means, filling, mass, features, detector, match, offset, masks)
    if earlier is not None and all(option in (None, []) for option in options):
        settings, wanted = earlier.settings, earlier.recordings
    else:
        folders = FeatureFolders.of(features or [])
        settings = default_settings(
            dataset,
            shape=chosen_shape if wall is None else replace(chosen_shape, wall_mm=wall),
            selection=chosen_selection,
            means=None if means is None else TrainingMeans.of(open_dataset(means)),
            filling=filling,
            mass=mass,
            features=folders.sound,
            sight=folders.sight,
            detector=None if detector is None else find_detector(detector),
            matching=view_matching(match, offset),
            masks=masks or "detected",
        )
        wanted = tuple(ids or dataset.ids)
    note = left_out_note(dataset, settings)
    if note:
        say(note)
    chosen_engine = choose_engine(
        engine,
        workers=workers,
        scheduler=scheduler,
        recordings=len(wanted),
        detects=settings.detector is not None,
    )
    with resumable_progress(len(wanted)) as progress:
        run = make_run(
            name,
            dataset,
            settings,
            store=store,
            recordings=wanted,
            engine=chosen_engine,
            progress=progress,
            is_kept=is_kept,
        )
    write_estimates(run.table, out)
    complain_of(_failures(run), others_in=str(out))
    say(f"{out}: {_counts(run)}")
    if is_kept:
        say(f"Run: {run.name}")


def list_runs(root: Root, *, as_json: AsJson = False) -> None:
    """List the runs on a dataset, newest first."""
    import pandas as pd

    from corsmal import runs
    from corsmal.dataset import open_dataset
    from corsmal.store import Store

    found = [
        {"name": run.name, "note": run.note, "archived": run.is_archived, **run.facts()}
        for run in runs.list_runs(store=Store(), dataset=open_dataset(root).root)
    ]
    columns = ["name", "recordings", "parameters", "created", "note"]
    if as_json:
        typer.echo(json.dumps(found, indent=1))
    else:
        typer.echo(pd.DataFrame(found)[columns].to_string(index=False) if found else "There are no runs.")


def show(root: Root, name: Name, *, as_json: AsJson = False) -> None:
    """Show what a run was made with, and its progress."""
    _, run = open_run(root, name)
    files = {
        f"{file.kind} weights": str(file.path) for file in (run.settings.filling, run.settings.mass) if file is not None
    }
    label = {"name": run.name, "id": run.short_id, "note": run.note}
    facts = {**label, **run.facts(), **files, "estimates": _counts(run)}
    if as_json:
        typer.echo(json.dumps(facts, indent=1))
    else:
        typer.echo("\n".join(f"{fact}: {value}" for fact, value in facts.items()))


def delete(root: Root, name: Name) -> None:
    """Delete a run; within 30 days `runs restore` brings it back. The estimates of its recordings stay."""
    from corsmal import runs
    from corsmal.store import Store

    _, run = open_run(root, name)
    runs.delete_run(run, store=Store())


def export(
    root: Root,
    name: Name,
    out: Annotated[Path, typer.Argument(metavar="OUT", help="File to write: .csv, .json or .parquet.")],
) -> None:
    """Write a run's estimates; `submit` writes the challenge's file."""
    from corsmal.evaluation import write_estimates

    _, run = open_run(root, name)
    write_estimates(run.table, out)
    say(f"{out}: {_counts(run)}")


def submit(
    root: Root,
    estimates: Annotated[str, typer.Argument(metavar="NAME", help="Name of a run, or a table that `estimate` wrote.")],
    out: Annotated[Path, typer.Argument(metavar="OUT", help="File to write.")] = Path("submission.csv"),
) -> None:
    """Write the challenge's submission file, a row for every recording of a dataset."""
    from corsmal.dataset import open_dataset
    from corsmal.evaluation import read_estimates, submission_table, write_submission
    from corsmal.evaluation.foreign import ASSUMED

    is_table = Path(estimates).suffix.lower() in TABLE_ENDINGS
    table = read_estimates(estimates) if is_table else open_run(root, estimates)[1].table
    for note in table.attrs.get(ASSUMED, ()):
        say(note)
    write_submission(submission_table(table, recordings=open_dataset(root).ids), out)
    say(f"Submission: {out}")


def open_run(root: Path, name: str) -> "tuple[Dataset, Run]":
    """A dataset and the run of a name on it.

    Raises:
        NotFoundError: there is no such run.
    """
    from corsmal import runs
    from corsmal.dataset import open_dataset
    from corsmal.store import Store

    dataset, store = open_dataset(root), Store()
    run = runs.load_run(name, dataset=dataset.root, store=store)
    if run is None:
        names = [found.name for found in runs.list_runs(store=store, dataset=dataset.root)]
        raise NotFoundError(f"there is no run {name!r} on {dataset.root}; runs: {', '.join(names) or 'none'}")
    return dataset, run


def _is_writable(store: "Store") -> bool:
    try:
        store.check_writable()
    except CorsmalError as error:
        complain("Results will not be stored", error)
        return False
    return True


def _failures(run: "Run") -> list[tuple[str, str]]:
    """Which recordings failed, with the first one's reason where they differ in nothing but the recording's name."""
    alike: dict[str, list[tuple[str, str]]] = {}
    for row in (row for row in run.rows if row["status"] == "failed"):
        name, reason = row["recording_id"], row["notes"]
        alike.setdefault(reason.replace(name, ""), []).append((name, reason))
    found = [(*each[0], len(each) - 1) for each in alike.values()]
    return [(f"{name} and {others} more" if others else name, reason) for name, reason, others in found]


def _counts(run: "Run") -> str:
    counts = run.table["status"].value_counts()
    return ", ".join(f"{count} {status}" for status, count in counts.items()) or "no estimates yet"
