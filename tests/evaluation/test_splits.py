import numpy as np
import pandas as pd
import pytest

from corsmal.dataset import open_dataset
from corsmal.evaluation import challenge_scores, find_split
from tests.evaluation.made import made_annotation, perfect_submission

COUNTS = [84] * 6 + [60] * 3


def training_set() -> pd.DataFrame:
    """As many recordings of each container as the training set has."""
    annotation = made_annotation(684)
    annotation["container id"] = np.repeat(range(1, 10), COUNTS)
    return annotation


@pytest.mark.parametrize("name", ["train", "CCM", "test_pub"])
def test_training_set_is_known_by_its_annotation_whatever_its_folder_is_called(name):
    found = find_split(training_set(), name=name)
    assert found.split == "train"
    assert str(found) == (
        "Scored as the challenge's training set, because it has the training set's 684 annotated recordings of "
        "containers 1 to 9."
    )


def test_recordings_without_an_annotation_do_not_hide_the_training_set():
    annotation = pd.concat([training_set(), pd.DataFrame({"id": [900, 901]})])
    assert find_split(annotation, name="train").split == "train"


@pytest.mark.parametrize(
    ("name", "split"),
    [("test_pub", "public"), ("ccm_test_public", "public"), ("Test_Pri", "private"), ("private", "private")],
)
def test_test_sets_are_known_by_their_folder_and_size(name, split):
    ids = pd.DataFrame({"id": range(228)})
    assert find_split(ids, name=name).split == split
    short = find_split(ids[:100], name=name)
    assert short.split == "other"
    assert "has 100 recordings, but" in short.reason


@pytest.mark.parametrize("name", ["train", "demo", "publications", "sprite", ""])
def test_anything_else_is_a_set_of_its_own(name):
    found = find_split(made_annotation(228), name=name)
    assert found.split == "other"
    assert str(found).startswith("Scored as a set that is none of the challenge's, because it is neither")


def test_training_sized_set_of_other_containers_is_no_training_set():
    annotation = training_set()
    annotation["container id"] += 1
    assert find_split(annotation, name="train").split == "other"


def test_perfect_training_set_scores_100_in_s8_and_75_overall(real_dataset_root):
    """Its annotated filling masses are not quite level × capacity × density, which the set's offset makes up for."""
    dataset = open_dataset(real_dataset_root)
    known = pd.read_csv(real_dataset_root / "ccm_train_annotation.csv")
    found = find_split(dataset.table, name=dataset.name)
    scores = challenge_scores(dataset.table, perfect_submission(known), split=found.split)
    assert scores["s8"] == pytest.approx(100, abs=1e-4)
    assert scores["overall"] == pytest.approx(75, abs=1e-4)
    without = challenge_scores(dataset.table, perfect_submission(known), split="other")
    assert without["s8"] == pytest.approx(95.2495, abs=1e-3)
