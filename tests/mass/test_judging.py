import numpy as np
import pandas as pd
import pytest

from corsmal.errors import ArgumentError
from corsmal.mass import MassPredictor, restore_mask, save_mass
from corsmal.mass.judging import judge_mass, mask_iou, mass_table
from tests.mass.made import CUP, container, gripped
from tests.mass.test_prediction import made_model
from tests.mass.test_samples import made_row


def test_iou_by_hand():
    first, second = np.zeros((4, 4), bool), np.zeros((4, 4), bool)
    assert mask_iou(first, second) == 1
    first[0], second[0, 2:], second[1] = True, True, True
    assert mask_iou(first, second) == 2 / 8
    with pytest.raises(ArgumentError, match="same shape"):
        mask_iou(first, second[:2])


@pytest.mark.parametrize(("axis", "tilt_deg"), [("base", 8), ("whole", 8), ("top", 0)])  # the last one is upright
@pytest.mark.parametrize("is_gripped", [True, False])
def test_a_restored_mask_is_nearly_the_whole_silhouette(axis, tilt_deg, is_gripped):
    whole = container(CUP, tilt_deg=tilt_deg)
    seen = gripped(whole, tilt_deg=tilt_deg) if is_gripped else whole
    assert mask_iou(restore_mask(seen, axis=axis).mask, whole) > 0.95


def test_masses_are_judged_and_failures_said(tmp_path):
    save_mass(tmp_path / "mass.safetensors", made_model())
    rows = [made_row(0), made_row(1, height_mm=None)]
    judged = judge_mass(MassPredictor(tmp_path / "mass.safetensors"), rows)
    assert judged["recording_id"].to_list() == ["1-0", "1-1"]
    assert judged["reason"].to_list() == ["", "height_mm is missing"]
    assert judged["mass_g"].notna().to_list() == [True, False]


def test_mass_table_by_hand():
    judged = pd.DataFrame(
        [
            ("a", "10", 10.0, 15.0, ""),
            ("b", "10", 10.0, np.nan, "x"),
            ("c", "2", 2.0, 2.0, ""),
            ("d", "2", 2.0, 6.0, ""),
        ],
        columns=["recording_id", "container", "true_g", "mass_g", "reason"],
    )
    table = mass_table(judged)
    assert table.index.to_list() == ["2", "10", "average"]
    assert table["recordings"].to_list() == [2, 2, 4]
    assert table["failed"].to_list() == [0, 1, 1]
    assert table["mape"].to_list() == pytest.approx([100, 50, 75])
    assert table["s7"].to_list() == pytest.approx(
        [50 * (1 + np.exp(-2)), 50 * np.exp(-0.5), 25 * (1 + np.exp(-2) + np.exp(-0.5))]
    )
    assert table["mean_g"].to_list() == pytest.approx([4, 15, 9.5])
