import numpy as np
import pandas as pd

from corsmal.figures.attribution import stage_figure
from corsmal.figures.runs import RunNumbers, runs_figure
from corsmal.figures.style import INSIDE, OUTSIDE, PRESET_COLOURS, TRUTH, run_colour
from corsmal.figures.summary import multiples_figure
from tests.figures.made import traces

LABELS = {"capacity_mape": "Capacity", "filling_type_mpf1": "Type"}


def cells(value=20.0):
    rows = []
    for metric in LABELS:
        for name, published in (("red cup", 30.0), ("own cup", np.nan), ("Average", 30.0)):
            rows.append((name, metric, value, value - 5, value + 10, published))
    return pd.DataFrame(rows, columns=["container", "metric", "value", "low", "high", "published"])


def test_each_metric_has_a_panel_whose_points_know_metric_and_container():
    figure = multiples_figure(cells(), labels=LABELS, colour="#123456")
    runs = [trace for trace in figure.data if trace.name.startswith("this run")]
    assert [trace.customdata[0] for trace in runs] == [["capacity_mape", "red cup"], ["filling_type_mpf1", "red cup"]]
    assert tuple(runs[0].y) == (2, 1, 0)  # the average stands at the foot
    assert (runs[0].error_x.array[0], runs[0].error_x.arrayminus[0]) == (10, 5)
    paper = next(trace for trace in figure.data if trace.name.startswith("paper"))
    np.testing.assert_array_equal(paper.x, [30, np.nan, 30])
    assert figure.layout.yaxis.ticktext[0] == "<b>Average</b>"
    assert [note.text for note in figure.layout.annotations] == ["<b>Capacity</b> ↓", "<b>Type</b> ↑"]


def test_an_error_beyond_the_scale_stands_at_its_edge_and_is_told():
    figure = multiples_figure(cells(900.0), labels=LABELS, colour="#123456")
    run = next(trace for trace in figure.data if trace.name.startswith("this run"))
    assert run.x[0] == 100
    assert run.text[0].startswith("red cup, Capacity: 900.0 %")


def test_numbers_that_are_not_there_have_no_point():
    table = cells().assign(value=np.nan, low=np.nan, high=np.nan)
    run = next(trace for trace in multiples_figure(table, labels=LABELS, colour="#123456").data if "run" in trace.name)
    assert np.isnan(run.x).all()


def test_runs_lie_side_by_side_in_the_colours_of_their_presets():
    runs = [RunNumbers(name, preset, cells()) for name, preset in (("a", "paper"), ("b", "paper"), ("<c>", "own"))]
    found = traces(runs_figure(runs, metric="capacity_mape", label="Capacity (%)"))
    assert list(found) == ["paper (real recordings)", "a", "b", "&lt;c&gt;"]
    assert found["a"].marker.color == found["b"].marker.color == PRESET_COLOURS["paper"]
    assert found["a"].marker.symbol != found["b"].marker.symbol
    assert found["&lt;c&gt;"].marker.color == run_colour("own parameters")
    assert found["a"].y[0] > found["b"].y[0] > found["&lt;c&gt;"].y[0]
    assert found["a"].customdata == ("red cup", "own cup", "Average")


def test_a_stage_shows_what_falls_what_grows_and_what_may_be_chance():
    rows = [
        ("Masks", "Capacity", 24.0, 10.0, True),
        ("Masks", "Height", 5.0, 9.0, True),
        ("Masks", "Mass", 4.0, 3.0, False),
    ]
    table = pd.DataFrame(rows, columns=["stage", "label", "before", "after", "is_clear"]).assign(told="so much")
    found = traces(stage_figure(table))
    np.testing.assert_array_equal(found["as it is"].x, [24, 5, 4])
    after = found["with the truth (faded: no clear change)"]
    assert after.marker.color == (INSIDE, OUTSIDE, TRUTH)
    assert tuple(after.y) == (2, 1, 0)
