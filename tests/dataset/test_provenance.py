import json
import shutil
from dataclasses import replace

import pytest

from corsmal.dataset import open_dataset
from corsmal.dataset.provenance import TrainedOn, parts_of
from corsmal.errors import ArgumentError


@pytest.fixture(scope="module")
def dataset(tiny_dataset_root):
    return open_dataset(tiny_dataset_root)


def test_what_was_trained_on_is_seen_and_the_rest_is_not(dataset):
    trained = TrainedOn.of([dataset["000000"], dataset["000001"]])
    assert [trained.has_seen(recording) for recording in dataset] == [True, True, False]


def test_a_copy_in_another_folder_is_recognised(dataset, tmp_path):
    trained = TrainedOn.of(dataset)
    shutil.copytree(dataset.root, tmp_path / "copy")  # with times of its own
    assert all(trained.has_seen(recording) for recording in open_dataset(tmp_path / "copy"))


def test_another_set_s_recording_of_the_same_number_is_not_taken_for_it(dataset):
    trained = TrainedOn.of(dataset)
    other = replace(dataset["000000"], audio_path=dataset["000001"].views["view1"].video_path)
    assert parts_of(other)["audio"] != parts_of(dataset["000000"])["audio"]
    assert not trained.has_seen(other)
    container = replace(dataset["000000"].annotation, container_id=15)
    assert not trained.has_seen(replace(dataset["000000"], annotation=container))


def test_what_cannot_be_told_apart_counts_as_seen(dataset):
    nothing_known = replace(dataset["000000"], views={}, audio_path=None, annotation=None)
    assert TrainedOn.of(dataset).has_seen(nothing_known)
    assert TrainedOn.of([nothing_known]).has_seen(dataset["000000"])


def test_arrays_tell_recordings_apart(dataset):
    trained = TrainedOn.of([dataset["000000"]], features={"000000": "a"})
    assert trained.has_seen(dataset["000000"], features="a")
    assert not trained.has_seen(dataset["000000"], features="b")


def test_it_survives_json(dataset):
    trained = replace(TrainedOn.of(dataset), protocol="held-out", fold=3)
    assert trained.is_synthetic is False
    assert TrainedOn.from_json(json.loads(json.dumps(trained.to_json()))) == trained


def test_weights_that_do_not_say_are_none_and_others_are_refused():
    assert TrainedOn.from_json({}) is None
    with pytest.raises(ArgumentError, match="trained on"):
        TrainedOn.from_json({"recordings": [1]})
