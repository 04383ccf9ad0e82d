import numpy as np
import pandas as pd

from corsmal.figures.evaluation import comparison_figure, spread_figure
from tests.figures.made import traces

BARS = pd.DataFrame(
    {"container": ["flute", "cup"], "value": [80.0, np.nan], "recordings": [6, 1], "paper": [np.nan, 34.2]}
)
POINTS = pd.DataFrame(
    {
        "container": ["flute"] * 6 + ["cup"],
        "error": [10.0, -20, 30, 40, np.nan, 60, 5],
        "failed": [False] * 5 + [True, False],
    },
    index=[f"{number:06d}" for number in range(7)],
)


def test_bars_come_from_above_the_worst_first_and_know_their_container():
    figure = spread_figure(BARS, None, metric="Capacity", unit="%", colour="#123456")
    bars, paper = figure.data
    assert bars.customdata == ("flute", "cup")
    assert tuple(bars.y) == (1, 0)
    assert bars.text == ("80.0", "no number")
    np.testing.assert_array_equal(paper.x, [np.nan, 34.2])


def test_points_know_their_recording_and_the_failed_ones_stand_out():
    found = traces(spread_figure(BARS, POINTS, metric="Capacity", unit="%", colour="#123456"))
    assert found["measured"].customdata == ("000000", "000001", "000002", "000003", "000006")
    np.testing.assert_array_equal(found["measured"].x, [10, -20, 30, 40, 5])
    assert found["failed: training mean"].customdata == ("000005",)
    assert found["measured"].marker.color != found["failed: training mean"].marker.color


def test_points_stay_near_their_row_and_few_of_them_have_no_box():
    figure = spread_figure(BARS, POINTS, metric="Capacity", unit="%", colour="#123456")
    found = traces(figure)
    assert np.abs(np.array(found["measured"].y[:4]) - 1).max() < 0.5
    assert found["measured"].y[4] == 0
    [box] = [trace for trace in figure.data if trace.type == "box"]
    np.testing.assert_array_equal(box.x, [10, -20, 30, 40, 60])


def test_differences_have_their_intervals_and_colours():
    rows = pd.DataFrame(
        {
            "container": ["cup", "flute", "box"],
            "difference": [-5.0, 2.0, 1.0],
            "low": [-8.0, 1.0, np.nan],
            "high": [-1.0, 6.0, np.nan],
            "verdict": ["better", "worse", "no significant difference"],
        }
    )
    found = traces(comparison_figure(rows, label="container"))
    better, worse = found["second run better"], found["second run worse"]
    assert (better.customdata, tuple(better.y), tuple(worse.y)) == (("cup",), (2,), (1,))
    assert (better.error_x.array[0], better.error_x.arrayminus[0]) == (4.0, 3.0)
    assert better.marker.color != worse.marker.color
    assert np.isnan(found["no significant difference"].error_x.array[0])
