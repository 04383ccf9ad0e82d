import os
import signal
import subprocess
import sys
from dataclasses import replace
from logging import CRITICAL
from pathlib import Path

import pytest
from distributed import LocalCluster

from corsmal.engines import dask_cluster
from corsmal.engines.dask_cluster import DaskCluster
from corsmal.engines.engine import completed_rows, in_turn, run_batch
from corsmal.engines.processes import Processes
from corsmal.engines.tasks import DetectTask, EstimateTask, open_detector
from corsmal.errors import CorsmalError
from corsmal.notes import listening
from corsmal.stages.settings import EstimateSettings, find_detector
from corsmal.stages.version import METHOD_VERSION
from corsmal.store import digest
from corsmal.weights import find_weights
from tests.engines.faulty import Faulty, ReadsStore, wait_for
from tests.networks import write_networks

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture(scope="module")
def settings(tmp_path_factory):
    paths = write_networks(tmp_path_factory.mktemp("networks"))
    return EstimateSettings(**{name: find_weights(name, path) for name, path in paths.items()})


@pytest.fixture
def cluster():
    """The address of a running cluster; one for each test, since some kill its workers."""
    with LocalCluster(
        n_workers=2, threads_per_worker=1, dashboard_address="127.0.0.1:0", silence_logs=CRITICAL
    ) as cluster:
        yield cluster.scheduler_address


@pytest.fixture(params=["in turn", "processes", "dask"])
def engine(request):
    if request.param == "dask":
        return DaskCluster(request.getfixturevalue("cluster"))
    return Processes(2) if request.param == "processes" else in_turn


@pytest.fixture
def broken(dataset, tmp_path):
    """The recordings with one more, whose calibration is broken."""
    path = tmp_path / "broken.pickle"
    path.write_bytes(b"no calibration")
    views = {name: replace(view, calibration_path=path) for name, view in dataset["000000"].views.items()}
    return [replace(dataset["000000"], id="000009", views=views), *dataset]


def untimed(rows):
    """Rows without how long each took, which no two computations share."""
    return [{**row, "execution_time_ms": None} for row in rows]


@pytest.mark.parametrize("engine", ["processes", "dask"], indirect=True)
def test_every_engine_gives_the_same_rows(engine, broken, settings, tmp_path):
    steps = []
    expected = run_batch(EstimateTask(tmp_path / "one", settings), broken)
    rows = run_batch(
        EstimateTask(tmp_path / "other", settings),
        broken,
        engine=engine,
        progress=lambda *step: steps.append(step),
    )
    assert untimed(rows) == untimed(expected)
    assert [row["recording_id"] for row in rows] == ["000009", "000000", "000001", "000002"]
    assert [row["status"] for row in rows] == ["failed", "fitted", "fitted", "failed"]
    assert "broken.pickle" in rows[0]["notes"]
    assert steps == [(done, 4) for done in range(5)]


def test_what_happens_to_one_recording_is_one_row_with_the_reason(engine, dataset):
    recordings = [replace(dataset["000000"], id=name) for name in ("fine", "clear", "unforeseen", "deadly")]
    is_here = engine is in_turn
    faults = {"clear": "clear", "unforeseen": "unforeseen"} | ({} if is_here else {"deadly": "kill"})
    rows = {row["recording_id"]: row for row in run_batch(Faulty(faults), recordings, engine=engine)}
    assert {name for name, row in rows.items() if row["status"] == "failed"} == set(faults)
    assert rows["clear"]["notes"] == "the recording is broken"
    assert "stopped unexpectedly: ZeroDivisionError" in rows["unforeseen"]["notes"]
    assert is_here or "ended" in rows["deadly"]["notes"]


def test_what_the_store_says_elsewhere_is_heard_here(engine, dataset, store):
    key = digest("a key")
    path = store.file("fits", key, ".json")
    path.parent.mkdir(parents=True)
    path.write_bytes(b"broken")
    with listening() as said:
        run_batch(ReadsStore(store.root, key), list(dataset), engine=engine)
    [sentence] = dict.fromkeys(said)
    assert sentence.startswith(f"{path}: cannot be read (")


def test_cancelled_work_ends_early(engine, dataset):
    recordings = [replace(dataset["000000"], id=str(number)) for number in range(8)]
    done = []
    cancelled = {"progress": lambda step, _: done.append(step), "cancelled": lambda: 2 in done}
    rows = list(completed_rows(Faulty(), recordings, engine=engine, **cancelled))
    assert [row["status"] for row in rows] == ["done", "done"]


def test_a_cluster_without_workers_is_given_up(dataset, monkeypatch):
    monkeypatch.setattr(dask_cluster, "WORKERLESS_S", 0.4)
    with LocalCluster(n_workers=0, dashboard_address="127.0.0.1:0", silence_logs=CRITICAL) as cluster:
        engine = DaskCluster(cluster.scheduler_address)
        with pytest.raises(CorsmalError, match="no worker for 0 s; what was done is kept: start workers"):
            run_batch(Faulty(), list(dataset), engine=engine)
        monkeypatch.setattr(dask_cluster, "WORKERLESS_S", 600)
        assert list(completed_rows(Faulty(), list(dataset), engine=engine, cancelled=lambda: True)) == []


def test_no_recordings_are_no_rows(engine):
    assert run_batch(Faulty(), [], engine=engine) == []


def test_the_keyboard_stops_a_command_and_the_same_command_goes_on(tiny_dataset_root, tmp_path):
    command = [sys.executable, "-m", "corsmal", "estimate", tiny_dataset_root, "--workers", "2", "--out"]
    environment = os.environ | {"CORSMAL_CACHE": str(tmp_path / "cache")}
    table = tmp_path / "estimates.csv"
    with subprocess.Popen([*command, table], env=environment, cwd=ROOT, stderr=subprocess.PIPE, text=True) as process:
        wait_for(lambda: any((tmp_path / "cache").glob("estimates/*/*.json")))
        process.send_signal(signal.SIGINT)
        said = process.stderr.read()
    kept = {path: path.stat().st_mtime_ns for path in (tmp_path / "cache").glob("estimates/*/*.json")}
    if process.returncode:  # it may have been quicker
        assert process.returncode == 130
        assert "the same command resumes it" in said
        assert "Traceback" not in said
    command[-2] = "1"
    subprocess.run([*command, table], env=environment, cwd=ROOT, check=True, capture_output=True)
    assert table.is_file()
    assert {path: path.stat().st_mtime_ns for path in kept} == kept


def test_without_an_address_a_cluster_is_started_and_ended(dataset):
    rows = run_batch(Faulty(), [dataset["000000"]], engine=DaskCluster(workers=1))
    assert [row["status"] for row in rows] == ["done"]


def test_a_scheduler_that_does_not_answer_is_one_sentence(dataset, monkeypatch):
    monkeypatch.setattr("corsmal.engines.dask_cluster.TIMEOUT_S", 1)
    with pytest.raises(CorsmalError, match=r"scheduler tcp://127\.0\.0\.1:1 does not answer"):
        run_batch(Faulty(), list(dataset), engine=DaskCluster("tcp://127.0.0.1:1"))


def test_networks_and_versions_that_differ_from_those_that_are_meant_are_refused(
    dataset, settings, tmp_path, monkeypatch
):
    task = EstimateTask(tmp_path, settings, key=settings.open().key)
    monkeypatch.setattr("corsmal.stages.estimates.METHOD_VERSION", METHOD_VERSION + 1)
    rows = run_batch(task, [dataset["000000"]])
    assert "the networks or the version of the method on" in rows[0]["notes"]
    assert "differ from those where the run was started" in rows[0]["notes"]
    detector = find_detector("demo")
    assert open_detector(detector, detector.open().digest).digest
    with pytest.raises(CorsmalError, match="the detector's weights"):
        open_detector(detector, "another")
    rows = run_batch(DetectTask(tmp_path, detector, "another"), [dataset["000000"]])
    assert rows[0]["status"] == "failed"
