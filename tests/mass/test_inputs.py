import numpy as np
import pytest

from corsmal.mass.inputs import mass_input, square_image
from corsmal.mass.network import MassConfig
from tests.mass.made import CUP, container, gripped

SIZES = {"width_top_mm": 98.0, "width_bottom_mm": 61.0, "height_mm": 119.0}


def test_a_stretched_image_is_filled_by_the_crop():
    image, scale = square_image(np.ones((56, 224), bool), resize="stretch")
    assert image.shape == (112, 112)
    assert image.dtype == np.float32
    assert (image == 1).all()
    assert scale == pytest.approx(1)  # 2 down, 0.5 across


@pytest.mark.parametrize(
    ("shape", "rows", "columns"), [((56, 224), (42, 70), (0, 112)), ((224, 56), (0, 112), (42, 70))]
)
def test_a_letterboxed_image_keeps_proportions_and_is_padded(shape, rows, columns):
    image, scale = square_image(np.ones(shape, bool), resize="letterbox")
    expected = np.zeros((112, 112))
    expected[slice(*rows), slice(*columns)] = 1
    np.testing.assert_array_equal(image, expected)
    assert scale == 0.5


def test_a_pixel_is_the_share_of_the_mask_that_it_covers():
    crop = np.zeros((224, 224), bool)
    crop[0, 0] = crop[0:2, 2:4] = True
    image, _ = square_image(crop, resize="stretch")
    assert (image[0, 0], image[0, 1], image.sum()) == (0.25, 1, 1.25)


@pytest.mark.parametrize("resize", ["stretch", "letterbox"])
@pytest.mark.parametrize("shape", [(1, 1), (1, 400), (700, 2), (113, 111)])
def test_crops_of_any_shape_become_an_image(shape, resize):
    image, scale = square_image(np.ones(shape, bool), resize=resize)
    assert image.shape == (112, 112)
    assert image.max() == pytest.approx(1)
    assert scale > 0


def test_input_is_the_restored_crop_and_the_dimensions():
    mask = gripped(container(CUP))
    given = mass_input(mask, config=MassConfig.paper(), **SIZES)
    assert (given.reason, given.numbers) == ("", (98, 61, 119))
    assert given.restored.added.any()
    np.testing.assert_array_equal(given.image, square_image(given.restored.cropped, resize="stretch")[0])


def test_the_scale_is_that_of_the_networks_own_pixels():
    mask = np.zeros((300, 300), bool)
    mask[50:259, 100:150] = True  # with 15 px of padding 239 high, so 112 / 239 of it
    config = MassConfig(resize="letterbox", with_scale=True)
    given = mass_input(mask, config=config, mm_per_px=1.5, **SIZES)
    assert given.numbers == pytest.approx((98, 61, 119, 1.5 * 239 / 112))
    assert mass_input(mask, config=config, **SIZES).reason == "mm_per_px is missing"
    assert mass_input(mask, config=MassConfig.paper(), mm_per_px=1.5, **SIZES).numbers == (98, 61, 119)


@pytest.mark.parametrize(
    ("name", "value", "reason"),
    [
        ("width_top_mm", None, "width_top_mm is missing"),
        ("width_bottom_mm", -3.0, "width_bottom_mm must be positive, got -3"),
        ("height_mm", 0.0, "height_mm must be positive, got 0"),
        ("height_mm", float("nan"), "height_mm must be positive, got nan"),
        ("width_top_mm", float("inf"), "width_top_mm must be positive, got inf"),
    ],
)
def test_a_dimension_that_cannot_be_is_the_reason(name, value, reason):
    given = mass_input(container(CUP), config=MassConfig.paper(), **{**SIZES, name: value})
    assert (given.reason, given.numbers) == (reason, ())
    assert given.image is not None


def test_an_empty_mask_has_no_image():
    given = mass_input(np.zeros((20, 30), bool), config=MassConfig.paper(), **SIZES)
    assert (given.image, given.reason) == (None, "the mask is empty")


def test_padding_is_part_of_the_image():
    mask = container(CUP)
    shares = [mass_input(mask, config=MassConfig(padding_px=px), **SIZES).image.mean() for px in (0, 15, 60)]
    assert shares == sorted(shares, reverse=True)
    assert shares[0] > 2 * shares[2]
