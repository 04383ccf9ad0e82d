"""Tables as other programs write them, with the answer that the plain file gives."""

import csv
import io
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from corsmal.dataset import Dataset, open_dataset
from corsmal.dataset.annotation_file import TABLE_COLUMNS
from corsmal.dataset.findings import Finding
from corsmal.dataset.number_cells import find_decimal
from corsmal.dataset.tables import read_table
from corsmal.errors import ArgumentError, FileError
from tests.tiny import CONTAINERS, annotation_row, write_json

ROWS = [annotation_row(number, container) for number, container in enumerate(CONTAINERS)]
KEYS = list(ROWS[0])


def written(rows: list[list[object]], separator: str = ",") -> str:
    buffer = io.StringIO()
    csv.writer(buffer, delimiter=separator, lineterminator="\n").writerows(rows)
    return buffer.getvalue()


def plain(separator: str = ",", *, decimal: str = ".") -> str:
    """The annotation as a table of text."""
    values = [[str(value).replace(".", decimal) for value in row.values()] for row in ROWS]
    return written([list(KEYS), *values], separator)


def opened(tmp_path: Path, content: str | bytes, name: str = "ccm_annotation.csv") -> Dataset:
    tmp_path.mkdir(exist_ok=True)
    (tmp_path / "audio").mkdir()
    (tmp_path / "audio" / "000000.wav").touch()
    (tmp_path / name).write_bytes(content.encode() if isinstance(content, str) else content)
    return open_dataset(tmp_path)


def on_annotation(dataset: Dataset) -> list[Finding]:
    return [finding for finding in dataset.findings if finding.kind == "annotation"]


def with_ids(change: str) -> str:
    rows = [[change.format(row["id"]), *list(row.values())[1:]] for row in ROWS]
    return written([list(KEYS), *rows])


@pytest.fixture(scope="module")
def right(tmp_path_factory: pytest.TempPathFactory) -> list[object]:
    root = tmp_path_factory.mktemp("plain")
    write_json(root / "ccm_annotation.json", {"annotations": ROWS})
    return [recording.annotation for recording in open_dataset(root)]


OTHERS = {
    "trailing commas": (plain().replace("\n", ",\n").replace(",\n", "\n", 1), "rows end in more commas"),
    "trailing commas in the headings too": (plain().replace("\n", ",,\n"), ""),
    "semicolons and decimal commas": (plain(";", decimal=","), "decimal comma"),
    "tabs and decimal commas": (plain("\t", decimal=","), "separated by tabs"),
    "quoted decimal commas between commas": (plain(decimal=","), "decimal comma"),
    "semicolons and decimal points": (plain(";"), "semicolons"),
    "vertical bars": (plain("|"), "vertical bars"),
    "a line that names the separator": ("sep=;\n" + plain(";", decimal=","), "semicolons"),
    "UTF-16": (plain("\t").encode("utf-16"), "UTF-16"),
    "UTF-16, big end first, without a mark": (plain().encode("utf-16-be"), "UTF-16"),
    "UTF-32": (plain().encode("utf-32"), "UTF-32"),
    "UTF-8 with a mark": (plain().encode("utf-8-sig"), ""),
    "Windows-1252": (
        written([[*KEYS, "Bemerkung"], *([*row.values(), "gr\u00fcn"] for row in ROWS)]).encode("cp1252"),
        "Windows-1252",
    ),
    "old Macintosh lines": (plain().replace("\n", "\r"), ""),
    "capitals and underscores": (plain().replace("container capacity", "Container_Capacity"), "'Container_Capacity'"),
    "field names": (plain().replace("container capacity", "capacity_ml"), ""),
    "words run together": (
        plain().replace(",".join(KEYS), ",".join(key.title().replace(" ", "") for key in KEYS)),
        "'ContainerId' as 'container id'",
    ),
    "a mark, semicolons, decimal commas and quotes": (
        "\ufeff" + "".join(f'"{line}"\n'.replace(";", '";"') for line in plain(";", decimal=",").splitlines()),
        "decimal comma",
    ),
    "units in headings": (plain().replace("width at the top", "Width at the top (mm)"), "read by their meaning"),
    "ids as floats": (with_ids("{}.0"), "'0.0' are read as 000000"),
    "ids as text formulas": (with_ids('="{:06d}"'), "are read as 000000"),
    "ids as file names": (with_ids("view1/rgb/{:06d}.mp4"), "are read as 000000"),
    "an index column": (written([["", *KEYS], *([i, *row.values()] for i, row in enumerate(ROWS))]), "without a head"),
    "row names of R": (
        plain().splitlines()[0]
        + "".join(f'\n"{i}",{line}' for i, line in enumerate(plain().splitlines()[1:], start=1)),
        "begin with their numbers",
    ),
    "titles above the headings": ("Exported on Monday\n\n" + plain(), "above the headings"),
    "empty rows below": (plain() + "," * (len(KEYS) - 1) + "\n\n", ""),
    "a column twice": (written([[*KEYS, "ID "], *([*row.values(), row["id"]] for row in ROWS)]), ""),
    "whole lines in quotes": ("".join(f'"{line}"\n' for line in plain().splitlines()), ""),
    "typeset minus signs": (plain().replace("-1.0", "\u22121.0"), ""),
}


@pytest.mark.parametrize("kind", list(OTHERS))
def test_a_table_of_another_program_says_the_same(tmp_path: Path, right: list[object], kind: str) -> None:
    content, note = OTHERS[kind]
    dataset = opened(tmp_path, content)
    assert [recording.annotation for recording in dataset] == right
    found = on_annotation(dataset)
    assert all(finding.severity == "note" and finding.file == "ccm_annotation.csv" for finding in found)
    assert any(note in finding.what for finding in found) if note else found == []


@pytest.mark.parametrize("ending", [".tsv", ".txt", ".CSV"])
def test_a_table_may_have_other_endings(tmp_path: Path, right: list[object], ending: str) -> None:
    dataset = opened(tmp_path, plain("\t" if ending == ".tsv" else ","), f"annotation{ending}")
    assert [recording.annotation for recording in dataset] == right


def test_numbers_in_groups_of_thousands_are_read(tmp_path: Path) -> None:
    text = "id;container capacity;filling density\n1;3.209,397;0,34\n2;1.240;0,82\n3;1 240,5;0,82\n"
    dataset = opened(tmp_path, text)
    assert dataset.table["capacity_ml"].dropna().tolist() == [3209.397, 1240.0, 1240.5]
    assert any("'1.240' is read with a point between thousands" in each.what for each in on_annotation(dataset))


@pytest.mark.parametrize(
    ("content", "said"),
    [
        ('id,height\n1,"1,234"\n', "may have a decimal comma or a comma between thousands"),
        ("id;height;depth\n1;2.345;6.789\n", "may have a decimal point or a point between thousands"),
        ("id;height;depth\n1;98,5;61.5\n", "have a decimal comma (98,5) and a decimal point (61.5)"),
        (
            "id,container id,height\n1,2,98,5\n",
            "has 4 cells where there are 3 headings; put numbers with decimal commas",
        ),
        ("id,height\n1;98\n2;99\n", "its headings are separated by commas and its rows are not"),
        ("id,height,Height\n1,98,99\n", "differ and both mean 'height'"),
        ("id,height (cm)\n1,9.8\n", "is in cm, and mm is expected"),
        (",height\n0,98\n1,99\n", "counts the rows, so it is not clear"),
        ("this is no table\n", "has no heading that is known, such as 'id'; its first line is"),
        ('id,height\n1,"98\n', "is a quotation mark not closed?"),
        ("", "is empty"),
        (b"PK\x03\x04 and more", "is a spreadsheet or another archive and no text; open it and save it as CSV"),
        (b"<!DOCTYPE html><html>", "is a web page"),
        (b"version https://git-lfs.github.com/spec/v1", "Git LFS"),
        (b"id,height\n1,\x00\x00\x00\n", "holds zero bytes"),
    ],
)
def test_what_is_no_table_or_ambiguous_is_refused_in_one_sentence(
    tmp_path: Path, content: str | bytes, said: str
) -> None:
    dataset = opened(tmp_path, content)
    assert dataset["000000"].annotation is None
    [finding] = on_annotation(dataset)
    assert (finding.severity, finding.file) == ("error", "ccm_annotation.csv")
    assert said in finding.what


def test_a_spreadsheet_is_named_with_what_to_do(tmp_path: Path) -> None:
    dataset = opened(tmp_path, b"PK\x03\x04", "ccm_train_annotation.xlsx")
    assert "ccm_train_annotation.xlsx: is a spreadsheet and not read; save it as CSV" in dataset.problems


def test_alone_in_its_folder_a_broken_annotation_is_the_error(tmp_path: Path) -> None:
    (tmp_path / "annotation.csv").write_bytes(b"PK\x03\x04")
    with pytest.raises(FileError, match=r"holds no recordings: annotation\.csv: is a spreadsheet"):
        open_dataset(tmp_path)


def test_a_table_of_containers_is_no_annotation_of_recordings(tmp_path: Path) -> None:
    dataset = opened(tmp_path, "container id,height\n4,91\n")
    assert any("it has no column 'id'" in problem for problem in dataset.problems)
    assert dataset["000000"].annotation is None


def test_first_column_without_heading_can_be_the_ids(tmp_path: Path) -> None:
    dataset = opened(tmp_path, ",height\n618,119\n17,98\n")
    assert dataset.ids == ("000000", "000017", "000618")
    assert any("taken as the recordings' ids" in finding.what for finding in on_annotation(dataset))


@pytest.mark.parametrize(
    ("cells", "sign"),
    [(["1.5", "1,234"], "."), (["1,5", "1.234"], ","), (["1.234.567"], ","), (["1,234,567"], "."), (["0,340"], ",")],
)
def test_decimal_sign_follows_from_the_cells_that_can_be_read_in_one_way(cells: list[str], sign: str) -> None:
    assert find_decimal(cells, separator=",").sign == sign


def test_cells_that_are_no_numbers_say_nothing_about_the_sign() -> None:
    decimal = find_decimal(["12.11.2026", "a,b", "", "1.2.3"], separator=",")
    assert (decimal.sign, decimal.note, decimal.plain("12.11.2026")) == (".", "", "12.11.2026")
    with pytest.raises(ArgumentError, match="'2,345'"):
        find_decimal(["2,345"], separator=";")


TEXT = st.text(st.one_of(st.sampled_from('id,;\t|\n\r"0123.-=()\0\u2212é'), st.characters()), max_size=80)


@settings(max_examples=150, derandomize=True)
@given(
    head=st.sampled_from(["id,height,filling type\n", "sep=;\nID;Height\n", "", "id\theight\n", ",height\n"]),
    text=TEXT,
    encoding=st.sampled_from(["utf-8", "utf-16", "utf-16-be", "utf-32", "cp1252"]),
)
def test_any_text_is_a_table_or_one_sentence(
    tmp_path_factory: pytest.TempPathFactory, head: str, text: str, encoding: str
) -> None:
    path = tmp_path_factory.getbasetemp() / "any.csv"
    path.write_bytes((head + text).encode(encoding, "replace"))
    try:
        table = read_table(path, TABLE_COLUMNS)
    except FileError as error:
        table, said = None, str(error)
    if table is None:
        assert "\n" not in said
        return
    assert all(len(row) == len(table.names) for row in table.rows)
    assert all("\n" not in note for note in table.notes)
