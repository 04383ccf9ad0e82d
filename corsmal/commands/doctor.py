"""``doctor``: what is missing or broken in a dataset, and whether this machine is ready for it."""

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

import typer

from corsmal.commands import Ids, Root, chosen
from corsmal.commands.engines import EngineName, Scheduler, Workers, choose_engine, run
from corsmal.errors import CorsmalError

if TYPE_CHECKING:
    from corsmal.dataset import Dataset, Recording
    from corsmal.engines.engine import Row
    from corsmal.store import Store

AGREES_MAX = 0.02
"""Share of the image width. Intact recordings of the demo reach 0.017; with exchanged cameras most have 0.03 to 0.3."""

SHOWN_MAX = 20


@dataclass
class _Report:
    """The lines to print, and the number of problems among them."""

    lines: list[str] = field(default_factory=list)
    problems: int = 0

    def note(self, sentence: str) -> None:
        self.lines.append(f"  {sentence}")

    def problem(self, sentence: str) -> None:
        self.problems += 1
        self.lines.append(f"! {sentence}")

    def problem_list(self, sentences: Sequence[str]) -> None:
        for sentence in sentences[:SHOWN_MAX]:
            self.problem(sentence)
        if len(sentences) > SHOWN_MAX:
            self.problems += len(sentences) - SHOWN_MAX
            self.lines.append(f"! … and {len(sentences) - SHOWN_MAX} more")


def doctor(
    root: Root,
    ids: Ids = None,
    *,
    engine: EngineName = "local",
    workers: Workers = None,
    scheduler: Scheduler = None,
) -> None:
    """Check a dataset's files, cameras and detections, and the networks and the cache on this machine.

    Problems are marked with !; if there are any, the exit status is 1. Parts that the whole dataset lacks are listed
    without a mark: they may not have been downloaded.
    """
    from corsmal.dataset import open_dataset
    from corsmal.stages.examination import ExamineTask
    from corsmal.store import Store

    dataset, store, report = open_dataset(root), Store(), _Report()
    recordings = chosen(dataset, ids)
    chosen_engine = choose_engine(engine, workers=workers, scheduler=scheduler, recordings=len(recordings))
    rows = run(ExamineTask(store.root.resolve()), recordings, chosen_engine)
    _on_completeness(report, dataset, recordings)
    _on_files(report, rows)
    _on_agreement(report, rows)
    _on_networks(report)
    _on_store(report, store)
    typer.echo("\n".join(report.lines))
    if report.problems:
        typer.echo(f"{report.problems} problem{'' if report.problems == 1 else 's'}")
        raise typer.Exit(1)
    typer.echo("no problems")


def _on_completeness(report: _Report, dataset: "Dataset", recordings: "Sequence[Recording]") -> None:
    report.note(f"{dataset.root}: {len(dataset)} recordings, {len(recordings)} checked")
    for sentence in dataset.problems:
        report.note(sentence)
    lacking: dict[str, list[str]] = {}
    for recording in recordings:
        for part in recording.missing:
            lacking.setdefault(part, []).append(recording.id)
    for part, names in lacking.items():
        is_whole_set = len(names) == len(recordings)
        (report.note if is_whole_set else report.problem)(f"{part} is missing in {_listed(names)}")


def _on_files(report: _Report, rows: "Iterable[Row]") -> None:
    broken = [
        f"{row['recording_id']}: {sentence}"
        for row in rows
        for sentence in row.get("broken") or filter(None, [row["notes"]])
    ]
    report.problem_list(broken)
    if not broken:
        report.note("every file can be read")


def _on_agreement(report: _Report, rows: "Iterable[Row]") -> None:
    errors = {row["recording_id"]: row["reprojection"] for row in rows if row.get("reprojection") is not None}
    if not errors:
        report.note("calibration and detections cannot be compared: no frame has a container and a camera in two views")
        return
    worst = sorted(errors, key=errors.__getitem__, reverse=True)
    report.note(
        f"calibration against detections, {len(errors)} recordings: the reprojected centroid misses the mask's by "
        f"{_percent(errors[worst[len(worst) // 2]])} of the image width (median; worst: {_percent(errors[worst[0]])})"
    )
    report.problem_list(
        [
            f"{name}: calibration and detections disagree ({_percent(errors[name])}): is one of another recording?"
            for name in worst
            if errors[name] > AGREES_MAX
        ]
    )


def _on_networks(report: _Report) -> None:
    import torch

    from corsmal.detection import SmallDetector
    from corsmal.detection.coco_weights import coco_weights_file
    from corsmal.filling import FillingPredictor
    from corsmal.mass import MassPredictor
    from corsmal.weights import Kind, find_weights

    coco = coco_weights_file()
    report.note(
        f"Mask R-CNN weights: {coco if coco.is_file() else f'not there yet; downloaded on first use to {coco}'}"
    )
    openers: dict[Kind, Callable[[Path], object]] = {
        "detector": lambda path: SmallDetector(path, device="cpu"),
        "filling": FillingPredictor,
        "mass": MassPredictor,
    }
    for kind, opened in openers.items():
        weights = find_weights(kind)
        try:
            opened(weights.path)
            report.note(f"{kind} weights ({weights.origin}): {weights.path}")
        except CorsmalError as error:
            report.problem(str(error))
    report.note(f"GPU: {torch.cuda.get_device_name() if torch.cuda.is_available() else 'none; the CPU is used'}")


def _on_store(report: _Report, store: "Store") -> None:
    report.note(f"results are stored in {store.root}")
    try:
        store.check_writable()
    except CorsmalError as error:
        report.problem(str(error))
    leftovers = store.leftovers()
    if leftovers:
        size_mb = sum(path.stat().st_size for path in leftovers) / 1e6
        report.note(
            f"{len(leftovers)} files there are unused ({size_mb:.1f} MB) and can be deleted, such as {leftovers[0]}"
        )


def _listed(names: list[str]) -> str:
    shown = ", ".join(names[:3])
    return f"{len(names)} recording{'' if len(names) == 1 else 's'}: {shown}{', …' if len(names) > 3 else ''}"


def _percent(share: float) -> str:
    return f"{100 * share:.2f} %" if math.isfinite(share) else "behind a camera"
