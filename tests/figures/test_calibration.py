import pandas as pd
import pytest

from corsmal.evaluation import reliability_table, risk_coverage_table
from corsmal.figures.calibration import calibration_figure
from tests.figures.made import traces

SURE, RIGHT = [0.95, 0.95, 0.65, 0.65, 0.65, 0.3], [True, True, True, False, False, False]


def figure(threshold: float):
    curve = risk_coverage_table(SURE, RIGHT)
    return traces(calibration_figure(reliability_table(SURE, RIGHT), curve, threshold=threshold, colour="#123456"))


def test_bins_lie_where_they_were_given_and_right_and_are_as_large_as_their_recordings():
    bins = next(trace for name, trace in figure(0.0).items() if name.startswith("this run"))
    assert bins.x == pytest.approx((30, 65, 95))
    assert bins.y == pytest.approx((0, 100 / 3, 100))
    assert bins.text == ("1", "3", "2")
    assert bins.marker.size[0] < bins.marker.size[2] < bins.marker.size[1]
    assert bins.customdata == ("30–40 %", "60–70 %", "90–100 %")


@pytest.mark.parametrize(("threshold", "place"), [(0.0, (100, 50)), (0.6, (500 / 6, 40)), (0.95, (200 / 6, 0))])
def test_the_threshold_stands_on_the_curve(threshold, place):
    [mark] = [trace for name, trace in figure(threshold).items() if name == "the threshold"]
    assert (mark.x[0], mark.y[0]) == pytest.approx(place)
    assert mark.xaxis == "x2"


def test_a_threshold_that_nothing_reaches_has_no_mark():
    assert "the threshold" not in figure(0.99)


def test_a_single_answer_can_be_drawn():
    reliability = reliability_table([1.0], [True])
    found = calibration_figure(
        reliability, pd.DataFrame(risk_coverage_table([1.0], [True])), threshold=0.5, colour="#123456"
    )
    assert len(found.data) == 4
