import json
from dataclasses import replace
from functools import partial

import pytest

from corsmal.errors import ArgumentError, FileError
from corsmal.filling import FillingPredictor, FillingSample, read_filling, train_filling
from corsmal.filling import training as training_file
from corsmal.filling.loop import kept_epoch
from corsmal.filling.training import hold_out, missing_classes, part_of
from tests.filling.made import JOINT, PAPER, SMALL, made_features, made_samples, same, state

SHORT = replace(JOINT, networks=(SMALL, replace(SMALL, standardise=False)), epochs=2)


def test_weights_predict_what_was_trained(tmp_path):
    shares = []
    samples = made_samples(28)
    path = train_filling(tmp_path, samples, preset=replace(SHORT, epochs=8, batch=4, rate=1e-2), progress=shares.append)
    assert path == tmp_path / "filling.safetensors"
    assert shares == pytest.approx([(epoch + 1) / 16 for epoch in range(16)])
    predictor = FillingPredictor(path)
    right = [
        predictor.predict(sample.features).pair == (sample.filling_type, sample.filling_level) for sample in samples
    ]
    assert sum(right) >= 26
    assert "mean of 2" in predictor.name


def test_networks_of_one_run_start_differently(tmp_path):
    first, second = read_filling(
        train_filling(tmp_path, made_samples(14), preset=replace(SHORT, networks=(SMALL,) * 2))
    )
    assert not same(state(first), state(second))


def test_network_takes_the_samples_channels(tmp_path):
    path = train_filling(tmp_path, made_samples(14, channels=1), preset=replace(SHORT, epochs=1))
    assert FillingPredictor(path).channels == 1


def test_finished_run_is_returned_at_once(tmp_path):
    path = train_filling(tmp_path, made_samples(14), preset=SHORT)
    before = path.stat().st_mtime_ns
    shares = []
    assert train_filling(tmp_path, made_samples(14), preset=SHORT, progress=shares.append) == path
    assert (shares, path.stat().st_mtime_ns) == ([], before)


def test_folder_of_another_run_is_refused(tmp_path):
    samples = made_samples(14)
    train_filling(tmp_path, samples, preset=SHORT)
    changed = [replace(samples[0], features=samples[0].features + 1), *samples[1:]]
    for given in ((samples, SHORT, 1), (samples, replace(SHORT, epochs=3), 0), (changed, SHORT, 0)):
        with pytest.raises(FileError, match="other recordings or settings") as raised:
            train_filling(tmp_path, given[0], preset=given[1], seed=given[2])
        assert raised.value.path == tmp_path / "settings.json"
    assert json.loads((tmp_path / "settings.json").read_text())["epochs"] == 2


def test_broken_settings_are_named(tmp_path):
    (tmp_path / "settings.json").write_text("{")
    with pytest.raises(FileError, match="delete the folder to begin again"):
        train_filling(tmp_path, made_samples(14), preset=SHORT)


def test_folder_that_cannot_be_written_is_named(tmp_path):
    (tmp_path / "file").write_bytes(b"")
    with pytest.raises(FileError, match="choose another folder"):
        train_filling(tmp_path / "file" / "run", made_samples(14), preset=SHORT)


@pytest.fixture
def fits(monkeypatch):
    """The calls of ``fit_network``: whom it trained on, by whom it chose, and how."""
    seen = []

    def spy(folder, samples, *, training, validation, **others):
        ids = [{sample.recording_id for sample in part} for part in (samples, validation)]
        seen.append((*ids, training))
        return original(folder, samples, training=training, validation=validation, **others)

    original = training_file.fit_network
    monkeypatch.setattr(training_file, "fit_network", spy)
    return seen


def ids(samples):
    return {sample.recording_id for sample in samples}


def test_the_paper_s_weights_are_those_that_rule_1_kept_on_a_seventh(tmp_path, fits):
    samples = made_samples(49)
    path = train_filling(tmp_path, samples, preset=replace(PAPER, epochs=3))
    [(trained, held, settings)] = fits
    assert (len(held), trained | held, trained & held) == (7, ids(samples), set())
    assert (settings.keep, settings.epochs) == ("best", 3)
    [network], [kept] = read_filling(path), read_filling(tmp_path / "network0" / "kept.safetensors")
    assert same(state(network), state(kept))


def test_retraining_is_on_all_for_as_long_as_rule_1_chose(tmp_path, fits):
    samples, settings, shares = made_samples(49), replace(PAPER, epochs=3, retrain=True), []
    path = train_filling(tmp_path, samples, preset=settings, progress=shares.append)
    (trained, held, search), (everyone, nobody, last) = fits
    assert (len(held), trained | held, trained & held) == (7, ids(samples), set())
    assert (everyone, nobody) == (ids(samples), set())
    assert search == settings
    chosen = kept_epoch(tmp_path / "network0" / "search")[0]
    assert 1 <= chosen <= 3
    assert last == replace(settings, keep="last", schedule="cosine", epochs=2 * chosen)
    assert shares == sorted(shares)
    assert shares[-1] == 1
    [network] = read_filling(path)
    assert same(state(network), state(read_filling(tmp_path / "network0" / "network.safetensors")[0]))


def test_a_search_that_was_stopped_goes_on_and_gives_the_same(tmp_path):
    samples, settings = made_samples(28), replace(PAPER, epochs=4, retrain=True)
    whole = read_filling(train_filling(tmp_path / "whole", samples, preset=settings))

    def stop_after(limit, share):
        if share > limit:
            raise RuntimeError("stopped")

    for limit in (0.2, 0.4, 0.7):
        with pytest.raises(RuntimeError, match="stopped"):
            train_filling(tmp_path / "stopped", samples, preset=settings, progress=partial(stop_after, limit))
    stopped = read_filling(train_filling(tmp_path / "stopped", samples, preset=settings))
    assert same(state(whole[0]), state(stopped[0]))


def test_recordings_that_are_given_to_validate_are_never_trained_on(tmp_path, fits):
    samples, extra = made_samples(49), made_samples(7, seed=1)
    train_filling(tmp_path / "given", samples, preset=replace(PAPER, epochs=1), validation=extra)
    train_filling(tmp_path / "last", samples, preset=replace(JOINT, epochs=1), validation=extra)
    given, last = fits
    assert given[:2] == (ids(samples), ids(extra))
    assert last[:2] == (ids(samples), set())


def test_held_out_recordings_are_of_every_configuration():
    kept, held = hold_out(made_samples(70))
    pairs = [(sample.filling_type, sample.filling_level) for sample in held]
    assert (len(kept), len(held), len(set(pairs))) == (60, 10, 7)


@pytest.mark.parametrize(("filling", "names"), [(3, ["water"]), (0, ["none", "empty"])])
def test_classes_that_are_missing_are_named_and_the_others_learnt(tmp_path, filling, names):
    samples = [sample for sample in made_samples(28) if sample.filling_type != filling]
    assert missing_classes(samples) == names
    path = train_filling(tmp_path, samples, preset=SHORT)
    assert FillingPredictor(path).predict(samples[0].features).ok


def test_a_single_class_is_refused(tmp_path):
    samples = [sample for sample in made_samples(28) if sample.filling_type == 0]
    with pytest.raises(ArgumentError, match="two classes of filling_type or more, got none only"):
        train_filling(tmp_path, samples, preset=SHORT)


def test_no_samples_and_samples_of_several_forms_are_refused(tmp_path):
    with pytest.raises(ArgumentError, match="samples must hold recordings"):
        train_filling(tmp_path, [], preset=SHORT)
    mixed = [*made_samples(14), FillingSample("000099", 1, made_features(5, channels=1), 0, 0)]
    with pytest.raises(ArgumentError, match="000099"):
        train_filling(tmp_path, mixed, preset=SHORT)


def test_part_of_a_progress():
    shares = []
    part_of(shares.append, 1, 4)(0.5)
    assert shares == [0.375]
    assert part_of(None, 1, 4) is None
