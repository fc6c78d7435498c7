"""Hands that rest, told by the colours of those that pass: flat pictures with a little noise."""

from __future__ import annotations

import numpy as np
import pytest

from mcsl_core.alignment.relief.foreign import ForeignColours, foreign_colours
from mcsl_core.alignment.steady import steady_view

SIZE = (320, 180)
CLOTH, SKIN, GLOVE, SLEEVE = (70, 110, 40), (120, 150, 210), (225, 230, 235), (150, 90, 50)  # BGR
FIELD = (slice(60, 120), slice(110, 210))
RESTS = (slice(90, 140), slice(180, 260))  # a part of it before the field
MOMENTS = 12


def moments(passing: tuple[int, int, int], resting: tuple[int, int, int] | None, cloth=CLOTH) -> list[np.ndarray]:
    """Cloth about a field of skin; something goes across above it, and something may rest at its corner."""
    rng = np.random.default_rng(3)
    made = []
    for k in range(MOMENTS):
        picture = np.full((SIZE[1], SIZE[0], 3), cloth, float)
        picture[FIELD] = SKIN
        if resting is not None:
            picture[RESTS] = resting
        if k % 3 == 0:
            picture[5:50, 20 * k : 20 * k + 70] = passing
            picture[0:12, 20 * k : 20 * k + 70] = SLEEVE
        made.append(np.clip(picture + rng.normal(0, 2, picture.shape), 0, 255).astype(np.uint8))
    return made


def told(pictures: list[np.ndarray]) -> ForeignColours:
    view = steady_view(pictures)
    assert view is not None
    field = np.zeros((SIZE[1] // 2, SIZE[0] // 2), bool)
    field[30:60, 55:105] = True
    return foreign_colours([{"cam1": p} for p in pictures], {"cam1": view}, {"cam1": field})["cam1"]


def places(pictures: list[np.ndarray]) -> np.ndarray:
    return told(pictures).sure


@pytest.mark.parametrize("glove", [GLOVE, (60, 60, 60), (190, 120, 60)], ids=["white", "black", "blue"])
def test_a_hand_that_rests_is_of_the_gloves_that_pass(glove: tuple[int, int, int]) -> None:
    found = places(moments(glove, glove))
    assert found[RESTS].mean() > 0.95
    found[86:144, 176:264] = False  # its rim
    assert not found.any(), "neither the field nor the cloth"


def test_where_nothing_rests_nothing_is_foreign() -> None:
    assert not places(moments(GLOVE, None)).any()
    assert not places(moments(GLOVE, (40, 200, 240))).any(), "a marker of a colour that never passes"


def test_bare_hands_do_not_take_the_field_away() -> None:
    found = told(moments(SKIN, SKIN))
    assert not (found.sure | found.likely)[FIELD].any()


def test_what_passes_has_most_of_the_fields_colours_and_tells_nothing() -> None:
    pictures = moments(SKIN, SKIN)
    for picture in pictures:
        picture[FIELD[0], 170:210] = (40, 40, 150)  # what is left has three fifths of the field
        picture[:50][(picture[:50] - np.array(SLEEVE)).max(axis=2) < 12] = SKIN
    found = told(pictures)
    assert not (found.sure | found.likely).any()


def test_cloth_of_the_sleeves_colour_stays() -> None:
    found = places(moments(GLOVE, GLOVE, cloth=SLEEVE))
    assert found[RESTS].mean() > 0.95
    assert not found[140:].any()


TAN = (110, 140, 180)


def tan_gloves(rows: int) -> list[np.ndarray]:
    """A tan glove rests; of what passes, white gloves for the most part, so many rows have its colours."""
    rng = np.random.default_rng(4)
    made = []
    for k in range(MOMENTS):
        picture = np.full((SIZE[1], SIZE[0], 3), CLOTH, float)
        picture[FIELD] = SKIN
        picture[RESTS] = TAN
        if k % 3 == 0:
            picture[5:55, 20 * k : 20 * k + 70] = GLOVE
            picture[5 : 5 + rows, 20 * k : 20 * k + 70] = TAN
        made.append(np.clip(picture + rng.normal(0, 2, picture.shape), 0, 255).astype(np.uint8))
    return made


@pytest.mark.parametrize(("rows", "likely", "sure"), [(5, 0, 0), (20, 1, 0), (35, 1, 1)])
def test_what_is_as_often_the_scenes_as_of_what_passes_is_likely_foreign(rows: int, likely: int, sure: int) -> None:
    found = told(tan_gloves(rows))
    assert found.likely[RESTS].mean() == pytest.approx(likely, abs=0.2)
    assert found.sure[RESTS].mean() == pytest.approx(sure, abs=0.2)
    found.likely[86:144, 176:264] = False  # its rim
    assert not found.likely.any()


def test_a_camera_without_any_sample_is_left_alone() -> None:
    view = steady_view(moments(GLOVE, GLOVE))
    assert view is not None
    field = np.ones((SIZE[1], SIZE[0]), bool)
    assert not foreign_colours([{"cam1": None}], {"cam1": view}, {"cam1": field})["cam1"].likely.any()
