"""Predicted errors of fits: their formula by hand, and that worse masks raise them."""

import numpy as np
import pytest

from corsmal.parameters import ShapeParameters
from corsmal.shape import fit_hull
from corsmal.shape.quality import BOX, ROUND, predicted_error_pct
from tests.tiny import silhouette, tiny_cameras

SIZE = (1280, 720)
CUP = (np.array([0.0, 119.0]), np.array([30.5, 49.0]))
EVIDENCE = {"unexplained": 0.05, "ends": 0.1, "beyond": 0.2, "coarse": 0.03, "pair": 1.0}


def test_the_logarithm_is_a_weighted_sum_of_the_evidence():
    exponent = ROUND["constant"] + 0.05 * ROUND["unexplained"] + 0.1 * ROUND["ends"] + 0.2 * ROUND["beyond"]
    exponent += 0.03 * ROUND["coarse"] + ROUND["pair"]
    assert predicted_error_pct(EVIDENCE, is_box=False) == pytest.approx(np.exp(exponent))
    assert predicted_error_pct(EVIDENCE, is_box=True) == pytest.approx(
        np.exp(BOX["constant"] + 0.05 * BOX["unexplained"] + 0.1 * BOX["ends"] + 0.03 * BOX["coarse"] + BOX["pair"])
    )


@pytest.mark.parametrize(("name", "is_box"), [(name, False) for name in ROUND] + [(name, True) for name in BOX])
def test_more_of_any_evidence_is_a_larger_error(name, is_box):
    if name != "constant":
        more = {**EVIDENCE, name: 2 * EVIDENCE[name]}
        assert predicted_error_pct(more, is_box=is_box) > predicted_error_pct(EVIDENCE, is_box=is_box)


def test_it_stays_between_half_a_percent_and_a_hundred():
    assert predicted_error_pct({**EVIDENCE, "unexplained": 9.0}, is_box=False) == 100
    assert predicted_error_pct({**EVIDENCE, "ends": -9.0}, is_box=True) == 0.5


def test_masks_that_do_not_belong_together_raise_it():
    cameras = [tiny_cameras(SIZE)[view] for view in ("view3", "view1")]
    masks = [silhouette(camera, CUP, (0.01, -0.02, 0.03)) for camera in cameras]
    good = fit_hull(cameras, masks, ShapeParameters.tuned())
    taller = (np.array([0.0, 150.0]), np.array([30.5, 53.0]))
    mixed = [masks[0], silhouette(cameras[1], taller, (0.01, -0.02, 0.03))]
    assert fit_hull(cameras, mixed, ShapeParameters.tuned()).error_pct > 1.1 * good.error_pct
    assert fit_hull(cameras, masks).error_pct is None
