"""Names and places: which file is used for which recording, and what is said about the others."""

from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from corsmal.dataset import Dataset, open_dataset
from corsmal.dataset.ids import recording_id
from corsmal.errors import FileError
from tests.tiny import CONTAINERS, annotation_row, write_json

ROW = annotation_row(3, CONTAINERS[1])


def touch(root: Path, *names: str) -> Path:
    for name in names:
        (root / name).parent.mkdir(parents=True, exist_ok=True)
        (root / name).touch()
    return root


def unused(dataset: Dataset) -> dict[str, str]:
    return {finding.file: str(finding) for finding in dataset.findings if finding.kind == "unused"}


@pytest.mark.parametrize(
    ("value", "expected"),
    [
        (618, "000618"),
        (618.0, "000618"),
        ("618", "000618"),
        ("0618", "000618"),
        ("0000618", "000618"),
        ("618.0", "000618"),
        ("618,00", "000618"),
        ("6.18E+02", "000618"),
        ("6,18e+02", "000618"),
        ("6.185E+02", None),
        ("1e3", "1e3"),
        (" 618 ", "000618"),
        ('="000618"', "000618"),
        ("'000618", "000618"),
        ("000618.MP4", "000618"),
        ("view1/rgb/618.mp4", "000618"),
        ("view1\\rgb\\618.wav", "000618"),
        ("1234567", "1234567"),
        ("4_s0_fi2_fu1_b1_l1", "4_s0_fi2_fu1_b1_l1"),
        ("10_0012", "10_0012"),
        (0, "000000"),
        ("cup-a", "cup-a"),
        *((nothing, None) for nothing in (-1, "-1", 1.5, "1.5", "", None, True, float("nan"), "a b", "../x", 10**200)),
        ("x" * 200, None),
    ],
)
def test_one_rule_makes_ids(value: object, expected: str | None) -> None:
    assert recording_id(value) == expected


@pytest.mark.parametrize(
    "names",
    [
        ("view1/rgb/3.mp4", "view1/calib/3.pickle", "audio/3.wav", "view1/detections/3.json"),
        ("view1/rgb/0003.MOV", "view1/calib/0003.PICKLE", "audio/0003.WAV", "view1/detections/0003.JSON"),
        ("view1/rgb/000003.avi", "view1/calib/000003.pkl", "audio/000003.flac", "view1/detections/000003.json"),
        ("View1/RGB/000003.mkv", "View1/Calib/3.pkl", "Audio/3.Flac", "View1/Detections/3.json"),
        ("view_1/videos/3.m4v", "view_1/calibration/3.pickle", "audios/3.wav", "view_1/detections/3.json"),
        (
            "view1/rgb/view1_000003.mp4",
            "view1/calib/3_calib.pkl",
            "audio/000003_audio.wav",
            "view1/detections/c1-3.json",
        ),
        ("view1/view1/rgb/3.webm", "view1/view1/calib/3.pickle", "audio/audio/3.wav", "view1/view1/detections/3.json"),
    ],
)
def test_files_are_found_under_other_names(tmp_path: Path, names: tuple[str, ...]) -> None:
    write_json(touch(tmp_path, *names) / "ccm_annotation.json", {"annotations": [ROW]})
    dataset = open_dataset(tmp_path)
    [recording] = dataset
    view, annotation = recording.views["view1"], recording.annotation
    assert (recording.id, annotation is not None and annotation.container_id) == ("000003", 4)
    paths = (view.video_path, view.calibration_path, recording.audio_path, view.detections_path)
    assert paths == tuple(tmp_path / name for name in names)
    assert unused(dataset) == {}
    said = [finding.what for finding in dataset.findings if finding.kind == "name"]
    assert len(said) == (0 if "000003" in names[1] else 1)


UNUSED = {
    "view1/rgb/000003 (1).mp4": "named like a copy of 000003",
    "view1/rgb/000003 - Copy.mp4": "named like a copy of 000003",
    "view1/rgb/000003 copy 2.mp4": "named like a copy of 000003",
    "view1/rgb/000003 \u2013 Kopie (2).mp4": "named like a copy of 000003",
    "view1/rgb/Copy of 000003.mp4": "named like a copy of 000003",
    "view1/rgb/000003_rgb.mp4": "000003.mp4 is the one used for recording 000003",
    "labels.json": "rename it to ccm_train_annotation.json",
    "train.csv": "rename it to ccm_train_annotation.json",
    "view1/rgb/000003 2.mp4": "named like a copy of 000003",
    "view1/rgb/000003_copy.mp4": "named like a copy of 000003",
    "view1/rgb/3.mp4": "000003.mp4 is the one used for recording 000003",
    "view1/rgb/000003.avi": "000003.mp4 is the one used for recording 000003",
    "view1/rgb/000003.mp4.crdownload": "an unfinished download",
    "view1/rgb/000003.wmv": "convert it to MP4",
    "view1/calib/000003.npz": "none of the files that belong here (.pickle, .pkl)",
    "view1/calib/-1.pickle": "no name that can be a recording's id",
    "view1/000004.mp4": "move it into a folder such as view1/rgb",
    "view1/depth/000003.png": "",
    "audio/-1.wav": "no name that can be a recording's id",
    "audio/000003.mp3": "convert it to WAV or FLAC",
    "audio.zip": "an archive and is not used; unpack it here",
    "000003.wav": "move it into the folder audio",
    "view5/rgb/000003.mp4": "",
}


@pytest.mark.parametrize("name", list(UNUSED))
def test_what_is_not_used_is_named_with_the_reason(tmp_path: Path, name: str) -> None:
    dataset = open_dataset(touch(tmp_path, "view1/rgb/000003.mp4", "audio/000003.wav", name))
    assert dataset.ids == ("000003",)
    assert dataset["3"].views["view1"].video_path == tmp_path / "view1/rgb/000003.mp4"
    assert dataset["3"].audio_path == tmp_path / "audio/000003.wav"
    [(file, said)] = unused(dataset).items()
    if reason := UNUSED[name]:
        assert file == name
        assert reason in said
        assert "1 file is not used; the Recordings page and doctor name the reasons" in dataset.problems
    else:
        assert name.startswith(file)
        assert "this folder is not used" in said


def test_other_tables_are_only_noted_where_the_annotation_was_found(tmp_path: Path) -> None:
    touch(tmp_path, "data/train/audio/000003.wav", "data/train/labels.csv")
    write_json(tmp_path / "data/ccm_train_annotation.json", {"annotations": [ROW]})
    [finding] = [each for each in open_dataset(tmp_path / "data/train").findings if each.kind == "unused"]
    assert (finding.severity, finding.file) == ("note", "labels.csv")


def test_links_that_lead_nowhere_and_hidden_files_are_named(tmp_path: Path) -> None:
    touch(tmp_path, "view1/rgb/000003.mp4", "view1/rgb/._000003.mp4", "view1/rgb/.DS_Store", "view1/rgb/Thumbs.db")
    (tmp_path / "view1/rgb/000004.mp4").symlink_to(tmp_path / "nowhere.mp4")
    found = unused(open_dataset(tmp_path))
    assert found["view1/rgb/000004.mp4"].endswith("is a link that leads nowhere")
    assert found["view1/rgb"].endswith("hidden files are not used: .DS_Store and 2 more")


@pytest.mark.parametrize(
    ("places", "used"),
    [
        (("data/ccm_train_annotation.json",), "data/ccm_train_annotation.json"),
        (("data/annotation.json",), "data/annotation.json"),
        (("data/ccm_train_annotation.json", "data/ccm_test_annotation.json"), "data/ccm_train_annotation.json"),
        (("data/train/annotations/ccm_train_annotation.json",), "data/train/annotations/ccm_train_annotation.json"),
        (("data/annotations/ccm_train_annotation.json",), "data/annotations/ccm_train_annotation.json"),
        (("data/ccm_test_pub_annotation.json",), None),
        (("data/one_annotation.json", "data/other_annotation.json"), None),
    ],
)
def test_annotation_beside_its_set_is_found(tmp_path: Path, places: tuple[str, ...], used: str | None) -> None:
    touch(tmp_path, "data/train/audio/000003.wav")
    for place in places:
        write_json(tmp_path / place, {"annotations": [ROW]})
    dataset = open_dataset(tmp_path / "data/train")
    assert (dataset["000003"].annotation is not None) == (used is not None)
    if used is not None:
        assert any(f"{used.rpartition('/')[2]}: is used" in problem for problem in dataset.problems)
    elif len(places) > 1:
        assert any("annotations of several sets lie beside the folder" in problem for problem in dataset.problems)


def test_annotation_of_other_recordings_beside_a_set_is_left_alone(tmp_path: Path) -> None:
    touch(tmp_path, "data/train/audio/000099.wav")
    write_json(tmp_path / "data/annotation.json", {"annotations": [ROW]})
    assert open_dataset(tmp_path / "data/train").ids == ("000099",)


def test_broken_annotation_beside_a_set_and_remarks_in_it_are_named(tmp_path: Path) -> None:
    touch(tmp_path, "data/train/audio/000003.wav", "data/annotation.csv")
    (tmp_path / "data/train/annotation_readme.txt").write_text("Written by hand.\n", encoding="utf-8")
    dataset = open_dataset(tmp_path / "data/train")
    assert "../annotation.csv: is empty" in dataset.problems
    said = {finding.file: (finding.severity, finding.what) for finding in dataset.findings}
    assert said["annotation_readme.txt"][0] == "note"
    assert "has no heading that is known" in said["annotation_readme.txt"][1]


def test_folder_above_is_pointed_down_even_with_an_annotation(tmp_path: Path) -> None:
    touch(tmp_path, "data/train/audio/000003.wav")
    write_json(tmp_path / "data/ccm_train_annotation.json", {"annotations": [ROW]})
    with pytest.raises(FileError, match="did you mean its folder 'train'"):
        open_dataset(tmp_path / "data")


@pytest.mark.parametrize("part", ["view1", "view1/rgb", "audio"])
def test_a_part_of_a_dataset_points_up(tmp_path: Path, part: str) -> None:
    touch(tmp_path, "view1/rgb/000003.mp4", "audio/000003.wav")
    with pytest.raises(FileError, match=f"did you mean the folder '{tmp_path}'"):
        open_dataset(tmp_path / part)


def test_names_that_the_annotation_does_not_have_are_said(tmp_path: Path) -> None:
    write_json(touch(tmp_path, "audio/rec_3.wav") / "annotation.json", {"annotations": [ROW]})
    problems = open_dataset(tmp_path).problems
    assert any(
        "the annotation has none of the recordings' ids: recording rec_3 there, 000003 here" in p for p in problems
    )


def test_the_other_form_of_an_annotation_is_said_to_be_unused(tmp_path: Path) -> None:
    write_json(touch(tmp_path, "audio/000003.wav") / "ccm_annotation.json", {"annotations": [ROW]})
    (tmp_path / "ccm_annotation.csv").write_text("id\n3\n", encoding="utf-8")
    found = unused(open_dataset(tmp_path))
    assert found == {"ccm_annotation.csv": "ccm_annotation.csv: is not used: ccm_annotation.json is the annotation"}


STEMS = st.one_of(
    st.sampled_from(["3", "000003", "000003 (1)", "-1", "a b", "cup_a", "000004", "é", "3.0"]),
    st.text(st.characters(exclude_characters="/\0", exclude_categories=["Cs", "Cc"]), min_size=1, max_size=6),
)
FOLDERS = ["view1/rgb", "View2/RGB", "view3/calib", "view1/detections", "audio", "view1", ""]
ENDINGS = [".mp4", ".MOV", ".wav", ".flac", ".pickle", ".json", ".zip", ".part", ""]
NAMES = st.builds("{}/{}{}".format, st.sampled_from(FOLDERS), STEMS, st.sampled_from(ENDINGS))


@settings(max_examples=60, derandomize=True)
@given(names=st.sets(NAMES, min_size=1, max_size=8))
def test_every_file_of_a_part_is_used_or_named(tmp_path_factory: pytest.TempPathFactory, names: set[str]) -> None:
    root = touch(tmp_path_factory.mktemp("any"), "audio/000099.wav", *(name.lstrip("/") for name in names))
    dataset = open_dataset(root)
    used = {recording.audio_path for recording in dataset}
    for recording in dataset:
        assert recording.id == recording_id(recording.id)
        for view in recording.views.values():
            used |= {view.video_path, view.calibration_path, view.detections_path}
    named = {finding.file for finding in dataset.findings}
    for path in (path for path in (*root.glob("*/*/*"), *(root / "audio").iterdir()) if path.is_file()):
        shown, folder = (each.relative_to(root).as_posix() for each in (path, path.parent))
        assert path in used or shown in named or folder in named, shown
