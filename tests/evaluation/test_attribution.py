import math

import pytest

from corsmal.errors import ArgumentError
from corsmal.evaluation import KNOWN_STAGES, blame_table, container_table, error_table, with_true
from tests.evaluation.made import made_annotation, perfect_estimates


@pytest.fixture
def annotation():
    return made_annotation()


@pytest.fixture
def estimates(annotation):
    table = perfect_estimates(annotation)
    table["capacity_ml"] *= 1.5
    table["height_mm"] *= 0.8
    table["container_mass_g"] *= 2
    table["filling_type"] = 2
    return table


@pytest.mark.parametrize(
    ("stage", "gone", "left"),
    [
        ("dimensions", ["capacity_mape", "height_mape"], {"mass_mape": 100}),
        ("filling", ["filling_type_mpf1"], {"capacity_mape": 50, "height_mape": 20}),
        ("container mass", ["mass_mape"], {"capacity_mape": 50}),
    ],
)
def test_true_stage_makes_no_error_and_leaves_the_others(annotation, estimates, stage, gone, left):
    table = container_table(error_table(with_true(estimates, annotation, stage), annotation))
    for metric in gone:
        assert table[metric].eq(100 if metric.endswith("mpf1") else 0).all()
    for metric, value in left.items():
        assert table[metric].tolist() == pytest.approx([value] * 4)


def test_masses_follow_from_what_is_true(annotation, estimates):
    table = with_true(with_true(estimates, annotation, "dimensions"), annotation, "filling")
    assert table["filling_mass_g"].tolist() == pytest.approx(annotation["filling mass"].tolist())
    expected = annotation["filling mass"] + 2 * annotation["container mass"]
    assert table["object_mass_g"].tolist() == pytest.approx(expected.tolist())


def test_what_the_annotation_does_not_know_stays_as_estimated(annotation, estimates):
    annotation.loc[0, "height"] = math.nan
    table = with_true(estimates, annotation, "dimensions")
    assert table["height_mm"].tolist()[:2] == [pytest.approx(0.8 * 119), 88]


def test_blame_by_hand(annotation, estimates):
    runs = {"as it is": error_table(estimates, annotation)}
    half = estimates.assign(capacity_ml=estimates["capacity_ml"] * 1.25 / 1.5, height_mm=estimates["height_mm"] * 0.5)
    runs["half"] = error_table(half, annotation)
    runs |= {stage: error_table(with_true(estimates, annotation, stage), annotation) for stage in KNOWN_STAGES}
    blame = blame_table(runs).set_index(["stage", "container"])
    assert len(blame) == 4 * 4
    assert blame.loc[("half", "red cup"), "capacity_mape"] == pytest.approx(25)
    assert blame.loc[("half", "red cup"), "capacity_mape_removed"] == pytest.approx(50)
    assert blame.loc[("half", "Average"), "height_mape_removed"] == pytest.approx(-200)
    assert blame.loc[("dimensions", "Average"), "capacity_mape_removed"] == pytest.approx(100)
    assert blame.loc[("filling", "cereal box"), "filling_type_mpf1_removed"] == pytest.approx(100)
    assert math.isnan(blame.loc[("filling", "red cup"), "width_top_mape_removed"])


def test_bad_input_is_one_clear_sentence(annotation, estimates):
    with pytest.raises(ArgumentError, match="stage must be one of dimensions, filling, container mass, got 'masks'"):
        with_true(estimates, annotation, "masks")
    with pytest.raises(ArgumentError, match="runs must hold the run as it is and one with a stage replaced, got 1"):
        blame_table({"a": error_table(estimates, annotation)})
