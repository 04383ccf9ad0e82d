"""The Evaluation page repeats the paper's evaluation by the same call as the command, and each shows the other's."""

import time
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from corsmal.dataset import open_dataset
from corsmal.engines import local
from corsmal.runs import Reproduction, reproduce
from corsmal.runs.reproduction_kept import SUMMARY, read_reproduction
from corsmal.runs.reproduction_settings import ReproductionSettings, plan
from corsmal.store import Store
from corsmal.ui import shared
from corsmal.ui.evaluation.new_reproduction import job_key
from tests.app.driver import Visitor
from tests.runs.test_reproduction import QUICK, write_dataset
from tests.tiny import write_tiny_dataset

pytestmark = pytest.mark.filterwarnings("ignore:.*isinstance.treespec, LeafSpec.*")  # Lightning's own call of PyTorch
TIMEOUT_S = 600


@pytest.fixture(autouse=True)
def one_process(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(local, "default_workers", lambda: 1)


@pytest.fixture(scope="module")
def root(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_dataset(tmp_path_factory.mktemp("set") / "ROOT")


@pytest.fixture(scope="module")
def test_root(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_tiny_dataset(tmp_path_factory.mktemp("set") / "TEST", frames=3)


@pytest.fixture(scope="module")
def cache(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("cache")


@pytest.fixture(scope="module")
def commanded(root: Path, test_root: Path, cache: Path, tmp_path_factory: pytest.TempPathFactory) -> Reproduction:
    """As the command makes it."""
    out = tmp_path_factory.mktemp("out")
    return reproduce(root, out=out, settings=QUICK, tests=[test_root], store=Store(cache))


@pytest.fixture
def same_store(cache: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("CORSMAL_CACHE", str(cache))


def opened(root: Path, *, out: Path | None = None) -> Visitor:
    visitor = Visitor(root).open("evaluation")
    visitor.choose("evaluation_view", "reproduction")
    if out is not None:
        [folder] = [each for each in visitor.test.text_input if each.label == "Output folder"]
        folder.set_value(str(out)).run()
    return visitor


def tables(visitor: Visitor) -> list[pd.DataFrame]:
    return [frame.value for frame in visitor.test.dataframe]


def ended(out: Path) -> str:
    """The state in which the job of an output folder ends."""
    job = shared.jobs().get(job_key(out.resolve()))
    assert job is not None
    deadline = time.monotonic() + TIMEOUT_S
    while job.active:
        assert time.monotonic() < deadline, job.label
        time.sleep(0.2)
    return job.state


def files_of(folder: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in folder.iterdir()}


def test_the_plan_of_the_chosen_settings_is_shown_before_it_starts(root: Path, test_root: Path) -> None:
    visitor = opened(root)
    visitor.choose("reproduction_seeds", 3)
    visitor.choose("reproduction_protocol", "paper")
    visitor.choose("reproduction_tests", str(test_root))
    [shown] = tables(visitor)
    expected = plan(open_dataset(root), ReproductionSettings(protocol="paper", seeds=3), [open_dataset(test_root)])
    assert list(shown["step"]) == [step.name for step in expected]
    assert list(shown["what"]) == [step.what for step in expected]
    assert "on two cores where nothing is kept yet" in visitor.sentences
    visitor.choose("reproduction_networks", "released")
    [shown] = tables(visitor)
    assert "21 networks of 100 epochs" in list(shown["what"])
    assert visitor.crashes == visitor.errors == []


@pytest.mark.usefixtures("same_store")
def test_the_page_shows_what_the_command_made(commanded: Reproduction, root: Path) -> None:
    visitor = opened(root, out=commanded.out)
    assert visitor.crashes == visitor.errors == []
    _, table_2, scores = tables(visitor)
    averages = commanded.table2[commanded.table2["container_id"].isna()].set_index("metric")
    for metric, value in averages["value"].items():
        np.testing.assert_allclose(table_2[metric].iloc[-1], value)
    assert scores["team"].str.startswith("this program").tolist() == [True]
    assert {"fig3_filling_level", "fig3_filling_type"} <= set(visitor.plots)
    assert "a first look, not a result" in "\n".join(visitor.warnings)
    labels = [each.label for each in visitor.test.get("download_button")]
    assert {"Report (HTML)", "Estimates (CSV)", "Submission TEST (CSV)", "LaTeX", "Markdown"} <= set(labels)


@pytest.mark.usefixtures("same_store")
def test_a_click_on_a_number_of_table_2_lists_its_recordings(commanded: Reproduction, root: Path) -> None:
    visitor = opened(root, out=commanded.out)
    key = visitor.test.dataframe[1].proto.id.split("-", 2)[2]
    visitor.test.session_state[key] = {"selection": {"rows": [], "columns": [], "cells": [(0, "capacity_mape")]}}
    visitor.test.run()
    assert any(each.value.startswith("Capacity, red cup: 7 recordings") for each in visitor.test.subheader)


@pytest.mark.usefixtures("same_store")
def test_stopped_on_the_page_and_resumed_it_leaves_the_command_s_bytes(
    commanded: Reproduction, root: Path, test_root: Path, tmp_path: Path
) -> None:
    visitor = opened(root, out=tmp_path / "out")
    visitor.choose("reproduction_quick", True)
    visitor.choose("reproduction_tests", str(test_root))
    visitor.press("Reproduce Table 2")
    visitor.wait_for(lambda visitor: any("Reproducing Table 2, " in text for text in visitor.progress))
    visitor.press("Stop")
    assert ended(tmp_path / "out") == "cancelled"
    visitor.test.run()
    assert "started again with the same settings, it resumes" in visitor.sentences
    visitor.press("Reproduce Table 2")
    assert ended(tmp_path / "out") == "done"
    visitor.test.run()
    assert len(tables(visitor)) == 3
    folder = commanded.report.parent
    assert files_of(tmp_path / "out" / folder.name) == files_of(folder)


@pytest.mark.usefixtures("same_store")
def test_what_is_wrong_with_the_input_is_said(commanded: Reproduction, root: Path, test_root: Path) -> None:
    visitor = opened(root)
    visitor.choose("reproduction_features", "/no/such/folder")
    assert visitor.errors == ["/no/such/folder: there is no such folder of features"]
    visitor.choose("reproduction_features", "")
    visitor.choose("reproduction_tests", "/no/such/test")
    assert "/no/such/test" in visitor.errors[0]
    visitor = opened(test_root, out=commanded.out)
    visitor.press("Reproduce Table 2")
    visitor.wait_for(lambda visitor: visitor.errors)
    assert "holds the reproduction of another dataset (ROOT)" in visitor.errors[0]


def test_a_broken_summary_is_reported_and_the_page_stays(commanded: Reproduction, root: Path, tmp_path: Path) -> None:
    folder = tmp_path / "out" / "held-out-spread"
    folder.mkdir(parents=True)
    (folder / SUMMARY).write_text("{")
    visitor = opened(root, out=tmp_path / "out")
    assert "is broken or of another version; make the reproduction again" in visitor.errors[0]
    assert len(tables(visitor)) == 1
    assert read_reproduction(commanded.report.parent).settings == QUICK
