import gc
import os
import signal
import subprocess
import sys
import threading
from pathlib import Path

import pytest

from corsmal.engines.engine import run_batch
from corsmal.engines.processes import Processes, cores
from corsmal.engines.workers import GIVING_WAY, THREADS
from corsmal.errors import ArgumentError
from tests.engines.copying import LOADED, copies, what_is_loaded
from tests.engines.faulty import Faulty, wait_for

ROOT = Path(__file__).resolve().parents[2]
GRACE_S = 2


def test_a_recording_whose_process_was_killed_once_is_begun_again(dataset, tmp_path):
    task = Faulty(raises={"000001": "kill"}, once=tmp_path / "killed")
    rows = run_batch(task, list(dataset), engine=Processes(1))
    assert [row["status"] for row in rows] == ["done"] * 3


def test_processes_end_when_the_work_is_given_up(dataset, tmp_path):
    outcomes = Processes(2)(Faulty(raises={"000001": "sleep"}, pids=tmp_path), list(dataset))
    next(outcomes)
    wait_for(lambda: len(pids_in(tmp_path)) == 2)
    outcomes.close()
    assert not any(map(is_alive, pids_in(tmp_path)))


def test_cancelled_work_is_dropped_and_what_was_done_is_kept(dataset, tmp_path):
    task = Faulty(raises={"000001": "sleep"}, pids=tmp_path)
    outcomes = Processes(1)(task, list(dataset), cancelled=lambda: len(started) > 0)
    started = []
    assert next(outcomes).index == 0
    started.append(True)
    assert list(outcomes) == []
    assert not any(map(is_alive, pids_in(tmp_path)))


def test_work_begins_in_processes_that_were_started_ahead(tmp_path):
    engine = Processes(2)
    engine.start(process_of, [tmp_path])
    wait_for(lambda: len(pids_in(tmp_path)) == 2)
    outcomes = list(engine(process_of, [tmp_path] * 4))
    assert sorted(outcome.index for outcome in outcomes) == [0, 1, 2, 3]
    assert len(pids_in(tmp_path)) == 2
    list(engine(process_of, [tmp_path]))
    assert len(pids_in(tmp_path)) == 3


def test_a_process_that_dies_before_its_work_is_replaced(dataset):
    engine = Processes(1)
    engine.start(Faulty(raises={"000001": "kill"}), [dataset["000001"]])
    assert [outcome.row["status"] for outcome in engine(Faulty(), list(dataset))] == ["done"] * 3


def test_workers_that_stay_do_the_next_work_too(tmp_path):
    engine = Processes(2, stays=True)
    for _ in range(2):
        assert len(list(engine(process_of, [tmp_path] * 4))) == 4
    pids = pids_in(tmp_path)
    assert len(pids) == 2
    assert all(map(is_alive, pids))
    engine.close()
    assert not any(map(is_alive, pids))


def test_work_of_workers_that_stay_is_completed_as_far_as_it_was_begun(dataset, tmp_path):
    engine, stopped = Processes(1, stays=True), []
    outcomes = engine(Faulty(raises={"000001": "pause"}, pids=tmp_path), list(dataset), cancelled=lambda: bool(stopped))
    assert next(outcomes).index == 0
    stopped.append(True)
    assert [outcome.index for outcome in outcomes] in ([], [1])  # the second may have been begun
    assert len(list(engine(Faulty(pids=tmp_path), list(dataset)))) == 3
    assert len(pids_in(tmp_path)) == 1
    engine.close()


def test_a_worker_that_died_while_it_waited_is_replaced(tmp_path):
    engine = Processes(1, stays=True)
    list(engine(process_of, [tmp_path]))
    [pid] = pids_in(tmp_path)
    os.kill(pid, signal.SIGKILL)
    [outcome] = engine(process_of, [tmp_path])
    assert outcome.row is not None
    assert len(pids_in(tmp_path)) == 2
    engine.close()


def test_work_gives_way_where_it_is_to(tmp_path):
    mine = os.getpriority(os.PRIO_PROCESS, 0)
    for gives_way, expected in ((False, mine), (True, max(mine, GIVING_WAY))):
        outcomes = Processes(1, gives_way=gives_way)(process_of, [tmp_path] * 2)
        assert [outcome.row["niceness"] for outcome in outcomes] == [expected, expected]


def test_all_processes_together_use_the_cores_once(tmp_path, monkeypatch):
    forget_threads(monkeypatch)
    [outcome] = Processes(1)(threads_of, [tmp_path])
    assert set(outcome.row.values()) == {cores()}
    outcomes = list(Processes(cores())(threads_of, [tmp_path] * cores()))
    assert all(set(outcome.row.values()) == {1} for outcome in outcomes)


def test_the_environment_is_the_callers_with_what_is_named(tmp_path, monkeypatch):
    monkeypatch.setenv("OMP_NUM_THREADS", "1")
    [outcome] = Processes(1, environment={"NUMBA_NUM_THREADS": "4"})(threads_of, [tmp_path])
    assert (outcome.row["torch"], outcome.row["numba"]) == (1, 4)


@pytest.mark.parametrize("engine", ["Processes(2)", "Processes(2, forks=True)"])
@pytest.mark.parametrize("fault", ["sleep", "compute"])
def test_no_process_outlives_the_program_by_more_than_two_seconds(fault, engine, tiny_dataset_root, tmp_path):
    # without a main guard: workers must not run the script again
    program = (
        "import sys; from pathlib import Path; from tests.engines.faulty import Faulty\n"
        "from corsmal.engines.processes import Processes; from corsmal.dataset import open_dataset\n"
        f"task = Faulty(raises=dict.fromkeys(['000000', '000001'], '{fault}'), pids=Path(sys.argv[2]))\n"
        f"list({engine}(task, list(open_dataset(sys.argv[1]))))\n"
    )
    script, folder = tmp_path / "program.py", tmp_path / "pids"
    script.write_text(program, encoding="utf-8")
    folder.mkdir()
    environment = os.environ | {"PYTHONPATH": str(ROOT)} | dict.fromkeys(THREADS, "1")
    with subprocess.Popen([sys.executable, script, tiny_dataset_root, folder], env=environment) as process:
        wait_for(lambda: len(pids_in(folder)) == 2)
        process.kill()
    wait_for(lambda: not any(map(is_alive, pids_in(folder))), seconds=GRACE_S)


def test_processes_that_had_not_begun_when_the_program_was_killed_end_too(tiny_dataset_root, tmp_path):
    program = (
        "import os, signal, sys; from pathlib import Path; from tests.engines.faulty import Faulty\n"
        "from corsmal.engines.processes import Processes; from corsmal.dataset import open_dataset\n"
        "engine, recordings = Processes(3), list(open_dataset(sys.argv[1]))\n"
        "engine.start(Faulty(raises=dict.fromkeys(['000000', '000001', '000002'], 'sleep')), recordings)\n"
        "[Path(sys.argv[2], str(worker._process.pid)).touch() for worker in engine._ahead]\n"
        "os.kill(os.getpid(), signal.SIGKILL)\n"
    )
    environment = os.environ | {"PYTHONPATH": str(ROOT)}
    subprocess.run([sys.executable, "-c", program, tiny_dataset_root, tmp_path], env=environment, check=False)
    assert len(pids_in(tmp_path)) == 3
    wait_for(lambda: not any(map(is_alive, pids_in(tmp_path))), seconds=GRACE_S)


@pytest.mark.parametrize("fault", ["time.sleep(600)", "sum(range(10**12))"])
def test_a_forked_process_ends_with_the_one_that_holds_its_lifeline(fault, tmp_path):
    program = (
        "import os, sys, time; from pathlib import Path; from corsmal.engines.lifeline import end_with\n"
        "reader, writer = os.pipe()\n"
        "if not os.fork():\n"
        f"    os.close(writer); end_with(reader); Path(sys.argv[1], str(os.getpid())).touch(); {fault}\n"
        "time.sleep(600)\n"
    )
    environment = os.environ | {"PYTHONPATH": str(ROOT)}
    with subprocess.Popen([sys.executable, "-c", program, tmp_path], env=environment) as process:
        wait_for(lambda: len(pids_in(tmp_path)) == 1)
        assert all(map(is_alive, pids_in(tmp_path)))
        process.kill()
    wait_for(lambda: not any(map(is_alive, pids_in(tmp_path))), seconds=GRACE_S)


def test_what_was_given_to_a_worker_ahead_is_done_though_it_dies(dataset, tmp_path):
    engine = Processes(1, stays=True)
    task = Faulty(raises={"000001": "kill"}, once=tmp_path / "killed")
    items = [dataset[name] for name in ("000000", "000001", "000002", "000000", "000002")]
    outcomes = list(engine(task, items))
    engine.close()
    assert sorted(outcome.index for outcome in outcomes) == [0, 1, 2, 3, 4]
    assert [outcome.problem for outcome in outcomes] == [""] * 5


def test_the_connection_to_a_process_that_died_is_not_kept(dataset, tmp_path):
    gc.collect()
    before = len(os.listdir("/proc/self/fd"))
    task = Faulty(raises={"000001": "kill"}, once=tmp_path / "killed")
    run_batch(task, list(dataset), engine=Processes(1))
    gc.collect()
    assert len(os.listdir("/proc/self/fd")) <= before


def test_a_process_with_several_threads_is_no_copy(tmp_path, monkeypatch):
    forget_threads(monkeypatch)
    monkeypatch.setitem(LOADED, "network", "open")
    [outcome] = Processes(1, forks=True, environment={"OMP_NUM_THREADS": "2"})(what_is_loaded, [tmp_path])
    assert (outcome.row["network"], outcome.row["torch"]) == (None, 2)


def test_a_process_is_not_copied_while_another_thread_of_it_runs(tmp_path, monkeypatch):
    monkeypatch.setitem(LOADED, "network", "open")
    done = threading.Event()
    thread = threading.Thread(target=done.wait)
    thread.start()
    outcomes = list(copies()(what_is_loaded, [tmp_path]))
    done.set()
    thread.join()
    assert [outcome.row["network"] for outcome in outcomes] == [None]


@pytest.mark.parametrize("name", ["have_what_is_loaded", "are_replaced", "end_with_the_work", "estimate_the_same"])
def test_copies(name, tiny_dataset_root, tmp_path):
    # in a process without other threads, which this one may have from other tests
    program = f"from tests.engines import copying; copying.{name}({str(tiny_dataset_root)!r}, {str(tmp_path)!r})"
    environment = {key: value for key, value in os.environ.items() if key not in THREADS} | {"PYTHONPATH": str(ROOT)}
    subprocess.run([sys.executable, "-c", program], env=environment, check=True, timeout=300)


@pytest.mark.parametrize("count", [0, -1])
def test_fewer_processes_than_one_are_refused(count):
    with pytest.raises(ArgumentError, match=f"count must be at least 1, got {count}"):
        Processes(count)


def process_of(folder: Path) -> dict[str, int]:
    """A task that leaves a file named after its process, and returns its niceness."""
    (folder / str(os.getpid())).touch()
    return {"niceness": os.getpriority(os.PRIO_PROCESS, 0)}


def threads_of(_folder: Path) -> dict[str, int]:
    """A task that returns how many threads the libraries use in its process."""
    import cv2  # noqa: PLC0415 - the tests themselves do not need it
    import numba  # noqa: PLC0415
    import torch  # noqa: PLC0415

    return {"torch": torch.get_num_threads(), "cv2": cv2.getNumThreads(), "numba": numba.get_num_threads()}


def forget_threads(monkeypatch):
    """Leave the numbers of threads to the engine; Dask's workers, started by another test, set some for good."""
    for name in (*THREADS, "MKL_NUM_THREADS", "OPENBLAS_NUM_THREADS"):
        monkeypatch.delenv(name, raising=False)


def pids_in(folder):
    return [int(path.name) for path in folder.iterdir() if path.name.isdigit()]


def is_alive(pid):
    """Whether a process runs; one that has ended and was not waited for does not."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except FileNotFoundError:
        return False
