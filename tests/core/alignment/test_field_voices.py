"""The field by what cameras aim at and colours that are only there: of any hue, and none where nothing shows one."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from mcsl_core.alignment.aligned_views import AlignedPose
from mcsl_core.alignment.field import aim_of
from mcsl_core.alignment.field_voices import field_by_voices, find_field, gather

SIZE = (240, 136)
FIELD = (slice(42, 96), slice(78, 164))
NAMES = ("cam1", "cam2", "cam3")
RED, GREEN, BLACK, BLUE, WHITE, BROWN = (
    (90, 110, 190),
    (60, 110, 40),
    (24, 20, 22),
    (150, 80, 40),
    (225, 228, 230),
    (60, 90, 130),
)


def aligned(shift: float = 8) -> AlignedPose:
    """Three cameras, a little beside each other."""
    moved = {name: np.array([[1, 0, shift * (i - 1)], [0, 1, 0], [0, 0, 1.0]]) for i, name in enumerate(NAMES)}
    moved = {name: h @ np.linalg.inv(moved["cam1"]) for name, h in moved.items()}
    return AlignedPose(SIZE, "cam1", moved, dict.fromkeys(NAMES, SIZE), np.zeros((SIZE[1], SIZE[0]), bool))


def picture(field, drape, seed: int = 0) -> np.ndarray:
    """Brighter in the middle, as under a lamp, with folds."""
    made = np.full((SIZE[1], SIZE[0], 3), drape, np.float32)
    made[FIELD] = field
    y, x = np.indices(made.shape[:2])
    lamp = 1.15 - 0.35 * np.hypot(x - 120, y - 68) / 138
    rng = np.random.default_rng(seed)
    folds = cv2.GaussianBlur(rng.normal(0, 30, made.shape[:2]).astype(np.float32), (0, 0), 3)
    return np.clip(made * lamp[..., None] + folds[..., None] + rng.normal(0, 2, made.shape), 0, 255).astype(np.uint8)


def found(*shown: np.ndarray) -> np.ndarray:
    pose = aligned(0)
    return field_by_voices(gather(pose, [dict.fromkeys(NAMES, one) for one in shown])).mask


def overlap(mask: np.ndarray) -> float:
    true = np.zeros(mask.shape, bool)
    true[FIELD] = True
    return float((mask & true).sum() / (mask | true).sum())


@pytest.mark.parametrize(
    ("field", "drape"), [(RED, GREEN), (RED, WHITE), (BLACK, GREEN), (BLACK, BLUE), (RED, BROWN), (WHITE, BLUE)]
)
def test_the_field_is_what_has_its_own_colours_at_the_aim_whatever_they_are(field, drape) -> None:
    assert overlap(found(picture(field, drape))) > 0.8


def test_things_of_the_fields_hue_elsewhere_do_not_count() -> None:
    shown = picture(RED, GREEN)
    shown[5:60, 190:235] = RED
    shown[100:130, 5:60] = RED
    assert overlap(found(shown)) > 0.8


@pytest.mark.parametrize("drape", [GREEN, BROWN, RED, WHITE])
def test_none_is_claimed_where_nothing_shows_one(drape) -> None:
    assert not found(picture(drape, drape)).any()


def test_colours_that_come_and_go_say_little_and_their_bite_is_filled() -> None:
    pose, rng, glove = aligned(0), np.random.default_rng(1), (200, 205, 210)
    samples = []
    for at in range(20):
        shown = {name: picture(BLACK, GREEN, 3 * at + i) for i, name in enumerate(NAMES)}
        for own in shown.values():
            cv2.circle(own, (160, 100), 26, glove, -1)
            cv2.circle(own, (int(rng.integers(20, 220)), int(rng.integers(10, 125))), 34, glove, -1)
        samples.append(shown)
    evidence = gather(pose, samples)
    assert evidence.said[100, 165] < evidence.said[55, 100], "it rests, but the others of its colour work"
    assert evidence.said[55, 100] > 0.9
    assert overlap(field_by_voices(evidence).mask) > 0.75


def worked_on(skin, drape, hand, wound: tuple[int, int]) -> list[dict[str, np.ndarray]]:
    """A wound of two half axes; hands rest across two sides of the field, others work in every third picture."""
    rng, samples = np.random.default_rng(5), []
    for at in range(24):
        shown = {}
        for i, name in enumerate(NAMES):
            own = picture(skin, drape)
            cv2.ellipse(own, (121, 69), wound, 0, 0, 360, (25, 25, 90), -1)
            for middle, turn in (((168, 69), 0), ((121, 104), 90)):
                cv2.ellipse(own, middle, (26, 15), turn, 0, 360, hand, -1)
            if (at + i) % 3 == 0:
                middle = int(rng.integers(20, 220)), int(rng.integers(10, 125))
                cv2.ellipse(own, middle, (35, 18), float(rng.uniform(0, 180)), 0, 360, hand, -1)
            shown[name] = np.clip(own + rng.normal(0, 3, own.shape), 0, 255).astype(np.uint8)
        samples.append(shown)
    return samples


@pytest.mark.parametrize("wound", [(22, 11), (30, 15)])
def test_neither_the_wound_nor_drapes_of_the_skins_hue_pass_for_the_field(wound) -> None:
    """The wound agreed to 0.80, where the field's two sides under hands had 0.68; the hue takes in the drapes."""
    assert overlap(find_field(aligned(0), worked_on((110, 150, 205), BROWN, WHITE, wound))) > 0.9


def test_what_was_found_before_stays_where_it_tells_more_of_the_colours() -> None:
    samples = worked_on((70, 95, 135), WHITE, (70, 95, 135), (22, 11))
    field = np.zeros((SIZE[1], SIZE[0]), bool)
    field[FIELD] = True
    alone = find_field(aligned(0), samples)
    assert overlap(alone) < 0.9, "a part of the bare hands that rest across its edges as well"
    assert overlap(find_field(aligned(0), samples, field)) > 0.95
    wound = cv2.ellipse(np.zeros(field.shape, np.uint8), (121, 69), (22, 11), 0, 0, 360, 1, -1) > 0
    clear = [{name: picture(RED, GREEN) for name in NAMES}]
    for wrong in (wound, np.zeros_like(field)):
        assert overlap(find_field(aligned(0), clear, wrong)) > 0.8


def test_cameras_aim_where_the_middles_of_their_pictures_meet() -> None:
    aim = aim_of(aligned(30))
    row, column = np.unravel_index(aim.argmax(), aim.shape)
    assert abs(column - (120 + 30)) <= 2, "the second of three lies 30 pixels to the right of the reference"
    assert abs(row - 68) <= 1
    assert aim.max() <= 1
