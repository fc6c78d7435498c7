"""Two cameras of known difference over one field, with heads before them for as long as the pose lasts."""

from __future__ import annotations

import cv2
import numpy as np

from mcsl_core.alignment.agreed_colours import agreed_colours, steady_colours
from mcsl_core.alignment.aligned_views import AlignedPose, Picture
from mcsl_core.alignment.colour_match import as_matrix
from mcsl_core.edl import Colour

SIZE, NAMES, INSTANTS = (640, 360), ("a", "b"), 9
GAINS, OFFSETS = np.array([0.85, 1.0, 1.15]), np.array([3.0, 0.0, 4.0])
UNDOES = as_matrix(1 / GAINS, -OFFSETS / GAINS)
POSE = AlignedPose(SIZE, "a", dict.fromkeys(NAMES, np.eye(3)), dict.fromkeys(NAMES, SIZE), np.ones(SIZE[::-1], bool))


def cloth(seed: int, colour: tuple[int, int, int], contrast: float = 500.0) -> np.ndarray:
    noise = np.random.default_rng(seed).normal(0, 1, SIZE[::-1]).astype(np.float32)
    return np.array(colour, np.float32) + contrast * cv2.GaussianBlur(noise, (0, 0), 7)[..., None]


def samples(head_a: np.ndarray | None, head_b: np.ndarray | None, field: np.ndarray) -> list[dict[str, Picture | None]]:
    """Instants of what both cameras show: the field, before it a head where a mask is not 0, and a hand that moves."""
    made = []
    for n in range(INSTANTS):
        shown = field.copy()
        cv2.circle(shown, (200 + 20 * n, 180), 30, (150, 170, 210), -1)
        pictures: dict[str, Picture | None] = {}
        for seed, (name, head) in enumerate(zip(NAMES, (head_a, head_b), strict=True)):
            own = shown
            if head is not None:
                own = np.where(head[..., None] > 0, cloth(40 + seed, ((170, 90, 50), (70, 150, 160))[seed]), shown)
            own = own * GAINS + OFFSETS if name == "b" else own
            noise = np.random.default_rng([n, seed]).normal(0, 2, own.shape)
            pictures[name] = np.clip(own + noise, 0, 255).astype(np.uint8)
        made.append(pictures)
    return made


def disc(x: int, radius: int) -> np.ndarray:
    return cv2.circle(np.zeros(SIZE[::-1], np.uint8), (x, 180), radius, 255, -1)


def codes_off(found: Colour) -> float:
    codes = np.array([[60, 128, 128, 1], [180, 128, 128, 1], [110, 110, 150, 1], [120, 150, 110, 1]], float).T
    return float(np.abs(np.array(found.matrix) @ codes - np.array(UNDOES.matrix) @ codes).max())


def test_heads_that_stay_before_both_cameras_do_not_tint_the_match() -> None:
    shown = samples(disc(150, 170), disc(500, 190), cloth(1, (90, 120, 70)))
    assert codes_off(agreed_colours(POSE, shown)["b"]) < 6


def test_cameras_that_show_nothing_in_common_are_not_matched() -> None:
    everywhere = np.full(SIZE[::-1], 255, np.uint8)
    assert agreed_colours(POSE, samples(None, everywhere, cloth(1, (90, 120, 70)))) == {}


def test_a_smooth_field_is_matched_by_what_is_steady_alone() -> None:
    smooth = np.broadcast_to(np.linspace(60, 180, SIZE[0])[None, :, None], (*SIZE[::-1], 3)).astype(np.float32)
    shown = samples(None, None, smooth.copy())
    assert codes_off(steady_colours(POSE, shown, {"b"})["b"]) < 6


def test_an_instant_without_a_picture_is_left_out() -> None:
    shown = samples(None, None, cloth(1, (90, 120, 70)))
    assert agreed_colours(POSE, [{**shown[0], "b": None}, {**shown[1], "a": None}]) == {}
    assert codes_off(agreed_colours(POSE, [{**shown[0], "a": None}, *shown[1:]])["b"]) < 6
    assert steady_colours(POSE, shown, set()) == {}


def test_light_that_falls_off_alike_is_nothing_in_common() -> None:
    """A green drape before one camera, a blue cap before the other, both smooth."""
    y, x = np.mgrid[: SIZE[1], : SIZE[0]]
    light = 1 - 0.5 * ((x / SIZE[0] - 0.5) ** 2 + (y / SIZE[1] - 0.5) ** 2) * 2
    pictures = {
        name: np.clip(light[..., None] * np.array(colour), 0, 255).astype(np.uint8)
        for name, colour in (("a", (90, 150, 60)), ("b", (190, 110, 60)))
    }
    assert agreed_colours(POSE, [dict(pictures)] * 5) == {}
