"""Looks: the colours of the person, the room and the light. Twelve for the demo, any number for training."""

import colorsys
from dataclasses import dataclass

import numpy as np

Colour = tuple[int, int, int]


@dataclass(frozen=True)
class Look:
    """The colours of one recording, RGB 0..255.

    Args:
        shirt: the clothes of the upper body.
        stripe: a second colour of the clothes; the same as ``shirt`` where they are plain.
        is_long_sleeved: whether the forearms are covered.
        accent: curtain or pictures.
        jug: jug or packet from which is poured.
    """

    shirt: Colour
    stripe: Colour
    is_long_sleeved: bool
    skin: Colour
    hair: Colour
    wall: Colour
    accent: Colour
    table: Colour
    chair: Colour
    jug: Colour


@dataclass(frozen=True)
class Light:
    """The light of one recording.

    Args:
        direction: from the scene to the lamp, (x, y, z), a unit vector.
        ambient: brightness of what the lamp does not reach, 0..1.
        lamp: brightness that the lamp adds, 0..1.
        gains: factors of red, green and blue.
    """

    direction: tuple[float, float, float]
    ambient: float
    lamp: float
    gains: tuple[float, float, float]


_SKINS = ((236, 196, 170), (222, 172, 140), (198, 146, 112), (164, 112, 82), (120, 80, 58), (90, 60, 46))
_HAIRS = ((38, 30, 28), (74, 50, 34), (24, 24, 28), (140, 104, 62), (96, 92, 90))
_NAVY, _GREY, _OLIVE, _WINE = (34, 42, 74), (122, 126, 130), (92, 98, 62), (106, 36, 50)
_TEAL, _WHITE, _BLACK, _SAND = (30, 104, 112), (214, 214, 210), (36, 36, 40), (186, 162, 128)
_OAK, _WALNUT, _PALE, _SLATE = (206, 150, 88), (128, 86, 56), (222, 206, 178), (112, 116, 122)
_COOL, _WARM, _MINT = (188, 192, 196), (206, 198, 184), (178, 192, 184)

DEMO_LOOKS = (
    Look(_NAVY, _NAVY, True, _SKINS[0], _HAIRS[0], _COOL, (120, 134, 150), _OAK, (40, 40, 44), (206, 214, 220)),
    Look(_GREY, _GREY, False, _SKINS[1], _HAIRS[1], _WARM, (150, 110, 84), _OAK, (60, 62, 68), (70, 110, 170)),
    Look(_OLIVE, _OLIVE, True, _SKINS[2], _HAIRS[2], _COOL, (96, 120, 104), _PALE, (36, 36, 38), (214, 206, 190)),
    Look(_WINE, _WINE, True, _SKINS[0], _HAIRS[3], _MINT, (132, 96, 100), _WALNUT, (48, 44, 42), (206, 214, 220)),
    Look(_WHITE, _NAVY, False, _SKINS[3], _HAIRS[2], _WARM, (110, 126, 146), _OAK, (44, 46, 52), (180, 90, 60)),
    Look(_TEAL, _TEAL, True, _SKINS[4], _HAIRS[2], _COOL, (160, 150, 120), _SLATE, (30, 30, 34), (214, 214, 208)),
    Look(_BLACK, _BLACK, False, _SKINS[0], _HAIRS[1], _WARM, (124, 112, 130), _PALE, (70, 70, 74), (96, 150, 120)),
    Look(_SAND, _SAND, True, _SKINS[5], _HAIRS[2], _MINT, (110, 100, 92), _WALNUT, (50, 50, 56), (200, 206, 214)),
    Look(_NAVY, _WHITE, True, _SKINS[1], _HAIRS[4], _WARM, (128, 140, 118), _OAK, (40, 42, 46), (188, 168, 90)),
    Look(_GREY, _BLACK, True, _SKINS[2], _HAIRS[0], _COOL, (140, 120, 96), _SLATE, (58, 54, 50), (206, 214, 220)),
    Look(_WINE, _SAND, False, _SKINS[3], _HAIRS[0], _MINT, (90, 110, 130), _PALE, (36, 36, 40), (120, 124, 190)),
    Look(_OLIVE, _GREY, False, _SKINS[0], _HAIRS[3], _COOL, (150, 126, 110), _WALNUT, (44, 44, 48), (210, 196, 170)),
)

DEMO_LIGHTS = (
    Light((0.25, 0.45, 0.857), 0.62, 0.46, (1.0, 1.0, 1.0)),
    Light((-0.62, 0.5, 0.605), 0.46, 0.58, (1.06, 0.98, 0.86)),
)


def random_look(rng: np.random.Generator) -> Look:
    """Colours at random: none of the demo's looks."""
    skin = np.array(_SKINS[rng.integers(len(_SKINS))]) * rng.uniform(0.8, 1.12) + rng.uniform(-8, 8, 3)
    shirt = _random_colour(rng, saturation=(0.0, 0.7), value=(0.1, 0.9))
    return Look(
        shirt=shirt,
        stripe=shirt if rng.random() < 0.6 else _random_colour(rng, saturation=(0.0, 0.6), value=(0.1, 0.9)),
        is_long_sleeved=bool(rng.random() < 0.55),
        skin=_as_colour(skin),
        hair=_as_colour(np.array(_HAIRS[rng.integers(len(_HAIRS))]) * rng.uniform(0.7, 1.3)),
        wall=_random_colour(rng, saturation=(0.0, 0.16), value=(0.5, 0.9)),
        accent=_random_colour(rng, saturation=(0.05, 0.6), value=(0.25, 0.85)),
        table=_random_colour(rng, saturation=(0.05, 0.6), value=(0.3, 0.9), hues=(0.04, 0.14)),
        chair=_random_colour(rng, saturation=(0.0, 0.3), value=(0.08, 0.45)),
        jug=_random_colour(rng, saturation=(0.0, 0.6), value=(0.35, 0.9)),
    )


def random_light(rng: np.random.Generator) -> Light:
    """A lamp somewhere above, of any colour from warm to cool."""
    direction = np.array([rng.uniform(-0.9, 0.9), rng.uniform(-0.1, 0.7), rng.uniform(0.5, 1.0)])
    x, y, z = direction / np.linalg.norm(direction)
    ambient = rng.uniform(0.36, 0.68)
    warmth = rng.uniform(-0.12, 0.12)
    lamp = rng.uniform(0.9, 1.1) - ambient
    return Light((float(x), float(y), float(z)), float(ambient), float(lamp), (1 + warmth, 1.0, 1 - warmth))


def _random_colour(
    rng: np.random.Generator,
    *,
    saturation: tuple[float, float],
    value: tuple[float, float],
    hues: tuple[float, float] = (0.0, 1.0),
) -> Colour:
    return _as_colour(
        255 * np.array(colorsys.hsv_to_rgb(rng.uniform(*hues), rng.uniform(*saturation), rng.uniform(*value)))
    )


def _as_colour(values: np.ndarray) -> Colour:
    red, green, blue = np.clip(values, 0, 255).astype(int).tolist()
    return red, green, blue
