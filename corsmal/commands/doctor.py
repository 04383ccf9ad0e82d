"""``doctor``: what is missing or broken in a dataset, and whether this machine is ready for it."""

import json
from collections.abc import Callable
from dataclasses import dataclass, field
from itertools import groupby
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from corsmal.commands import Ids, Root, chosen
from corsmal.commands.engines import EngineName, Scheduler, Workers, choose_engine, run
from corsmal.errors import CorsmalError

if TYPE_CHECKING:
    from corsmal.dataset.findings import Finding, Severity
    from corsmal.store import Store
    from corsmal.weights import Kind

SHOWN_MAX = 20


@dataclass
class _Report:
    """The sentences to print, in their order, and what was found."""

    findings: "list[Finding]" = field(default_factory=list)

    def note(self, sentence: str, *, kind: str) -> None:
        self._add("note", sentence, kind)

    def problem(self, sentence: str, *, kind: str) -> None:
        self._add("error", sentence, kind)

    def _add(self, severity: "Severity", sentence: str, kind: str) -> None:
        from corsmal.dataset.findings import Finding

        self.findings.append(Finding(severity, kind, sentence))

    @property
    def problems(self) -> int:
        return sum(finding.is_problem for finding in self.findings)

    def lines(self) -> list[str]:
        """A line per finding, no more than ``SHOWN_MAX`` of a kind and severity that stand together."""
        lines = []
        for (severity, _), group in groupby(self.findings, key=lambda finding: (finding.severity, finding.kind)):
            found = list(group)
            mark = "  " if severity == "note" else f"! {severity}: "
            lines += [f"{mark}{finding}" for finding in found[:SHOWN_MAX]]
            if len(found) > SHOWN_MAX:
                lines.append(f"{mark}… and {len(found) - SHOWN_MAX} more, which --json lists")
        return lines


def doctor(
    root: Root,
    ids: Ids = None,
    *,
    deep: Annotated[
        bool,
        typer.Option(
            "--deep",
            help="Read sounds whole, decode videos at both ends, look for offsets between views and load the networks; "
            "default: headers.",
        ),
    ] = False,
    as_json: Annotated[bool, typer.Option("--json", help="Print a JSON list of findings.")] = False,
    engine: EngineName = "local",
    workers: Workers = None,
    scheduler: Scheduler = None,
) -> None:
    """Check a dataset's files, cameras and detections, and the networks and the cache on this machine.

    Problems are marked with !, and with how bad they are: what an error names cannot be used; a warning is about
    what is left out, or used otherwise than it may be meant. If there are any, the exit status is 1. Parts that the
    whole dataset lacks are listed without a mark: they may not have been downloaded.
    """
    from corsmal.dataset import open_dataset
    from corsmal.stages.checkup import agreement, examined_findings, set_findings
    from corsmal.stages.examination import ExamineTask
    from corsmal.store import Store

    dataset, store, report = open_dataset(root), Store(), _Report()
    recordings = chosen(dataset, ids)
    chosen_engine = choose_engine(engine, workers=workers, scheduler=scheduler, recordings=len(recordings))
    rows = run(ExamineTask(store.root.resolve(), deep=deep), recordings, chosen_engine)
    report.note(f"{dataset.root}: {len(dataset)} recordings, {len(recordings)} checked", kind="dataset")
    report.findings += set_findings(dataset, recordings)
    found = examined_findings(rows, root=dataset.root)
    report.findings += found
    if not any(finding.severity == "error" for finding in found):
        report.note("every file can be read", kind="dataset")
    report.note(agreement(rows), kind="agreement")
    _on_networks(report, deep=deep)
    _on_store(report, store)
    if as_json:
        typer.echo(json.dumps([finding.to_json() for finding in report.findings], indent=1, ensure_ascii=False))
    else:
        problems = (
            f"{report.problems} problem{'' if report.problems == 1 else 's'}" if report.problems else "no problems"
        )
        typer.echo("\n".join([*report.lines(), problems]))
    if report.problems:
        raise typer.Exit(1)


def _on_networks(report: _Report, *, deep: bool) -> None:
    from corsmal.detection.coco_weights import coco_weights_file
    from corsmal.weights import Kind, check_network_file, find_weights

    coco = coco_weights_file()
    report.note(
        f"Mask R-CNN weights: {coco if coco.is_file() else f'not there yet; downloaded on first use to {coco}'}",
        kind="network",
    )
    kinds: tuple[Kind, ...] = ("detector", "filling", "mass")
    openers = _openers() if deep else dict.fromkeys(kinds, check_network_file)
    for kind in kinds:
        weights = find_weights(kind)
        try:
            openers[kind](weights.path, kind)
            report.note(f"{kind} weights ({weights.origin}): {weights.path}", kind="network")
        except CorsmalError as error:
            report.problem(str(error), kind="network")
    report.note(f"GPU: {_gpu()}", kind="network")


def _openers() -> "dict[Kind, Callable[[Path, Kind], object]]":
    """What loads each network, which takes seconds and half a gigabyte: PyTorch."""
    from corsmal.detection import SmallDetector
    from corsmal.filling import open_filling
    from corsmal.mass import MassPredictor

    return {
        "detector": lambda path, _: SmallDetector(path, device="cpu"),
        "filling": lambda path, _: open_filling(path),
        "mass": lambda path, _: MassPredictor(path),
    }


def _gpu() -> str:
    from corsmal.engines.local import has_gpu

    if not has_gpu():
        return "none; the CPU is used"
    import torch

    return torch.cuda.get_device_name()


def _on_store(report: _Report, store: "Store") -> None:
    report.note(f"results are stored in {store.root}", kind="cache")
    try:
        store.check_writable()
    except CorsmalError as error:
        report.problem(str(error), kind="cache")
    leftovers = store.leftovers()
    if leftovers:
        size_mb = sum(path.lstat().st_size for path in leftovers) / 1e6
        report.note(
            f"{len(leftovers)} files there are unused ({size_mb:.1f} MB) and can be deleted, such as {leftovers[0]}",
            kind="cache",
        )
