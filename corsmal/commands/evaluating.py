"""``evaluate estimates``, ``submit``, ``budget`` and ``train wall``: what is done with estimates."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from corsmal.commands import Root, demo_detector, progress_bar, say, show

if TYPE_CHECKING:
    from corsmal.evaluation.exporting import TableFormat

Estimates = Annotated[Path, typer.Argument(help="The table that `estimate` wrote.")]


def estimates(
    root: Root,
    table: Estimates,
    *,
    out: Annotated[Path | None, typer.Option(help="Table 2 as .csv, .tex or .html.")] = None,
) -> None:
    """Compare estimates with a dataset's annotation: the paper's Table 2 and the challenge's scores."""
    from corsmal.dataset import open_dataset
    from corsmal.evaluation import (
        challenge_scores,
        confusion_tables,
        container_table,
        error_table,
        export_table,
        read_estimates,
        submission_table,
    )
    from corsmal.files import writing

    annotation, found = open_dataset(root).table, read_estimates(table)
    errors = error_table(found, annotation)
    for note in errors.attrs.get("notes", ()):
        say(note)
    by_container = container_table(errors)
    show("By container: MPF1 and MAPE in %", by_container)
    for quantity in ("filling_level", "filling_type"):
        for kind, counts in confusion_tables(errors, quantity).items():
            if counts.to_numpy().sum():
                show(f"{quantity.replace('_', ' ')}, {kind}: rows are true, columns estimated", counts)
    scores = challenge_scores(annotation, submission_table(found), split="other")
    show("The challenge's scores in %", scores.rename("score").to_frame())
    if out is not None:
        formats: dict[str, TableFormat] = {".csv": "csv", ".tex": "latex", ".html": "html"}
        if out.suffix not in formats:
            raise typer.BadParameter(f"the name must end in {', '.join(formats)}", param_hint="--out")
        with writing(out, advice="choose another file") as part:
            part.write_text(export_table(by_container, table_format=formats[out.suffix]), encoding="utf-8")


def submit(
    root: Root,
    table: Estimates,
    out: Annotated[Path, typer.Argument(help="The challenge's file.")] = Path("submission.csv"),
) -> None:
    """Write the challenge's submission file, a row for every recording of a dataset."""
    from corsmal.dataset import open_dataset
    from corsmal.evaluation import read_estimates, submission_table, write_submission

    write_submission(submission_table(read_estimates(table), recordings=open_dataset(root).table.index), out)
    say(f"Submission: {out}")


def budget(
    root: Root,
    scatter: Annotated[Path | None, typer.Option(help="HTML file for View Scores against errors.")] = None,
    *,
    preset: Annotated[str, typer.Option(help="Parameters of the fit: paper, lode or tuned.")] = "paper",
    ablation: Annotated[bool, typer.Option("--ablation", help="All presets, tuned less each of its parts.")] = False,
) -> None:
    """Show which stage of the geometry loses what, on a demo whose containers were detected."""
    from corsmal.dataset import open_dataset
    from corsmal.figures.scores import score_error_figure
    from corsmal.files import writing
    from corsmal.parameters import SHAPE_PRESETS
    from corsmal.runs.ablation import ablation_errors, ablation_table
    from corsmal.runs.budget import budget_table, geometry_budget, score_against_error
    from corsmal.stages.detections import load_detections
    from corsmal.store import Store

    if preset not in SHAPE_PRESETS:
        raise typer.BadParameter(f"there are {', '.join(SHAPE_PRESETS)}", param_hint="--preset")
    dataset, store, shape = open_dataset(root), Store(), SHAPE_PRESETS[preset]
    with progress_bar("recordings") as progress:
        if ablation:
            errors = ablation_errors(
                dataset, lambda recording: load_detections(recording, store=store).views, progress=progress
            )
            show("MAPE in %, and % of the truths inside their 90 % intervals", ablation_table(errors))
            return
        rows = geometry_budget(
            dataset,
            lambda recording: load_detections(recording, store=store).views,
            detector=demo_detector(),
            shape=shape,
            progress=progress,
        )
    show(f"MAPE in %, preset {preset}", budget_table(rows))
    scores = score_against_error(dataset, shape=shape)
    correlation = scores["rank"].corr(scores["error_rank"])
    typer.echo(f"View Score against error of a frame, rank correlation within recordings: {correlation:+.2f}")
    if scatter is not None:
        with writing(scatter, advice="choose another file") as part:
            score_error_figure(scores).write_html(part, include_plotlyjs=True, config={"showSendToCloud": False})


def wall(root: Root) -> None:
    """Learn the wall thickness that the preset tuned subtracts from round containers, from annotated capacities."""
    from corsmal.dataset import open_dataset
    from corsmal.runs.wall import learn_wall
    from corsmal.store import Store

    with progress_bar("recordings") as progress:
        learnt = learn_wall(list(open_dataset(root)), store=Store(), progress=progress)
    show(
        "Mean capacity error in % by container: without a wall, with the preset's, with that of the other containers",
        learnt.table.set_index("container"),
    )
    say(f"Wall: {learnt.wall_mm:.1f} mm. To use it: estimate --preset tuned --wall {learnt.wall_mm:.1f}")
