import numpy as np
import pandas as pd
import pytest

from corsmal.figures.heatmaps import confusion_figure, share_figure, sweep_figure
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


AXES, LABELS = ("circumferences", "max_difference_mm"), ("L", "d_max (mm)", "Capacity")


def sweep():
    rows = [
        (100, 0.5, 30.0, 10.0, 4.0, 16.0),
        (100, 1.0, 20.0, 0.0, 0.0, 0.0),
        (200, 0.5, 18.0, -2.0, -6.0, 2.0),
        (200, 1.0, np.nan, np.nan, np.nan, np.nan),
    ]
    metric = "capacity_mape"
    columns = [*AXES, metric, f"{metric}_difference", f"{metric}_low", f"{metric}_high"]
    return pd.DataFrame(rows, columns=columns).assign(recordings=3, failures=[0, 0, 1, 3])


def drawn(table, current=(100, 1.0)):
    return sweep_figure(table, metric="capacity_mape", axes=AXES, labels=LABELS, current=current)


@pytest.mark.parametrize(("current", "place"), [((100, 0.5), (0, 0)), ((150, 1.0), (0.5, 1)), ((900, 0.0), (1, 0))])
def test_sweep_marks_the_current_setting_between_the_cells(current, place):
    marker = traces(drawn(sweep(), current))["the run's setting"]
    assert (marker.x[0], marker.y[0]) == place


def test_sweep_colours_only_what_is_more_than_noise_and_knows_its_settings():
    cells, texts, *_ = drawn(sweep()).data
    np.testing.assert_array_equal(cells.z, [[10, 0], [0, np.nan]])  # 2 points less may be chance
    assert list(cells.customdata[0][1][:4]) == [200, 0.5, 1, 3]
    assert texts.text == ("30.0", "18.0", "20.0", "–")
    assert (cells.zmin, cells.zmax) == (-10, 10)


def test_sweep_has_a_star_only_where_a_setting_is_better_for_sure():
    assert "smallest error" not in traces(drawn(sweep()))
    table = sweep()
    table.loc[2, "capacity_mape_high"] = -1.0
    star = traces(drawn(table))["smallest error"]
    assert (round(star.x[0]), star.y[0]) == (1, 0)


def test_sweep_without_any_measure_is_drawn():
    table = sweep()
    table.iloc[:, 2:6] = np.nan
    assert drawn(table).data[1].text == ("–",) * 4


def test_shares_of_an_error_lie_between_nothing_and_all_of_it():
    rows = [("Masks", "cup", 58.0, "58 %"), ("Masks", "box", np.nan, "−0.3"), ("Filling", "cup", 0.0, "+700.0")]
    table = pd.DataFrame(rows, columns=["stage", "container", "share", "text"]).assign(told="so much")
    cells, texts = share_figure(table, rows="container", columns="stage").data
    np.testing.assert_array_equal(cells.z, [[58, 0], [0, 0]])
    assert (cells.zmin, cells.zmax) == (0, 100)
    assert texts.text == ("58 %", "+700.0", "−0.3", "")
