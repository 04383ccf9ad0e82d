import math

import pandas as pd
import pytest

from corsmal.errors import ArgumentError
from corsmal.evaluation import sweep_table
from tests.evaluation.made import made_annotation, perfect_estimates

SETTINGS = ["circumferences", "max_difference_mm"]


def settings_of(annotation):
    base = perfect_estimates(annotation)
    parts = []
    for count in (50, 145):
        for difference in (0.5, 1.0):
            part = base.assign(circumferences=count, max_difference_mm=difference)
            part["capacity_ml"] *= 1 + count / 1000
            part["height_mm"] *= 1 - difference / 10
            parts.append(part)
    return pd.concat(parts, ignore_index=True)


def test_each_setting_has_its_errors_and_failures():
    annotation = made_annotation(6)
    rows = settings_of(annotation)
    rows.loc[0, ["capacity_ml", "height_mm"]] = math.nan
    table = sweep_table(rows, annotation, settings=SETTINGS)
    assert table[SETTINGS].to_numpy().tolist() == [[50, 0.5], [50, 1.0], [145, 0.5], [145, 1.0]]
    assert table["capacity_mape"].tolist() == pytest.approx([5, 5, 14.5, 14.5])
    assert table["height_mape"].tolist() == pytest.approx([5, 10, 5, 10])
    assert table["width_top_mape"].tolist() == [0, 0, 0, 0]
    assert table["recordings"].tolist() == [6, 6, 6, 6]
    assert table["failures"].tolist() == [1, 0, 0, 0]


def test_recordings_without_truth_are_left_out():
    annotation = made_annotation(6)
    annotation.loc[0, "height"] = -1
    rows = settings_of(annotation)
    assert sweep_table(rows, annotation, settings=["circumferences"])["recordings"].tolist() == [10, 10]


@pytest.mark.parametrize(
    ("drop", "settings", "message"),
    [
        ("height_mm", SETTINGS, "missing: height_mm"),
        ("circumferences", SETTINGS, "missing: circumferences"),
        ("status", [], "estimates must have the columns"),
    ],
)
def test_missing_columns_are_said(drop, settings, message):
    annotation = made_annotation(6)
    with pytest.raises(ArgumentError, match=message):
        sweep_table(settings_of(annotation).drop(columns=drop), annotation, settings=settings)


def test_no_recording_with_truth_is_an_error():
    annotation = made_annotation(6)
    with pytest.raises(ArgumentError, match="no recording whose capacity"):
        sweep_table(settings_of(annotation), annotation[["id"]], settings=SETTINGS)
