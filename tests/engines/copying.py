"""What holds of workers that are copies of a process: checked in a process that has no other threads of Python."""

import gc
import os
import time
from pathlib import Path

from corsmal.dataset import open_dataset
from corsmal.engines.engine import run_batch
from corsmal.engines.processes import Processes
from corsmal.engines.tasks import EstimateTask
from corsmal.engines.workers import THREADS, can_copy
from corsmal.stages.settings import EstimateSettings
from corsmal.weights import find_weights
from tests.engines.faulty import Faulty, wait_for
from tests.networks import write_networks

LOADED: dict[str, str] = {}
"""What this process has loaded, as it were: other processes import this module anew, copies do not."""


def copies():
    return Processes(2, forks=True, environment=dict.fromkeys(THREADS, "1"))


def what_is_loaded(_folder: Path) -> dict[str, object]:
    """A task that returns what its process found loaded, its id and its threads."""
    import cv2  # noqa: PLC0415 - the other tests do not need them
    import torch  # noqa: PLC0415

    time.sleep(0.1)
    gc.collect()
    threads = {"torch": torch.get_num_threads(), "cv2": cv2.getNumThreads()}
    return {"network": LOADED.get("network"), "pid": os.getpid(), **threads}


def use_all_threads(root):
    """Have PyTorch, OpenCV and a video's scaler start threads, which a copy lacks; the video is garbage afterwards."""
    import cv2  # noqa: PLC0415 - as above
    import numpy as np  # noqa: PLC0415
    import torch  # noqa: PLC0415

    torch.ones(3000, 3000) @ torch.ones(3000, 3000)
    cv2.GaussianBlur(np.zeros((2000, 2000, 3), np.uint8), (31, 31), 5)
    video = next(iter(open_dataset(root)["000000"].views.values())).video()
    held = [video, video[0]]
    held.append(held)


def have_what_is_loaded(root, folder):
    LOADED["network"] = "open"
    use_all_threads(root)
    before = what_is_loaded(Path(folder))
    use_all_threads(root)
    assert can_copy()
    outcomes = list(copies()(what_is_loaded, [Path(folder)] * 4))
    assert [outcome.row["network"] for outcome in outcomes] == ["open"] * 4
    assert before["pid"] not in {outcome.row["pid"] for outcome in outcomes}
    assert all(outcome.row["torch"] == outcome.row["cv2"] == 1 for outcome in outcomes)
    assert what_is_loaded(Path(folder)) == before


def are_replaced(root, folder):
    task, recordings = Faulty(raises={"000001": "kill"}, once=Path(folder, "killed")), list(open_dataset(root))
    assert [row["status"] for row in run_batch(task, recordings, engine=copies())] == ["done"] * 3
    [*_, row] = run_batch(Faulty(raises={"000002": "kill"}), recordings, engine=copies())
    assert "its process ended 2 times, by signal 9" in row["notes"]


def end_with_the_work(root, folder):
    outcomes = copies()(Faulty(raises={"000001": "sleep"}, pids=Path(folder)), list(open_dataset(root)))
    next(outcomes)
    wait_for(lambda: len(list(Path(folder).iterdir())) == 2)
    outcomes.close()
    for path in Path(folder).iterdir():
        assert not Path("/proc", path.name).exists()


def estimate_the_same(root, folder):
    paths = write_networks(Path(folder))
    settings = EstimateSettings(**{name: find_weights(name, path) for name, path in paths.items()})
    recordings = list(open_dataset(root))
    rows = [
        run_batch(EstimateTask(Path(folder, name), settings), recordings, **engine)
        for name, engine in (("one", {}), ("other", {"engine": copies()}))
    ]
    one, other = ([{**row, "execution_time_ms": None} for row in each] for each in rows)
    assert one == other
    assert [row["status"] for row in one] == ["fitted", "fitted", "failed"]
