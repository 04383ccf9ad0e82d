import pytest

from corsmal.errors import ArgumentError
from corsmal.estimation.filling_mass import filling_mass_interval_g


def test_a_sure_filling_of_a_known_capacity_has_one_mass():
    assert filling_mass_interval_g([0, 0, 0, 1], [0, 0, 1], 500.0) == pytest.approx((450, 450))
    assert filling_mass_interval_g([1, 0, 0, 0], [1, 0, 0], 500.0) == (0, 0)


def test_ends_are_masses_of_fillings_and_what_is_less_likely_than_a_twentieth_is_left_out():
    # water, half or full: 250 g and 450 g
    assert filling_mass_interval_g([0, 0, 0, 1], [0, 0.94, 0.06], 500.0) == pytest.approx((250, 450))
    assert filling_mass_interval_g([0, 0, 0, 1], [0, 0.96, 0.04], 500.0) == pytest.approx((250, 250))


def test_pairs_that_do_not_exist_take_nothing():
    # nothing that is full, and water that is empty, do not exist: of the rest 0.1 · 0.1 are empty, 0.9 · 0.9 full
    low, high = filling_mass_interval_g([0.1, 0, 0, 0.9], [0.1, 0, 0.9], 100.0)
    assert (low, high) == pytest.approx((90, 90))
    low, _ = filling_mass_interval_g([0.3, 0, 0, 0.7], [0.3, 0, 0.7], 100.0)  # 0.09 against 0.49
    assert low == 0


def test_a_capacity_that_is_not_exact_widens_it():
    low, high = filling_mass_interval_g([0, 0, 0, 1], [0, 0, 1], 500.0, capacity_interval_ml=(400.0, 600.0))
    assert (low, high) == pytest.approx((0.9 * 400, 0.9 * 600), rel=0.01)
    assert filling_mass_interval_g([0, 0, 0, 1], [0, 0, 1], 50.0, capacity_interval_ml=(-50.0, 50.0))[0] == 0


@pytest.mark.parametrize(("types", "levels"), [([1, 0, 0], [1, 0, 0]), ([0, 0, 0, 0], [1, 0, 0])])
def test_what_is_no_distribution_is_refused(types, levels):
    with pytest.raises(ArgumentError):
        filling_mass_interval_g(types, levels, 500.0)
