"""The paper's evaluation from a dataset to its tables, step by step; killed anywhere, it is resumed."""

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from datetime import date
from pathlib import Path

import pandas as pd

from corsmal.dataset import Dataset, TrainedOn, open_dataset
from corsmal.engines.engine import Engine, in_turn, never
from corsmal.errors import ArgumentError, FileError
from corsmal.files import writing
from corsmal.runs.reproduction_files import write_results
from corsmal.runs.reproduction_settings import PlannedStep, ReproductionSettings, check_features, is_filmed, plan
from corsmal.runs.reproduction_steps import Work
from corsmal.store import Store, digest

CLAIM = "reproduction.txt"
"""The file in the output folder that says which dataset the folder belongs to."""


@dataclass(frozen=True)
class StepProgress:
    """How far a reproduction is.

    Args:
        step: name of the current step.
        share: of the whole work, 0..1.
        left_s: estimated seconds left.
    """

    step: str
    share: float
    left_s: float


@dataclass(frozen=True, eq=False)
class Reproduction:
    """The results.

    Args:
        table2: the paper's Table 2 cell by cell, see ``cell_table``.
        rows: the estimates table behind it, a row per annotated recording.
        report: the HTML report.
        out: the folder with all files.
        notes: sentences on what was missing or left out.
    """

    table2: pd.DataFrame
    rows: pd.DataFrame
    report: Path
    out: Path
    notes: tuple[str, ...]


def reproduce(
    root: str | Path,
    *,
    out: str | Path,
    settings: ReproductionSettings | None = None,
    tests: Sequence[str | Path] = (),
    store: Store | None = None,
    engine: Engine = in_turn,
    progress: Callable[[StepProgress], None] | None = None,
    cancelled: Callable[[], bool] = never,
) -> Reproduction:
    """Repeat the paper's evaluation on a dataset (paper 4).

    Detections where there are none, geometry of every recording, filling and mass by cross-validation, final networks
    on all recordings, Table 2, Fig. 3, and for every test set Table 3, its row of the leaderboard and its submission.
    Every step's result is kept under what it depends on: a second call computes nothing, a changed setting repeats
    only what depends on it, and a call that was killed is resumed.

    Args:
        root: the training set's folder; its annotation must name containers and fillings.
        out: folder for networks, tables and the report.
        settings: the settings; default: the held-out protocol with the paper's method.
        tests: folders of test sets, with or without annotation.
        store: keeps detections, estimates and features; default: the library's own.
        engine: does the recordings' work.
        progress: called with the step, the share and the time left.
        cancelled: true ends the work between two recordings or networks; what was done is kept.

    Returns:
        The results.

    Raises:
        ArgumentError: the dataset has no annotated recording, a test set is named twice or holds recordings of the
            training set.
        FileError: a folder cannot be read or written, or ``out`` holds a reproduction of another dataset.
        CancelledError: ``cancelled`` ended it.
    """
    settings, store, out = settings or ReproductionSettings(), store or Store(), Path(out)
    dataset, *test_sets = (open_dataset(folder).matched(settings.matching) for folder in (root, *tests))
    _check(dataset, settings)
    _refuse_training_recordings(dataset, test_sets)
    began = _claim(out, dataset)
    steps = plan(dataset, settings, test_sets)
    clock = _Clock(steps, progress)
    work = Work(dataset, settings, store=store, engine=engine, out=out, report=clock.at, cancelled=cancelled)
    results = work.results(test_sets)
    clock.at("tables", 0.0)
    cells, report = write_results(results, settings, out, began=began)
    clock.at("tables", 1.0)
    return Reproduction(cells, results.rows, report, out, results.notes)


class _Clock:
    """The time left: the plan's, corrected by what the steps so far have taken.

    Args:
        steps: the plan.
        progress: gets every change.
    """

    def __init__(self, steps: Sequence[PlannedStep], progress: Callable[[StepProgress], None] | None) -> None:
        self._steps, self._progress = {step.name: max(step.seconds, 0.1) for step in steps}, progress
        self._began_s = time.monotonic()
        self._order = list(self._steps)
        self._current = ""
        self._entered_s = self._began_s

    def at(self, name: str, share: float) -> None:
        """A step is done to a share of 0..1."""
        if self._progress is None:
            return
        now = time.monotonic()
        if name != self._current:
            self._current, self._entered_s = name, now
        place = self._order.index(name)
        share = min(max(share, 0.0), 1.0)
        planned, total = self._steps[name], sum(self._steps.values())
        before = sum(self._steps[each] for each in self._order[:place])
        after = total - before - planned
        spent = now - self._entered_s
        # the rate of the step itself is known once a part of it is done; the later steps follow the plan
        own_left = spent * (1 - share) / share if share > 0.02 else planned * (1 - share)
        self._progress(StepProgress(name, (before + share * planned) / total, max(0.0, own_left + after)))


def _check(dataset: Dataset, settings: ReproductionSettings) -> None:
    check_features(settings.features, settings.sight)
    table = dataset.table
    if not table["container_id"].notna().any():
        raise ArgumentError(
            f"{dataset.root} has no annotation that names containers: there is nothing to train on or judge"
        )


def _refuse_training_recordings(dataset: Dataset, tests: Sequence[Dataset]) -> None:
    trained = TrainedOn.of(dataset)
    for test in tests:
        seen = [recording.id for recording in test if is_filmed(recording) and trained.has_seen(recording)]
        if seen:
            raise ArgumentError(
                f"the test set {test.root} holds {len(seen)} recordings of the training set, such as {seen[0]}; a "
                "network would be judged on what it was trained on"
            )


def _claim(out: Path, dataset: Dataset) -> date:
    """Write down whose reproduction the folder holds, or check that it is this dataset's; the day it was begun."""
    path = out / CLAIM
    annotated = dataset.table.dropna(subset=["container_id"]).drop(columns="missing")  # files may come later
    identity = f"{dataset.name} {digest('annotation', annotated.to_csv())}\n"
    try:
        found = path.read_text(encoding="utf-8")
    except (FileNotFoundError, NotADirectoryError):
        with writing(path, advice="choose another folder") as part:
            part.write_text(identity, encoding="utf-8")
        found = identity
    except (OSError, ValueError) as error:
        raise FileError(path, "cannot be read; choose another folder") from error
    if found != identity:
        name = next(iter(found.split()), "unknown")
        raise FileError(out, f"holds the reproduction of another dataset ({name}); choose another folder")
    return date.fromtimestamp(path.stat().st_mtime)
