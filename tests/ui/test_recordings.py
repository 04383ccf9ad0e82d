import pandas as pd
import pytest

from corsmal.dataset import open_dataset
from corsmal.ui.recordings import (
    UNKNOWN,
    filter_table,
    most_complete,
    recording_labels,
    recordings_table,
)
from tests.tiny import CONTAINERS, annotation_row, write_json, write_tiny_dataset


@pytest.fixture(scope="module")
def dataset(tiny_dataset_root):
    return open_dataset(tiny_dataset_root)


@pytest.fixture(scope="module")
def bare(tmp_path_factory):
    """Two recordings of which nothing is known."""
    root = write_tiny_dataset(tmp_path_factory.mktemp("bare"), recordings=2, frames=2)
    (root / "ccm_tiny_annotation.json").unlink()
    return open_dataset(root)


def test_a_label_says_what_is_known(dataset):
    assert recording_labels(dataset.table) == {
        "000000": "000000 · red cup · empty",
        "000001": "000001 · green glass · rice, half",
        "000002": "000002 · small white cup · water, full",
    }


def test_a_label_of_an_unknown_recording_is_its_id(bare):
    assert recording_labels(bare.table) == {"000000": "000000", "000001": "000001"}


def test_a_label_with_a_type_but_no_level(bare):
    table = bare.table.assign(filling=pd.array(["rice", "none"], dtype="string"))
    assert list(recording_labels(table).values()) == ["000000 · rice", "000001 · empty"]


@pytest.mark.parametrize(
    ("missing", "chosen"),
    [
        (["audio", "", "audio, annotation"], 1),
        (["view1 video, audio", "audio", "annotation"], 1),
        (["", "", ""], 0),
        (["audio"], 0),
    ],
)
def test_the_first_recording_that_lacks_the_least_is_shown_first(missing, chosen):
    ids = [f"{number:06d}" for number in range(len(missing))]
    table = pd.DataFrame({"missing": pd.array(missing, dtype="string")}, index=pd.Index(ids, name="id"))
    assert most_complete(table) == ids[chosen]


def test_the_table_has_names_for_numbers(dataset):
    shown = recordings_table(dataset.table)
    assert list(shown.index) == ["000000", "000001", "000002"]
    assert list(shown["scenario"]) == ["on the table", "held", "brought in"]
    assert list(shown["kind"]) == ["cup", "glass", "cup"]
    assert shown.loc["000001", "width_top_mm"] == 64.0
    assert shown.loc["000001", "missing"] == "view2 video, audio"


def test_what_is_not_known_is_called_unknown(bare):
    shown = recordings_table(bare.table)
    for column in ("container", "kind", "filling", "level", "scenario"):
        assert set(shown[column]) == {UNKNOWN}
    assert shown["capacity_ml"].isna().all()


@pytest.mark.parametrize(
    ("chosen", "ids"),
    [
        ({}, [0, 1, 2]),
        ({"filling": []}, [0, 1, 2]),
        ({"filling": ["rice", "water"]}, [1, 2]),
        ({"filling": ["rice", "water"], "kind": ["cup"]}, [2]),
        ({"container": ["tea box"]}, []),
    ],
)
def test_rows_are_kept_by_what_was_chosen(dataset, chosen, ids):
    rows = filter_table(recordings_table(dataset.table), chosen=chosen)
    assert list(rows.index) == [f"{number:06d}" for number in ids]


def test_rows_are_kept_by_what_is_on_disk(tmp_path, dataset):
    root = write_tiny_dataset(tmp_path, recordings=2, frames=2)
    rows = [annotation_row(number, container) for number, container in enumerate(CONTAINERS)]
    write_json(root / "ccm_tiny_annotation.json", {"annotations": rows})
    shown = recordings_table(open_dataset(root).table)
    assert len(shown) == 3  # the third is in the annotation alone
    assert list(filter_table(shown, chosen={}, lacks="video").index) == ["000000", "000001"]
    assert list(filter_table(shown, chosen={}, lacks="complete").index) == ["000000"]
    assert len(filter_table(recordings_table(dataset.table), chosen={}, lacks="complete")) == 2
