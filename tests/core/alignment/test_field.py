"""Where the field lies: what is usually seen there decides, not who works above it."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from mcsl_core.alignment.aligned_views import AlignedPose
from mcsl_core.alignment.field import modal_picture, shared_aim
from mcsl_core.alignment.field_voices import find_field
from mcsl_core.imaging.masks import central_ellipse, close_gaps, convex_hull

SIZE = (240, 136)
FIELD = (slice(45, 95), slice(80, 160))


def aligned() -> AlignedPose:
    cameras = ("cam1", "cam2", "cam3")
    empty = np.zeros((SIZE[1], SIZE[0]), bool)
    return AlignedPose(SIZE, "cam1", {c: np.eye(3) for c in cameras}, dict.fromkeys(cameras, SIZE), empty)


def samples(count: int, glove: tuple[int, int, int]):
    """Skin in green drapes, and a glove that works in two of three views at most, most of the time."""
    rng = np.random.default_rng(3)
    for sample in range(count):
        pictures = {}
        for number in range(3):
            picture = np.full((SIZE[1], SIZE[0], 3), (60, 110, 40), np.uint8)
            picture[FIELD] = (110, 140, 200)
            if (sample + number) % 3:
                x, y = rng.integers(60, 140), rng.integers(30, 80)
                shade = rng.uniform(0.6, 1.1)
                colour = tuple(float(min(255, v * shade)) for v in glove)
                cv2.ellipse(picture, (int(x), int(y)), (45, 25), float(rng.uniform(0, 180)), 0, 360, colour, -1)
            noise = rng.normal(0, 4, picture.shape)
            pictures[f"cam{number + 1}"] = np.clip(picture + noise, 0, 255).astype(np.uint8)
        yield pictures


def overlap(mask: np.ndarray) -> float:
    true = np.zeros(mask.shape, bool)
    true[FIELD] = True
    return float((mask & true).sum() / (mask | true).sum())


def test_the_field_is_found_under_gloves_of_any_colour() -> None:
    for glove in ((200, 90, 40), (235, 235, 235), (100, 130, 210)):  # blue, white, the skin's own
        assert overlap(find_field(aligned(), [*samples(40, glove)])) > 0.85, glove


WHITE = (235, 235, 235)


def scene(skin: tuple[int, int, int], drape: tuple[int, int, int], hand: tuple[int, int, int] = WHITE):
    """A wound in skin in drapes, lit brightest in the middle; hands that work, and one that rests on a side."""
    rng = np.random.default_rng(5)
    y, x = np.mgrid[: SIZE[1], : SIZE[0]]
    light = (0.5 + 0.6 * np.exp(-((x - 120) ** 2 + (y - 70) ** 2) / (2 * 70.0**2)))[..., None]
    for sample in range(24):
        pictures = {}
        for number in range(3):
            picture = np.full((SIZE[1], SIZE[0], 3), drape, np.float32)
            picture[FIELD] = skin
            cv2.ellipse(picture, (120, 70), (20, 8), 0, 0, 360, (25, 25, 90), -1)
            cv2.rectangle(picture, (100, 78), (118, 135), hand, -1)
            if (sample + number) % 3 == 0:
                at = (int(rng.integers(20, 220)), int(rng.integers(10, 125)))
                cv2.ellipse(picture, at, (35, 18), float(rng.uniform(0, 180)), 0, 360, hand, -1)
            shown = picture * light + rng.normal(0, 3, picture.shape)
            pictures[f"cam{number + 1}"] = np.clip(shown, 0, 255).astype(np.uint8)
        yield pictures


@pytest.mark.parametrize(
    ("skin", "drape"),
    [
        ((28, 30, 36), (60, 130, 50)),  # nearly black, in green: the wound alone has the field's hue
        ((130, 160, 215), (60, 92, 128)),  # light, in brown: all has it
        ((28, 30, 36), (60, 92, 128)),  # nearly black, in brown
        ((70, 95, 135), (170, 120, 60)),  # brown, in blue
    ],
)
def test_the_field_is_told_from_drapes_by_its_own_colours(
    skin: tuple[int, int, int], drape: tuple[int, int, int]
) -> None:
    found = find_field(aligned(), [*scene(skin, drape)])
    assert overlap(found) > 0.8


def test_under_bare_hands_the_field_is_more_than_its_wound() -> None:
    skin = (110, 150, 205)
    assert overlap(find_field(aligned(), [*scene(skin, (60, 130, 50), skin)])) > 0.8


def test_what_is_usually_seen_is_coarse_but_right() -> None:
    picture = modal_picture(aligned(), samples(40, (235, 235, 235)))
    assert picture.shape == (SIZE[1], SIZE[0], 3)
    b, g, r = picture[60, 100].astype(int)
    assert r > g + 30 > b + 30, "skin, though a white glove works before it"
    b, g, r = picture[10, 10].astype(int)
    assert g > max(b, r) + 30, "the drape"


def test_no_field_where_nothing_shows_one() -> None:
    plain = np.full((SIZE[1], SIZE[0], 3), (60, 110, 40), np.uint8)
    shown = {camera: plain for camera in aligned().homographies}
    assert not find_field(aligned(), [shown] * 5).any()
    assert not find_field(aligned(), [{"cam1": None}]).any()
    assert not convex_hull(np.zeros((20, 30), bool)).any()


def test_instruments_and_a_dark_wound_are_closed_and_the_edge_is_kept() -> None:
    mask = np.zeros((136, 240), bool)
    mask[FIELD] = True
    holed = mask.copy()
    holed[60:80, 100:130] = False  # a wound
    holed[45:70, 140:144] = False  # an instrument that comes in from the edge
    np.testing.assert_array_equal(close_gaps(mask), mask)
    assert (close_gaps(holed) ^ mask).mean() < 0.002
    at_the_border = np.zeros((136, 240), bool)
    at_the_border[:40] = True
    np.testing.assert_array_equal(close_gaps(at_the_border), at_the_border)


def test_the_middle_is_the_middle() -> None:
    mask = central_ellipse((200, 100))
    assert mask[50, 100]
    assert not mask[5, 100]
    assert not mask[50, 20]
    assert 0.2 < mask.mean() < 0.35


def test_cameras_of_a_lamp_aim_at_one_place_and_those_about_a_room_do_not() -> None:
    def aim(shift: float, turned: float = 0.0) -> float:
        pose = aligned()
        laid = {}
        for i, name in enumerate(pose.homographies):
            turn = np.vstack([cv2.getRotationMatrix2D((120, 68), turned * i, 1.0), [0, 0, 1]])
            laid[name] = np.array([[1, 0, shift * i], [0, 1, 0], [0, 0, 1.0]]) @ turn
        return shared_aim(AlignedPose(SIZE, "cam1", laid, pose.camera_sizes, pose.field))

    assert aim(0) > 0.99
    assert aim(0, turned=72) > 0.99
    assert aim(6, turned=72) > 0.97
    assert aim(60) < 0.8
