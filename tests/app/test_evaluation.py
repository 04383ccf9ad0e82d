"""The Evaluation page: run, judge, click through to the recording."""

from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from threading import Event
from typing import Any

import numpy as np
import pandas as pd
import pytest

import corsmal.filling.features  # noqa: F401 - loads PyTorch, before a test's clock runs
from corsmal.dataset import Dataset, open_dataset
from corsmal.dataset.clock import Matching
from corsmal.engines import local
from corsmal.engines.tasks import open_detector, open_predictors
from corsmal.evaluation import METRICS, container_table, error_table, estimates_table
from corsmal.figures.pin_collections import load_collection
from corsmal.parameters import ShapeParameters
from corsmal.runs import Run, list_runs, make_run
from corsmal.runs.run import save_run
from corsmal.stages.detections import load_detections
from corsmal.stages.estimates import Predictors
from corsmal.stages.settings import DetectorSettings, EstimateSettings, default_settings
from corsmal.ui import shared
from corsmal.ui.evaluation.downloads import estimates_file, submission_file
from corsmal.ui.evaluation.judged import Judged, runs
from corsmal.ui.evaluation.new_run import job_key
from corsmal.ui.evaluation.report import _made
from tests.app.driver import Visitor, seen
from tests.fakes import FakeDetector, FakeFilling, FakeMass

PAGE = "pages/evaluation.py"


@pytest.fixture(autouse=True)
def fake_networks(monkeypatch: pytest.MonkeyPatch) -> FakeDetector:
    """Runs are made in this process, with networks that know their answers; gives the detector."""

    def open_fakes(settings: EstimateSettings) -> Predictors:
        return Predictors(settings.shape, settings.means, FakeFilling(2, 1), FakeMass(20.0))

    detector = FakeDetector()
    monkeypatch.setattr(EstimateSettings, "open", open_fakes)
    monkeypatch.setattr(DetectorSettings, "open", lambda _, **_options: detector)
    monkeypatch.setattr(local, "default_workers", lambda: 1)
    open_predictors.cache_clear()
    open_detector.cache_clear()
    return detector


@pytest.fixture
def dataset(tiny_dataset_root: Path) -> Dataset:
    return open_dataset(tiny_dataset_root)


@pytest.fixture
def run(dataset: Dataset) -> Run:
    return recorded(dataset, "first")


def recorded(
    dataset: Dataset,
    name: str,
    shape: ShapeParameters | None = None,
    *,
    detector: DetectorSettings | None = None,
    stop_after: int | None = None,
) -> Run:
    settings = default_settings(dataset, shape=shape or ShapeParameters.paper(), detector=detector)
    done: list[int] = []
    return make_run(
        name,
        dataset,
        settings,
        store=shared.store(),
        progress=lambda step, _: done.append(step),
        cancelled=lambda: stop_after in done,
    )


def opened(root: object, section: str = "Containers") -> Visitor:
    """The page with a section of it; without a run there is none."""
    visitor = Visitor(root)
    visitor.test.switch_page(PAGE).run()
    with suppress(StopIteration):
        visitor.choose("section_control", section)
    return visitor


def no_job(_visitor: Visitor) -> bool:
    return not any(job.active for job in shared.jobs()._jobs.values())


def table(visitor: Visitor, number: int = 0) -> pd.DataFrame:
    return visitor.test.dataframe[number].value


def select(visitor: Visitor, number: int, *, cell: tuple[int, str] | None = None, row: int | None = None) -> None:
    """Click a cell or a row of a table."""
    key = visitor.test.dataframe[number].proto.id.split("-", 2)[2]
    chosen: dict[str, Any] = {"rows": [] if row is None else [row], "columns": [], "cells": [cell] if cell else []}
    visitor.test.session_state[key] = {"selection": chosen}
    visitor.test.run()


def title(visitor: Visitor) -> str:
    return visitor.test.title[0].value


def test_without_a_run_the_page_says_what_one_is_and_makes_it(dataset: Dataset) -> None:
    visitor = opened(dataset.root)
    assert "There is no run on this dataset yet" in visitor.sentences
    visitor.choose("evaluation_view", "runs")
    assert "There is no run on this dataset yet: make one under *Results*" in visitor.sentences
    visitor.choose("evaluation_view", "results")
    assert "Choose the parameters below and press *Run*" in visitor.sentences
    assert visitor.test.text_input(key="run_name paper 0").value == "paper"
    visitor.press("Run")
    visitor.wait_for(no_job)
    visitor.test.run()
    [kept] = list_runs(store=shared.store(), dataset=dataset.root)
    assert (kept.name, kept.is_complete, kept.settings.shape) == ("paper", True, ShapeParameters.paper())
    assert "summary" in visitor.plots
    visitor.choose("section_control", "Containers")
    assert len(table(visitor)) == 3 + 1
    assert "parameters: paper (L 145, d_max 1 mm)" in visitor.sentences
    assert visitor.crashes == visitor.errors == []


def test_table_2_is_the_librarys(run: Run, dataset: Dataset) -> None:
    visitor = opened(dataset.root)
    shown = table(visitor)
    expected = container_table(error_table(estimates_table(run.rows), dataset.table))
    assert list(shown["container"]) == list(expected["container"])
    for metric in METRICS:
        pd.testing.assert_series_equal(shown[metric], expected[metric], check_names=False)
    assert list(shown["failed"]) == list(expected["failures"])
    assert "for orientation, not for comparison" in visitor.sentences
    assert "Averages are compared with the paper's over the containers" in visitor.sentences


@pytest.mark.usefixtures("run")
@pytest.mark.parametrize(
    ("column", "page"),
    [("capacity_mape", "Shape"), ("difference height_mape", "Shape"), ("mass_mape", "Mass"), ("failed", "Frames")],
)
def test_a_click_on_a_number_lists_its_recordings_and_a_click_there_opens_one(
    dataset: Dataset, column: str, page: str
) -> None:
    visitor = opened(dataset.root)
    visitor.choose("protocol_control", "in-sample")  # the fake networks are of unknown origin
    assert not [name for name in table(visitor) if name.startswith("difference")]
    visitor.choose("table_side", "difference")
    row = 1  # of the small white cup, which has no detections and so gets the mean
    assert table(visitor)["container"].iloc[row] == "small white cup"
    select(visitor, 0, cell=(row, column))
    assert visitor.test.subheader[0].value.endswith("small white cup: 1 recording")
    assert list(table(visitor, 1).index) == ["000002"]
    select(visitor, 1, row=0)
    assert visitor.crashes == []
    assert title(visitor) == page
    assert visitor.address["recording"] == "000002"


def test_the_recording_opens_with_the_runs_parameters_pair_and_frame(dataset: Dataset) -> None:
    run = recorded(dataset, "own", ShapeParameters(circumferences=90))
    visitor = opened(dataset.root)
    select(visitor, 0, cell=(0, "capacity_mape"))
    select(visitor, 1, row=0)
    frame, pair = run.rows[0]["best_frame"], run.rows[0]["pair"].replace(" + ", "-")
    assert visitor.address == {
        "recording": "000000",
        "L": "90",
        "frame": str(frame),
        "pair": pair,
        "estimate": "shown",
        "run": run.short_id,
        "section": "Containers",
    }
    assert visitor.metrics["Capacity"] == f"{run.rows[0]['capacity_ml']:.0f} mL"


def test_a_runs_recording_opens_with_its_views_matched_as_in_the_run(dataset: Dataset) -> None:
    settings = default_settings(dataset, shape=ShapeParameters.paper(), matching=Matching(offsets_s=(("view1", 0.1),)))
    run = make_run("late", dataset, settings, store=shared.store())
    assert run.rows[0]["flags"] == "views-by-time"
    visitor = opened(dataset.root)
    assert "views matched: by time, view1 +0.1 s" in visitor.sentences
    select(visitor, 0, cell=(0, "capacity_mape"))
    select(visitor, 1, row=0)
    assert visitor.address["offset"] == "view1:0.1"
    assert visitor.address["frame"] == str(run.rows[0]["best_frame"])
    assert visitor.metrics["Capacity"] == f"{run.rows[0]['capacity_ml']:.0f} mL"
    visitor.open("frames")
    assert visitor.time_line["best"] == run.rows[0]["best_frame"]
    assert visitor.crashes == visitor.errors == []


def test_a_run_from_the_page_matches_the_views_as_is_chosen(dataset: Dataset) -> None:
    visitor = Visitor(dataset.root, match="index").open("evaluation")
    assert "The views of all recordings are matched by frame number" in visitor.sentences
    visitor.press("Run")
    visitor.wait_for(no_job)
    [kept] = list_runs(store=shared.store(), dataset=dataset.root)
    assert kept.settings.matching == Matching(by="index")
    assert visitor.crashes == visitor.errors == []


def test_flagged_rows_are_left_out_on_request_in_the_address_and_in_files(run: Run, dataset: Dataset) -> None:
    assert not opened(dataset.root).test.multiselect
    rows = [{**row, "flags": "implausible" * (row["recording_id"] == "000000")} for row in run.rows]
    save_run(replace(run, rows=tuple(rows)), store=shared.store())
    visitor = opened(dataset.root)
    control = visitor.test.multiselect(key="without_control")
    assert control.options == ["any (1)", "implausible (1)"]
    assert len(table(visitor)) == 3 + 1
    control.set_value(["implausible"]).run()
    assert visitor.address["without"] == "implausible"
    assert list(table(visitor)["container"]) == ["small white cup", "green glass", "Average"]
    assert "1 of 3 rows are left out, here, in downloads and in the report" in visitor.sentences
    visitor.choose("section_control", "Recordings")
    assert list(table(visitor).index) == ["000001", "000002"]
    judged = Judged(runs(dataset)[0], dataset, "held-out", ("implausible",))
    assert [line[:6] for line in estimates_file(judged).decode().splitlines()[1:]] == ["000001", "000002"]
    assert submission_file(judged).decode().splitlines()[1].startswith("0,-1,-1,")
    visitor.choose("evaluation_view", "runs")
    assert table(visitor)["failed"].tolist() == [2]
    again = Visitor(dataset.root, without="any", section="Containers").open("evaluation")
    assert len(table(again)) == 2 + 1
    assert again.crashes == again.errors == []


@pytest.mark.usefixtures("run")
def test_a_bar_lists_its_recordings_and_a_point_opens_its_own(dataset: Dataset) -> None:
    visitor = opened(dataset.root, "Errors")
    visitor.report("spread", click={"curve": 0, "x": 3, "y": 1, "customdata": "green glass"})
    assert visitor.test.subheader[0].value == "Capacity, green glass: 1 recording"
    visitor.report("spread", click={"curve": 2, "x": 3, "y": 1, "customdata": "000001"})
    assert title(visitor) == "Shape"
    assert visitor.address["recording"] == "000001"


@pytest.mark.usefixtures("run")
def test_a_click_on_what_is_not_there_changes_nothing(dataset: Dataset) -> None:
    visitor = opened(dataset.root, "Errors")
    visitor.report("spread", click={"curve": 0, "x": 3, "y": 1, "customdata": "no such cup"})
    assert visitor.crashes == []
    visitor.choose("section_control", "Confusion")
    visitor.report("confusion", click={"curve": 9, "x": "rice", "y": "water"})
    visitor.report("confusion", click={"curve": 0, "x": "beer", "y": 3})
    assert visitor.crashes == visitor.errors == []


@pytest.mark.usefixtures("run")
def test_a_cell_of_a_confusion_matrix_lists_its_recordings(dataset: Dataset) -> None:
    visitor = opened(dataset.root, "Confusion")
    assert "it was not estimated, does not count or is not annotated" in visitor.sentences  # of unknown origin
    visitor.choose("protocol_control", "in-sample")
    visitor.report("confusion", click={"curve": 1, "x": "rice", "y": "rice"})
    assert visitor.test.subheader[0].value == "glass, rice taken for rice: 0 recordings"  # it has no sound
    visitor.report("confusion", click={"curve": 1, "x": "no estimate", "y": "rice"})
    assert list(table(visitor).index) == ["000001"]
    select(visitor, 0, row=0)
    assert title(visitor) == "Filling"


@pytest.mark.usefixtures("run")
def test_confidence_has_its_error_and_a_threshold_that_stands_in_the_address(dataset: Dataset) -> None:
    visitor = opened(dataset.root, "Confidence")
    assert "No probability can be compared here" in visitor.sentences  # of unknown origin
    visitor.choose("protocol_control", "in-sample")
    sure = 100 * np.exp(3) / (np.exp(3) + 3)  # what the fake network gives rice; each recording with sound is judged
    shown = {metric.label: metric.value for metric in visitor.test.metric}
    answered, total = map(int, shown["Answered"].split(" of "))
    right = sum(dataset.table["filling_type"][dataset.table["missing"].map(lambda each: "audio" not in each)] == 2)
    assert answered == total > 0
    assert shown["Expected calibration error"] == f"{abs(sure - 100 * right / total):.1f} %"
    assert shown["Wrong among these"] == shown["Wrong if all are answered"] == f"{100 - 100 * right / total:.1f} %"
    visitor.test.slider(key="confidence_threshold").set_value(90.0).run()
    shown = {metric.label: metric.value for metric in visitor.test.metric}
    assert (shown["Answered"], shown["Wrong among these"]) == (f"0 of {total}", "–")
    assert visitor.address["sure"] == "90"
    assert visitor.crashes == visitor.errors == []


@pytest.mark.usefixtures("run")
def test_a_run_that_is_not_on_a_leaderboards_recordings_stands_apart_from_its_teams(dataset: Dataset) -> None:
    visitor = opened(dataset.root, "Leaderboard")
    own, teams = table(visitor), table(visitor, 1)
    assert list(own["team"]) == ["▶ first (this run, held-out)"]
    assert len(teams) == 12
    assert "KEIO-ICS" in list(teams["team"])
    assert not teams["team"].str.contains("first").any()
    assert "Scored as a set that is none of the challenge's" in visitor.sentences
    assert "cannot be ranked against each other" in visitor.sentences


@pytest.mark.usefixtures("run")
def test_a_run_on_a_leaderboards_recordings_stands_among_its_teams(dataset: Dataset) -> None:
    visitor = opened(dataset.root, "Leaderboard")
    visitor.test.selectbox(key="score_split").set_value("private").run()
    assert len(table(visitor)) == 1  # the filling's network is of unknown origin: not all of the set is scored
    visitor.choose("protocol_control", "in-sample")
    assert len(table(visitor)) == 13
    assert "▶ first (this run, in-sample)" in list(table(visitor)["team"])
    visitor.choose("leaderboard_split private", "public")
    assert len(table(visitor)) == 1
    assert visitor.crashes == visitor.errors == []


def test_in_sample_numbers_are_shown_when_wanted_and_stamped(run: Run, dataset: Dataset) -> None:
    visitor = opened(dataset.root)
    assert table(visitor)[["filling_type_mpf1", "mass_mape"]].isna().all(axis=None)
    assert (
        "Recordings left out, because a network was trained on them or may have been: Held-out: " in visitor.sentences
    )
    assert visitor.warnings == []
    visitor.choose("protocol_control", "in-sample")
    expected = container_table(error_table(estimates_table(run.rows), dataset.table, protocol="in-sample"))
    pd.testing.assert_series_equal(table(visitor)["mass_mape"], expected["mass_mape"], check_names=False)
    assert visitor.warnings[0].startswith("**In-sample: networks are judged on recordings that they were trained on")
    for section in ("Errors", "Confusion", "Leaderboard", "Recordings", "Report"):
        visitor.choose("section_control", section)
        assert visitor.warnings[0].startswith("**In-sample"), section


@pytest.mark.usefixtures("run")
def test_table_2_has_a_column_group_per_protocol_and_everything_beside_a_number(dataset: Dataset) -> None:
    visitor = opened(dataset.root)
    visitor.choose("more held-out", ["in-sample"])
    visitor.choose("table_side", "difference")
    shown = table(visitor)
    assert "in-sample: mass_mape" in shown
    assert "in-sample: difference mass_mape" in shown
    visitor.choose("table_side", "published")
    assert table(visitor)["published capacity_mape"].tolist()[:2] == [34.2, 42.8]
    visitor.choose("table_side", "interval")
    assert table(visitor)["interval capacity_mape"].isna().all()  # of one recording there is no interval
    visitor.choose("table_side", "counts")
    assert table(visitor)["counts capacity_mape"].tolist() == ["1", "1 (1)", "1", "3 (1)"]
    assert visitor.crashes == visitor.errors == []


@pytest.mark.usefixtures("run")
def test_recordings_are_filtered_and_a_number_opens_its_own_stage(dataset: Dataset) -> None:
    visitor = opened(dataset.root, "Recordings")
    assert list(table(visitor).index) == list(dataset.ids)
    visitor.test.toggle(key="rows_failed").set_value(True).run()
    assert list(table(visitor).index) == ["000001", "000002"]
    visitor.test.multiselect(key="rows_container").set_value(["green glass"]).run()
    select(visitor, 0, cell=(0, "Mass"))
    assert (title(visitor), visitor.address["recording"]) == ("Mass", "000001")


@pytest.mark.usefixtures("run")
def test_two_runs_are_compared(dataset: Dataset) -> None:
    assert "There is one run" in opened(dataset.root, "Compare").sentences
    recorded(dataset, "other", ShapeParameters.lode())
    visitor = opened(dataset.root, "Compare")
    points = [trace for trace in visitor.plots["comparison"]["figure"]["data"] if len(trace["x"])]
    assert {name for trace in points for name in trace["customdata"]} >= {"Capacity", "Height"}
    visitor.report("comparison", click={"curve": 0, "x": 1, "y": 1, "customdata": "Height"})
    assert any("**Height** by container" in text.value for text in visitor.test.markdown)
    assert visitor.test.subheader[0].value.startswith("Changed sides")
    assert visitor.crashes == []


@pytest.mark.usefixtures("run")
def test_attribution_is_told_in_a_sentence_per_stage(dataset: Dataset) -> None:
    visitor = opened(dataset.root, "Attribution")
    assert "known only for synthetic recordings" in visitor.sentences
    visitor.press("Attribute errors to stages")
    visitor.wait_for(no_job)
    visitor.test.run()
    told = next(seen(text.value) for text in visitor.test.markdown if "Dimensions" in text.value)
    assert "With the annotated capacity, widths and height " in told
    assert "With the annotated filling " in told
    shown = table(visitor)
    assert not [name for name in shown if "_" in name]
    average = shown[(shown["Container"] == "Average") & (shown["Error of"] == "Capacity")].set_index("Stage replaced")
    assert list(average.index) == ["Dimensions", "Filling"]
    assert average.loc["Dimensions", "With the truth (%)"] == 0
    assert shown["Share (%)"].dropna().between(0, 100).all()
    assert visitor.crashes == visitor.errors == []


@pytest.mark.usefixtures("run")
def test_attribution_refuses_a_run_of_other_networks(dataset: Dataset, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(EstimateSettings, "open", lambda settings: Predictors(settings.shape, mass=FakeMass(7.0)))
    visitor = opened(dataset.root, "Attribution")
    visitor.press("Attribute errors to stages")
    visitor.wait_for(no_job)
    visitor.test.run()
    assert "make a new run" in visitor.errors[0]


@pytest.mark.usefixtures("run")
def test_a_cell_of_the_sweep_takes_its_setting_to_the_shape_page(dataset: Dataset) -> None:
    visitor = opened(dataset.root, "Sweep")
    sweep(visitor)
    cells = visitor.plots["sweep"]["figure"]["data"][0]
    assert cells["customdata"][1][0][:4] == [40, 1.0, 0, 2]
    visitor.report("sweep", click={"curve": 0, "x": 0, "y": 1, "customdata": [40, 0.5, 0, 2]})
    assert title(visitor) == "Shape"
    assert (visitor.address["L"], visitor.address["dmax"]) == ("40", "0.5")


def sweep(visitor: Visitor) -> None:
    narrow(visitor)
    visitor.press("Sweep 4 settings over 2 recordings")
    visitor.wait_for(no_job)
    visitor.test.run()


def narrow(visitor: Visitor) -> None:
    """Two values of each parameter, the run's own among them."""
    own = next(str(each.key) for each in visitor.test.multiselect if str(each.key).startswith("sweep_circumferences"))
    visitor.test.multiselect(key=own).set_value([40, 145]).run()
    visitor.test.multiselect(key=own.replace("circumferences", "max_difference_mm")).set_value([0.5, 1.0]).run()


def test_a_sweep_belongs_to_its_run_and_outlives_the_session(dataset: Dataset, run: Run) -> None:
    other = recorded(dataset, "other", ShapeParameters(points=9))
    visitor = opened(dataset.root, "Sweep")
    assert visitor.test.selectbox(key="run_picker").value == other.short_id
    sweep(visitor)
    assert "sweep" in visitor.plots
    visitor.test.selectbox(key="run_picker").set_value(run.short_id).run()
    assert "sweep" not in visitor.plots
    later = opened(dataset.root, "Sweep")
    narrow(later)
    later.report("sweep", click={"curve": 0, "x": 0, "y": 1, "customdata": [40, 0.5, 0, 2]})
    assert title(later) == "Shape"
    assert later.address["N"] == "9"


def test_a_sweep_offers_only_what_the_runs_preset_uses(dataset: Dataset) -> None:
    recorded(dataset, "tuned", ShapeParameters.tuned())
    visitor = opened(dataset.root, "Sweep")
    assert visitor.widget("sweep_across tuned").options == [
        "Expected tilt (°)",
        "Wall (mm)",
        "Frames fitted",
        "L, circumferences",
    ]
    assert not {"d_max (mm)", "Expected tilt (°)"} & set(visitor.widget("sweep_down tuned").options)


def test_an_incomplete_run_is_shown_as_partial_and_can_be_resumed(dataset: Dataset) -> None:
    recorded(dataset, "half", stop_after=1)
    gate = Event()
    job = shared.jobs().start(job_key(dataset), "Run half", lambda _: gate.wait(60))
    visitor = opened(dataset.root)
    assert visitor.warnings == ["**Partial results**: 1 of 3 recordings are estimated so far."]
    assert len(table(visitor)) == 1 + 1
    assert visitor.progress == ["Run half …"]
    gate.set()
    visitor.wait_for(lambda _: not job.active)
    visitor.test.run()
    assert visitor.warnings == ["**Partial results**: this run is incomplete, 1 of 3 recordings are estimated."]
    visitor.press("Resume")
    visitor.wait_for(no_job)
    visitor.test.run()
    assert visitor.warnings == []
    assert list_runs(store=shared.store())[0].is_complete


@pytest.mark.parametrize(("stop_after", "button"), [(1, "Resume"), (None, "Update")])
def test_resuming_and_updating_detect_with_the_runs_detector(
    dataset: Dataset, fake_networks: FakeDetector, stop_after: int | None, button: str
) -> None:
    made = recorded(dataset, "half", detector=DetectorSettings(every=6), stop_after=stop_after)
    assert made.is_complete == (stop_after is None)
    if stop_after is None:  # new files: what was detected is of no use
        for path in (shared.store().root / "detections").glob("*/*.parquet"):
            path.unlink()
    fake_networks.seen = 0
    visitor = opened(dataset.root)
    visitor.press(button)
    visitor.wait_for(no_job)
    [run] = list_runs(store=shared.store())
    assert run.is_complete
    assert fake_networks.seen > 0
    assert run.rows[2]["status"] == "fitted"
    assert load_detections(dataset["000002"], store=shared.store()).views


@pytest.mark.usefixtures("run")
def test_a_bad_name_is_said_before_a_run_begins_and_one_with_a_good_name_is_shown(dataset: Dataset) -> None:
    visitor = opened(dataset.root)
    visitor.choose("run_preset", "lode")
    for name, said in (("first", "the name 'first' is taken"), ("<b>", "begins with a letter"), (" ", "needs a name")):
        visitor.test.text_input(key="run_name lode 1").set_value(name).run()
        visitor.press("Run")
        assert said in visitor.errors[0]
    assert [run.name for run in list_runs(store=shared.store())] == ["first"]
    visitor.test.text_input(key="run_name lode 1").set_value("a good name").run()
    visitor.press("Run")
    visitor.wait_for(no_job)
    visitor.test.run()
    [made] = [run for run in list_runs(store=shared.store()) if run.name == "a good name"]
    assert visitor.address["run"] == visitor.widget("run_picker").value == made.short_id
    assert visitor.errors == visitor.crashes == []


@pytest.mark.usefixtures("run")
def test_a_deleted_run_leaves_the_page_as_it_began_and_comes_back(dataset: Dataset) -> None:
    visitor = opened(dataset.root)
    visitor.press("Delete")
    assert "There is no run on this dataset yet" in visitor.sentences
    assert list_runs(store=shared.store()) == []
    visitor.press("Undo")
    assert [run.name for run in list_runs(store=shared.store())] == ["first"]
    assert len(table(visitor)) == 3 + 1
    assert visitor.crashes == visitor.errors == []


def test_without_annotation_the_estimates_are_still_shown(root: Path) -> None:
    next(root.glob("*annotation*")).unlink()
    recorded(open_dataset(root), "first")
    visitor = opened(root)
    assert "There is no annotation with a truth here" in visitor.sentences
    assert list(table(visitor).index) == ["000000"]
    assert visitor.crashes == visitor.errors == []


def test_missing_weights_are_said(dataset: Dataset, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    for name in ("FILLING", "MASS"):
        monkeypatch.setenv(f"CORSMAL_{name}_WEIGHTS", str(tmp_path / "none.safetensors"))
    assert opened(dataset.root).sentences.count("its weights are not in") == 2


@pytest.mark.usefixtures("run")
def test_report_holds_the_run_and_what_was_pinned(dataset: Dataset, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("BROWSER_PATH", "/nowhere/chrome")
    visitor = opened(dataset.root, "Report")
    assert "Nothing is pinned yet" in visitor.sentences
    visitor.choose("section_control", "Summary")
    visitor.press("Pin the figure")
    visitor.choose("section_control", "Report")
    visitor.open("shape")
    visitor.press("Pin the hull")
    visitor.open("evaluation")
    assert any("Hull of 000000" in element.value for element in visitor.test.markdown)
    assert "Nothing is pinned yet" not in visitor.sentences
    visitor.choose("report_title", "<b>Cups</b>")
    visitor.choose("report_author", "A. Author")
    visitor.press("Make report")
    visitor.wait_for(lambda seen: "Made: first_report.html" in seen.sentences)
    assert "The reader's browser will draw the figures: Drawing figures as files needs Chrome" in visitor.sentences
    page = next(iter(_made().values())).content.decode()
    of_run, _ = load_collection(visitor.link["pins"], dataset=dataset.fingerprint, store=shared.store()).pins
    assert (of_run.title, of_run.facts["run"]) == ("All metrics by container, run first", "first")
    assert of_run.facts["numbers"]["Capacity"].endswith(" %")
    assert "section=" not in of_run.facts["link"]  # the first one is the default
    assert "<h1>&lt;b&gt;Cups&lt;/b&gt;</h1>" in page
    assert "A. Author" in page
    assert "Hull of 000000" in page
    assert visitor.crashes == visitor.errors == []
