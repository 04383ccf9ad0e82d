import csv
import json
import math

import pandas as pd
import pytest

from corsmal.errors import ArgumentError, FileError
from corsmal.evaluation import (
    ESTIMATE_COLUMNS,
    check_estimates,
    estimates_table,
    read_estimates,
    truth_table,
    write_estimates,
)
from tests.evaluation.made import made_annotation, perfect_estimates


@pytest.fixture
def annotation():
    return made_annotation(6)


@pytest.fixture
def recordings(annotation):
    return truth_table(annotation).index


@pytest.fixture
def estimates(annotation):
    table = perfect_estimates(annotation)
    table.loc[1, ["capacity_ml", "container_mass_g", "best_frame"]] = math.nan
    table.loc[2, "filling_type"] = -1
    table.loc[1, "status"] = "failed"
    table.loc[1, "notes"] = 'view3 + view1: "no frame", ü'
    return table


@pytest.mark.parametrize("suffix", [".json", ".csv", ".parquet", ".CSV"])
def test_written_table_comes_back(tmp_path, estimates, suffix):
    write_estimates(estimates, tmp_path / f"run{suffix}")
    again = read_estimates(tmp_path / f"run{suffix}")
    pd.testing.assert_frame_equal(again, estimates_table(estimates))
    assert again.columns.tolist() == list(ESTIMATE_COLUMNS)
    assert again["best_frame"].isna().tolist() == [False, True, False, False, False, False]
    assert [path.name for path in tmp_path.iterdir()] == [f"run{suffix}"]


def test_a_csv_file_has_nan_for_numbers_that_are_not_there_and_nothing_for_other_values(tmp_path, estimates):
    write_estimates(estimates, tmp_path / "run.csv")
    with (tmp_path / "run.csv").open(encoding="utf-8", newline="") as lines:
        row = list(csv.DictReader(lines))[1]
    assert math.isnan(float(row["capacity_ml"]))
    assert row["container_mass_g"] == "NaN"
    assert (row["best_frame"], row["flags"], row["protocol"]) == ("", "", "")


@pytest.mark.parametrize("number", ["9" * 400, "1e999", "-" + "9" * 30])
def test_a_number_too_large_for_any_quantity_is_unusable_and_named(tmp_path, recordings, number):
    text = f"recording_id,height_mm,filling_type\n0,{number},{number}\n1,119,1\n"
    (tmp_path / "run.csv").write_text(text, encoding="utf-8")
    checked = check_estimates(read_estimates(tmp_path / "run.csv"), recordings)
    assert checked.table["height_mm"].tolist()[1:] == [119]
    assert any("'height_mm' is unusable for recording 000000" in note for note in checked.notes)


def test_more_columns_are_kept(tmp_path, estimates):
    write_estimates(estimates.assign(duration_s=1.5), tmp_path / "run.json")
    assert read_estimates(tmp_path / "run.json")["duration_s"].tolist() == [1.5] * 6


def test_json_is_plain_rows_with_null_for_nothing(tmp_path, estimates):
    write_estimates(estimates, tmp_path / "run.json")
    rows = json.loads((tmp_path / "run.json").read_text(encoding="utf-8"))
    assert rows[1]["capacity_ml"] is None
    assert rows[0]["recording_id"] == "000000"
    assert rows[0]["filling_type"] == 0


def test_rows_of_records_become_a_table_with_all_columns():
    table = estimates_table([{"recording_id": 7, "height_mm": "12.5"}, {"recording_id": "b", "status": None}])
    assert table.columns.tolist() == list(ESTIMATE_COLUMNS)
    assert table["recording_id"].tolist() == ["000007", "b"]
    assert table["height_mm"].tolist()[0] == 12.5
    assert table["status"].tolist() == ["", ""]
    assert estimates_table([]).columns.tolist() == list(ESTIMATE_COLUMNS)


def test_checked_table_has_the_annotations_recordings_and_no_estimate_is_nan(recordings, estimates):
    checked = check_estimates(estimates.sample(frac=1, random_state=0), recordings)
    assert checked.table.index.tolist() == estimates["recording_id"].tolist()
    assert checked.notes == ()
    assert checked.table["capacity_ml"].isna().tolist() == [False, True, False, False, False, False]
    assert checked.table["filling_type"].isna().tolist() == [False, False, True, False, False, False]


def test_everything_odd_is_said_and_the_rest_is_used(recordings, estimates):
    odd = estimates.astype(object).drop(columns=["status", "width_top_mm"])
    odd.loc[0, "filling_level"] = 3
    odd.loc[3, "height_mm"] = "tall"
    odd.loc[4, "capacity_ml"] = -math.inf
    odd = pd.concat([odd[:5], odd[3:4], odd[:1].assign(recording_id="009999"), odd[:1].assign(recording_id=None)])
    checked = check_estimates(odd, recordings)
    assert checked.table.index.tolist() == [f"{number:06d}" for number in range(5)]
    assert checked.table["width_top_mm"].isna().all()
    assert checked.table["status"].eq("").all()
    assert checked.notes == (
        "estimates: 1 of 8 rows have no usable 'recording_id' and were left out",
        "estimates: recording 000003 appears more than once; the first row was taken",
        "estimates: the annotation does not have recording 009999; left out",
        "estimates: there is no row for 1 of 6 annotated recordings (recording 000005); not evaluated",
        "estimates: there is no column 'status'; a recording counts as failed where a number is missing",
        "estimates: 'capacity_ml' is unusable for recording 000004; counted as no estimate",
        "estimates: there is no column 'width_top_mm'; counted as no estimate",
        "estimates: 'height_mm' is unusable for recording 000003; counted as no estimate",
        "estimates: 'filling_level' is unusable for recording 000000; counted as no estimate",
    )


@pytest.mark.parametrize(
    ("table", "message"),
    [
        ([1, 2], "estimates must be a pandas DataFrame, got list"),
        (pd.DataFrame({"height_mm": [1.0]}), "estimates must have a column 'recording_id', got height_mm"),
        (
            pd.DataFrame({"recording_id": ["000700"]}),
            "no row is of a recording of the annotation, which has recordings 000000",
        ),
        (pd.DataFrame({"recording_id": []}), "no row is of a recording of the annotation"),
    ],
)
def test_table_that_cannot_be_used_is_an_error(recordings, table, message):
    with pytest.raises(ArgumentError, match=message):
        check_estimates(table, recordings)


@pytest.mark.parametrize(
    ("name", "content"),
    [
        ("run.json", b'{"a": 1}'),
        ("run.json", b"[1, 2]"),
        ("run.json", b'[{"height_mm": 3}]'),
        ("run.json", b"\xff\xfe["),
        ("run.json", b"[" * 100_000),
        ("run.csv", b""),
        ("run.csv", b"height_mm\n3\n"),
        ("run.csv", b'recording_id\n"1'),
        ("run.parquet", b"PAR1 and no more"),
        ("run.parquet", b""),
    ],
)
def test_broken_file_is_one_clear_sentence(tmp_path, name, content):
    (tmp_path / name).write_bytes(content)
    with pytest.raises(FileError, match=rf"{name}: (is|has|begins|its) "):
        read_estimates(tmp_path / name)


def test_absent_file_and_unknown_format_are_said(tmp_path, estimates):
    with pytest.raises(FileError, match=r"cannot be read \(No such file or directory\)"):
        read_estimates(tmp_path / "run.csv")
    with pytest.raises(ArgumentError, match=r"path must end in .json, .csv, .parquet, got 'run.xlsx'"):
        write_estimates(estimates, tmp_path / "run.xlsx")
    (tmp_path / "file").write_bytes(b"")
    with pytest.raises(FileError, match="cannot be written"):
        write_estimates(estimates, tmp_path / "file" / "run.csv")
    with pytest.raises(ArgumentError, match="rows must have a 'recording_id', got height_mm"):
        write_estimates(pd.DataFrame({"height_mm": [1.0]}), tmp_path / "run.csv")
