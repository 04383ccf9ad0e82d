import errno
import html
import json
import os
import shutil
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import soundfile

from corsmal.dataset import Recording, open_dataset
from corsmal.errors import ArgumentError, FileError
from corsmal.evaluation import read_estimates
from corsmal.filling import (
    FillingConfig,
    FillingPredictor,
    FillingTraining,
    FusedPredictor,
    LogMelParameters,
    log_mel,
)
from corsmal.mass import MassConfig, MassPredictor
from corsmal.parameters import ShapeParameters
from corsmal.runs import reproduce
from corsmal.runs.reproduction_kept import read_reproduction, results_folder
from corsmal.runs.reproduction_results import CancelledError
from corsmal.runs.reproduction_settings import ReproductionSettings, _mel_epoch_s, named_tests, plan
from corsmal.store import Store
from corsmal.weights import read_training
from tests.networks import untrained_filling, untrained_mass
from tests.tiny import write_tiny_dataset

pytestmark = pytest.mark.filterwarnings("ignore:.*isinstance.treespec, LeafSpec.*")  # Lightning's own call of PyTorch

FILLINGS = ((0, 0), (1, 1), (1, 2), (2, 1), (2, 2), (3, 1), (3, 2))
FULL, QUICK = ReproductionSettings(), ReproductionSettings(is_quick=True)
COUNT = 21


def write_dataset(root, *, recordings=COUNT):
    """Recordings of two frames, whose containers and fillings are spread."""
    write_tiny_dataset(root, recordings=recordings, frames=2)
    change_annotation(root, lambda index: FILLINGS[index % len(FILLINGS)])
    return root


def change_annotation(root, filling):
    """Give every recording the filling type and level of its place."""
    path = next(root.glob("*annotation.json"))
    content = json.loads(path.read_text())
    for index, row in enumerate(content["annotations"]):
        row["filling type"], row["filling level"] = filling(index)
    path.write_text(json.dumps(content))


@pytest.fixture(scope="module")
def root(tmp_path_factory):
    return write_dataset(tmp_path_factory.mktemp("set") / "ROOT")


@pytest.fixture(scope="module")
def test_root(tmp_path_factory):
    """A test set: other recordings of the same numbers."""
    root = write_tiny_dataset(tmp_path_factory.mktemp("set") / "TEST", frames=3)
    path = next(root.glob("*annotation.json"))
    content = json.loads(path.read_text())
    for row in content["annotations"]:
        row["container id"] += 9
    path.write_text(json.dumps(content))
    return root


@pytest.fixture
def untrained(monkeypatch):
    leave_untrained(monkeypatch)


def leave_untrained(patch):
    """Networks are as they are before their first epoch, which takes no time."""
    patch.setattr("corsmal.filling.training.fit_network", untrained_filling)
    patch.setattr("corsmal.filling.loop.kept_epoch", lambda folder: (1, float(folder.parent.name == "fold2")))
    patch.setattr("corsmal.mass.training._fit", untrained_mass)


@pytest.fixture(scope="module")
def made(root, test_root, tmp_path_factory):
    out, states = tmp_path_factory.mktemp("out"), []
    store = Store(tmp_path_factory.mktemp("cache"))
    with pytest.MonkeyPatch.context() as patch:
        leave_untrained(patch)
        found = reproduce(root, out=out, settings=QUICK, tests=[test_root], store=store, progress=states.append)
    return found, states, store


def refuse(*_args, **_options):
    raise AssertionError("this should have been kept")


def files_of(folder):
    return {str(path.relative_to(folder)): path.read_bytes() for path in sorted(folder.rglob("*")) if path.is_file()}


def test_every_number_of_a_network_is_held_out(made):
    found, _, _ = made
    rows = found.rows[found.rows["filling_type"].notna()]
    assert len(found.rows) == COUNT
    assert rows["filling_held_out"].all()
    assert found.rows.loc[found.rows["container_mass_g"].notna(), "mass_held_out"].all()
    averages = found.table2[found.table2["container_id"].isna()].set_index("metric")
    assert averages.loc["capacity_mape", "recordings"] == COUNT
    assert averages["left_out"].eq(0).all()


def test_it_leaves_tables_submission_and_report(made):
    found, _, _ = made
    folder = found.report.parent
    assert folder.name == "held-out-spread-quick"
    assert {path.name for path in folder.iterdir()} >= {
        "table2.csv",
        "table2.tex",
        "table2.md",
        "table2.html",
        "estimates.csv",
        "submission_TEST.csv",
        "report.html",
    }
    assert len(read_estimates(folder / "estimates.csv")) == COUNT
    submission = pd.read_csv(folder / "submission_TEST.csv")
    assert len(submission) == 3
    assert (submission["Execution time"] > 0).any()
    report = found.report.read_text(encoding="utf-8")
    assert "no network was trained on a recording that it is judged on" in report
    assert "a first look, not a result" in report


@pytest.mark.usefixtures("untrained")
def test_tables_of_other_settings_are_not_written_over(root, made, tmp_path):
    _, _, store = made
    lode = ShapeParameters.lode()
    variants = {
        "held-out-spread-quick": QUICK,
        "held-out-spread-tuned-quick": replace(QUICK, networks="tuned"),
        "held-out-spread-quick-2": replace(QUICK, shape=lode),
        "held-out-spread-released-quick": replace(QUICK, networks="released"),
    }
    for name, settings in variants.items():
        folder = results_folder(tmp_path, settings)
        assert folder.name == name
        if settings.networks == "paper":
            assert reproduce(root, out=tmp_path, settings=settings, store=store).report.parent == folder
    first, second = (read_estimates(tmp_path / name / "estimates.csv") for name in list(variants)[::2])
    assert not first["capacity_ml"].equals(second["capacity_ml"])
    assert [results_folder(tmp_path, settings).name for settings in variants.values()] == list(variants)


def test_weights_keep_only_what_matters_to_their_estimates(made):
    found, _, _ = made
    for kind in ("filling", "mass"):
        weights = list(found.out.rglob(f"{kind}.safetensors"))
        assert len(weights) > 1
        for path in weights:
            facts = read_training(path, kind)["facts"]
            assert "means" in facts
            assert facts.get("shape") == ("paper" if kind == "mass" else None)


def test_progress_names_the_steps_in_order_and_ends(made):
    _, states, _ = made
    order = list(dict.fromkeys(state.step for state in states))
    assert order == ["geometry", "features", "filling", "masks", "mass", "final networks", "test TEST", "tables"]
    shares = [state.share for state in states]
    assert shares == sorted(shares)
    assert shares[-1] == 1
    assert all(state.left_s >= 0 for state in states)


def test_a_second_call_trains_nothing_and_gives_the_same_bytes(made, root, test_root, monkeypatch):
    found, _, store = made
    before = files_of(found.out)

    monkeypatch.setattr("corsmal.filling.training.fit_network", refuse)
    monkeypatch.setattr("corsmal.mass.training._fit", refuse)
    reproduce(root, out=found.out, settings=QUICK, tests=[test_root], store=store)
    assert files_of(found.out) == before


@pytest.mark.usefixtures("untrained")
def test_a_reproduction_that_is_killed_in_every_step_is_resumed_to_the_same_bytes(made, root, test_root, tmp_path):
    """What an epoch was killed in is for tests of the trainings."""
    _, _, store = made
    whole, killed = [
        partial(reproduce, root, out=tmp_path / name, settings=QUICK, tests=[test_root], store=store)
        for name in ("whole", "killed")
    ]
    whole()

    class Killed(BaseException):
        pass

    for step in ("geometry", "features", "filling", "masks", "mass", "final networks", "test TEST", "tables"):

        def kill(state, step=step):
            if state.step == step:
                raise Killed

        with pytest.raises(Killed):
            killed(progress=kill)
    killed()
    assert files_of(tmp_path / "killed") == files_of(tmp_path / "whole")


@pytest.mark.usefixtures("untrained")
def test_the_paper_s_protocol_judges_mass_on_its_fifth_and_says_so(root, made, tmp_path):
    _, _, store = made
    paper = ReproductionSettings(protocol="paper", is_quick=True)
    found = reproduce(root, out=tmp_path, settings=paper, store=store)
    assert set(found.rows["protocol"]) == {"paper"}
    weighed = found.rows["container_mass_g"].notna().sum()
    assert 0 < weighed < COUNT / 2
    report = html.unescape(found.report.read_text(encoding="utf-8"))
    assert "The paper's protocol" in report
    assert "the round whose kept epoch has the least loss" in report


@pytest.mark.usefixtures("untrained")
def test_the_authors_networks_hear_with_their_own_front_end(root, test_root, made, tmp_path, monkeypatch):
    def opened(folder):
        dataset = open_dataset(folder)
        if folder == root:
            dataset._recordings["000005"] = replace(dataset["000005"], sound_end_s=0.5)
        return dataset

    monkeypatch.setattr("corsmal.runs.reproduction.open_dataset", opened)
    _, _, store = made
    released = replace(QUICK, networks="released", shape=ShapeParameters.released())
    found = reproduce(root, out=tmp_path, settings=released, tests=[test_root], store=store)
    assert any(note.startswith("000005: its recorder was not stopped") for note in found.notes)
    [predictions] = tmp_path.glob("filling/*/predictions.csv")
    table = pd.read_csv(predictions, dtype={"recording_id": "str"}).set_index("recording_id")
    assert len(table) == COUNT - 2  # that one, and one without sound
    place = predictions.parent / "seed0" / f"fold{table.loc['000002', 'fold']}" / "filling.safetensors"
    predictor = FillingPredictor(place)
    assert predictor.config == FillingConfig.released()
    waveform = open_dataset(root)["000002"].audio().samples
    answer = predictor.predict(log_mel(waveform, parameters=LogMelParameters.of("released")))
    shown = [table.loc["000002", f"p_{name}"] for name in ("none", "pasta", "rice", "water")]
    np.testing.assert_allclose(shown, answer.type_probabilities, rtol=1e-4)
    masses = [MassPredictor(path).config for path in tmp_path.rglob("mass.safetensors")]
    assert {replace(config, least_mass_g=None) for config in masses} == {MassConfig.released()}
    assert found.rows["filling_type"].notna().sum() == COUNT - 2
    assert pd.read_csv(found.report.parent / "submission_TEST.csv")["Filling type"].ge(0).any()
    assert "Preset of the networks" in found.report.read_text(encoding="utf-8")
    assert read_reproduction(found.report.parent).settings == released


def test_labels_learned_by_heart_do_not_reach_the_tables(root, tmp_path, monkeypatch):
    """Random labels and features that name the recording: in-sample 100 %, held out no better than chance."""
    rng = np.random.default_rng(0)
    copied = shutil.copytree(root, tmp_path / "ROOT")
    numbers = rng.permutation(COUNT)
    change_annotation(copied, lambda index: FILLINGS[numbers[index] % len(FILLINGS)])
    arrays = tmp_path / "arrays"
    arrays.mkdir()
    for index, name in enumerate(open_dataset(copied).ids):
        array = rng.normal(0, 0.1, (6, 128)).astype(np.float32)
        array[:, 4 * index : 4 * index + 4] += 6
        np.save(arrays / f"{name}.npy", array)
    settings = ReproductionSettings(features=arrays)
    by_heart = FillingTraining(keep="last", passes="joint", epochs=25, rate=3e-3)
    monkeypatch.setattr(ReproductionSettings, "filling", by_heart)
    monkeypatch.setattr("corsmal.mass.training._fit", untrained_mass)
    found = reproduce(copied, out=tmp_path / "out", settings=settings, store=Store(tmp_path / "cache"))
    dataset = open_dataset(copied)
    truth = dataset.table
    [weights] = (tmp_path / "out" / "networks").glob("filling-*/filling.safetensors")
    predictor = FillingPredictor(weights)
    in_sample = [
        predictor.predict(np.load(arrays / f"{name}.npy")[None]).pair
        == (truth.loc[name, "filling_type"], truth.loc[name, "filling_level"])
        for name in dataset.ids
    ]
    assert np.mean(in_sample) == 1.0
    assert all(predictor.trained_on.has_seen(recording) for recording in dataset)
    rows = found.rows.set_index("recording_id")
    held_out = (rows["filling_type"] == truth["filling_type"]) & (rows["filling_level"] == truth["filling_level"])
    assert held_out.mean() < 0.5


@pytest.fixture
def both(root, test_root, tmp_path):
    """Settings with arrays of sound and of sight, of a test set's recordings, too, but for one without sight."""
    rng = np.random.default_rng(0)
    for folder, shape in (("heard", (4, 128)), ("seen", (3, 5, 512))):
        (tmp_path / folder).mkdir()
        for name in {*open_dataset(root).ids, *open_dataset(test_root).ids}:
            np.save(tmp_path / folder / f"{name}.npy", rng.normal(size=shape).astype(np.float32))
    return replace(QUICK, networks="fused", features=tmp_path / "heard", sight=tmp_path / "seen")


@pytest.mark.usefixtures("untrained")
def test_sound_and_sight_are_reproduced_together_and_kept(root, test_root, both, tmp_path, monkeypatch):
    store, out = Store(tmp_path / "cache"), tmp_path / "out"
    found = reproduce(root, out=out, settings=both, tests=[test_root], store=store)
    rows = found.rows
    assert rows["filling_held_out"].all()
    assert rows["filling_type"].notna().all()
    [weights] = (out / "networks").glob("filling-*/filling.safetensors")
    assert FusedPredictor(weights).trained_on.has_seen(open_dataset(root)["000000"])
    submission = pd.read_csv(found.report.parent / "submission_TEST.csv")
    assert (submission["Filling level"] >= 0).all()  # the test set's arrays were used
    assert "heard; seen" in html.unescape(found.report.read_text(encoding="utf-8"))
    before = files_of(out)
    with monkeypatch.context() as patch:
        patch.setattr("corsmal.filling.fused_training.train_filling", refuse)
        patch.setattr("corsmal.mass.training._fit", refuse)
        reproduce(root, out=out, settings=both, tests=[test_root], store=store)
    assert files_of(out) == before
    assert read_reproduction(found.report.parent).settings == both
    np.save(both.sight / "000000.npy", np.ones((3, 2, 512), np.float32))
    reproduce(root, out=out, settings=both, store=store)
    assert len(list((out / "networks").glob("filling-*"))) == 2  # trained anew


@pytest.mark.usefixtures("untrained")
def test_a_recording_without_one_of_its_arrays_is_left_out_and_named(root, both, tmp_path):
    (both.sight / "000003.npy").unlink()
    (both.features / "000004.npy").unlink()
    found = reproduce(root, out=tmp_path / "out", settings=both, store=Store(tmp_path / "cache"))
    silent = found.rows.set_index("recording_id")["filling_type"].isna()
    assert list(silent.index[silent]) == ["000004"]  # without sight it is still heard
    assert any("000003" in note and "seen" in note for note in found.notes)


@pytest.mark.parametrize("changes", [{"networks": "fused"}, {"networks": "paper", "sight": Path("seen")}])
def test_features_of_the_videos_belong_to_the_networks_of_both_senses(changes):
    with pytest.raises(ArgumentError, match="to them only"):
        ReproductionSettings(**changes)


def test_plan_of_both_senses_counts_its_networks(root, both):
    words = {step.name: step.what for step in plan(open_dataset(root), both)}
    assert words["features"] == f"arrays of {COUNT} recordings"
    assert words["filling"].startswith("49 networks of 3 epochs")


def test_a_test_set_of_training_recordings_is_refused(root, tmp_path):
    with pytest.raises(ArgumentError, match="recordings of the training set"):
        reproduce(root, out=tmp_path, settings=QUICK, tests=[root], store=Store(tmp_path / "cache"))


def test_a_folder_of_another_reproduction_is_refused(made, test_root):
    found, _, store = made
    with pytest.raises(FileError, match="another dataset"):
        reproduce(test_root, out=found.out, settings=QUICK, store=store)


@pytest.mark.usefixtures("untrained")
def test_a_dataset_whose_files_come_later_is_the_same(root, tmp_path):
    copied = shutil.copytree(root, tmp_path / "ROOT")
    sound = next((copied / "audio").glob("*.wav"))
    sound.rename(tmp_path / sound.name)
    for _ in range(2):
        with pytest.raises(CancelledError):
            reproduce(copied, out=tmp_path / "out", store=Store(tmp_path / "cache"), cancelled=lambda: True)
        shutil.copy(tmp_path / sound.name, sound)


@pytest.mark.usefixtures("untrained")
def test_a_class_in_one_fold_only_is_said_and_the_others_are_judged(tmp_path):
    root = write_dataset(tmp_path / "ROOT", recordings=12)
    change_annotation(root, lambda index: (3, 1) if index == 0 else ((0, 0), (2, 2), (1, 1))[index % 3])
    found = reproduce(root, out=tmp_path / "out", settings=QUICK, store=Store(tmp_path / "cache"))
    assert any("The filling type water is in fold" in note for note in found.notes)
    assert found.rows["filling_type"].notna().sum() == 11, found.notes  # one recording has no sound


@pytest.mark.usefixtures("untrained")
def test_without_any_second_class_the_rest_is_reproduced(tmp_path):
    root = write_dataset(tmp_path / "ROOT", recordings=6)
    change_annotation(root, lambda _: (1, 1))
    found = reproduce(root, out=tmp_path / "out", settings=QUICK, store=Store(tmp_path / "cache"))
    assert any("two classes of filling_type or more, got pasta only" in note for note in found.notes)
    assert found.rows["filling_type"].isna().all()
    assert found.rows["capacity_ml"].notna().any()


def test_a_full_disk_at_the_report_is_one_sentence_and_costs_nothing(made, root, test_root, monkeypatch):
    found, _, store = made
    write_text = Path.write_text

    def full(path, text, **options):
        if "report" in path.name:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        return write_text(path, text, **options)

    before = found.report.read_bytes()
    with monkeypatch.context() as patch:
        patch.setattr(Path, "write_text", full)
        with pytest.raises(FileError, match=r"report\.html.*No space left on device.*free the disk"):
            reproduce(root, out=found.out, settings=QUICK, tests=[test_root], store=store)
    assert found.report.read_bytes() == before
    monkeypatch.setattr("corsmal.filling.training.fit_network", refuse)
    reproduce(root, out=found.out, settings=QUICK, tests=[test_root], store=store)
    assert found.report.read_bytes() == before
    assert not [path for path in found.out.rglob("*") if path.name.startswith(".")]


def test_a_test_set_without_annotation_has_a_submission_and_no_scores(made, root, test_root, tmp_path):
    found, _, store = made
    blind = shutil.copytree(test_root, tmp_path / "BLIND")
    next(blind.glob("*annotation.json")).unlink()
    again = reproduce(root, out=found.out, settings=QUICK, tests=[blind], store=store)
    assert len(pd.read_csv(again.report.parent / "submission_BLIND.csv")) == 3
    assert "without annotation there are no scores" in again.report.read_text(encoding="utf-8")


def test_a_dataset_without_annotation_is_refused(root, tmp_path):
    copied = shutil.copytree(root, tmp_path / "ROOT")
    next(copied.glob("*annotation.json")).unlink()
    with pytest.raises(ArgumentError, match="no annotation"):
        reproduce(copied, out=tmp_path / "out", settings=QUICK, store=Store(tmp_path / "cache"))


def test_the_plan_has_a_time_for_every_step(root, test_root):
    steps = plan(open_dataset(root), QUICK, [open_dataset(test_root)])
    assert [step.name for step in steps][-2:] == ["test TEST", "tables"]
    assert all(step.seconds >= 0 for step in steps)
    longer = plan(open_dataset(root), ReproductionSettings(seeds=3))
    assert sum(step.seconds for step in longer) > sum(step.seconds for step in steps)


@pytest.mark.parametrize(
    ("networks", "what"),
    [("paper", "7 networks of 150"), ("released", "7 networks of 100"), ("tuned", "56 networks of 30")],
)
def test_the_plan_names_the_networks_of_the_preset(root, networks, what):
    [filling] = [step for step in plan(open_dataset(root), replace(FULL, networks=networks)) if step.name == "filling"]
    assert filling.what == f"{what} epochs"
    training = FillingTraining.of(networks)
    assert filling.what == f"{7 * len(training.networks)} networks of {training.epochs} epochs"


def test_an_epoch_on_sound_of_25_s_is_planned_as_measured(tmp_path):
    """On two cores an epoch took 0.155 s of a recording of 25 s, 0.014 s of one of 5 s."""
    for name, seconds in (("short", 5), ("long", 25)):
        soundfile.write(tmp_path / f"{name}.wav", np.zeros((seconds * 8000, 8), np.int16), 8000)
    planned = [_mel_epoch_s(Recording(name, audio_path=tmp_path / f"{name}.wav")) for name in ("short", "long")]
    assert planned == pytest.approx([0.014, 0.155], rel=0.05)


def test_wrong_choices_are_named():
    with pytest.raises(ArgumentError, match="protocol must be one of"):
        ReproductionSettings(protocol="none")
    with pytest.raises(ArgumentError, match="seeds"):
        ReproductionSettings(seeds=0)


def test_test_sets_in_folders_of_one_name_have_a_submission_each(root, test_root, tmp_path):
    other = tmp_path / test_root.name
    shutil.copytree(test_root, other)
    named = named_tests([open_dataset(test_root), open_dataset(other), open_dataset(root)])
    assert list(named) == ["TEST-1", "TEST-2", "ROOT"]
    assert named["TEST-2"].root == other
    with pytest.raises(ArgumentError, match="is named more than once"):
        named_tests([open_dataset(other), open_dataset(other)])
    steps = [step.name for step in plan(open_dataset(root), QUICK, [open_dataset(test_root), open_dataset(other)])]
    assert steps[-3:] == ["test TEST-1", "test TEST-2", "tables"]


def test_a_missing_folder_of_features_ends_it_before_anything_is_computed(root, tmp_path):
    settings = ReproductionSettings(is_quick=True, features=tmp_path / "vggish")
    with pytest.raises(FileError, match="vggish: there is no such folder of features"):
        reproduce(root, out=tmp_path / "out", settings=settings, store=Store(tmp_path / "cache"))
    assert not (tmp_path / "out").exists()
