import json
from pathlib import Path

import pytest

from corsmal.dataset import Annotation, Dataset, open_dataset
from tests.tiny import CONTAINERS, annotation_row, write_json

ROW = annotation_row(0, CONTAINERS[0])


def _open(root: Path, rows: list[dict], **more: object) -> Dataset:
    write_json(root / "ccm_train_annotation.json", {"annotations": rows, **more})
    return open_dataset(root)


def _annotation_problems(dataset: Dataset) -> list[str]:
    return [problem for problem in dataset.problems if "annotation" in problem]


def _known(dataset: Dataset, name: str | int) -> Annotation:
    annotation = dataset[name].annotation
    assert annotation is not None
    return annotation


def test_json_and_csv_of_the_same_content_agree(tmp_path: Path) -> None:
    rows = [annotation_row(number, container) for number, container in enumerate(CONTAINERS)]
    lines = [",".join(rows[0]), *(",".join(str(value) for value in row.values()) for row in rows)]
    (tmp_path / "csv").mkdir()
    (tmp_path / "csv" / "test_annotation.csv").write_text("\ufeff" + "\r\n".join(lines), encoding="utf-8")
    from_csv, from_json = open_dataset(tmp_path / "csv"), _open(tmp_path / "json", rows)
    assert [recording.annotation for recording in from_csv] == [recording.annotation for recording in from_json]
    assert _annotation_problems(from_csv) == []


def test_json_is_preferred_and_csv_used_when_it_is_broken(tmp_path: Path) -> None:
    (tmp_path / "ccm_annotation.csv").write_text("id,container id\n5,3\n", encoding="utf-8")
    assert open_dataset(tmp_path).ids == ("000005",)
    assert _open(tmp_path, [ROW]).ids == ("000000",)
    (tmp_path / "ccm_train_annotation.json").write_text('{"annotations": [{"id": 1,', encoding="utf-8")
    dataset = open_dataset(tmp_path)
    assert dataset.ids == ("000005",)
    assert any("ccm_train_annotation.json: the annotation cannot be read" in problem for problem in dataset.problems)


@pytest.mark.parametrize(
    "content", [b"", b"[1, 2]", b'{"annotations": 3}', b"null", b"\xff\xfe", b"[" * 100_000], ids=range(6)
)
def test_file_that_is_no_annotation_is_a_problem_and_not_an_error(tmp_path: Path, content: bytes) -> None:
    (tmp_path / "annotation.json").write_bytes(content)
    (tmp_path / "audio").mkdir()
    (tmp_path / "audio" / "000000.wav").touch()
    dataset = open_dataset(tmp_path)
    assert dataset["000000"].annotation is None
    assert any("annotation.json" in problem for problem in dataset.problems)


def test_set_with_container_ids_alone_is_used_and_its_lack_is_said_once(tmp_path: Path) -> None:
    dataset = _open(tmp_path, [{"id": number, "container id": number} for number in range(1, 10)])
    problems = _annotation_problems(dataset)
    assert len(problems) == 1
    assert "there is no column 'scenario'" in problems[0]
    assert "'filling mass'" in problems[0]
    assert dataset.table["kind"].tolist() == ["cup"] * 3 + ["glass"] * 3 + ["box"] * 3
    assert dataset.table["container"].tolist()[3] == "green glass"
    assert dataset.table["height_mm"].isna().all()


@pytest.mark.parametrize(
    ("key", "field"),
    [("height", "height_mm"), ("container capacity", "capacity_ml"), ("filling type", "filling_type")],
)
@pytest.mark.parametrize("value", [None, float("nan"), float("inf"), "", "tall", [1], {}, True, -1, -7.5, 10**400])
def test_unusable_value_is_unknown_and_the_rest_of_the_row_is_used(
    tmp_path: Path, key: str, field: str, value: object
) -> None:
    if isinstance(value, bool) and key == "filling type":
        value = 2.5
    dataset = _open(tmp_path, [ROW | {key: value}, ROW | {"id": 1}])
    assert getattr(_known(dataset, 0), field) is None
    assert _known(dataset, 0).width_top_mm == 98.0
    assert getattr(_known(dataset, 1), field) is not None
    assert _annotation_problems(dataset) == [
        f"ccm_train_annotation.json: {key!r} is missing or unusable for recording 000000"
    ]


def test_depth_of_round_containers_is_unknown_without_a_problem(tmp_path: Path) -> None:
    dataset = _open(tmp_path, [ROW | {"depth": -1.0}, ROW | {"id": 1, "depth": "-1"}, ROW | {"id": 2, "depth": 56}])
    assert [_known(dataset, number).depth_mm for number in range(3)] == [None, None, 56.0]
    assert _annotation_problems(dataset) == []


def test_numbers_written_as_text_are_read(tmp_path: Path) -> None:
    known = _known(_open(tmp_path, [{key: str(value) for key, value in ROW.items()}]), 0)
    assert (known.container_id, known.height_mm, known.filling) == (1, 119.0, "none")


def test_repeated_and_unusable_ids_are_said(tmp_path: Path) -> None:
    rows = [ROW, ROW | {"height": 5.0}, ROW | {"id": None}, ROW | {"id": "../x"}, ROW | {"id": -3}, ROW | {"id": True}]
    dataset = _open(tmp_path, rows)
    assert dataset.ids == ("000000",)
    assert _known(dataset, 0).height_mm == 119.0
    problems = " ".join(_annotation_problems(dataset))
    assert "4 of 6 rows have no usable 'id'" in problems
    assert "recording 000000 appears more than once; the first row was taken" in problems


def test_many_unusable_rows_make_one_short_sentence(tmp_path: Path) -> None:
    dataset = _open(tmp_path, [ROW | {"id": number, "height": None} for number in range(9)])
    assert _annotation_problems(dataset)[0].endswith("for recordings 000000, 000001, 000002 and 6 more")


def test_containers_that_the_file_describes_are_used(tmp_path: Path) -> None:
    described = [{"id": 10, "name": "blue mug", "type": "cup"}, {"id": 11, "name": "jar", "type": "jar"}, "nonsense"]
    rows = [ROW | {"id": number, "container id": number} for number in (9, 10, 11, 12)]
    table = _open(tmp_path, rows, containers=described).table
    assert table["container"].fillna("?").tolist() == ["tea box", "blue mug", "jar", "?"]
    assert table["kind"].fillna("?").tolist() == ["box", "cup", "?", "?"]


def test_empty_list_of_rows_is_a_problem(tmp_path: Path) -> None:
    (tmp_path / "audio").mkdir()
    (tmp_path / "audio" / "000000.wav").touch()
    assert "ccm_train_annotation.json: it has no rows" in _open(tmp_path, []).problems


def test_real_csv_and_json_agree(real_dataset_root: Path, tmp_path: Path) -> None:
    source = real_dataset_root / "ccm_train_annotation.csv"
    (tmp_path / source.name).write_bytes(source.read_bytes())
    from_csv = {recording.id: recording.annotation for recording in open_dataset(tmp_path)}
    assert from_csv == {recording.id: recording.annotation for recording in open_dataset(real_dataset_root)}
    rows = json.loads((real_dataset_root / "ccm_train_annotation.json").read_text(encoding="utf-8"))["annotations"]
    first = from_csv[f"{rows[0]['id']:06d}"]
    assert first is not None
    assert first.capacity_ml == rows[0]["container capacity"]
