import numpy as np
import pandas as pd
import pytest

from corsmal.figures.heatmaps import blame_figure, confusion_figure, sweep_figure
from tests.figures.made import traces

TYPES = ["none", "pasta"]


def counts(*rows):
    return pd.DataFrame(rows, index=TYPES, columns=[*TYPES, "no estimate"])


def test_confusion_shows_shares_of_the_true_class_and_counts():
    figure = confusion_figure({"cup": counts([3, 1, 0], [0, 0, 0]), "box": counts([0, 0, 2], [1, 1, 0])})
    cup, box, cup_texts, _ = figure.data
    assert (cup.name, box.name) == ("cup", "box")
    np.testing.assert_array_equal(cup.z, [[75, 25, 0], [0, 0, 0]])  # a class that is never there has no shares
    np.testing.assert_array_equal(box.z, [[0, 0, 100], [50, 50, 0]])
    assert cup_texts.text == ("3", "1", "", "", "", "")
    assert (cup_texts.x[1], cup_texts.y[1]) == ("pasta", "none")
    assert (cup.x, cup.y) == (("none", "pasta", "no estimate"), ("none", "pasta"))
    assert figure.layout.yaxis2.autorange == "reversed"
    assert [note.text for note in figure.layout.annotations] == ["<b>cup</b>, 4", "<b>box</b>, 4"]


def sweep():
    rows = [(100, 0.5, 30.0), (100, 1.0, 20.0), (200, 0.5, 10.0), (200, 1.0, np.nan)]
    table = pd.DataFrame(rows, columns=["circumferences", "max_difference_mm", "capacity_mape"])
    return table.assign(recordings=3, failures=[0, 0, 1, 3])


@pytest.mark.parametrize(("current", "place"), [((100, 0.5), (0, 0)), ((150, 1.0), (0.5, 1)), ((900, 0.0), (1, 0))])
def test_sweep_marks_the_current_setting_between_the_cells(current, place):
    found = traces(sweep_figure(sweep(), metric="capacity_mape", label="Capacity", current=current))
    marker = found["current setting"]
    assert (marker.x[0], marker.y[0]) == place


def test_sweep_cells_know_their_setting_and_the_best_has_a_star():
    figure = sweep_figure(sweep(), metric="capacity_mape", label="Capacity", current=(100, 1.0))
    cells, star = figure.data[0], traces(figure)["smallest error"]
    np.testing.assert_array_equal(cells.z, [[30, 10], [20, np.nan]])
    assert list(cells.customdata[0][1]) == [200, 0.5, 1, 3]
    assert list(map(tuple, cells.text)) == [("30.0", "10.0"), ("20.0", "–")]
    assert (round(star.x[0]), star.y[0]) == (1, 0)


def test_sweep_without_a_number_has_no_star():
    table = sweep().assign(capacity_mape=np.nan)
    found = traces(sweep_figure(table, metric="capacity_mape", label="Capacity", current=(100, 1.0)))
    assert "smallest error" not in found


def test_blame_is_drawn_in_the_tables_order_and_cut_at_twice_the_error():
    table = pd.DataFrame(
        {"stage": ["masks", "masks", "filling"], "metric": ["Top", "Mass", "Top"], "removed": [40.0, -250.0, np.nan]}
    )
    cells, texts = blame_figure(table, rows="stage", columns="metric", value="removed", label="removed").data
    assert (cells.y, cells.x) == (("masks", "filling"), ("Top", "Mass"))
    np.testing.assert_array_equal(cells.z, [[40, -100], [np.nan, np.nan]])
    assert texts.text == ("+40 %", "-250 %", "", "")
