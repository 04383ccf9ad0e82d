from corsmal.dataset import open_dataset
from corsmal.ui.shape.measures import annotated
from tests.tiny import CONTAINERS, annotation_row, write_json


def test_the_truth_is_the_annotation_as_far_as_it_is_known(tiny_dataset_root):
    dataset = open_dataset(tiny_dataset_root)
    known = dataset["000001"]
    assert {name: round(value) for name, value in annotated(known).items()} == {
        "capacity_ml": 450,
        "width_top_mm": 64,
        "width_bottom_mm": 64,
        "height_mm": 140,
    }


def test_a_truth_with_a_gap_leaves_it_out(tmp_path):
    row = annotation_row(0, CONTAINERS[0])
    del row["width at the bottom"]
    write_json(tmp_path / "ccm_tiny_annotation.json", {"annotations": [row]})
    recording = open_dataset(tmp_path)["000000"]
    assert "width_bottom_mm" not in annotated(recording)
    assert "height_mm" in annotated(recording)
