import numpy as np
import pandas as pd
import pytest

from corsmal.errors import ArgumentError
from corsmal.mass import MassPredictor, save_mass
from corsmal.mass.judging import judge_mass, judge_restoration, mask_iou, mass_table, restoration_table
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


def test_frames_are_judged_by_both_rules():
    whole = container(CUP, tilt_deg=8)
    seen = gripped(whole, tilt_deg=8)
    frames = judge_restoration([("1", 8.0, seen, whole), ("2", 0.0, whole, whole)])
    assert frames["before"].to_list() == [mask_iou(seen, whole), 1]
    assert frames["hidden"].to_list() == [1 - seen.sum() / whole.sum(), 0]
    assert (frames.loc[0, ["base", "whole"]] > 0.95).all()
    assert (frames.loc[1, ["base", "whole"]] > 0.95).all()


FRAMES = pd.DataFrame(
    [("10", 1.0, 0.1, 0.9, 0.8, 1.0), ("2", -7.0, 0.2, 0.8, 0.9, 0.9), ("2", 30.0, 0.2, 0.6, 0.9, 0.5)],
    columns=["container", "tilt_deg", "hidden", "before", "base", "whole"],
)


def test_restoration_table_by_container():
    table = restoration_table(FRAMES)
    assert table.index.to_list() == ["2", "10", "all"]
    assert table.loc["2"].to_dict() == pytest.approx(
        {"frames": 2, "before": 0.7, "base": 0.9, "worse_base": 0, "whole": 0.7, "worse_whole": 0.5}
    )
    assert table.loc["all", "worse_base"] == pytest.approx(1 / 3)


def test_restoration_table_by_tilt():
    table = restoration_table(FRAMES, by="tilt")
    assert table["frames"].to_list() == [1, 1, 1, 3]
    assert table["before"].to_list() == pytest.approx([0.9, 0.8, 0.6, 2.3 / 3])
    with pytest.raises(ArgumentError, match="by must be container or tilt"):
        restoration_table(FRAMES, by="colour")


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
