"""Commands that measure how good a stage is, and the challenge's file."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from corsmal.commands import FeatureFolder, Root, RunFolder, demo_detector, progress_bar, say

if TYPE_CHECKING:
    import pandas as pd

    from corsmal.evaluation.exporting import TableFormat

app = typer.Typer(no_args_is_help=True, help="Measure how good a stage is.")

Estimates = Annotated[Path, typer.Argument(help="The table that `estimate` wrote.")]


@app.command("detector")
def detector(
    weights: Annotated[
        Path | None, typer.Argument(help="Weights; default: CORSMAL_DETECTOR_WEIGHTS, else the bundled ones.")
    ] = None,
    *,
    frames: Annotated[int, typer.Option(help="How many frames of the demo.", min=1)] = 200,
) -> None:
    """Measure the demo's detector on frames of the demo that it has not seen."""
    from corsmal.synthetic.training.detector_report import detector_report, detector_table  # noqa: PLC0415 - load what is needed

    with progress_bar("frames") as progress:
        report = detector_report(demo_detector(weights), frames=frames, progress=progress)
    typer.echo(detector_table(report).round(3).to_string())
    worst = report[report["asked"]].fillna({"iou": 0.0}).sort_values("iou").head(10)
    typer.echo(f"\nThe worst frames:\n{worst.to_string(index=False)}")


@app.command("filling")
def filling(
    root: Root,
    folder: RunFolder,
    *,
    features: FeatureFolder = None,
    preset: Annotated[Literal["paper", "tuned"], typer.Option(help="What is trained, and how.")] = "paper",
    folds: Annotated[
        Literal["spread", "containers"], typer.Option(help="spread: seven, the paper's; containers: 147, 258, 369.")
    ] = "spread",
    seeds: Annotated[int, typer.Option(help="How many cross-validations.", min=1)] = 1,
) -> None:
    """Cross-validate the network for filling type and level."""
    from corsmal.commands.filling import dataset_samples  # noqa: PLC0415
    from corsmal.dataset import open_dataset  # noqa: PLC0415
    from corsmal.evaluation import (  # noqa: PLC0415
        filling_confusion_tables,
        filling_container_table,
        pooled_table,
    )
    from corsmal.filling import FillingTraining, cross_validate, folds_by_container, spread_folds  # noqa: PLC0415

    settings = FillingTraining.of(preset)
    samples = dataset_samples(root, features)
    known = open_dataset(root).table.loc[[sample.recording_id for sample in samples]]
    split = spread_folds(known) if folds == "spread" else folds_by_container(known)
    with progress_bar("training, %") as progress:
        predictions = cross_validate(
            folder,
            samples,
            folds=split,
            preset=settings,
            seeds=range(seeds),
            progress=lambda share: progress(round(100 * share), 100),
        )
    show("Weighted F1 in %, all folds together", pooled_table(predictions))
    show("MPF1 in % by container", filling_container_table(predictions))
    for quantity in ("filling_level", "filling_type"):
        for kind, table in filling_confusion_tables(predictions, quantity).items():
            show(f"{quantity.replace('_', ' ')}, {kind}: rows are true, columns predicted", table)


@app.command("mass")
def mass(
    root: Root, weights: Annotated[Path | None, typer.Argument(help="Weights; default: the demo's.")] = None
) -> None:
    """Measure the network for the container's mass on a dataset whose containers were detected."""
    from corsmal.dataset import open_dataset  # noqa: PLC0415
    from corsmal.mass import MassPredictor, judge_mass, mass_table  # noqa: PLC0415
    from corsmal.stages.mass_rows import mass_rows  # noqa: PLC0415
    from corsmal.store import Store  # noqa: PLC0415
    from corsmal.weights import find_weights  # noqa: PLC0415

    predictor = MassPredictor(find_weights("mass", weights).path)
    with progress_bar("recordings") as progress:
        rows = list(mass_rows(list(open_dataset(root)), store=Store(), progress=progress))
    judged = judge_mass(predictor, rows)
    show("Mass: MAPE in %, challenge score s7 in %", mass_table(judged))
    guess = sum(row.mass_g for row in rows) / max(1, len(rows))
    show(f"The same for always {guess:.1f} g, the mean", mass_table(judged.assign(mass_g=guess)))


@app.command("estimates")
def estimates(
    root: Root,
    table: Estimates,
    *,
    out: Annotated[Path | None, typer.Option(help="Table 2 as .csv, .tex or .html.")] = None,
) -> None:
    """Compare estimates with a dataset's annotation: the paper's Table 2 and the challenge's scores."""
    from corsmal.dataset import open_dataset  # noqa: PLC0415
    from corsmal.evaluation import (  # noqa: PLC0415
        challenge_scores,
        confusion_tables,
        container_table,
        error_table,
        export_table,
        read_estimates,
        submission_table,
    )
    from corsmal.files import writing  # noqa: PLC0415

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
    from corsmal.dataset import open_dataset  # noqa: PLC0415
    from corsmal.evaluation import read_estimates, submission_table, write_submission  # noqa: PLC0415

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
    from corsmal.dataset import open_dataset  # noqa: PLC0415
    from corsmal.figures.scores import score_error_figure  # noqa: PLC0415
    from corsmal.files import writing  # noqa: PLC0415
    from corsmal.parameters import SHAPE_PRESETS  # noqa: PLC0415
    from corsmal.runs.ablation import ablation_errors, ablation_table  # noqa: PLC0415
    from corsmal.runs.budget import budget_table, geometry_budget, score_against_error  # noqa: PLC0415
    from corsmal.stages.detections import load_detections  # noqa: PLC0415
    from corsmal.store import Store  # noqa: PLC0415

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


def show(title: str, table: "pd.DataFrame") -> None:
    """Print a table with its title."""
    typer.echo(f"{title}\n{table.round(1).to_string()}\n")
