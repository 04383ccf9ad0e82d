import io
import re
from html.parser import HTMLParser

import pandas as pd
import pytest

from corsmal.errors import ArgumentError
from corsmal.evaluation import TABLE_FORMATS, container_table, error_table, export_table, paper_table_2
from corsmal.evaluation.exporting import heading
from tests.evaluation.made import made_annotation, perfect_estimates

TABLE = pd.DataFrame(
    {
        "container_id": pd.array([1, None], dtype="Int64"),
        "container": ["<b> 100 % & co_2", "Average"],
        "capacity_mape": [34.249, float("nan")],
        "height_error_percent": [-0.06, 12.0],
        "recordings": [84, 84],
    }
)


def test_csv_keeps_names_and_leaves_out_what_is_missing():
    assert export_table(TABLE, table_format="csv") == (
        "container_id,container,capacity_mape,height_error_percent,recordings\n"
        "1,<b> 100 % & co_2,34.2,-0.1,84\n"
        ",Average,,12.0,84\n"
    )


def test_latex_has_headings_escapes_and_signs():
    lines = export_table(TABLE, table_format="latex").splitlines()
    assert lines[0] == r"\begin{tabular}{rlrrr}"
    assert (
        lines[2] == r"Container id & Container & Capacity, MAPE (\%) $\downarrow$ & Height error (\%) & Recordings \\"
    )
    assert lines[4] == r"1 & \textless{}b\textgreater{} 100 \% \& co\_2 & 34.2 & $-$0.1 & 84 \\"
    assert lines[5] == r"-- & Average & -- & 12.0 & 84 \\"
    assert lines[-1] == r"\end{tabular}"


def test_html_is_escaped_and_reads_back():
    text = export_table(TABLE, table_format="html")
    assert "<b>" not in text

    class Cells(HTMLParser):
        found: list[str]

        def handle_data(self, data):
            self.found += [data] if data.strip() else []

    parser = Cells()
    parser.found = []
    parser.feed(text)
    assert parser.found[5:10] == ["1", "<b> 100 % & co_2", "34.2", "−0.1", "84"]
    assert parser.found[10:] == ["–", "Average", "–", "12.0", "84"]


def test_digits_are_chosen_and_a_named_index_is_kept():
    table = pd.DataFrame({"height_mm": [1.23456]}, index=pd.Index(["000618"], name="recording_id"))
    assert export_table(table, table_format="csv", digits=3) == "recording_id,height_mm\n000618,1.235\n"
    assert export_table(table, table_format="csv", digits=0) == "recording_id,height_mm\n000618,1\n"


@pytest.mark.parametrize("table_format", TABLE_FORMATS)
def test_real_tables_are_exported(table_format):
    annotation = made_annotation()
    for table in (paper_table_2(), container_table(error_table(perfect_estimates(annotation), annotation))):
        text = export_table(table, table_format=table_format)
        assert "Average" in text
        assert "nan" not in text.lower()
    assert len(pd.read_csv(io.StringIO(export_table(paper_table_2(), table_format="csv")))) == 10


@pytest.mark.parametrize(
    ("name", "shown"),
    [
        ("filling_level_mpf1", "Filling level, MPF1 (%) ↑"),
        ("capacity_ml", "Capacity (mL)"),
        ("width_top_mm", "Width top (mm)"),
        ("capacity_mape_removed", "Capacity, MAPE (%) ↓, removed (%)"),
        ("team", "Team"),
    ],
)
def test_headings_are_for_people(name, shown):
    assert heading(name) == shown


def test_bad_input_is_one_clear_sentence():
    with pytest.raises(ArgumentError, match="table_format must be one of csv, latex, html, markdown, got 'xlsx'"):
        export_table(TABLE, table_format="xlsx")
    with pytest.raises(ArgumentError, match="digits must not be negative, got -1"):
        export_table(TABLE, table_format="csv", digits=-1)


HOSTILE = (
    "=HYPERLINK(\"http://x\")", "+1+1", "-2+3", "@SUM(A1)", "\tx", "＝1+1", "</script><script>alert(1)</script>",
    "| a | b |", "[a](javascript:alert(1))", "![](http://x)", "`x`", r"\input{/etc/passwd}", "line\n\nbreak",
    "[2cm] row", "* row", "100 % & #1_$~^{}", "\x00\x1b[31m", "カップ 🥤 ßéł",
)  # fmt: skip


def test_texts_are_neither_formulas_nor_commands_nor_markup():
    table = pd.DataFrame({"=name": HOSTILE, "height_mm": -1.5, "change": "-12.0 %"})
    read = pd.read_csv(io.StringIO(export_table(table, table_format="csv")))
    assert list(read.columns) == ["'=name", "height_mm", "change"]
    assert not any(text[0] in "=+-@\t＝" for text in read["'=name"])
    assert read["height_mm"].tolist() == [-1.5] * len(HOSTILE)
    assert set(read["change"]) == {"-12.0 %"}

    rows = export_table(table, table_format="latex").splitlines()
    assert len(rows) == len(HOSTILE) + 6  # no text breaks a line
    assert not any(row.startswith(("[", "*")) for row in rows)
    assert r"\input" not in "".join(rows)
    assert "??? ? ßéł" in rows[-3]

    rows = export_table(table, table_format="markdown").splitlines()
    assert len(rows) == len(HOSTILE) + 2
    assert {len(re.findall(r"(?<!\\)\|", row)) for row in rows} == {4}
    assert not re.search(r"<|\]\(|(?<!\\)`", "".join(rows))

    assert "<script" not in export_table(table, table_format="html")
