"""The dataset's layout before its restructuring: opened, estimated, evaluated."""

import os
import shutil
from pathlib import Path

import pytest

from corsmal.dataset import Annotation, open_dataset
from corsmal.estimation import estimate
from corsmal.evaluation import container_table, error_table, estimates_table
from tests.tiny import CONTAINERS, annotation_row, write_json, write_tiny_dataset

SHOWN = CONTAINERS[0]
FOUND = ("width_top_mm", "width_bottom_mm", "height_mm", "capacity_ml", "container_mass_g")


def write_older(root: Path, source: Path, *, sounds: str = "audios") -> Path:
    """All fifteen containers with one recording each, links to one tiny recording."""
    for number in range(1, 16):
        name = (
            f"s{number % 3}_fi{number % 3}_fu{min(1, number % 3)}_b{number % 2}_l1" if number < 10 else f"{number:04d}"
        )
        folder = root / str(number)
        for part in ("rgb", "calib", "detections", sounds, "depth", "ir"):
            (folder / part).mkdir(parents=True)
        os.link(source / "audio/000000.wav", folder / sounds / f"{name}_audio.wav")
        for view in (1, 2, 3):
            os.link(source / f"view{view}/rgb/000000.mp4", folder / f"rgb/{name}_c{view}.mp4")
            os.link(source / f"view{view}/calib/000000.pickle", folder / f"calib/{name}_c{view}_calib.pickle")
            os.link(source / f"view{view}/detections/000000.json", folder / f"detections/{name}_c{view}.json")
    return root


@pytest.fixture(scope="module")
def source(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_tiny_dataset(tmp_path_factory.mktemp("source"), recordings=1, frames=3)


@pytest.fixture
def root(source: Path, tmp_path: Path) -> Path:
    return write_older(tmp_path / "old", source)


def test_all_fifteen_containers_are_opened(root: Path) -> None:
    dataset = open_dataset(root)
    assert len(dataset) == 15
    assert (dataset.ids[0], dataset.ids[8], dataset.ids[-1]) == ("10_0010", "3_s0_fi0_fu0_b1_l1", "9_s0_fi0_fu0_b1_l1")
    for recording in dataset:
        assert (list(recording.views), recording.missing) == (["view1", "view2", "view3"], ())
        assert recording.views["view2"].camera().size == (640, 360)
        assert recording.audio().samples.shape[0] == 8
    assert dataset["5_s2_fi2_fu1_b1_l1"].annotation == Annotation(
        container_id=5,
        container="wine glass",
        kind="glass",
        scenario=2,
        background=1,
        illumination=1,
        filling_type=2,
        filling_level=1,
        filling_density_g_per_ml=0.82,
    )
    assert dataset["10_0010"].annotation == Annotation(container_id=10)
    assert any("the dataset's older layout" in problem for problem in dataset.problems)
    assert [finding for finding in dataset.findings if finding.kind == "unused"] == []


def test_sounds_are_enough_and_may_lie_in_either_folder(tmp_path: Path) -> None:
    for path in ("4/audio/s0_fi2_fu1_b1_l1_audio.wav", "10/audios/0012_audio.WAV"):
        (tmp_path / path).parent.mkdir(parents=True)
        (tmp_path / path).touch()
    dataset = open_dataset(tmp_path)
    assert dataset.ids == ("10_0012", "4_s0_fi2_fu1_b1_l1")
    assert any("no view1 videos: N/rgb/NAME_c1.mp4 is not there" in problem for problem in dataset.problems)


def test_one_containers_folder_is_opened_with_the_same_ids(root: Path) -> None:
    assert open_dataset(root / "4").ids == ("4_s1_fi1_fu1_b0_l1",)
    assert open_dataset(root / "12").ids == ("12_0012",)


@pytest.mark.parametrize("with_rows", ["published", "containers", "own"])
def test_an_annotation_completes_what_the_names_say(root: Path, with_rows: str) -> None:
    row = annotation_row(7, CONTAINERS[1]) | {"scenario": 1, "background": 0, "illumination": 1}
    row |= {"filling type": 1, "filling level": 1, "filling mass": 77.0}
    if with_rows == "own":
        write_json(root / "annotation.json", {"annotations": [row | {"id": "4_s1_fi1_fu1_b0_l1"}]})
    elif with_rows == "published":
        write_json(root / "annotation.json", {"annotations": [row, row | {"id": 8, "background": 1}]})
    else:
        text = "container id;container capacity;height\n4;296,5;91\n10;500;140\n"
        (root / "container_annotation.csv").write_text(text, encoding="utf-8")
    dataset = open_dataset(root)
    assert len(dataset) == 15
    known, unknown = dataset["4_s1_fi1_fu1_b0_l1"].annotation, dataset["10_0010"].annotation
    assert known is not None
    assert unknown is not None
    assert (known.scenario, known.filling_type, known.container) == (1, 1, "green glass")
    assert known.height_mm == (91.0 if with_rows == "containers" else 140.0)
    assert known.filling_mass_g == (None if with_rows == "containers" else 77.0)
    assert unknown.capacity_ml == (500.0 if with_rows == "containers" else None)


def test_all_are_estimated_and_evaluated(root: Path) -> None:
    rows = "".join(
        f"{number},{SHOWN.width_top_mm},{SHOWN.width_bottom_mm},{SHOWN.height_mm},600,10\n" for number in range(1, 16)
    )
    head = "container id,width at the top,width at the bottom,height,container capacity,container mass\n"
    (root / "container_annotation.csv").write_text(head + rows, encoding="utf-8")
    dataset = open_dataset(root)
    estimates = estimates_table([estimate(recording).row() for recording in dataset])
    assert estimates["status"].tolist() == ["fitted"] * 15
    errors = error_table(estimates, dataset.table)
    assert len(errors) == 15
    table = container_table(errors).set_index("container_id")
    assert table.loc[1:15, "capacity_mape"].between(0, 40).all()


def test_other_endings_copies_and_strange_names_are_handled(root: Path) -> None:
    folder = root / "4" / "rgb"
    (folder / "s1_fi1_fu1_b0_l1_c3.mp4").rename(folder / "S1_FI1_FU1_B0_L1_C3.MOV")
    shutil.copy(folder / "s1_fi1_fu1_b0_l1_c1.mp4", folder / "s1_fi1_fu1_b0_l1_c1 (1).mp4")
    (folder / "s1_fi1_fu1_b0_l1_c1.avi").touch()
    (root / "4" / "imu2").mkdir()
    dataset = open_dataset(root)
    assert list(dataset["4_s1_fi1_fu1_b0_l1"].views) == ["view1", "view2", "view3"]
    said = {finding.file: finding.what for finding in dataset.findings if finding.kind == "unused"}
    assert "none of the older layout's names" in said["4/rgb/s1_fi1_fu1_b0_l1_c1 (1).mp4"]
    assert "s1_fi1_fu1_b0_l1_c1.mp4 is the one used" in said["4/rgb/s1_fi1_fu1_b0_l1_c1.avi"]
    assert "this folder is not used" in said["4/imu2"]
    (root / "4/calib/s1_fi1_fu1_b0_l1_c2_calib.pickle").unlink()
    with pytest.raises(Exception, match=r"s1_fi1_fu1_b0_l1_c2_calib\.pickle: the calibration of view2 is missing"):
        open_dataset(root)["4_s1_fi1_fu1_b0_l1"].views["view2"].camera()
