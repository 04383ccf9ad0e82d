import io
import re

import numpy as np
import pandas as pd
import pytest

from corsmal.errors import ArgumentError
from corsmal.evaluation import (
    METRICS,
    cell_table,
    container_table,
    error_table,
    paper_table_2,
    table_2_texts,
    typeset_table_2,
)
from tests.evaluation.made import made_annotation, perfect_estimates

FORMATS = ("latex", "html", "markdown")


def made_cells(*protocols, scale=1.2, containers=9, change=None):
    annotation = made_annotation(6 * containers)
    annotation["container id"] = annotation["id"] % containers + 1
    estimates = perfect_estimates(annotation)
    estimates[["capacity_ml", "container_mass_g"]] *= scale
    if change is not None:
        change(estimates)
    tables = [error_table(estimates, annotation, protocol=protocol) for protocol in protocols]
    return pd.concat([cell_table(errors, rng=np.random.default_rng(0)) for errors in tables])


def body(text):
    """The rows of a LaTeX table as lists of cells, a multicolumn as many cells as it spans."""
    rows = []
    for line in text.splitlines():
        if line.endswith(r"\\"):
            cells = []
            for cell in line.removesuffix(r"\\").split("&"):
                span = re.match(r"\s*\\multicolumn\{(\d+)\}", cell)
                cells += [cell.strip()] * (int(span[1]) if span else 1)
            rows.append(cells)
    return rows


@pytest.mark.parametrize("protocols", [("held-out",), ("held-out", "paper"), ("held-out", "paper", "in-sample")])
def test_latex_is_a_whole_table_in_the_published_rows_and_order(protocols):
    text = typeset_table_2(made_cells(*protocols), table_format="latex")
    width = len(re.search(r"\\begin\{tabular\}\{([lr]+)\}", text)[1])
    assert width == 1 + 8 * len(protocols) + 7
    rows = body(text)
    assert {len(cells) for cells in rows} == {width}
    names = [cells[0] for cells in rows if cells[0] and cells[0] != "Container"]
    published = [name.replace(" glass", "") if "Champagne" in name else name for name in paper_table_2()["container"]]
    assert names == published
    assert rows[1][-7:] == [
        "Filling Level",
        "Filling Type",
        "Capacity",
        "Top Width",
        "Bottom Width",
        "Height",
        "Mass",
    ]
    assert rows[2][-7:] == [r"MPF1 $\uparrow$"] * 2 + [r"MAPE $\downarrow$"] * 5
    assert text.count("{") == text.count("}")
    assert re.sub(r"\\[%&_#$]", "", "".join(text.splitlines()[len(protocols) :])).count("%") == 1  # after \resizebox
    for internal in ("_mape", "_mpf1", "container_id", "nan"):
        assert internal not in text
    for pair in ("table*", "tabular"):
        assert text.count(rf"\begin{{{pair}}}") == text.count(rf"\end{{{pair}}}") == 1


def test_the_best_number_of_a_cell_is_bold_and_an_in_sample_one_never():
    [row] = [
        cells for cells in body(typeset_table_2(made_cells("held-out"), table_format="latex")) if "Wine" in cells[0]
    ]
    assert row[1:9] == [
        "6",
        r"\textbf{100.0}",
        r"\textbf{100.0}",
        r"\textbf{20.0}",
        *[r"\textbf{0.0}"] * 3,
        r"\textbf{20.0}",
    ]
    assert row[9:] == ["78.0", r"\textbf{100.0}", "49.0", "21.9", "54.1", "20.0", "21.2"]
    worse = typeset_table_2(made_cells("held-out", scale=9), table_format="latex")
    [row] = [cells for cells in body(worse) if "Wine" in cells[0]]
    assert (row[4], row[11]) == ("800.0", r"\textbf{49.0}")
    both = typeset_table_2(made_cells("in-sample", "held-out"), table_format="latex")
    [row] = [cells for cells in body(both) if "Wine" in cells[0]]
    assert r"\textbf" not in "".join(row[1:9])
    assert row[10] == r"\textbf{100.0}"


def test_nothing_is_bold_where_the_recordings_are_not_the_published_ones():
    text = typeset_table_2(made_cells("held-out"), table_format="latex", is_like_with_like=False)
    assert r"\textbf" not in text
    assert "for orientation, not for comparison" in " ".join(text.split())


def test_counts_that_differ_from_the_row_are_marked():
    def change(estimates):
        estimates.loc[[0, 9], "mass_held_out"] = False
        estimates.loc[[18, 27], "capacity_ml"] = -1

    text = typeset_table_2(made_cells("held-out", change=change), table_format="latex")
    [row] = [cells for cells in body(text) if cells[0] == "Red cup"]
    assert row[1] == "6"
    assert row[4] == r"\textbf{20.0}$^{2}$"
    assert row[8] == r"\textbf{20.0}$_{4}$"


@pytest.mark.parametrize("table_format", FORMATS)
def test_in_sample_is_stamped_and_notes_are_kept(table_format):
    text = typeset_table_2(made_cells("in-sample"), table_format=table_format, notes=("Mass: 3 are left out.",))
    assert "In-sample: networks are judged on recordings that they were trained on" in text
    assert "Mass: 3 are left out." in text
    if table_format == "latex":
        assert "% Mass: 3 are left out." in text.splitlines()
        assert text.startswith("% In-sample: ")
        assert "In-sample: networks" in text[text.index(r"\caption") :]
    held_out = typeset_table_2(made_cells("held-out"), table_format=table_format)
    assert "In-sample" not in held_out
    assert "Held-out: no number comes from a network" in held_out


def test_csv_has_a_row_per_cell_and_a_column_for_the_protocol_and_no_comment():
    cells = made_cells("held-out", "in-sample")
    again = pd.read_csv(io.StringIO(typeset_table_2(cells, table_format="csv")))
    assert again.columns.tolist() == cells.columns.tolist()
    assert len(again) == 2 * 10 * len(METRICS)
    assert again["protocol"].value_counts().to_dict() == {"held-out": 70, "in-sample": 70}
    np.testing.assert_allclose(again["value"], cells["value"], atol=5e-4)


def test_texts_hold_all_of_a_cell():
    def change(estimates):
        estimates.loc[0, "capacity_ml"] = -1

    texts = table_2_texts(made_cells("held-out", containers=3, change=change)).set_index("container")
    assert texts.loc["Red cup", "Held-out: Capacity, MAPE (%) ↓"] == "20.0 [20.0, 20.0], n = 6, 1 failed"
    assert texts.loc["Red cup", "Published: Capacity, MAPE (%) ↓"] == "34.2"
    assert texts.index[-1] == "Average"
    assert "–" not in texts.loc["Red cup"].tolist()


def test_a_container_of_one_protocol_only_is_a_dash_in_the_other():
    cells = made_cells("held-out", "paper")
    cells = cells[(cells["protocol"] == "held-out") | (cells["container_id"] != 2)]
    texts = table_2_texts(cells).set_index("container")
    assert texts.loc["Small white cup", "Paper's protocol: Capacity, MAPE (%) ↓"] == "–"
    [row] = [cells for cells in body(typeset_table_2(cells, table_format="latex")) if cells[0] == "Small white cup"]
    assert row[9:17] == ["0", *["--"] * 7]


def test_the_average_says_what_it_is_compared_over():
    sentence = "over the containers that both tables have a number for"
    assert sentence in typeset_table_2(made_cells("held-out", containers=3), table_format="markdown")
    assert sentence not in typeset_table_2(made_cells("held-out"), table_format="markdown")


def test_bad_input_is_one_clear_sentence():
    annotation = made_annotation(9)
    wide = container_table(error_table(perfect_estimates(annotation), annotation))
    with pytest.raises(ArgumentError, match="cells must come from cell_table"):
        typeset_table_2(wide, table_format="latex")
    with pytest.raises(ArgumentError, match="table_format must be one of"):
        typeset_table_2(made_cells("held-out"), table_format="xlsx")
