"""Hands that rest on a surface are found and the surface goes on under them; what belongs to the scene stays."""

from __future__ import annotations

import numpy as np
import pytest

from mcsl_core.alignment.relief.foreign import ForeignColours
from mcsl_core.alignment.relief.protocol import ReliefCamera, ReliefSurface, ReliefView
from mcsl_core.alignment.relief.resting_hands import ForeignShare, foreign_share, without_resting_hands

ROWS, COLUMNS = 54, 96
Y, X = np.mgrid[:ROWS, :COLUMNS].astype(float)


def surface(gamma: np.ndarray, confidence: float | np.ndarray = 0.9) -> ReliefSurface:
    return ReliefSurface(gamma, np.broadcast_to(confidence, gamma.shape).astype(float), frozenset({"cam1", "cam2"}))


def ground() -> np.ndarray:
    """Gentle hills of 6 pixels, on a slope."""
    return 6 * np.sin(X / 15) * np.cos(Y / 12) + 0.1 * X


def hand() -> tuple[np.ndarray, np.ndarray]:
    """(where a forearm and a hand lie, how high): from the right edge, 25 pixels high, falling to the fingers."""
    where = (abs(Y - 27) < 7) & (X > 50)
    return where, np.where(where, np.minimum(25, 8 + 1.2 * (X - 50)), 0.0)


def sleeve(where: np.ndarray) -> ForeignShare:
    return ForeignShare(foreign := (where & (X > 80)).astype(float), foreign)


NOWHERE = ForeignShare(np.zeros((ROWS, COLUMNS)), np.zeros((ROWS, COLUMNS)))


@pytest.mark.parametrize("up", [1.0, -1.0, 0.4])
def test_under_a_hand_the_ground_goes_on(up: float):
    where, high = hand()
    found, hands = without_resting_hands(surface((ground() + high) / up), sleeve(where), up)
    assert hands[where].mean() > 0.9
    assert hands[~where].mean() < 0.03
    off = abs(found.gamma * up - ground())
    assert np.sqrt((off[where] ** 2).mean()) < 0.4 * np.sqrt((high[where] ** 2).mean())
    assert off[~where].mean() < 0.3


def test_near_what_is_seen_the_ground_is_half_sure_and_far_from_it_not_at_all():
    where = (X > 66) & (abs(Y - 27) < 14)
    found, hands = without_resting_hands(surface(ground() + 30.0 * where), sleeve(where), 1.0)
    assert hands[where].all()
    assert found.confidence[27, 67] > 0.4
    assert found.confidence[27, 90] < 0.05


def test_what_has_the_scenes_own_colours_stays():
    limb = 40 * np.maximum(0, 1 - ((Y - 27) / 14) ** 2)
    rim = 10 * np.exp(-((np.hypot(X - 48, Y - 27) - 8) ** 2))
    little = ForeignShare(np.full((ROWS, COLUMNS), 0.03), np.full((ROWS, COLUMNS), 0.3))  # as noise has it
    for bump in (limb, rim):
        given = surface(ground() + bump)
        found, hands = without_resting_hands(given, little, 1.0)
        assert not hands.any()
        assert found is given


def test_foreign_colours_that_lie_flat_are_no_hand():
    cloth = (np.hypot(X - 20, Y - 20) < 9).astype(float)
    found, hands = without_resting_hands(surface(ground()), ForeignShare(cloth, cloth), 1.0)
    assert not hands.any()
    np.testing.assert_array_equal(found.gamma, ground())


def test_foreign_colours_are_looked_up_where_each_camera_sees_the_surface():
    size, shifted = (960, 540), np.eye(3, 4)
    shifted[0, 3] = 1.0  # a pixel to the right for each of gamma
    seen = np.ones((270, 480), bool)
    view = ReliefView(np.zeros((270, 480, 3), np.uint8), seen)
    cameras = {
        "cam1": ReliefCamera(size, np.eye(3, 4), np.eye(3), (view,)),
        "cam2": ReliefCamera(size, shifted, np.eye(3), (view,)),
    }
    left = np.zeros((270, 480), bool)
    left[:, :240] = True
    colours = ForeignColours(left, ~left)
    share = foreign_share(surface(np.full((ROWS, COLUMNS), 96.0)), size, cameras, dict.fromkeys(cameras, colours))
    at = np.linspace(0, 959, COLUMNS)
    np.testing.assert_allclose(share.sure[20, at < 380], 1.0)
    np.testing.assert_allclose(share.sure[20, (at > 390) & (at < 475)], 0.5)
    np.testing.assert_allclose(share.sure[20, at > 485], 0.0)
    np.testing.assert_allclose(share.likely[20, (at > 485) & (at < 850)], 1.0)


def test_a_limb_stays_under_a_hand_of_nearly_its_colours():
    limb = 60 * np.maximum(0, 1 - ((Y - 27) / 16) ** 2)
    where = (abs(X - 48) < 8) & (Y > 20)
    likely = ForeignShare(np.zeros((ROWS, COLUMNS)), where.astype(float))
    found, hands = without_resting_hands(surface(limb + 30.0 * where), likely, 1.0)
    assert hands[where & (Y < 45)].mean() > 0.8
    assert hands[~where].mean() < 0.03
    assert abs(found.gamma - limb)[(abs(X - 48) < 8) & (abs(Y - 27) < 7)].mean() < 10  # it was 30


def test_what_covers_most_of_the_field_is_the_field_though_a_hand_lies_on_it():
    limb = abs(Y - 27) < 8
    field = (abs(Y - 27) < 10) & (abs(X - 40) < 16)
    given = surface(ground() + 30.0 * limb)
    for coloured in (ForeignShare(sleeve(limb).sure, NOWHERE.likely), ForeignShare(NOWHERE.sure, 1.0 * limb)):
        assert without_resting_hands(given, coloured, 1.0)[1][field].mean() > 0.5
        found, hands = without_resting_hands(given, coloured, 1.0, field)
        assert found is given
        assert not hands.any()


def test_on_a_grid_of_a_few_nodes_nothing_is_told():
    given = ReliefSurface(np.zeros((2, 3)), np.ones((2, 3)), frozenset({"cam1"}))
    found, hands = without_resting_hands(given, ForeignShare(np.ones((2, 3)), np.ones((2, 3))), 1.0)
    assert found is given
    assert hands.shape == (2, 3)
