"""Many visitors of one server at once, who step, drag and start runs: ``python -m tests.benchmarks.sessions``.

It starts a server with a cache of its own, lets the visitors come one after the other, work for some minutes and leave,
and prints how long answers took, by what was done and by visitor, and the memory of the server and its workers. With
``--out DIR`` it also writes the memory over the time as a table and a figure.
"""

import argparse
import itertools
import os
import random
import signal
import subprocess
import sys
import tempfile
import threading
import time
import urllib.request
from collections import defaultdict
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import pandas as pd
import plotly.graph_objects as go

from corsmal.figures.export import export_figure
from tests.benchmarks.visit import Visit

ROOT = Path(__file__).resolve().parents[2]
PAGES = ("hull", "hull", "hull", "best-frame", "", "best-frame", "sound", "hull", "weight", "results")
"""What the visitors open, in turn: most of the work is on the Shape page."""

THINK_S = (0.5, 2.5)
ARRIVE_S = 1.0
PRESETS = ("tuned", "released", "lode", "paper")


@dataclass
class Answers:
    """How long answers took, s, by what was done and by visitor; and what went wrong."""

    took_s: dict[tuple[str, int], list[float]] = field(default_factory=lambda: defaultdict(list))
    errors: list[str] = field(default_factory=list)

    def add(self, what: str, visitor: int, seconds: float | None) -> None:
        if seconds is not None:
            self.took_s[what, visitor].append(seconds)

    def table(self) -> pd.DataFrame:
        """A row for each thing that was done: how often, percentiles, and the best and the worst visitor's median."""
        rows = {}
        for what in dict.fromkeys(what for what, _ in self.took_s):
            by_visitor = [times for (done, _), times in self.took_s.items() if done == what]
            times, medians = np.concatenate(by_visitor), [np.median(each) for each in by_visitor if len(each) > 2]
            spread = {"least median": min(medians, default=np.nan), "largest median": max(medians, default=np.nan)}
            percentiles = {f"p{part}": np.percentile(times, part) for part in (50, 95, 100)}
            rows[what] = {"times": len(times), **percentiles, **spread}
        return pd.DataFrame.from_dict(rows, orient="index").round(3)


def visit(number: int, address: str, answers: Answers, leave: threading.Event) -> None:
    """Come, do what the page is for until it is time to leave, and leave."""
    rng, page = random.Random(number), PAGES[number % len(PAGES)]
    try:
        with Visit(address, page) as visitor:
            answers.add("open a page", number, visitor.open())
            for frame in itertools.count(rng.randrange(50)):
                if leave.wait(rng.uniform(*THINK_S)):
                    break
                act(visitor, page, frame, number=number, answers=answers, rng=rng)
            answers.errors += [f"visitor {number}: {error}" for error in (*visitor.errors, *visitor.problems)]
    except Exception as error:  # noqa: BLE001 - whatever it is, it is what is looked for
        answers.errors.append(f"visitor {number}: {error!r}")


def act(visitor: Visit, page: str, frame: int, *, number: int, answers: Answers, rng: random.Random) -> None:
    """Drag a slider, start a run, or step to the next frame and see its pictures."""
    if page == "hull" and rng.random() < 0.4:
        slider = visitor.components["hull"]["sliders"][0]
        for value in np.linspace(slider["min"], slider["max"], 8)[2:7].astype(int).tolist():
            values = {slider["name"]: value + frame % 7}
            answers.add("drag", number, visitor.report("hull", values=values, settled=False))
        answers.add("let go", number, visitor.report("hull", values=values, settled=True))
    elif page == "results":
        visitor.choose("run_preset", rng.choice(PRESETS))
        answers.add("start a run", number, visitor.press("start_run"))
        answers.add("look at results", number, visitor.open())
    elif "time_line" in visitor.components:
        line = visitor.components["time_line"]
        wanted = {"frame": frame % line["frames"]}
        answers.add("step", number, visitor.report("time_line", values=wanted, settled=True))
        for view in line["views"]:
            answers.add("picture", number, visitor.fetch(f"{line['url']}{view['name']}/{wanted['frame']}.jpg"))
    else:
        answers.add("look again", number, visitor.open())


def memory_mb(process: int) -> tuple[float, float]:
    """Resident memory of a process, and of all that it has started, MB."""
    children: dict[int, list[int]] = defaultdict(list)
    resident: dict[int, float] = {}
    for path in Path("/proc").glob("[0-9]*"):
        try:
            stat = (path / "stat").read_text().rpartition(")")[2].split()
        except OSError:
            continue
        children[int(stat[1])].append(int(path.name))
        resident[int(path.name)] = int(stat[21]) * os.sysconf("SC_PAGE_SIZE") / 1e6
    pending, started = list(children[process]), 0.0
    while pending:
        each = pending.pop()
        started += resident.get(each, 0.0)
        pending += children[each]
    return resident.get(process, 0.0), started


@contextmanager
def served(port: int, cache: str) -> Iterator[tuple[str, subprocess.Popen[bytes]]]:
    """A server of the app, with its address."""
    command = [sys.executable, "-m", "streamlit", "run", "app.py", "--server.headless", "true"]
    with subprocess.Popen(
        [*command, "--server.port", str(port)],
        cwd=ROOT,
        env=os.environ | {"CORSMAL_CACHE": cache},
        stdout=subprocess.DEVNULL,
        stderr=None,
    ) as server:
        address = f"http://127.0.0.1:{port}"
        try:
            while True:
                try:
                    with urllib.request.urlopen(f"{address}/_stcore/health", timeout=1):
                        break
                except OSError:
                    time.sleep(0.2)
            yield address, server
        finally:
            began_s = time.monotonic()
            server.send_signal(signal.SIGTERM)
            server.wait(30)
            print(f"stopped in {time.monotonic() - began_s:.1f} s")  # noqa: T201 - it is a command


def measure(visitors: int, minutes: float, port: int) -> tuple[Answers, pd.DataFrame]:
    """Let visitors come, work and leave; their answers, and the memory each second with how many are there."""
    answers, leave, memory = Answers(), threading.Event(), []
    with tempfile.TemporaryDirectory() as cache, served(port, cache) as (address, server):
        began_s = time.monotonic()
        with Visit(address) as first:  # what the server loads once is no visitor's share
            first.open()
        threads = [threading.Thread(target=visit, args=(each, address, answers, leave)) for each in range(visitors)]

        def wait(seconds: float, is_over: Callable[[], bool] = lambda: False) -> None:
            end_s = time.monotonic() + seconds
            while time.monotonic() < end_s and not is_over():
                present = sum(thread.is_alive() for thread in threads)
                memory.append((time.monotonic() - began_s, present, *memory_mb(server.pid)))
                time.sleep(1)

        wait(20)
        for thread in threads:
            thread.start()
            wait(ARRIVE_S)
        wait(60 * minutes)
        leave.set()
        wait(130, lambda: not any(thread.is_alive() for thread in threads))
        wait(60)
    return answers, pd.DataFrame(memory, columns=["seconds", "visitors", "server_mb", "workers_mb"])


def memory_figure(memory: pd.DataFrame) -> go.Figure:
    """The memory over the time, with the number of visitors."""
    lines = {"server_mb": "server", "workers_mb": "its workers", "visitors": "visitors (right axis)"}
    figure = go.Figure()
    for name, label in lines.items():
        axis = "y2" if name == "visitors" else "y"
        dash = "dot" if name == "visitors" else "solid"
        figure.add_scatter(x=memory["seconds"] / 60, y=memory[name], name=label, yaxis=axis, line={"dash": dash})
    return figure.update_layout(
        xaxis_title="time, minutes",
        yaxis={"title": "resident memory, MB", "rangemode": "tozero"},
        yaxis2={
            "title": "visitors",
            "overlaying": "y",
            "side": "right",
            "range": (0, 1.25 * memory["visitors"].max()),
            "tickmode": "linear",
            "dtick": max(1, round(memory["visitors"].max() / 4)),
            "showgrid": False,
        },
        legend={"orientation": "h", "y": 1.12},
    )


def main() -> None:
    """The command."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--visitors", type=int, default=20)
    parser.add_argument("--minutes", type=float, default=5.0)
    parser.add_argument("--port", type=int, default=8640)
    parser.add_argument("--out", type=Path)
    options = parser.parse_args()
    answers, memory = measure(options.visitors, options.minutes, options.port)
    print(answers.table().to_string())  # noqa: T201
    print(f"{len(answers.errors)} errors", *answers.errors[:10], sep="\n")  # noqa: T201
    for label, rows in (("before", memory[memory["visitors"] == 0].iloc[:20]), ("at last", memory.iloc[-10:])):
        print(f"memory {label}: {rows[['server_mb', 'workers_mb']].median().round().to_dict()} MB")  # noqa: T201
    during = memory[memory["visitors"] == options.visitors]
    print(f"memory with all: {during[['server_mb', 'workers_mb']].max().round().to_dict()} MB")  # noqa: T201
    if options.out is not None:
        options.out.mkdir(parents=True, exist_ok=True)
        memory.round(2).to_csv(options.out / "sessions.csv", index=False)
        export_figure(memory_figure(memory), options.out / "sessions.svg")


if __name__ == "__main__":
    main()
