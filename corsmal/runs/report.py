"""The report of a run: what was tried, on what, with which result, and how sure that is."""

from collections.abc import Sequence
from dataclasses import replace
from datetime import date

import numpy as np
import pandas as pd

from corsmal.dataset import Dataset
from corsmal.evaluation import (
    challenge_scores,
    compare_runs,
    comparison_note,
    confusion_tables,
    leaderboard_with,
    submission_table,
)
from corsmal.evaluation.metrics import CLASS_NAMES
from corsmal.evaluation.protocols import Protocol
from corsmal.evaluation.published import SCORE_NAMES
from corsmal.evaluation.tables import AVERAGE
from corsmal.evaluation.typesetting import TITLES
from corsmal.figures.evaluation import comparison_figure, errors_figure
from corsmal.figures.heatmaps import confusion_figure
from corsmal.figures.pins import Pin
from corsmal.figures.report import Answers, Block, Chart, Pinned, Report, Section, Table, Table2, Text
from corsmal.figures.style import run_colour
from corsmal.quantities import BY_METRIC, QUANTITIES
from corsmal.runs.judged import RESAMPLES_SEED, JudgedRun
from corsmal.runs.report_appendix import appendix, recordings_notes, recordings_table
from corsmal.runs.report_words import answers, banner, tiles
from corsmal.runs.run import Run

ROWS_MAX = 100
"""Recordings that a report lists, the worst first."""


def run_report(
    run: Run,
    dataset: Dataset,
    *,
    protocol: Protocol = "held-out",
    without: tuple[str, ...] = (),
    against: Run | None = None,
    pins: Sequence[Pin] = (),
    title: str = "",
    author: str = "",
    made: date | None = None,
) -> Report:
    """The report of a run, for ``corsmal.figures.report.report_html``.

    Args:
        run: what is reported.
        dataset: that it was made on.
        protocol: which numbers of networks count.
        without: rows that raise one of these flags are left out, here and of the earlier run.
        against: an earlier run on the same recordings, to compare with.
        pins: views to show, in order.
        title: default: the run's and the dataset's name.
        author: who makes it; may be empty.
        made: the day; default: today.

    Raises:
        ArgumentError: the run has no recording with a truth and a known container, or the protocol is unknown.
    """
    judged = JudgedRun(run, dataset, protocol, without)
    sections = [
        _summary(judged),
        _table_2(judged),
        _errors(judged),
        _challenge(judged),
        *([] if against is None else [_comparison(judged, against)]),
        *([Section("Pinned views", [Pinned(pin) for pin in pins], starts_page=True)] if pins else []),
        _recordings(judged),
        appendix(judged, against=against),
    ]
    return Report(
        title=title or f"Containers and fillings estimated: run {run.name} on {dataset.name}",
        author=author,
        made=f"{made or date.today():%-d %B %Y}",
        banner=banner(judged),
        sections=sections,
    )


def _summary(judged: JudgedRun) -> Section:
    return Section("Summary", [Answers(answers(judged)), tiles(judged)])


def _table_2(judged: JudgedRun) -> Section:
    caption = (
        f"Table 2 of the paper for this run ({TITLES[judged.protocol].lower()}), in %. MPF1: mean over classes of the "
        "F1-score. MAPE: mean absolute percentage error. Brackets: 95 % bootstrap intervals over recordings. Average: "
        "over containers." + (" Bold: not worse than the paper." if judged.is_like_with_like else "")
    )
    notes = [comparison_note(judged.cells), *map(_sentence, judged.errors.attrs["notes"])]
    table = Table2(judged.cells, caption, judged.is_like_with_like)
    return Section("Results by container", [table, Text(list(dict.fromkeys(notes)))], starts_page=True)


def _errors(judged: JudgedRun) -> Section:
    errors, blocks = judged.errors, list[Block]()
    if any(errors[quantity.error_column].notna().any() for quantity in QUANTITIES if not quantity.is_class):
        height_px = 130 + 36 * errors["container"].nunique()
        caption = (
            "Signed errors of the estimates, in % of the truth, by container; right of zero: too large. A point is a "
            "recording; a box, from five recordings on, holds the middle half."
        )
        blocks.append(Chart(errors_figure(errors, colour=run_colour(judged.run.preset)), caption, height_px))
    for name in CLASS_NAMES:
        tables = {kind: table for kind, table in confusion_tables(errors, name).items() if table.to_numpy().any()}
        if tables:
            label = name.replace("_", " ").capitalize()
            caption = f"{label} by kind of container (Fig. 3 of the paper): rows are true, columns predicted classes."
            blocks.append(Chart(confusion_figure(tables), caption, 330))
    return Section("Where the errors are", blocks or [Text(["No estimate can be compared with the annotation."])])


def _challenge(judged: JudgedRun) -> Section:
    """The leaderboard where the recordings are the teams' own, else the scores apart from it."""
    found = judged.split
    submission = submission_table(judged.table)
    scores = challenge_scores(judged.dataset.table, submission, split=found.split, absent="skip", errors=judged.errors)
    if found.split in ("public", "private") and scores.attrs["is_whole"]:
        table = leaderboard_with(scores, split=found.split, name=f"{judged.run.name} (this run)")
        order = ["team", "overall_without_simulator", *SCORE_NAMES.values()]
        caption = "The challenge's leaderboard, in %, with this run; scores that need the simulator are left out."
        return Section("CORSMAL Challenge", [Table(table[order], caption), Text([str(found)])])
    names = {**SCORE_NAMES, "overall": "overall", "JFTL": "JFTL", "CMD": "CMD"}
    row = {names[score].replace("_", " "): [float(scores[score])] for score in names if score in scores.index}
    caption = (
        f"The challenge's scores, in %, over {_counted(scores.attrs['scored'])}; a task without estimates scores 0. "
        "Without a simulator the best overall score is 75. JFTL: joint filling type and level. CMD: container capacity "
        f"and dimensions. {found} The teams of the leaderboard were scored on other recordings, so this run is not "
        "ranked among them."
    )
    return Section("CORSMAL Challenge", [Table(pd.DataFrame(row), caption)])


def _comparison(judged: JudgedRun, against: Run) -> Section:
    first = replace(judged, run=against)
    table = compare_runs(first.errors, judged.errors, rng=np.random.default_rng(RESAMPLES_SEED))
    averages = table[table["container"] == AVERAGE].assign(label=lambda rows: rows["metric"].map(_labels()))
    caption = (
        f"Averages over containers of run {judged.run.name} (second) minus run {against.name} (first), with 95 % "
        "bootstrap intervals of the paired difference. MAPE: left of zero is better; MPF1 (filling): right of zero is "
        "better. There is no interval where a container has one recording: whether such a difference means anything "
        "cannot be told."
    )
    shown = pd.DataFrame(
        {
            "metric": averages["label"],
            f"run {against.name} (%)": averages["first"],
            f"run {judged.run.name} (%)": averages["second"],
            "difference (points)": averages["difference"],
            "95 % interval": [
                _interval(low, high) for low, high in zip(averages["low"], averages["high"], strict=True)
            ],
            "verdict": averages["verdict"].where(averages["low"].notna(), "no interval"),
            "recordings": averages["recordings"],
        }
    )
    blocks: list[Block] = [Chart(comparison_figure(averages, label="label"), caption, 380), Table(shown)]
    return Section(f"Run {judged.run.name} against run {against.name}", blocks)


def _recordings(judged: JudgedRun) -> Section:
    table = recordings_table(judged.run, judged.errors)
    sentences = [
        "Estimates with their errors in % of the truth; failed recordings first, then by error of the capacity."
    ]
    if len(table) > ROWS_MAX:
        sentences.append(f"The first {ROWS_MAX} of {len(table)}. The command “runs export” of the appendix writes all.")
    return Section("Recordings", [Text(sentences), Table(table.head(ROWS_MAX)), Text(recordings_notes(judged.errors))])


def _labels() -> dict[str, str]:
    return {
        metric: f"{quantity.words.capitalize()}, {'MPF1' if quantity.is_class else 'MAPE'}"
        for metric, quantity in BY_METRIC.items()
    }


def _sentence(note: str) -> str:
    """A note on a table as a sentence of its own."""
    text = note.removeprefix("estimates: ").removeprefix("annotation: ")
    return f"{text[:1].upper()}{text[1:].rstrip('.')}."


def _counted(recordings: int) -> str:
    return f"{recordings} recording{'' if recordings == 1 else 's'}"


def _interval(low: float, high: float) -> str:
    return "" if pd.isna(low) else f"{low:+.1f} to {high:+.1f}".replace("-", "−")
