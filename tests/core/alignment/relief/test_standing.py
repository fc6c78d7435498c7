"""Hands over the field by their height: over skin, wounds and limbs, and where there are none."""

from __future__ import annotations

import numpy as np
import pytest

from mcsl_core.alignment.relief.field_surface import field_gamma, height_of_gamma, knows_up
from mcsl_core.alignment.relief.standing import standing_above

SIZE = (480, 270)
SIZES = dict.fromkeys(("a", "b0", "b1", "b2"), (960, 540))
FIELD = np.zeros(SIZE[::-1], bool)
FIELD[90:180, 170:310] = True
X, Y = (a.ravel() for a in np.meshgrid(np.arange(10, 470, 5.0), np.arange(10, 260, 5.0)))
NOISE = np.random.default_rng(1).normal(0, 0.4, len(X))
HAND = (np.abs(X - 200 - 0.1 * Y) < 28) & (Y > 110)  # its fingers over the field, its wrist beyond, ...
RAISED = 45 - 0.15 * (240 - np.minimum(Y, 240))  # ... which stands higher, above the skin or the ridge


def under_hand(heights: np.ndarray) -> np.ndarray:
    return np.where(HAND, np.maximum(heights, np.median(heights[HAND])) + RAISED, heights)


PATIENTS = {
    "skin": 4 + 0.02 * X - 0.03 * Y,
    "an open wound": 4 - 30 * np.exp(-(((X - 240) / 30) ** 2) - ((Y - 135) / 15) ** 2),
    "a limb": 15 - 60 * np.minimum(np.abs(Y - 135 + 0.1 * (X - 240)) / 60, 1) ** 2,
}


def points(heights: np.ndarray, height: float) -> np.ndarray:
    return np.column_stack([X, Y, (heights + NOISE) / height])


@pytest.mark.parametrize("height", [0.7, -300.0])
@pytest.mark.parametrize("patient", PATIENTS)
def test_a_hand_over_a_part_of_the_field_is_told_from_it(patient, height) -> None:
    hand = standing_above(points(under_hand(PATIENTS[patient]), height), FIELD, height)
    over = FIELD[Y.astype(int), X.astype(int)]
    assert hand[over & HAND].mean() > 0.9
    assert hand[over & ~HAND].mean() < 0.03


@pytest.mark.parametrize("patient", PATIENTS)
def test_a_field_before_which_nothing_stands_keeps_all_its_points(patient) -> None:
    assert not standing_above(points(PATIENTS[patient], 0.7), FIELD, 0.7).any()


def test_hands_beside_the_field_are_none_of_its_business() -> None:
    beside = (np.abs(X - 400) < 25) & (Y > 60)
    found = standing_above(points(PATIENTS["skin"] + 40 * beside, 0.7), FIELD, 0.7)
    assert not found[FIELD[Y.astype(int), X.astype(int)]].any()


def test_what_covers_nearly_all_of_the_field_is_taken_for_it() -> None:
    over = (X > 175) & (X < 330) & (Y > 60)
    assert not standing_above(points(PATIENTS["skin"] + 40 * over, 0.7), FIELD, 0.7).any()


@pytest.mark.parametrize("few", [1, 5])
def test_few_points_tell_nothing(few) -> None:
    assert not standing_above(points(PATIENTS["skin"], 0.7)[:few], FIELD, 0.7).any()


def test_without_the_hand_the_field_below_it_is_carried_on() -> None:
    true = PATIENTS["a limb"]
    known = points(under_hand(true), 0.7)
    below = FIELD[Y.astype(int), X.astype(int)] & HAND
    at = Y[below].astype(int), X[below].astype(int)

    def off(own: np.ndarray) -> float:
        return float(np.sqrt(np.mean((field_gamma(own, FIELD, 0.7)[at] * 0.7 - true[below]) ** 2)))

    assert off(known[~standing_above(known, FIELD, 0.7)]) < 5


@pytest.mark.parametrize(("leaning", "known"), [((3, 2, 4), True), ((3, -1, 4), True), ((3, 2, -3), False)])
def test_which_way_is_up_is_known_where_the_cameras_agree(leaning, known) -> None:
    projections = {"a": np.eye(3, 4)}
    for n, lean in enumerate(leaning):
        turn = 2 * n
        projections[f"b{n}"] = np.column_stack([np.eye(3), [300 * np.cos(turn), 300 * np.sin(turn), 0.05 * lean]])
    assert knows_up(projections, SIZES) is known
    assert knows_up({n: p * [1, 1, 1, -5] for n, p in projections.items()}, SIZES) is known
    assert (height_of_gamma(projections, SIZES, np.array([50.0, 40.0])) > 0) is (sum(leaning) > 0)
