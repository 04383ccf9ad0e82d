import numpy as np
import pandas as pd
import pytest

from corsmal.errors import ArgumentError, FileError
from corsmal.mass import mm_per_pixel, restore_mask
from corsmal.parameters import PAIRS
from corsmal.shape import fit_hull, measure_hull
from corsmal.synthetic.render.frame import render_frame
from corsmal.synthetic.scene.containers import demo_container
from corsmal.synthetic.scene.scene import training_scene
from corsmal.synthetic.training.mass import (
    COLUMNS,
    MassDataPlan,
    best_frames,
    make_mass_data,
    masks_of,
    mass_rows,
    read_mass_data,
    write_mass_data,
)

PLAN = MassDataPlan(recordings=1, containers=(1, 5), frames=3)


@pytest.fixture(scope="module")
def table():
    done = []
    made = make_mass_data(PLAN, progress=lambda *state: done.append(state))
    assert done == [(2, 2)]
    return made


def test_rows_are_what_the_renderer_and_the_fit_say(table):
    assert tuple(table.columns) == COLUMNS
    row = table[table["container_id"] == 5].iloc[-1]
    scene = training_scene(int(row["seed"]), containers=(5,))
    truths = {view: render_frame(scene, view, int(row["frame"])) for view in PAIRS[0]}
    cameras = [scene.camera(view, (640, 360)) for view in PAIRS[0]]
    hull = fit_hull(cameras, [truths[view].visible for view in PAIRS[0]])
    dimensions = measure_hull(hull)
    assert row["height_mm"] == dimensions.height_mm
    assert row["width_top_mm"] == dimensions.width_top_mm
    assert row["mm_per_px"] == pytest.approx(mm_per_pixel(cameras[0], hull.centroid_m))
    assert row["score"] == sum(truth.visible.sum() for truth in truths.values())
    for column in ("visible", "amodal"):
        [mask] = masks_of(table.loc[[row.name]], column)
        np.testing.assert_array_equal(mask, getattr(truths["view3"], column))


def test_every_recording_has_one_best_frame_that_with_the_highest_score(table):
    best = table[table["best"]]
    assert best["container_id"].to_list() == [1, 5]
    assert best["score"].to_list() == table.groupby("container_id")["score"].max().to_list()


def test_best_frames_are_those_with_the_highest_scores(table):
    pd.testing.assert_frame_equal(best_frames(table), table[table["best"]])
    two = best_frames(table, count=2)
    for number in (1, 5):
        scores = table.loc[table["container_id"] == number, "score"].to_list()
        assert sorted(two.loc[two["container_id"] == number, "score"]) == sorted(scores)[-2:]


def test_the_true_tilt_is_that_of_the_silhouette(table):
    for tilt_deg, mask in zip(table["tilt_deg"], masks_of(table, "amodal"), strict=True):
        assert restore_mask(mask, axis="whole").axis.tilt_deg == pytest.approx(tilt_deg, abs=2.5)


def test_rows_hold_measured_or_true_dimensions(table):
    [measured] = mass_rows(table.iloc[:1])
    [true] = mass_rows(table.iloc[:1], true_dimensions=True)
    container = demo_container(1)
    assert (true.width_top_mm, true.width_bottom_mm, true.height_mm) == (98, 61, 119)
    assert (measured.mass_g, true.mass_g) == (container.mass_g, container.mass_g)
    assert measured.height_mm == table.loc[0, "height_mm"]
    assert measured.container == "1"
    np.testing.assert_array_equal(measured.mask, next(masks_of(table)))


def test_a_failed_fit_is_a_row_without_dimensions(table):
    failed = table.iloc[:1].assign(width_top_mm=np.nan, height_mm=np.nan, reason="failed")
    [row] = mass_rows(failed)
    assert (row.width_top_mm, row.height_mm) == (None, None)


def test_another_seed_gives_other_recordings():
    assert set(make_mass_data(MassDataPlan(1, (1,), seed=1, frames=1))["seed"]).isdisjoint(
        make_mass_data(MassDataPlan(1, (1,), frames=1))["seed"]
    )


def test_a_table_survives_the_file(table, tmp_path):
    path = tmp_path / "mass.parquet"
    write_mass_data(path, table)
    pd.testing.assert_frame_equal(read_mass_data(path), table)


def test_broken_files_are_named(table, tmp_path):
    path = tmp_path / "mass.parquet"
    with pytest.raises(FileError, match="make the data first"):
        read_mass_data(path)
    path.write_bytes(b"no table")
    with pytest.raises(FileError, match="delete it and make the data again"):
        read_mass_data(path)
    write_mass_data(path, table[["seed", "frame"]])
    with pytest.raises(FileError, match="is no table of masks"):
        read_mass_data(path)


@pytest.mark.parametrize("change", [{"recordings": 0}, {"frames": 0}, {"seed": -1}, {"containers": ()}])
def test_plans_that_cannot_be_are_an_error(change):
    with pytest.raises(ArgumentError, match="must be at least 1"):
        MassDataPlan(**change)
