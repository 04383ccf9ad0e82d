"""The fit against the plain way. Compare the rows of one run: the ratio counts, not the time of the day."""

import itertools
from contextlib import suppress

import numpy as np
import pytest

from corsmal.errors import NotFoundError
from corsmal.estimation import RecordingMasks
from corsmal.parameters import METHOD_VIEWS, ShapeParameters
from corsmal.shape import fit_agreeing, fit_hull, measure_hull
from tests.shape.test_circumferences import BASE_M, CUP, slow_radii
from tests.tiny import silhouette, tiny_cameras

PLAIN_SHARE = 25
"""The plain version fits one height in so many: all 500 take a quarter of a minute."""


@pytest.fixture(scope="module")
def views():
    cameras = [tiny_cameras((1280, 720))[view] for view in ("view3", "view1")]
    return cameras, [silhouette(camera, CUP, BASE_M) for camera in cameras]


fitting = pytest.mark.benchmark(group="fit")
measuring = pytest.mark.benchmark(group="measure", max_time=0.3)


@fitting
@pytest.mark.parametrize(
    "preset",
    [
        pytest.param("paper", marks=pytest.mark.goal(seconds=0.002)),
        "released",
        pytest.param("lode", marks=pytest.mark.goal(seconds=0.003)),
        "tuned",
    ],
)
def test_fit_two_masks_of_1280x720(benchmark, views, preset):
    parameters = getattr(ShapeParameters, preset)()
    assert benchmark(fit_hull, *views, parameters).converged.any()


@pytest.fixture(scope="module")
def frames(recording, opened, cameras):
    """The masks of three views in eleven frames of the recording, with a hand about the container."""
    source = RecordingMasks(recording, opened.found.views)
    inspected = sorted(set.intersection(*(set(opened.found.views[view].by_frame) for view in METHOD_VIEWS)))
    masks = []
    for frame in inspected[:: max(1, len(inspected) // 11)]:
        with suppress(NotFoundError):
            masks.append([source.mask(view, frame, "none") for view in METHOD_VIEWS])
    return [cameras[view] for view in METHOD_VIEWS], masks


@fitting
@pytest.mark.parametrize("preset", [pytest.param("tuned", marks=pytest.mark.goal(seconds=0.025))])
def test_fit_three_masks_and_leave_out_what_contradicts(benchmark, frames, preset):
    cameras, masks = frames
    parameters, turns = getattr(ShapeParameters, preset)(), itertools.cycle(masks)
    assert benchmark.pedantic(
        fit_agreeing, setup=lambda: ((cameras, next(turns), parameters), {}), rounds=2 * len(masks), warmup_rounds=1
    ).ok


@fitting
def test_bare_look_ups_one_per_circumference(benchmark, views):
    """As many as LoDE has circumferences and radii."""
    _, masks = views
    rng = np.random.default_rng(0)
    rows, columns = rng.integers(0, 720, 2 * 500 * 145), rng.integers(0, 1280, 2 * 500 * 145)
    benchmark(lambda: masks[0][rows, columns])


@fitting
def test_plain_fit_of_a_25th_of_the_heights_of_lode(benchmark, views):
    parameters = ShapeParameters.lode()
    hull = fit_hull(*views, parameters)
    some = slice(None, None, PLAIN_SHARE)
    part = type(hull)(hull.heights_mm[some], hull.radii_mm[some], hull.converged[some], hull.centroid_m)
    radii, _ = benchmark.pedantic(slow_radii, args=(*views, part, parameters), rounds=1)
    np.testing.assert_array_equal(radii, part.radii_mm)


@measuring
def test_measure_a_hull(benchmark, views):
    hull = fit_hull(*views)
    assert benchmark(measure_hull, hull).ok


@measuring
def test_bare_integral_of_the_radii(benchmark, views):
    hull = fit_hull(*views)
    assert benchmark(lambda: np.pi * np.trapezoid(hull.radii_mm**2, hull.heights_mm)) > 0
