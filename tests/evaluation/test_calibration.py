import numpy as np
import pandas as pd
import pytest

from corsmal.errors import ArgumentError
from corsmal.evaluation import (
    calibration_error,
    calibration_table,
    condition_table,
    error_table,
    judged_confidences,
    reliability_table,
    risk_coverage_table,
)
from tests.evaluation.made import made_annotation, perfect_estimates

SURE = [0.95, 0.95, 0.65, 0.65, 0.65, 0.3]
RIGHT = [True, True, True, False, False, False]


def test_bins_hold_confidence_and_accuracy():
    table = reliability_table(SURE, RIGHT)
    assert table.to_dict("list") == {
        "low": [0.3, 0.6, 0.9],
        "high": [0.4, 0.7, 1.0],
        "recordings": [1, 3, 2],
        "confidence": pytest.approx([0.3, 0.65, 0.95]),
        "accuracy": pytest.approx([0, 1 / 3, 1]),
    }
    assert len(reliability_table([1.0, 0.0], [True, False])) == 2


def test_error_is_the_mean_distance_weighted_by_recordings():
    expected = 100 * (1 * 0.3 + 3 * (0.65 - 1 / 3) + 2 * 0.05) / 6
    assert calibration_error(SURE, RIGHT) == pytest.approx(expected)
    assert calibration_error([1.0, 1.0], [True, True]) == 0


def test_risk_falls_with_coverage():
    table = risk_coverage_table(SURE, RIGHT)
    assert table["threshold"].tolist() == [0.95, 0.65, 0.3]
    assert table["coverage"].tolist() == pytest.approx([2 / 6, 5 / 6, 1])
    assert table["risk"].tolist() == pytest.approx([0, 2 / 5, 3 / 6])


def test_tables_of_cross_validations():
    predictions = pd.DataFrame(
        {
            "recording_id": ["000000", "000001"],
            "container_id": [1, 1],
            "fold": 0,
            "seed": 0,
            "true_type": [0, 1],
            "true_level": [0, 1],
            "predicted_type": [0, 1],
            "predicted_level": [0, 2],
            "p_empty": [0.9, 0.0],
            "p_half": [0.1, 0.4],
            "p_full": [0.0, 0.6],
        }
    )
    table = calibration_table({"fused": predictions})
    assert table.loc["fused", "calibration_error"] == pytest.approx(100 * (0.1 + 0.6) / 2)
    assert table.loc["fused", ["wrong_at_100", "wrong_at_70"]].tolist() == [50, 50]
    scores = condition_table({"a": predictions, "b": predictions.assign(predicted_level=[0, 1])})
    assert scores.index.tolist() == ["a", "b"]
    assert scores.loc["b", "filling_level"] == 100
    assert scores.loc["a", "filling_type"] == 100
    assert scores.loc["a", "filling_level"] == 50


def test_confidence_is_the_probability_of_the_predicted_class():
    annotation = made_annotation(5)  # levels 0, 0, 0, 1, 1; the first three are empty
    estimates = perfect_estimates(annotation)
    estimates.loc[0, ["level_p0", "level_p1", "level_p2"]] = [0.7, 0.2, 0.1]
    estimates.loc[1, ["filling_level", "level_p0", "level_p1", "level_p2"]] = [2, 0.2, 0.2, 0.6]
    estimates.loc[2, ["level_p0", "level_p1", "level_p2"]] = np.nan  # not known
    estimates.loc[3, "filling_level"] = np.nan  # no answer
    estimates.loc[4, "level_p1"] = 1.5  # no probability
    errors = error_table(estimates, annotation)
    sure, right = judged_confidences(errors, "filling_level")
    assert (sure.tolist(), right.tolist()) == ([0.7, 0.6], [True, False])
    assert len(judged_confidences(errors, "filling_type")[0]) == 5
    seen = estimates.assign(filling_held_out=False)
    assert len(judged_confidences(error_table(seen, annotation), "filling_level")[0]) == 0


@pytest.mark.parametrize("given", [([], []), ([0.5], [True, False]), ([1.2], [True]), ([np.nan], [True])])
def test_wrong_probabilities_are_refused(given):
    with pytest.raises(ArgumentError):
        calibration_error(*given)
