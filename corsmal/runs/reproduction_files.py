"""The files of a reproduction: Table 2, Fig. 3, Table 3, the leaderboard's row, submissions and the report."""

from collections.abc import Mapping, Sequence
from datetime import date
from pathlib import Path

import numpy as np
import pandas as pd

from corsmal.dataset.annotation import Kind
from corsmal.errors import ArgumentError
from corsmal.evaluation import (
    cell_table,
    challenge_scores,
    confusion_tables,
    error_table,
    filling_confusion_tables,
    find_split,
    leaderboard_row,
    leaderboard_with,
    submission_table,
    typeset_table_2,
    write_estimates,
    write_submission,
)
from corsmal.evaluation.exporting import TableFormat
from corsmal.figures.heatmaps import confusion_figure
from corsmal.figures.report import Banner, Chart, Report, Section, Table, Table2, Text, report_html
from corsmal.files import writing
from corsmal.runs.judged import RESAMPLES_SEED
from corsmal.runs.report_appendix import parameters_table
from corsmal.runs.reproduction_kept import (
    DISK_ADVICE,
    ESTIMATES,
    REPORT,
    Confusions,
    results_folder,
    write_summary,
)
from corsmal.runs.reproduction_results import Results, TestResult
from corsmal.runs.reproduction_settings import ReproductionSettings, features_text
from corsmal.stages.settings import is_synthetic

FORMATS: dict[str, TableFormat] = {".csv": "csv", ".tex": "latex", ".md": "markdown", ".html": "html"}
LABELS = {"filling_level": "Filling level", "filling_type": "Filling type"}


def write_results(
    results: Results, settings: ReproductionSettings, out: Path, *, began: date
) -> tuple[pd.DataFrame, Path]:
    """Write everything that a reproduction leaves, in a folder of its own, see ``results_folder``.

    Args:
        results: what the steps found.
        settings: of the reproduction.
        out: the reproduction's folder.
        began: the day of the report: a reproduction that is resumed on another day leaves the same bytes.

    Returns:
        Table 2 cell by cell, and the path of the report.

    Raises:
        ArgumentError: no recording's container is known.
        FileError: a file cannot be written.
    """
    folder = results_folder(out, settings)
    annotation = results.dataset.table
    errors = error_table(results.rows, annotation, protocol=settings.protocol)
    cells = cell_table(errors, rng=np.random.default_rng(RESAMPLES_SEED))
    split = find_split(annotation, name=results.dataset.name)
    notes = tuple(dict.fromkeys((settings.sentence(), *results.notes, *errors.attrs["notes"])))
    for ending, table_format in FORMATS.items():
        text = typeset_table_2(cells, table_format=table_format, notes=notes, is_like_with_like=split.split == "train")
        _write(folder / f"table2{ending}", text)
    write_estimates(results.rows, folder / ESTIMATES)
    scores = {test.name: _test_table(test, folder) for test in results.tests}
    confusions = {quantity: _confusions(results, errors, quantity) for quantity in LABELS}
    report = folder / REPORT
    found = _report(results, settings, cells=cells, confusions=confusions, scores=scores, notes=notes, began=began)
    _write(report, report_html(found))
    write_summary(folder, settings, confusions=confusions, scores=scores, notes=notes)
    return cells, report


def _confusions(results: Results, errors: pd.DataFrame, quantity: str) -> dict[Kind, pd.DataFrame]:
    if results.rounds is not None:
        return filling_confusion_tables(results.rounds, quantity)
    return confusion_tables(errors, quantity)


def _report(
    results: Results,
    settings: ReproductionSettings,
    *,
    cells: pd.DataFrame,
    confusions: Confusions,
    scores: Mapping[str, pd.DataFrame],
    notes: Sequence[str],
    began: date,
) -> Report:
    """The report; its few figures are drawn by the reader's browser, so that none is needed here."""
    split = find_split(results.dataset.table, name=results.dataset.name)
    caption = "Table 2, in %: MPF1 and MAPE with 95 % bootstrap intervals over recordings, beside the paper's."
    shown = {
        quantity: {kind: table for kind, table in by_kind.items() if table.to_numpy().any()}
        for quantity, by_kind in confusions.items()
    }
    figures = [
        Chart(
            confusion_figure(by_kind),
            f"Fig. 3, {LABELS[quantity].lower()}: rows are true, columns predicted; {_judged(results)}.",
            330,
        )
        for quantity, by_kind in shown.items()
        if by_kind
    ]
    tests = [_test_section(name, table) for name, table in scores.items()]
    own = pd.DataFrame([{"setting": name, "value": value} for name, value in _settings_words(settings).items()])
    synthetic = is_synthetic(results.dataset)
    return Report(
        title=f"Reproduction of the paper's evaluation on {results.dataset.name}",
        author="",
        made=f"{began:%-d %B %Y}",
        banner=Banner("Synthetic data" if synthetic else "Real recordings", settings.sentence(), synthetic),
        sections=[
            Section("Table 2", [Table2(cells, caption, split.split == "train"), *_seeds(results, settings)]),
            *([Section("Fig. 3", figures)] if figures else []),
            *tests,
            Section("Notes", [Text([*notes, str(split)])]),
            Section(
                "Parameters",
                [Table(own), Table(parameters_table({"value": settings.shape}), "Parameters of the fit")],
                starts_page=True,
            ),
        ],
    )


def _judged(results: Results) -> str:
    return "all recordings" if results.rounds is None else "the round whose kept epoch has the least loss"


def _seeds(results: Results, settings: ReproductionSettings) -> list[Table]:
    """Table 2's averages by seed, where there are several."""
    if not results.more_seeds:
        return []
    rows = []
    for seed, table in enumerate((results.rows, *results.more_seeds)):
        errors = error_table(table, results.dataset.table, protocol=settings.protocol)
        cells = cell_table(errors, rng=np.random.default_rng(RESAMPLES_SEED))
        averages = cells[cells["container_id"].isna()]
        rows.append({"seed": str(seed)} | dict(zip(averages["metric"], averages["value"], strict=True)))
    table = pd.DataFrame(rows)
    numbers = table.drop(columns="seed")
    summary = pd.DataFrame([numbers.mean(), numbers.std()]).assign(seed=["mean", "standard deviation"])
    return [Table(pd.concat([table, summary], ignore_index=True), "Averages by seed")]


def _test_table(test: TestResult, folder: Path) -> pd.DataFrame:
    """The challenge's scores of a test set beside the published ones; its submission is written."""
    known = test.dataset.table
    submission = submission_table(test.rows, recordings=known.index)
    write_submission(submission, folder / f"submission_{test.name}.csv")
    split = find_split(known, name=test.dataset.name)
    try:
        scores = challenge_scores(known, submission, split=split.split)
    except ArgumentError as error:
        return pd.DataFrame({"note": [f"A submission was written; no scores: {error}"]})
    if scores.drop(["overall"]).isna().all():
        return pd.DataFrame({"note": ["A submission was written; without annotation there are no scores."]})
    if split.split in ("public", "private"):
        return leaderboard_with(scores, split=split.split, name="this program")
    return leaderboard_row(scores, name=f"this program; {split}")


def _test_section(name: str, table: pd.DataFrame) -> Section:
    """The scores of a test set; what is said about this program's row stands below the table."""
    if "team" not in table:
        return Section(f"Test set {name}", [Text(list(table["note"]))])
    teams = table["team"].str.partition("; ")
    known = table.assign(team=teams[0]).dropna(axis="columns", how="all")
    return Section(f"Test set {name}", [Table(known, "Scores in %"), Text(list(teams[2]))])


def _settings_words(settings: ReproductionSettings) -> dict[str, str]:
    """The settings of a reproduction as people read them."""
    detector = settings.detector
    return {
        "Protocol": settings.protocol,
        "Folds": settings.folds,
        "Cross-validations": str(settings.seeds),
        "Preset of the networks": settings.networks,
        "Features": features_text(settings, by=lambda folder: folder.name),
        "Detector": "none: existing detections are used" if detector is None else detector.method,
        "Views matched": str(settings.matching),
        "Training": "a few epochs only (quick)" if settings.is_quick else "in full",
    }


def _write(path: Path, text: str) -> None:
    with writing(path, advice=DISK_ADVICE) as part:
        part.write_text(text, encoding="utf-8")
