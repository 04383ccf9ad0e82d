import os
from dataclasses import replace
from pathlib import Path

import pytest

from corsmal.dataset import open_dataset
from corsmal.dataset.clock import Matching
from corsmal.errors import ArgumentError, FileError
from corsmal.parameters import SelectionParameters, ShapeParameters
from corsmal.runs import Run, list_runs, load_run
from corsmal.runs.making import data_digest
from corsmal.runs.run import first_id, named_run, save_run
from corsmal.stages.settings import DetectorSettings
from corsmal.store import Store
from corsmal.weights import WeightsFile
from tests.tiny import write_tiny_dataset


def assert_same(run: Run, other: Run | None) -> None:
    assert other is not None
    for name in Run.__dataclass_fields__:
        assert getattr(run, name) == getattr(other, name)
    assert run.key == other.key


def test_a_run_survives_the_program(run, dataset, store):
    assert_same(run, load_run("first", dataset=dataset.root, store=Store(store.root)))


def test_settings_survive_too(run, dataset, store):
    settings = replace(
        run.settings,
        shape=replace(ShapeParameters.lode(), circumferences=40, max_difference_mm=0.35),
        filling=WeightsFile("filling", Path("/weights/filling.safetensors"), "environment"),
        features=Path("/features"),
        detector=DetectorSettings("demo", Path("/weights/detector.safetensors"), every=7),
        matching=Matching(offsets_s=(("view1", 0.4), ("view2", -0.1))),
    )
    own = replace(run, name="own", id="", settings=settings, digests={**run.digests, "detector": "small 1"})
    save_run(own, store=store)
    assert_same(own, load_run("own", dataset=dataset.root, store=Store(store.root)))
    assert own.preset == "own parameters"
    assert own.facts()["views matched"] == "by time, view1 +0.4 s, view2 −0.1 s"


def test_a_run_keeps_its_selection_and_its_pairs(run, dataset, store):
    shape = replace(ShapeParameters.released(), pairs=(("view2", "view3"),))
    settings = replace(run.settings, shape=shape, selection=SelectionParameters.released())
    own = replace(run, name="own", id="", settings=settings)
    save_run(own, store=store)
    assert_same(own, load_run("own", dataset=dataset.root, store=Store(store.root)))
    assert own.facts()["selection"] == "released"
    assert own.key != run.key
    assert replace(own, settings=replace(settings, selection=SelectionParameters())).key != own.key


def test_a_run_of_an_earlier_version_selected_by_the_papers_rules(run, dataset, store):
    content = store.json("runs", run.id)
    del content["settings"]["selection"], content["settings"]["shape"]["pairs"]
    store.save_json("runs", run.id, content)
    assert_same(run, load_run("first", dataset=dataset.root, store=store))


def test_a_run_of_an_earlier_version_matched_its_views_by_time(run, dataset, store):
    content = store.json("runs", run.id)
    assert content is not None
    assert content["settings"].pop("matching") == {"by": "time", "offsets_s": []}
    store.save_json("runs", run.id, content)
    assert_same(run, load_run("first", dataset=dataset.root, store=store))


def test_a_run_keeps_which_masks_it_used_and_an_earlier_version_used_the_detected_ones(run, dataset, store):
    own = replace(run, name="own", id="", settings=replace(run.settings, masks="by-hand"))
    save_run(own, store=store)
    assert_same(own, load_run("own", dataset=dataset.root, store=Store(store.root)))
    assert own.facts()["masks"] == "by hand where present"
    assert own.conditions["masks"] == "by-hand"
    assert own.key != run.key
    content = store.json("runs", run.id)
    assert content["settings"].pop("masks") == "detected"
    store.save_json("runs", run.id, content)
    assert_same(run, load_run("first", dataset=dataset.root, store=store))


@pytest.mark.parametrize("name", ["", "   ", "x" * 61, "a\nb"])
def test_what_can_be_no_name_is_refused(run, name):
    with pytest.raises(ArgumentError, match="a run's name must be 1 to 60 printable characters"):
        replace(run, name=name)


def test_runs_are_listed_by_dataset_the_newest_first(run, dataset, store):
    save_run(replace(run, name="newer", id="", created="2999-01-01T00:00:00+00:00"), store=store)
    save_run(replace(run, dataset="/elsewhere", id=""), store=store)
    assert [found.name for found in list_runs(store=store, dataset=dataset.root)] == ["newer", "first"]
    assert len(list_runs(store=store)) == 3
    assert [found.dataset for found in list_runs(store=store, dataset="/elsewhere")] == ["/elsewhere"]


def test_a_file_of_an_earlier_version_without_an_id_is_found_under_its_key(run, dataset, store):
    content = store.json("runs", run.id)
    assert content is not None
    assert not {"note", "is_archived"} & set(content)
    del content["id"]
    store.save_json("runs", run.id, content)
    found = load_run("first", dataset=dataset.root, store=store)
    assert_same(run, found)
    assert run.id == first_id("first", str(dataset.root))


@pytest.mark.usefixtures("run")
@pytest.mark.parametrize("change", [{"name": ""}, {"settings": 3}, {"rows": None}, {"shape": {}}])
def test_what_another_version_wrote_is_no_run(store, change):
    path = next((store.root / "runs").glob("*/*.json"))
    content = store.json("runs", path.stem)
    store.save_json("runs", path.stem, {**content, **change})
    assert list_runs(store=store) == []
    del content["settings"]
    store.save_json("runs", path.stem, content)
    assert list_runs(store=store) == []


@pytest.mark.usefixtures("run")
def test_a_broken_file_is_set_aside(store):
    next((store.root / "runs").glob("*/*.json")).write_bytes(b"{")
    assert list_runs(store=store) == []
    assert "cannot be read" in store.problems[-1]


def test_changed_conditions_files_and_rows_have_other_digests(run, tmp_path):
    root = write_tiny_dataset(tmp_path / "set", recordings=1, frames=1)
    before = data_digest(open_dataset(root))
    os.utime(root / "audio" / "000000.wav", ns=(1, 1))
    assert data_digest(open_dataset(root)) != before
    assert replace(run, rows=run.rows[:1]).key != run.key
    assert replace(run, data_digest=before).key != run.key
    assert replace(run, method_version=run.method_version + 1).key != run.key
    assert replace(run, name="other", engine="elsewhere").key == run.key


def test_an_address_names_a_run_by_its_id_whatever_it_is_called_or_as_older_ones_by_its_name(run):
    other = replace(run, name=run.short_id, id="")
    renamed = replace(run, name="renamed")
    assert named_run([other, renamed], run.short_id) is renamed
    assert named_run([other, renamed], "renamed") is renamed
    assert named_run([other, renamed], "first") is None
    assert named_run([other, renamed], None) is None


def test_a_run_is_described(run):
    weights = WeightsFile("mass", Path("/mass.safetensors"), "bundled")
    detector = DetectorSettings("demo", Path("/detector.safetensors"), every=10)
    made = replace(
        run,
        settings=replace(run.settings, mass=weights, detector=detector),
        digests={"filling": None, "mass": f"mass network {64 * 'a'}", "detector": f"small {64 * 'b'}, score 0.05"},
        rows=run.rows[:2],
    )
    facts = made.facts()
    assert facts["parameters"] == "paper (L 145, d_max 1 mm)"
    assert facts["filling network"] == "none"
    lode = replace(made, settings=replace(made.settings, shape=ShapeParameters.lode()))
    assert lode.facts()["parameters"] == "lode (L 500)"  # it smooths no profile
    assert facts["mass network"] == "mass network aaaaaaaa (bundled)"
    assert facts["detector"] == "small bbbbbbbb score 0.05, every 10 frames"
    assert facts["recordings"] == "2 of 3"


def test_a_run_that_cannot_be_kept_is_an_error(run, blocked):
    with pytest.raises(FileError, match="the run could not be kept"):
        save_run(run, store=blocked)
