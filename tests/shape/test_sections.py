import numpy as np
import pytest

from corsmal.errors import ArgumentError
from corsmal.geometry import Camera
from corsmal.shape import Hull, agreement, silhouettes


def test_agreement_counts_what_the_silhouette_covers_and_what_lies_beyond() -> None:
    mask, silhouette = np.zeros((20, 30), dtype=bool), np.zeros((20, 30), dtype=bool)
    mask[5:10, 10:20] = True  # 50 pixels
    silhouette[5:10, 12:24] = True  # 60, of which 40 lie in the mask
    found = agreement(silhouette, mask)
    assert (found.both, found.mask, found.silhouette) == (40, 50, 60)
    assert found.explained == 0.8
    assert found.beyond == 0.4
    assert found.overlap == 40 / 70
    assert agreement(mask, mask).overlap == 1
    assert agreement(np.zeros_like(mask), mask).explained == 0


def test_agreement_with_an_empty_mask_is_refused() -> None:
    with pytest.raises(ArgumentError, match="must have a pixel"):
        agreement(np.ones((4, 4), dtype=bool), np.zeros((4, 4), dtype=bool))


def test_hull_without_circumferences_has_empty_silhouettes() -> None:
    nothing = np.zeros(3, dtype=bool)
    hull = Hull(np.arange(3.0), np.ones(3), nothing, np.array([0.0, 0.0, 1.0]))
    camera = Camera(np.diag([500.0, 500.0, 1.0]), np.eye(3), np.zeros(3), (64, 48))
    [seen] = silhouettes(hull, [camera])
    assert seen.shape == (48, 64)
    assert not seen.any()
