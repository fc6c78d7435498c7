"""The field's surface from points of a part of it: bent things, hands upon them, and which way is up."""

from __future__ import annotations

import numpy as np
import pytest

from mcsl_core.alignment.relief.field_surface import field_gamma, height_of_gamma, knows_up

SIZE = (240, 135)
FIELD = np.zeros(SIZE[::-1], bool)
FIELD[40:100, 80:170] = True


def limb(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """A limb across the picture: 25 pixels of parallax from its ridge to its sides."""
    return 12 - 25 * ((y - 70 + 0.2 * (x - 125)) / 35) ** 2


def points(keep, height: float) -> np.ndarray:
    x, y = (a.ravel() for a in np.meshgrid(np.arange(60, 190, 3.0), np.arange(25, 115, 3.0)))
    found = np.column_stack([x, y, limb(x, y) + np.random.default_rng(1).normal(0, 0.3, len(x))])
    found[:, 2] /= height
    return found[keep(x, y)]


@pytest.mark.parametrize("height", [0.7, -0.02, 1e4])
def test_what_no_match_reaches_is_carried_on_with_its_bend(height) -> None:
    known = points(lambda x, y: y > 58, height)
    gamma = field_gamma(known, FIELD, height)
    y, x = np.nonzero(FIELD)
    off = gamma[y, x] * height - limb(x, y)
    assert np.sqrt(np.mean(off**2)) < 3  # carried on level it would be 6.5
    assert np.abs(off[y > 62]).max() < 1


@pytest.mark.parametrize("height", [0.7, -0.7])
def test_a_hand_above_a_part_of_the_field_does_not_lift_it(height) -> None:
    known = points(lambda x, y: x == x, height)
    hand = (np.abs(known[:, 0] - 130) < 14) & (known[:, 1] > 65)
    known[hand, 2] += 30 / height
    gamma = field_gamma(known, FIELD, height)
    y, x = np.nonzero(FIELD)
    assert np.abs(gamma[y, x] * height - limb(x, y)).max() < 6
    assert np.sqrt(np.mean((gamma[y, x] * height - limb(x, y)) ** 2)) < 2


def test_a_field_of_which_hardly_anything_is_seen_is_as_its_surroundings() -> None:
    known = points(lambda x, y: (x < 70) | (x > 180), 1.0)
    gamma = field_gamma(known, FIELD, 1.0)
    assert np.isfinite(gamma).all()
    assert known[:, 2].min() - 1 <= gamma[FIELD].min() <= gamma[FIELD].max() <= known[:, 2].max() + 1


def camera_at(place: np.ndarray, focal: float, roll: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """K, R, t of a camera that looks at the origin."""
    ahead = -place / np.linalg.norm(place)
    right = np.cross(ahead, [np.cos(roll), np.sin(roll), 0])
    right /= np.linalg.norm(right)
    rotation = np.stack([right, np.cross(ahead, right), ahead])
    return np.array([[focal, 0, 320], [0, focal, 180], [0, 0, 1.0]]), rotation, -rotation @ place


@pytest.mark.parametrize("seed", range(6))
def test_what_stands_nearer_to_a_lamps_cameras_is_higher_whichever_way_gamma_grows(seed) -> None:
    """Cameras about a lamp of 0.3 m, 0.9 m above what they look at; gamma of either sign and any scale."""
    rng = np.random.default_rng(seed)
    turns = np.arange(5) * 2 * np.pi / 5 + rng.uniform(0, 1)
    places = [np.array([0.28 * np.cos(a), 0.28 * np.sin(a), 0.9 + rng.uniform(-0.04, 0.04)]) for a in turns]
    cameras = [camera_at(place, rng.uniform(500, 900), rng.uniform(0, 6)) for place in places]
    k, r, t = cameras[0]
    normal = r @ [0, 0, 1.0]  # the table, z = 0, in the first camera's space: normal . x + above = 0
    above = float(-normal @ t)
    scale = rng.choice([-1, 1]) * 10 ** rng.uniform(-3, 3)
    projections = {}
    for n, (own_k, own_r, own_t) in enumerate(cameras):
        turn = own_r @ r.T
        shift = own_t - turn @ t
        # x = K X / Z and gamma = scale * height / Z, so 1 / Z = (gamma / scale - normal . K^-1 x) / above
        plane = own_k @ (turn - np.outer(shift, normal) / above) @ np.linalg.inv(k)
        p = np.column_stack([plane, own_k @ shift / (above * scale)])
        projections[f"cam{n}"] = p / p[2, 2]
    up, down = np.array([0, 0, 0.03]), np.zeros(3)
    seen = [k @ (r @ point + t) for point in (down, up)]
    gammas = [scale * point[2] / (r @ point + t)[2] for point in (down, up)]
    there = np.array([*(seen[1][:2] / seen[1][2]), gammas[1]])
    own = projections["cam2"] @ [there[0], there[1], 1, there[2]]
    true = cameras[2][0] @ (cameras[2][1] @ up + cameras[2][2])
    assert own[:2] / own[2] == pytest.approx(true[:2] / true[2], abs=1e-6)  # the projections are right
    sizes, at = dict.fromkeys(projections, (640, 360)), np.array([320.0, 180.0])
    height = height_of_gamma(projections, sizes, at)
    assert height * (gammas[1] - gammas[0]) > 7  # pixels of 960, for 30 mm
    assert knows_up(projections, sizes)
    larger = {**projections, "cam3": np.diag([4, 4, 1]) @ projections["cam3"]}  # the same camera's finer pictures
    assert height_of_gamma(larger, {**sizes, "cam3": (2560, 1440)}, at) == pytest.approx(height)
    assert not knows_up({name: projections[name] for name in ("cam0", "cam1")}, sizes)


def test_a_bend_that_does_not_say_how_the_points_lie_is_not_carried_on() -> None:
    """An open wound in level skin, half of which is hidden: nothing bends beyond the points."""
    x, y = (a.ravel() for a in np.meshgrid(np.arange(60, 190, 3.0), np.arange(25, 115, 3.0)))
    deep = np.where(np.hypot((x - 125) / 1.6, y - 58) < 12, -15.0, 0.0) + np.random.default_rng(2).normal(0, 1, len(x))
    gamma = field_gamma(np.column_stack([x, y, deep])[y < 80], FIELD, 1.0)
    assert np.abs(gamma[80:100, 80:170]).max() < 2
