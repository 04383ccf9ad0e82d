"""What the README says one can type is typed here, on tiny data."""

import json
import re
import shlex
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import cached_property, partial
from importlib.metadata import entry_points, version
from itertools import pairwise
from pathlib import Path
from types import SimpleNamespace

import click
import numpy as np
import pandas as pd
import pytest
import torch
import typer
from packaging.requirements import Requirement
from torchvision.models.detection import maskrcnn_resnet50_fpn
from torchvision.models.video import r2plus1d_18
from typer.testing import CliRunner

import corsmal.__main__ as cli
from corsmal import detection
from corsmal.dataset import open_dataset
from corsmal.detection import MaskRCNNDetector
from corsmal.evaluation import read_estimates
from corsmal.filling import FillingPredictor, FusedPredictor, LogMelParameters
from corsmal.mass import MassConfig, MassPredictor
from corsmal.parameters import METHOD_VIEWS
from corsmal.stages.detections import load_detections
from corsmal.stages.true_masks import true_views
from corsmal.store import Store
from corsmal.weights import bundled_path
from tests.networks import write_networks
from tests.tiny import detections_of, write_json, write_tiny_dataset

REPOSITORY = Path(__file__).resolve().parents[2]
README = (REPOSITORY / "README.md").read_text(encoding="utf-8")
SETUP = "python3 -m venv .venv && .venv/bin/pip install -r requirements.txt && "
COMMAND = ".venv/bin/python -m corsmal "
INSTALLED = "corsmal "
"""How the installed package's commands begin."""


def lines_of(text: str) -> list[str]:
    """The lines of a document's shell blocks, without their comments."""
    blocks = re.findall(r"```sh\n(.*?)```", text, re.DOTALL)
    return [line for block in blocks for line in (re.sub(r"\s+#.*", "", line) for line in block.splitlines()) if line]


def commands_of(lines: list[str]) -> list[str]:
    """The commands of ``corsmal`` among lines, without what they begin with."""
    starts = (COMMAND, INSTALLED)
    words = [line.removeprefix(start) for line in lines for start in starts if line.startswith(start)]
    return [line for line in dict.fromkeys(words) if not line.startswith("--")]


LINES = lines_of(README)
SITE = {
    str(path.relative_to(REPOSITORY)): lines_of(path.read_text(encoding="utf-8"))
    for path in sorted((REPOSITORY / "docs").rglob("*.md"))
}
COMMANDS = commands_of([*LINES, *(line for lines in SITE.values() for line in lines)])
OTHERS = [
    SETUP + ".venv/bin/streamlit run app.py",
    SETUP + ".venv/bin/python -m pytest -n 2",
    'pip install ".[app]"',  # .ci/installed.py installs the wheel and starts the app
    "corsmal --install-completion",
    ".venv/bin/streamlit run app.py --server.baseUrlPath corsmal -- --data-root /data/corsmal",
    ".venv/bin/python -m dask scheduler",
    ".venv/bin/python -m dask worker tcp://10.0.0.5:8786 --nworkers 8 --nthreads 1",
    "export CORSMAL_CACHE=/shared/cache",
    ".venv/bin/python -m pytest tests/benchmarks --benchmark-only",
]
"""Lines that are no commands of ``corsmal``."""
SITE_OTHERS = {
    'pip install ".[app]"',
    'pip install ".[app,docs]" jupyterlab',
    "jupyter lab docs/notebooks",
    "corsmal --install-completion",
    "python -m dask scheduler",
    "python -m dask worker tcp://10.0.0.5:8786 --nworkers 8 --nthreads 1",
    "export CORSMAL_CACHE=/shared/cache",
    "python -m pytest tests/benchmarks --benchmark-only",
    "python -m pytest tests/benchmarks --benchmark-only --long --table docs/speed-table.md",
    "docker build -t corsmal .",
    "docker run -p 127.0.0.1:8501:8501 -v /data/corsmal:/data:ro -v corsmal-cache:/cache corsmal",
}
"""Such lines of the site."""

RUN_NAME = "first"
RECORDINGS, DETECTED_HERE = 9, "000002"
"""Of the dataset ROOT; the second has no detections beside its videos."""


class Place:
    """The folders and files that the README's commands name, made when they are first needed."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.table = folder / "estimates.csv"
        self._processes: list[subprocess.Popen[bytes]] = []

    @cached_property
    def dataset(self) -> Path:
        """Nine recordings of two frames, with every filling type and level."""
        root = write_tiny_dataset(self.folder / "ROOT", recordings=RECORDINGS, frames=2)
        path = root / "ccm_tiny_annotation.json"
        content = json.loads(path.read_text(encoding="utf-8"))
        for row in content["annotations"]:
            row["filling type"], row["filling level"] = ((0, 0), (1, 1), (2, 2), (3, 1))[row["id"] // 2 % 4]
        path.write_text(json.dumps(content), encoding="utf-8")
        return root

    @cached_property
    def demo(self) -> Path:
        """The demo with one small recording, and the true masks as its detections."""
        root = self.folder / "DIR"
        run(["demo", str(root), "--container", "1", "--recordings", "1", "--width", "160"])
        for name, view in true_views(open_dataset(root)["000000"]).items():
            masks = [found.masks.any(axis=0) for found in view.values()]
            write_json(root / name / "detections" / "000000.json", detections_of(masks))
        return root

    @cached_property
    def networks(self) -> dict[str, Path]:
        return write_networks(self.folder)

    @cached_property
    def others(self) -> Path:
        """Other recordings of the same numbers: one frame more."""
        return write_tiny_dataset(self.folder / "TEST", frames=3)

    def arrays(self, name: str, shape: tuple[int, ...]) -> Path:
        """A folder with an array for every recording of the dataset."""
        folder = self.folder / name
        folder.mkdir(exist_ok=True)
        for index, recording in enumerate(open_dataset(self.dataset)):
            np.save(folder / f"{recording.id}.npy", np.random.default_rng(index).normal(size=shape))
        return folder

    @cached_property
    def masks(self) -> Path:
        """What a labelling tool writes: the outline of a box in the first frame."""
        entry = {
            "image_id": 0,
            "category_id": 47,
            "score": 1.0,
            "segmentation": [[300, 100, 340, 100, 340, 170, 300, 170]],
        }
        return write_json(self.folder / "masks.json", [entry])

    @cached_property
    def mass_network(self) -> Path:
        """A network that has seen every recording of the dataset."""
        folder = self.run_of("train mass")
        run(["train", "mass", str(self.dataset), str(folder), "--epochs", "2"])
        return folder / "mass.safetensors"

    @cached_property
    def estimates(self) -> Path:
        run(["estimate", str(self.dataset), "--run", RUN_NAME, "--out", str(self.table), "--workers", "1"])
        return self.table

    @cached_property
    def scheduler(self) -> str:
        """The address of a cluster that the README's two lines start, of one worker."""
        scheduler, worker = (shlex.split(line)[1:] for line in OTHERS if " -m dask " in line)
        found = self.folder / "scheduler.json"
        self._start(
            [*scheduler, "--host", "127.0.0.1", "--port", "0", "--no-dashboard", "--scheduler-file", str(found)]
        )
        deadline_s = time.monotonic() + 60
        while not found.exists() and time.monotonic() < deadline_s:
            time.sleep(0.1)
        address = json.loads(found.read_text(encoding="utf-8"))["address"]
        worker[worker.index("tcp://10.0.0.5:8786")] = address
        worker[worker.index("8")] = "1"
        self._start([*worker, "--no-dashboard", "--local-directory", str(self.folder)])
        return address

    def run_of(self, words: str) -> Path:
        """The folder of a command's own training."""
        return self.folder / words.replace(" ", "-")

    def arguments(self, line: str) -> list[str]:
        """A command's arguments, with the folders and files that are here."""
        here = {
            "ROOT": lambda: self.dataset,
            "/shared/ccm/train": lambda: self.dataset,
            "DIR": lambda: self.demo,
            "OUT": lambda: self.folder / "OUT",
            "NAME": lambda: RUN_NAME,
            "RUN": lambda: self.run_of(" ".join([words_of(line), *({"released", "fused"} & set(line.split()))])),
            "VGGISH": lambda: self.arrays("VGGISH", (4, 128)),
            "R2PLUS1D": lambda: self.arrays("R2PLUS1D", (3, 5, 512)),
            "RUN/mass.safetensors": lambda: self.mass_network,
            "TEST": lambda: self.others,
            "000618": lambda: DETECTED_HERE,
            "recording.rrd": lambda: self.folder / "recording.rrd",
            "red-cup": lambda: "demo",  # tests/detection/test_entry_points.py has those of other packages
            "onnx": lambda: "demo",
            "RUN/filling.safetensors": lambda: self.networks["filling"],
            "network.onnx": lambda: bundled_path("detector"),
            "estimates.csv": lambda: self.table,
            "table.tex": lambda: self.folder / "table.tex",
            "submission.csv": lambda: self.folder / "submission.csv",
            "masks.json": lambda: self.masks,
            "report.html": lambda: self.folder / "report.html",
            "scores.html": lambda: self.folder / "scores.html",
            "tcp://10.0.0.5:8786": lambda: self.scheduler,
        }
        return [str(here[word]()) if word in here else word for word in shlex.split(line)]

    def _start(self, arguments: list[str]) -> None:
        process = subprocess.Popen([sys.executable, *arguments], cwd=REPOSITORY, stderr=subprocess.DEVNULL)
        self._processes.append(process)

    def end(self) -> None:
        for process in reversed(self._processes):
            process.terminate()
            process.wait(timeout=60)


@pytest.fixture(scope="module")
def place(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Place]:
    place = Place(tmp_path_factory.mktemp("readme"))
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("CORSMAL_CACHE", str(place.folder / "cache"))
        patch.setenv("COLUMNS", "200")
        yield place
    place.end()


def run(arguments: list[str]) -> str:
    """What a command prints; it must succeed."""
    result = CliRunner().invoke(cli.app, arguments, catch_exceptions=False)
    assert result.exit_code == 0, result.output
    return result.output


CHECKS: dict[str, Callable[[Place, list[str]], None]] = {}
"""Runs a command with the README's arguments and checks what came of it, by the command's words."""


def check(words: str) -> Callable[[Callable[[Place, list[str]], None]], Callable[[Place, list[str]], None]]:
    def add(checked: Callable[[Place, list[str]], None]) -> Callable[[Place, list[str]], None]:
        CHECKS[words] = checked
        return checked

    return add


def words_of(line: str) -> str:
    """The command's own words: ``train filling`` of ``train filling ROOT RUN``."""
    first, second, *_ = (*line.split(), "", "")
    return f"{first} {second}" if first in ("train", "evaluate", "runs", "export", "masks") else first


@pytest.mark.parametrize("line", COMMANDS)
def test_the_readmes_command_runs(line: str, place: Place) -> None:
    assert words_of(line) in CHECKS, f"the README's command has no test: {line}"
    CHECKS[words_of(line)](place, place.arguments(line))


def test_the_readme_names_every_command() -> None:
    groups = {
        "": cli.COMMANDS,
        "runs ": cli.RUNS,
        "export ": cli.EXPORT,
        "masks ": cli.MASKS,
        "train ": cli.TRAIN,
        "evaluate ": cli.EVALUATE,
    }
    every = {group + name for group, names in groups.items() for name in names}
    assert every == set(map(words_of, commands_of(LINES))) == set(map(words_of, COMMANDS))


def test_the_readme_has_no_other_lines_than_those_that_are_checked() -> None:
    known = {COMMAND + line for line in COMMANDS} | {INSTALLED + line for line in COMMANDS}
    assert [line for line in LINES if line not in known] == OTHERS
    assert {line for lines in SITE.values() for line in lines if line not in known} == SITE_OTHERS


@pytest.mark.parametrize("name", SITE)
def test_no_command_of_the_site_has_an_option_that_is_not_there(name: str) -> None:
    for line in commands_of(SITE[name]):
        group, words = typer.main.get_command(cli.app), shlex.split(line)
        while isinstance(group, click.Group):
            group = group.commands[words.pop(0)]
        group.make_parser(click.Context(group)).parse_args(words)


@check("app")
def _(_: Place, arguments: list[str]) -> None:
    started: list[list[str]] = []
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("streamlit.web.cli.main", started.append)
        run([*arguments, "--read-only"])
    [[command, script, *options]] = started
    assert (command, Path(script)) == ("run", REPOSITORY / "app.py")
    headless = str("--no-browser" in arguments).lower()
    below = arguments[arguments.index("--base-path") + 1] if "--base-path" in arguments else ""
    assert options[:3] == ["--server.port=8501", f"--server.baseUrlPath={below}", f"--server.headless={headless}"]
    own = [pair for pair in pairwise(arguments) if pair[0] in ("--data", "--data-root")]
    assert options[3:] == ["--", *(word for pair in own for word in pair), "--read-only"]


@check("demo")
def _(place: Place, arguments: list[str]) -> None:
    assert arguments == ["demo", str(place.demo)]  # where it was written
    assert open_dataset(place.demo).ids == ("000000",)
    assert (place.demo / "truth" / "000000.json").is_file()


@check("detect")
def _(place: Place, arguments: list[str]) -> None:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(detection, "MaskRCNNDetector", partial(MaskRCNNDetector, image_side_min_px=48))
        if "dask" in arguments:
            arguments += ["--demo-weights"]  # the workers have no weights of Mask R-CNN
        elif "--detector" in arguments:
            arguments.insert(2, DETECTED_HERE)
        elif "--demo-weights" in arguments:
            arguments = ["detect", str(place.dataset), *arguments[2:]]  # 2 frames where the demo has 147
        else:
            network = maskrcnn_resnet50_fpn(weights=None, weights_backbone=None, num_classes=91)
            torch.save(network.state_dict(), place.folder / "untrained.pth")
            arguments += ["--weights", str(place.folder / "untrained.pth")]
            arguments += [] if DETECTED_HERE in arguments else [DETECTED_HERE]
        if "dask" not in arguments:
            arguments += ["--workers", "1"]
        run(arguments)
    found = load_detections(open_dataset(place.dataset)[DETECTED_HERE], store=Store()).views
    assert set(found) == set(METHOD_VIEWS)
    assert all(0 in view for view in found.values())


@check("features")
def _(place: Place, arguments: list[str]) -> None:
    torch.save(r2plus1d_18(weights=None).state_dict(), place.folder / "clips.pth")  # the path only: it knows nothing
    run([*arguments, "--weights", str(place.folder / "clips.pth"), "--device", "cpu"])
    assert np.load(place.folder / "OUT" / f"{DETECTED_HERE}.npy").shape == (3, 1, 512)


@check("estimate")
def _(place: Place, arguments: list[str]) -> None:
    out = place.folder / "written.csv"
    if RUN_NAME in arguments and len(arguments) > 4:
        words = [word for word in arguments[2:] if word.isalpha() and word != RUN_NAME]
        arguments[arguments.index(RUN_NAME)] = f"with {' '.join(words)}"  # other settings than those of the first run
    one = [] if "dask" in arguments else ["--workers", "1"]
    run([*arguments, "--out", str(out), *one])
    rows = read_estimates(out).set_index("recording_id")
    if DETECTED_HERE in arguments:
        assert list(rows.index) == [DETECTED_HERE]
        return
    assert len(rows) == RECORDINGS
    assert rows.loc["000000", "status"] == "fitted"


@check("evaluate estimates")
def _(place: Place, arguments: list[str]) -> None:
    assert place.estimates.is_file()
    output = run(arguments)
    for title in ("By container", "The challenge's scores", "capacity"):
        assert title in output
    assert r"\end{tabular}" in (place.folder / "table.tex").read_text(encoding="utf-8")


@check("evaluate compare")
def _(place: Place, arguments: list[str]) -> None:
    out = place.folder / "compared.csv"
    output = run([*arguments, "000000", "--out", str(out), "--workers", "1"])
    assert "The paper with one rule of the program" in output
    assert "The published error of the height is 30.8 %" in output
    assert {"published", "paper", "released", "lode", "tuned"} <= set(pd.read_csv(out)["condition"])
    run([*arguments, "000000", "--out", str(out.with_suffix(".md")), "--workers", "1"])
    written = out.with_suffix(".md").read_text(encoding="utf-8")
    assert "| Method | Capacity | Top width | Bottom width | Height |" in written
    assert "| paper with height rule |" in written
    assert "| … and selection |" in written


@check("submit")
def _(place: Place, arguments: list[str]) -> None:
    assert place.estimates.is_file()
    run(arguments)
    assert len(pd.read_csv(place.folder / "submission.csv")) == RECORDINGS


@check("report")
def _(place: Place, arguments: list[str]) -> None:
    assert place.estimates.is_file()
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("BROWSER_PATH", str(place.folder / "no browser"))
        output = run([*arguments, "--author", "A. Author", "--against", RUN_NAME])
    assert "reader's browser will draw the figures: Drawing figures as files needs Chrome or Chromium" in output
    written = (place.folder / "report.html").read_text(encoding="utf-8")
    assert "A. Author" in written
    assert f"report ROOT {RUN_NAME} --protocol held-out --against {RUN_NAME} --out report.html" in written


@check("reproduce")
def _(place: Place, arguments: list[str]) -> None:
    output = run([*arguments, "--quick", "--workers", "1"])
    assert "capacity_mape" in output
    if "--networks" in arguments:
        weights = (place.folder / "OUT" / "networks").rglob("filling.safetensors")
        assert LogMelParameters.of("released") in [FillingPredictor(path).front_end for path in weights]
    assert next((place.folder / "OUT").rglob("*.html")).stat().st_size > 1000


@check("doctor")
def _(_: Place, arguments: list[str]) -> None:
    result = CliRunner().invoke(cli.app, [*arguments, "--workers", "1"])
    if DETECTED_HERE in arguments:
        assert result.exit_code == 0
        assert f"{RECORDINGS} recordings, 1 checked" in result.output
        return
    assert result.exit_code == 1  # recording 000001 has no sound
    if "--json" in arguments:
        found = [entry["what"] for entry in json.loads(result.stdout) if entry["severity"] == "warning"]
        assert "audio is missing in 1 recording: 000001" in found
        return
    assert "every file can be read" in result.output
    assert "audio is missing in 1 recording: 000001" in result.output


@check("export detections")
def _(place: Place, arguments: list[str]) -> None:
    arguments[arguments.index(DETECTED_HERE)] = "000000"  # has detections beside its videos
    run(arguments)
    form = {"coco": "detections"}.get(arguments[-1], arguments[-1])
    written = sorted((place.folder / "OUT").glob(f"*/{form}/000000.json"))
    assert [path.parts[-3] for path in written] == sorted(METHOD_VIEWS)
    assert json.loads(written[0].read_text(encoding="utf-8"))


@check("export rerun")
def _(place: Place, arguments: list[str]) -> None:
    pytest.importorskip("rerun", reason="needs the extra exchange")
    arguments[arguments.index(DETECTED_HERE)] = "000000"
    run(arguments)
    assert (place.folder / "recording.rrd").read_bytes().startswith(b"RRF")


@check("masks next")
def _(place: Place, arguments: list[str]) -> None:
    if DETECTED_HERE not in arguments:
        made = ["estimate", str(place.dataset), "000000", "000001", "--preset", "tuned", "--run", "sure"]
        run([*made, "--out", str(place.folder / "sure.csv"), "--workers", "1"])
        lines = run(arguments).splitlines()
        assert sorted(line[:25] for line in lines if "%" in line) == [f"00000{n}: 90 % intervals of" for n in (0, 1)]
        assert run([*arguments, "--run", "sure"]) == run(arguments)
        return
    arguments[arguments.index(DETECTED_HERE)] = "000000"
    lines = run(arguments).splitlines()
    assert "the estimate uses it" in lines[0]
    assert len(lines) == 2


@check("masks import")
def _(_: Place, arguments: list[str]) -> None:
    assert f"{DETECTED_HERE}, view3: 1 masks by hand" in run(arguments)


@check("masks show")
def _(place: Place, arguments: list[str]) -> None:
    assert "has no masks by hand" in run([*arguments[:-1], "000003"])
    for view in ("view3", "view1"):
        run(["masks", "import", str(place.dataset), "000000", view, str(place.masks)])
    output = run([*arguments[:-1], "000000"])
    assert "by hand" in output
    assert "`paper`: " in output


@check("masks export")
def _(place: Place, arguments: list[str]) -> None:
    run(["masks", "import", str(place.dataset), DETECTED_HERE, "view3", str(place.masks), "--who", "Ada"])
    run(arguments)
    [entry] = json.loads((place.folder / "OUT" / "view3" / "by-hand" / f"{DETECTED_HERE}.json").read_text())
    assert (entry["source"], entry["who"]) == ("by hand", "Ada")


@check("train filling")
def _(place: Place, arguments: list[str]) -> None:
    output = run([*arguments, "--epochs", "1"])
    weights = Path(arguments[3]) / "filling.safetensors"
    assert str(weights) in output
    if "fused" in arguments:
        fused = FusedPredictor(weights)
        assert fused.predict(None, sight=np.ones((3, 2, 512), np.float32)).ok
        assert len(fused.config.sound) + len(fused.config.sight) <= 8
        return
    predictor = FillingPredictor(weights)
    front_end = LogMelParameters.of("released" if "released" in arguments else "paper")
    assert predictor.front_end == front_end
    assert predictor.predict(np.zeros((8, 3, 128), np.float32)).ok
    assert predictor.trained_on is not None
    recordings = open_dataset(place.dataset)
    seen = [predictor.trained_on.has_seen(recording) for recording in recordings]
    assert seen == [recording.audio_path is not None for recording in recordings]


@check("evaluate filling")
def _(place: Place, arguments: list[str]) -> None:
    output = run([*arguments, "--epochs", "1"])
    assert "Weighted F1 in %" in output
    predictions = pd.read_csv(place.run_of("evaluate filling") / "predictions.csv")
    assert len(predictions) == predictions["seed"].nunique() * (RECORDINGS - 1)  # one has no sound
    assert predictions["fold"].nunique() == 7


@check("train mass")
def _(place: Place, arguments: list[str]) -> None:
    output = run([*arguments, "--epochs", "2"])
    assert "epochs: 2" in output
    mask = np.ones((30, 20), dtype=bool)
    predictor = MassPredictor(Path(arguments[3]) / "mass.safetensors")
    predicted = predictor.predict(mask, width_top_mm=90.0, width_bottom_mm=70.0, height_mm=120.0, mm_per_px=2.0)
    assert predicted.mass_g is not None
    preset = "released" if "released" in arguments else "paper"
    assert replace(predictor.config, least_mass_g=None) == MassConfig.of(preset)
    if preset == "released":
        return
    folder = place.folder / "otherwise"
    options = ["--epochs", "1", "--shape", "lode", "--axis", "whole", "--padding", "9"]
    run(["train", "mass", str(place.dataset), str(folder), *options])
    network = MassPredictor(folder / "mass.safetensors")
    assert (network.config.axis, network.config.padding_px) == ("whole", 9)
    assert network.trained_on is not None
    assert network.trained_on.facts["shape"] == "lode"
    assert network.trained_on.facts["means"]["source"] == place.dataset.name


@check("evaluate mass")
def _(place: Place, arguments: list[str]) -> None:
    output = run(arguments)
    assert "no number comes from a network that was trained on the recording" in output
    assert judged(output) == len(open_dataset(place.others))
    assert "always the dataset's mean" in output
    weights = str(place.mass_network)
    own = CliRunner().invoke(cli.app, ["evaluate", "mass", str(place.dataset), weights])
    assert own.exit_code != 0
    assert f"{RECORDINGS} of {RECORDINGS} recordings are left out: the network was trained on them" in own.output
    assert "no recording is left to judge" in str(own.exception)
    stamped = run(["evaluate", "mass", str(place.dataset), weights, "--protocol", "in-sample", "--shape", "tuned"])
    assert judged(stamped) == RECORDINGS
    assert "In-sample" in stamped
    assert "trained on dimensions of the shape preset paper; these are of tuned" in stamped


def judged(output: str) -> int:
    """How many recordings the average of a mass table is over."""
    return int(next(line.split()[1] for line in output.splitlines() if line.startswith("average")))


@check("train wall")
def _(_: Place, arguments: list[str]) -> None:
    output = run(arguments)
    assert re.search(r"--preset tuned --wall \d+\.\d", output)


@check("train detector")
def _(place: Place, arguments: list[str]) -> None:
    output = run([*arguments, "--steps", "1", "--batch", "1", "--whole", "0"])
    weights = place.run_of("train detector") / "detector.safetensors"
    assert str(weights) in output
    assert detection.SmallDetector(weights, device="cpu").detect([np.zeros((90, 160, 3), np.uint8)])


@check("evaluate detector")
def _(_: Place, arguments: list[str]) -> None:
    output = run([*arguments, "--frames", "2"])
    assert re.search(r"all frames +2 ", output)
    assert "The worst frames" in output


@check("attribute")
def _(place: Place, arguments: list[str]) -> None:
    if "--ablation" in arguments:
        assert "tuned, no wall" in run([*arguments, "--workers", "1"])
        return
    run(["estimate", arguments[1], "--run", RUN_NAME, "--out", str(place.folder / "demo.csv"), "--workers", "1"])
    output = run([*arguments, "--workers", "1"])
    assert "with one stage replaced by the truth" in output
    assert ("rank correlation" in output) == ("--scatter" in arguments)
    assert (place.folder / "scores.html").stat().st_size > 1000


@check("runs list")
def _(place: Place, arguments: list[str]) -> None:
    assert place.estimates.is_file()
    assert f"{RUN_NAME} " in run(arguments)


@check("runs show")
def _(place: Place, arguments: list[str]) -> None:
    assert place.estimates.is_file()
    assert f"recordings: {RECORDINGS}" in run(arguments)


@check("runs export")
def _(place: Place, arguments: list[str]) -> None:
    written = place.estimates.read_bytes()
    place.estimates.unlink()
    run(arguments)
    assert place.estimates.read_bytes() == written


def other_run(place: Place, name: str, *options: str) -> str:
    """A run of one recording, which the command may change."""
    out = str(place.folder / "other.csv")
    run(["estimate", str(place.dataset), "000000", "--run", name, "--out", out, *options])
    return name


def listed(place: Place) -> dict[str, dict[str, str]]:
    return {row["name"]: row for row in json.loads(run(["runs", "list", str(place.dataset), "--json"]))}


@check("runs compare")
def _(place: Place, arguments: list[str]) -> None:
    assert place.estimates.is_file()
    output = run([*arguments[:-1], other_run(place, "other preset", "--preset", "lode")])
    assert re.search(r"shape.circumferences +145 +500", output)


@check("runs rename")
def _(place: Place, arguments: list[str]) -> None:
    run([*arguments[:3], other_run(place, "before"), arguments[-1]])
    assert {"before", arguments[-1]} & set(listed(place)) == {arguments[-1]}


@check("runs note")
def _(place: Place, arguments: list[str]) -> None:
    run([*arguments[:3], other_run(place, "noted"), arguments[-1]])
    assert listed(place)["noted"]["note"] == "thin wall"


@check("runs archive")
def _(place: Place, arguments: list[str]) -> None:
    run([*arguments[:-1], other_run(place, "old")])
    assert listed(place)["old"]["archived"]
    run([*arguments[:-1], "old", "--undo"])
    assert not listed(place)["old"]["archived"]


@check("runs delete")
def _(place: Place, arguments: list[str]) -> None:
    run([*arguments[:-1], other_run(place, "another")])
    assert "another" not in listed(place)


@check("runs restore")
def _(place: Place, arguments: list[str]) -> None:
    run(["runs", "delete", str(place.dataset), other_run(place, "lost")])
    run([*arguments[:-1], "lost"])
    assert "lost" in listed(place)


def test_the_library_example_runs(place: Place, capsys: pytest.CaptureFixture[str]) -> None:
    [example] = re.findall(r"```python\n(.*?)```", README, re.DOTALL)
    for written, here in {
        "/path/to/dataset": place.dataset,
        "000618": "000000",
        "RUN1/filling.safetensors": place.networks["filling"],
        "RUN2/mass.safetensors": place.networks["mass"],
    }.items():
        assert written in example
        example = example.replace(written, str(here))
    names: dict[str, object] = {}
    exec(compile(example, "README.md", "exec"), names)
    found = SimpleNamespace(**names)
    assert found.result.status == "fitted"
    assert found.result.fit.frame == found.best.frame
    np.testing.assert_array_equal(found.hull.radii_mm, found.result.fit.hull.radii_mm)
    assert f"fitted {found.result.capacity_ml}" in capsys.readouterr().out


def test_the_set_up_commands_name_what_is_there() -> None:
    start, tests = (line.removeprefix(SETUP).split() for line in OTHERS[:2])
    scripts = {script.name for script in entry_points(group="console_scripts")}
    assert Path(start[0]).name in scripts
    assert (REPOSITORY / start[-1]).is_file()
    assert subprocess.run([sys.executable, *tests[1:], "--version"], capture_output=True, check=True)


def test_what_is_installed_is_what_the_requirements_name() -> None:
    lines = (REPOSITORY / "requirements.txt").read_text(encoding="utf-8").splitlines()
    requirements = [Requirement(line) for line in lines if line and not line.startswith("#")]
    assert len(requirements) > 20
    unmet = {str(each): version(each.name) for each in requirements if version(each.name) not in each.specifier}
    assert unmet == {}


def test_the_continuous_integration_finds_the_readmes_test_command() -> None:
    [extraction] = re.findall(r"tests=\$\((.*)\)\n", (REPOSITORY / ".ci" / "run").read_text(encoding="utf-8"))
    found = subprocess.run(["bash", "-c", extraction], cwd=REPOSITORY, capture_output=True, text=True, check=True)
    assert found.stdout == OTHERS[1] + "\n"
