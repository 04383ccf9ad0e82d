import math

import numpy as np
import pandas as pd
import pytest

from corsmal.errors import ArgumentError
from corsmal.evaluation import sweep_table
from tests.evaluation.made import made_annotation, perfect_estimates

SETTINGS = ["circumferences", "max_difference_mm"]
OWN = {"circumferences": 145, "max_difference_mm": 0.5}


def table_of(rows, annotation, reference=OWN):
    return sweep_table(rows, annotation, reference=reference, rng=np.random.default_rng(0), resamples=200)


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
    table = table_of(rows, annotation)
    assert table[SETTINGS].to_numpy().tolist() == [[50, 0.5], [50, 1.0], [145, 0.5], [145, 1.0]]
    assert table["capacity_mape"].tolist() == pytest.approx([5, 5, 14.5, 14.5])
    assert table["height_mape"].tolist() == pytest.approx([5, 10, 5, 10])
    assert table["width_top_mape"].tolist() == [0, 0, 0, 0]
    assert table["recordings"].tolist() == [6, 6, 6, 6]
    assert table["failures"].tolist() == [1, 0, 0, 0]
    assert table["capacity_mape_difference"].tolist() == pytest.approx([-9.5, -9.5, 0, 0])
    assert table["mean_mape"].iloc[3] == pytest.approx((14.5 + 10) / 4)


def test_noise_is_that_of_the_recordings_that_both_settings_measure():
    annotation = made_annotation(12)
    rows = settings_of(annotation)
    is_other = (rows["circumferences"] == 145) & (rows["max_difference_mm"] == 1.0)
    change = np.random.default_rng(1).normal(0, 0.1, is_other.sum())
    rows.loc[is_other, "width_top_mm"] *= 1 + change
    table = table_of(rows, annotation).set_index(SETTINGS)
    other = table.loc[(145, 1.0)]
    assert other["width_top_mape_difference"] == pytest.approx(100 * np.abs(change).mean())
    spread = 100 * np.abs(change).std() / np.sqrt(11)  # of a mean over eleven drawn
    half = (other["width_top_mape_high"] - other["width_top_mape_low"]) / 2
    assert half == pytest.approx(1.96 * spread, rel=0.25)
    assert other["height_mape_low"] == pytest.approx(5)  # the same in all recordings
    own = table.loc[tuple(OWN.values())]
    assert own[[name for name in table if name.endswith(("_difference", "_low", "_high"))]].eq(0).all()


def test_a_reference_that_was_not_measured_is_an_error():
    annotation = made_annotation(6)
    with pytest.raises(ArgumentError, match="must have the reference setting"):
        table_of(settings_of(annotation), annotation, reference={**OWN, "circumferences": 7})


def test_recordings_without_truth_are_left_out():
    annotation = made_annotation(6)
    annotation.loc[0, "height"] = -1
    rows = settings_of(annotation)
    assert table_of(rows, annotation)["recordings"].tolist() == [5, 5, 5, 5]


@pytest.mark.parametrize(
    ("drop", "reference", "message"),
    [
        ("height_mm", OWN, "missing: height_mm"),
        ("circumferences", OWN, "missing: circumferences"),
        ("status", {}, "estimates must have the columns"),
    ],
)
def test_missing_columns_are_said(drop, reference, message):
    annotation = made_annotation(6)
    with pytest.raises(ArgumentError, match=message):
        table_of(settings_of(annotation).drop(columns=drop), annotation, reference=reference)


def test_no_recording_with_truth_is_an_error():
    annotation = made_annotation(6)
    with pytest.raises(ArgumentError, match="no recording whose capacity"):
        table_of(settings_of(annotation), annotation[["id"]])
