import pytest

from corsmal.ui.amounts import amount, grams, mass_error, percent_error, total


@pytest.mark.parametrize(
    ("value", "true", "text"),
    [
        (121.6, 134, "12 g too low (−9 %; true 134 g)"),
        (38.0, 86.0, "48 g too low (−56 %; true 86 g)"),
        (3.0, 2.0, "1.0 g too high (+50 %; true 2.0 g)"),
        (4.0, 0.0, "4.0 g too high (true 0 g)"),
        (10.04, 10.0, "less than 0.1 g off (true 10 g)"),
        (10.0, 10.0, "exact (true 10 g)"),
        (None, 10.0, "true 10 g"),
        (3.0, None, "no annotation"),
    ],
)
def test_mass_error_says_how_far_off_in_grams_and_per_cent(value: float | None, true: float | None, text: str) -> None:
    assert mass_error(value, true) == text


def test_masses_below_ten_grams_have_a_decimal_and_what_is_missing_is_unknown() -> None:
    assert [grams(value) for value in (None, 0.0, 9.94, 9.96, 1234.5)] == ["unknown", "0 g", "9.9 g", "10 g", "1,234 g"]
    assert total(1.0, 2.0) == 3.0
    assert total(1.0, None) is None


def test_lengths_have_a_decimal_and_volumes_none() -> None:
    assert (amount("capacity_ml", 601.4), amount("height_mm", 118.96)) == ("601 mL", "119.0 mm")
    assert percent_error(90.0, 100.0) == "−10.0 %"
    assert percent_error(99.99, 100.0) == "+0.0 %"
