"""One run that is begun by command, resumed in the app and exported by command."""

import json
import os
import signal
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner

import corsmal.__main__ as cli
from corsmal.dataset import open_dataset
from corsmal.parameters import ShapeParameters
from corsmal.runs import load_run, make_run
from corsmal.stages.settings import default_settings
from corsmal.store import Store
from corsmal.ui import shared
from corsmal.ui.evaluation.downloads import estimates_file, submission_file
from corsmal.ui.evaluation.judged import Judged
from tests.app.driver import Visitor
from tests.engines.faulty import wait_for
from tests.networks import write_networks
from tests.tiny import write_tiny_dataset

REPOSITORY = Path(__file__).resolve().parents[2]
RECORDINGS = 30


@pytest.fixture(scope="module")
def root(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_tiny_dataset(tmp_path_factory.mktemp("many") / "train", recordings=RECORDINGS, frames=6)


@pytest.fixture(autouse=True)
def networks(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for kind, path in write_networks(tmp_path).items():
        monkeypatch.setenv(f"CORSMAL_{kind.upper()}_WEIGHTS", str(path))


def command(*arguments: object) -> None:
    result = CliRunner().invoke(cli.app, [str(argument) for argument in arguments], catch_exceptions=False)
    assert result.exit_code == 0, result.output


def test_begun_with_dask_stopped_resumed_in_the_app_and_exported_it_is_one_run(root: Path, tmp_path: Path) -> None:
    dataset, store = open_dataset(root), shared.store()
    arguments = ["estimate", root, "--run", "shared", "--engine", "dask", "--workers", "1"]
    begun = [sys.executable, "-m", "corsmal", *arguments, "--out", tmp_path / "unfinished.csv"]
    with subprocess.Popen(begun, cwd=REPOSITORY, env=os.environ, stderr=subprocess.DEVNULL) as process:
        wait_for(lambda: any(store.root.glob("estimates/*/*.json")))
        process.send_signal(signal.SIGINT)
    assert process.returncode == 130
    stopped = load_run("shared", dataset=dataset.root, store=store)
    assert stopped is not None
    assert stopped.engine == "Dask, processes: 1"
    assert len(stopped.rows) < RECORDINGS

    visitor = Visitor(root)
    visitor.test.switch_page("pages/evaluation.py").run()
    assert visitor.warnings == [
        f"**Partial results**: this run is incomplete, {len(stopped.rows)} of {RECORDINGS} recordings are estimated."
    ]
    visitor.press("Resume")
    wait_for(lambda: not any(job.active for job in shared.jobs()._jobs.values()), seconds=300)
    visitor.test.run()
    assert visitor.errors == visitor.warnings == visitor.crashes == []
    resumed = load_run("shared", dataset=dataset.root, store=store)
    assert resumed is not None
    assert (resumed.is_complete, resumed.created) == (True, stopped.created)
    assert resumed.engine != stopped.engine

    settings = default_settings(dataset, shape=ShapeParameters.paper())
    alone = make_run("alone", dataset, settings, store=Store(tmp_path / "other"))
    assert json.dumps(untimed(resumed.rows)) == json.dumps(untimed(alone.rows))

    judged = Judged(resumed, dataset, "held-out")
    for ending in ("csv", "json"):
        command("runs", "export", root, "shared", tmp_path / f"exported.{ending}")
    command("estimate", root, "--run", "shared", "--workers", "1", "--out", tmp_path / "again.csv")
    assert (tmp_path / "exported.csv").read_bytes() == (tmp_path / "again.csv").read_bytes() == estimates_file(judged)
    command("submit", root, "shared", tmp_path / "of_run.csv")
    command("submit", root, tmp_path / "exported.csv", tmp_path / "of_table.csv")
    submitted = submission_file(judged)
    assert (tmp_path / "of_run.csv").read_bytes() == (tmp_path / "of_table.csv").read_bytes() == submitted


def untimed(rows: Any) -> list[dict[str, Any]]:
    """Rows without how long each took, which no two computations share."""
    return [{**row, "execution_time_ms": None} for row in rows]


def test_page_and_command_submit_a_row_for_every_recording(root: Path, tmp_path: Path) -> None:
    command("estimate", root, "000000", "--run", "one", "--workers", "1", "--out", tmp_path / "one.csv")
    command("submit", root, "one", tmp_path / "submission.csv")
    dataset = open_dataset(root)
    run = load_run("one", dataset=dataset.root, store=shared.store())
    assert run is not None
    content = (tmp_path / "submission.csv").read_bytes()
    assert content == submission_file(Judged(run, dataset, "held-out"))
    lines = content.decode().splitlines()
    assert len(lines) == RECORDINGS + 1
    assert not lines[1].startswith("0,-1,")
    assert all(set(line.split(",")[1:]) == {"-1"} for line in lines[2:])
