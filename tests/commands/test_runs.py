import json
from pathlib import Path

import pandas as pd
import pytest
from typer.testing import CliRunner

import corsmal.__main__ as cli
from corsmal.commands.runs import open_run
from corsmal.dataset import open_dataset
from corsmal.dataset.clock import Matching
from corsmal.engines import local
from corsmal.errors import ArgumentError, CorsmalError, NotFoundError
from corsmal.evaluation import read_estimates
from corsmal.figures.pin_collections import add_pins
from corsmal.figures.pins import Pin
from corsmal.parameters import ShapeParameters
from corsmal.runs import list_runs, load_run, make_run
from corsmal.stages.settings import DetectorSettings, default_settings
from corsmal.store import Store
from tests.fakes import FakeDetector
from tests.networks import write_networks


@pytest.fixture(autouse=True)
def place(tmp_path, monkeypatch):
    """An own store, untrained networks, and this process as the only worker."""
    monkeypatch.setenv("CORSMAL_CACHE", str(tmp_path / "cache"))
    monkeypatch.setenv("COLUMNS", "200")
    for kind, path in write_networks(tmp_path).items():
        monkeypatch.setenv(f"CORSMAL_{kind.upper()}_WEIGHTS", str(path))
    monkeypatch.setattr(local, "default_workers", lambda: 1)
    monkeypatch.chdir(tmp_path)


@pytest.fixture
def root(tiny_dataset_root):
    return tiny_dataset_root


def command(*arguments):
    result = CliRunner().invoke(cli.app, [str(argument) for argument in arguments], catch_exceptions=False)
    assert result.exit_code == 0, result.output
    return result.output


def kept(root):
    return list_runs(store=Store(), dataset=open_dataset(root).root)


def test_estimates_are_a_run_with_a_name_after_the_preset_that_an_equal_command_resumes(root):
    assert "Run: paper" in command("estimate", root)
    command("estimate", root)
    command("estimate", root, "000000")
    command("estimate", root, "--preset", "lode")
    assert [(run.name, len(run.rows)) for run in kept(root)[::-1]] == [("paper", 3), ("paper 2", 1), ("lode", 3)]


def test_the_environments_networks_are_used_and_noted(root):
    command("estimate", root, "000000")
    facts = kept(root)[0].facts()
    assert facts["filling network"].endswith("(environment)")
    command("estimate", root, "000000", "--mass", "demo")
    facts = kept(root)[0].facts()
    assert facts["mass network"].endswith("(named)")


def test_a_run_of_the_app_is_resumed_with_its_settings(root, monkeypatch):
    detector = FakeDetector()
    monkeypatch.setattr(DetectorSettings, "open", lambda _, **_options: detector)
    dataset, done = open_dataset(root), []
    settings = default_settings(dataset, shape=ShapeParameters(circumferences=60), detector=DetectorSettings(every=6))
    make_run(
        "mine",
        dataset,
        settings,
        store=Store(),
        progress=lambda step, _: done.append(step),
        cancelled=lambda: 2 in done,
    )
    assert detector.seen == 0
    command("estimate", root, "--run", "mine")
    run = load_run("mine", dataset=dataset.root, store=Store())
    assert run.is_complete
    assert run.settings == settings
    assert detector.seen > 0
    with pytest.raises(CorsmalError, match=r"'mine' is taken by a run with other settings \(different: parameters"):
        command("estimate", root, "--run", "mine", "--preset", "tuned", "--detector", "coco")


def test_recordings_without_detections_are_detected_in_where_that_is_asked_for(root, monkeypatch):
    detector = FakeDetector()
    monkeypatch.setattr(DetectorSettings, "open", lambda _, **_options: detector)
    command("estimate", root, "000002", "--detector", "demo", "--out", "one.json")
    assert detector.seen > 0
    assert read_estimates("one.json")["status"].tolist() == ["fitted"]


def test_runs_are_listed_shown_exported_and_deleted(root):
    assert "There are no runs." in command("runs", "list", root)
    command("estimate", root, "--run", "mine", "--out", "written.csv")
    assert "3 of 3" in command("runs", "list", root)
    [listed] = json.loads(command("runs", "list", root, "--json"))
    assert listed["name"] == "mine"
    shown = command("runs", "show", root, "mine")
    assert "parameters: paper (L 145, d_max 1 mm)" in shown
    assert "mass weights: " in shown
    assert "estimates: 2 fitted" in shown
    assert json.loads(command("runs", "show", root, "mine", "--json"))["recordings"] == "3 of 3"
    for ending in ("csv", "json", "parquet"):
        command("runs", "export", root, "mine", f"exported.{ending}")
        assert read_estimates(f"exported.{ending}")["status"].tolist()[:2] == ["fitted"] * 2
    assert Path("exported.csv").read_bytes() == Path("written.csv").read_bytes()
    command("runs", "delete", root, "mine")
    assert kept(root) == []


def test_a_run_that_is_not_there_is_said_with_those_that_are(root):
    command("estimate", root, "000000", "--run", "mine")
    for arguments in (("runs", "show"), ("runs", "delete"), ("submit",), ("attribute",)):
        with pytest.raises(NotFoundError, match=r"there is no run 'yours' on .*; runs: mine"):
            command(*arguments, root, "yours")
    with pytest.raises(NotFoundError, match=r"there is no deleted run 'mine' on .*; deleted runs: none"):
        command("runs", "restore", root, "mine")
    with pytest.raises(CorsmalError, match="a run's name begins with a letter or digit"):
        command("runs", "rename", root, "mine", "<b>mine</b>")


def test_a_submission_has_a_row_for_every_recording_of_the_dataset(root):
    command("estimate", root, "000001", "--run", "mine")
    command("submit", root, "mine", "submission.csv")
    table = pd.read_csv("submission.csv")
    assert table["Configuration ID"].tolist() == [0, 1, 2]
    assert (table["Container capacity"] > 0).tolist() == [False, True, False]


def test_errors_are_attributed_as_on_the_page(root):
    command("estimate", root, "--run", "mine")
    output = command("attribute", root, "mine")
    for stage in ("as it is", "dimensions", "filling"):
        assert stage in output
    assert "With the annotated capacity, widths and height " in output
    assert "With the annotated filling " in output
    result = CliRunner().invoke(cli.app, ["attribute", str(root)])
    assert result.exit_code == 2


def test_a_report_shows_a_collection_of_pins_and_says_what_there_is_instead(root, monkeypatch):
    monkeypatch.setenv("BROWSER_PATH", "/nowhere/chrome")
    command("estimate", root, "000000")
    pin = Pin("The picture", content=b"x", medium="image/png")
    add_pins("talk", [pin], dataset=open_dataset(root).fingerprint, store=Store())
    command("report", root, "paper", "--pins", "talk", "--title", "A talk")
    written = Path("report.html").read_text(encoding="utf-8")
    assert "<h1>A talk</h1>" in written
    assert "The picture" in written
    for arguments, problem in (
        (["paper", "--pins", "lecture"], "there is no pin in a collection 'lecture'"),
        (["nobody"], "there is no run 'nobody'"),
        (["paper", "--against", "lode"], "there is no run 'lode'"),
    ):
        with pytest.raises(NotFoundError, match=problem):
            command("report", root, *arguments)


def test_views_are_matched_as_asked_and_flagged_rows_left_out(root, tmp_path):
    written = {}
    for name, options in {"plain": (), "later": ("--offset", "view1=0.1"), "number": ("--match", "index")}.items():
        written[name] = tmp_path / f"{name}.csv"
        command("estimate", root, "000000", "--out", written[name], *options)
    rows = {name: read_estimates(path).iloc[0] for name, path in written.items()}
    assert [row["flags"] for row in rows.values()] == ["", "views-by-time", ""]
    assert "view1 has 12 frames at 30 fps" in rows["later"]["notes"]
    assert rows["plain"]["capacity_ml"] == rows["number"]["capacity_ml"] != rows["later"]["capacity_ml"]
    assert "1 of 2 rows" not in command("evaluate", "estimates", root, written["plain"], "--without", "any")
    assert [open_run(root, name)[1].settings.matching for name in ("paper 2", "paper 3")] == [
        Matching(offsets_s=(("view1", 0.1),)),
        Matching(by="index"),
    ]
    assert "views matched: by frame number" in command("runs", "show", root, "paper 3")
    again = command("estimate", root, "--run", "paper 2", "--out", tmp_path / "again.csv")
    assert (tmp_path / "again.csv").read_bytes() == written["later"].read_bytes(), again
    with pytest.raises(ArgumentError, match="different: matching of the views"):
        command("estimate", root, "000000", "--run", "paper 2", "--match", "index")
    refused = CliRunner().invoke(cli.app, ["estimate", str(root), "--offset", "view1"])
    assert refused.exit_code == 2
    assert "is not like view1=0.4" in refused.output


@pytest.mark.parametrize(
    "words",
    [
        ("detect", "ROOT"),
        ("reproduce", "ROOT", "--out", "out"),
        ("train", "mass", "ROOT", "run"),
        ("evaluate", "mass", "ROOT"),
        ("train", "wall", "ROOT"),
    ],
)
def test_commands_that_fit_or_detect_match_views_as_asked(root, words):
    arguments = [str(root) if word == "ROOT" else word for word in words]
    for option, said in (("view1", "is not like view1=0.4"), ("view1=x", "is not like view1=0.4")):
        refused = CliRunner().invoke(cli.app, [*arguments, "--offset", option])
        assert (refused.exit_code, said in refused.output) == (2, True)
    both = CliRunner().invoke(cli.app, [*arguments, "--match", "index", "--offset", "view1=0.1"])
    assert isinstance(both.exception, ArgumentError)


def test_recordings_that_fail_are_named_with_the_reason(tmp_path):
    for view, ids in {"view1": range(4), "view2": range(3), "view3": range(3)}.items():
        (tmp_path / "set" / view / "rgb").mkdir(parents=True)
        for number in ids:
            (tmp_path / "set" / view / "rgb" / f"{number:06d}.mp4").write_bytes(b"no video")
    (tmp_path / "set" / "audio").mkdir()
    (tmp_path / "set" / "audio" / "000001.wav").write_bytes(b"no sound")
    said = command("estimate", tmp_path / "set").splitlines()
    [first] = [line for line in said if line.startswith("000000 and 2 more: ")]
    assert "no detections for view3 and view1" in first
    [second] = [line for line in said if line.startswith("000001: ")]
    assert str(tmp_path / "set" / "audio" / "000001.wav") in second
    assert "estimates.csv: 4 failed" in said
