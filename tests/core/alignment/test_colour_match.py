"""Colour matching against cameras whose difference is known."""

import cv2
import numpy as np
import pytest
from pictures import psnr

from mcsl_core.alignment.colour_match import apply_colour, as_matrix, match_colours
from mcsl_core.imaging.planes import Planes, bgr_to_planes, planes_to_bgr, upsample_chroma


def texture(seed=0, size=(320, 240)):
    rng = np.random.default_rng(seed)
    coarse = rng.integers(30, 200, (size[1] // 16, size[0] // 16, 3), dtype=np.uint8)
    return cv2.resize(coarse, size, interpolation=cv2.INTER_CUBIC)


def seen_by(picture, gains, offsets):
    return np.clip(np.round(picture * np.array(gains) + offsets), 0, 255).astype(np.uint8)


EVERYWHERE = np.full((240, 320), 255, np.uint8)


@pytest.mark.parametrize(
    ("gains", "offsets"),
    [((1, 1, 1), (0, 0, 0)), ((0.8, 1.0, 1.2), (6, -4, 10)), ((1.3, 1.1, 0.75), (-10, 0, 12))],
)
def test_a_known_difference_is_undone(gains, offsets):
    truth = texture()
    other = seen_by(truth, gains, offsets)
    found = match_colours(other, truth, EVERYWHERE)
    matched = planes_to_bgr(apply_colour(bgr_to_planes(other), found))
    clear = ((other > 8) & (other < 247)).all(axis=2).astype(np.uint8)
    assert psnr(matched, truth, clear) > 37  # 4:2:0 alone leaves about 40 on this texture
    expected = as_matrix(1 / np.array(gains), -np.array(offsets) / np.array(gains))
    assert np.abs(np.array(found.matrix)[:, :3] - np.array(expected.matrix)[:, :3]).max() < 0.06


def test_noise_parallax_and_a_third_of_foreign_things_do_not_throw_it():
    truth = texture()
    rng = np.random.default_rng(1)
    other = seen_by(np.roll(truth, 2, axis=1), (0.8, 0.95, 1.15), (4, 0, 8))
    other = np.clip(other + rng.normal(0, 4, other.shape), 0, 255).astype(np.uint8)
    other[:, :100] = (60, 160, 60)  # a glove over a third of the picture
    found = np.array(match_colours(other, truth, EVERYWHERE).matrix)
    expected = np.array(
        as_matrix(1 / np.array((0.8, 0.95, 1.15)), -np.array((4, 0, 8)) / np.array((0.8, 0.95, 1.15))).matrix
    )
    codes = np.array([[60, 128, 128, 1], [180, 128, 128, 1], [110, 110, 150, 1]], float).T
    assert np.abs(found @ codes - expected @ codes).max() < 5


def test_only_the_mask_counts_and_too_little_says_nothing():
    truth = texture()
    other = seen_by(truth, (0.8, 0.8, 0.8), (0, 0, 0))
    other[:120] = 255 - other[:120]
    mask = EVERYWHERE.copy()
    mask[:125] = 0
    found = np.array(match_colours(other, truth, mask).matrix)
    assert found[0, 0] == pytest.approx(1.25, abs=0.04)
    assert match_colours(other, truth, np.zeros_like(mask)) is None
    with pytest.raises(ValueError, match="size"):
        match_colours(other, truth[:100], mask)


def test_gains_stay_sane():
    truth = texture()
    found = np.array(match_colours(seen_by(truth, (0.1, 0.1, 0.1), (20, 20, 20)), truth, EVERYWHERE).matrix)
    assert found[0, 0] <= 2.0 + 1e-6


def test_what_shows_different_things_is_not_matched():
    """A cap over the field: a match by their means turned skin orange."""
    rng = np.random.default_rng(8)

    def cloth() -> np.ndarray:
        folds = cv2.GaussianBlur(rng.normal(0, 60, EVERYWHERE.shape).astype(np.float32), (0, 0), 4)
        return np.clip(np.array((150, 110, 60)) + folds[..., None] * np.array((1.0, 0.9, 0.8)), 0, 255).astype(np.uint8)

    assert match_colours(cloth(), cloth(), EVERYWHERE) is None


def test_flat_pictures_are_matched_by_offset():
    flat, target = np.full((240, 320, 3), 100, np.uint8), np.full((240, 320, 3), 120, np.uint8)
    matched = planes_to_bgr(apply_colour(bgr_to_planes(flat), match_colours(flat, target, EVERYWHERE)))
    assert np.abs(matched.astype(int) - 120).max() <= 2


def luma_sized(chroma):
    """Chroma at luma positions by MPEG-2 siting: columns lie on even luma columns, rows between two luma rows."""
    height = len(chroma)
    at = (np.arange(2 * height) - 0.5) / 2
    top = np.floor(at).astype(int)
    part = (at - top)[:, None]
    rows = (1 - part) * chroma[top.clip(0)] + part * chroma[(top + 1).clip(max=height - 1)]
    out = np.repeat(rows, 2, axis=1)
    out[:, 1:-1:2] = (rows[:, :-1] + rows[:, 1:]) / 2
    return out


def chroma_sized(y):
    rows = (y[::2] + y[1::2]) / 2
    mirrored = np.concatenate([rows[:, 1:2], rows], axis=1)
    return ((mirrored[:, :-2] + 2 * mirrored[:, 1:-1] + mirrored[:, 2:]) / 4)[:, ::2]


@pytest.mark.parametrize(
    ("gains", "offsets", "most"),
    [
        ((1.04, 0.97, 1.02), (-2, 1, 3), 1),
        ((1.3, 0.9, 0.8), (-5, 10, 3), 1),
        ((0.5, 1.2, 1.9), (10, 0, 0), 1),
        ((2, 0.5, 2), (0, 20, -20), 1.5),  # as far as a match may go: chroma's share of Y' no longer fits 8 bits finely
    ],
)
@pytest.mark.parametrize("noise", [False, True])
def test_apply_is_the_matrix_at_every_pixel_to_a_code(gains, offsets, most, noise):
    """In float64, every plane where it lies, also on codes without any likeness between neighbours."""
    planes = bgr_to_planes(texture(3))
    if noise:
        rng = np.random.default_rng(4)
        planes = Planes(*(rng.integers(16, 236, plane.shape, dtype=np.uint8) for plane in planes))
    m = np.array(as_matrix(np.array(gains), np.array(offsets, float)).matrix)
    y, u, v = (plane.astype(float) for plane in planes)
    expected = [m[0, 0] * y + m[0, 1] * luma_sized(u) + m[0, 2] * luma_sized(v) + m[0, 3]]
    expected += [m[i, 0] * chroma_sized(y) + m[i, 1] * u + m[i, 2] * v + m[i, 3] for i in (1, 2)]
    for found, wanted in zip(
        apply_colour(planes, as_matrix(np.array(gains), np.array(offsets, float))), expected, strict=True
    ):
        error = found - wanted.clip(0, 255)
        assert np.abs(error).max() <= most
        assert abs(error.mean()) < 0.15  # no shift


def test_the_identity_changes_no_bit():
    rng = np.random.default_rng(4)
    planes = Planes(*(rng.integers(0, 256, shape, dtype=np.uint8) for shape in ((64, 96), (32, 48), (32, 48))))
    for found, plane in zip(apply_colour(planes, as_matrix(np.ones(3), np.zeros(3))), planes, strict=True):
        assert np.array_equal(found, plane)


def test_chroma_is_enlarged_from_where_it_lies():
    plane = np.random.default_rng(5).integers(0, 256, (30, 44), dtype=np.uint8)
    assert np.abs(upsample_chroma(plane) - luma_sized(plane.astype(float))).max() <= 1  # rounded twice


@pytest.mark.parametrize("size", [(2, 2), (4, 2), (2, 6)])
def test_the_smallest_pictures_have_colours_too(size):
    grey = Planes(*(np.full(shape, 100, np.uint8) for shape in (size, *[(size[0] // 2, size[1] // 2)] * 2)))
    found = apply_colour(grey, as_matrix(np.array([1.0, 1.0, 1.0]), np.array([20.0, 20.0, 20.0])))
    assert [plane.shape for plane in found] == [plane.shape for plane in grey]
    assert [set(plane.ravel().tolist()) for plane in found] == [{117}, {100}, {100}]


@pytest.mark.parametrize("seed", range(4))
def test_white_stays_white_when_only_mid_tones_are_shared(seed):
    """Drapes and skin, nothing bright, shaded differently where the other camera stands: folds, its own corners."""
    rng = np.random.default_rng(seed)
    tones = np.array([[60, 75, 35], [55, 70, 30], [48, 60, 50], [70, 85, 40]], float)
    cloth = cv2.resize(tones[rng.integers(0, 4, (18, 32))], (640, 360), interpolation=cv2.INTER_NEAREST)
    shade = cv2.resize(rng.uniform(0.75, 1.25, (12, 20)), (640, 360), interpolation=cv2.INTER_CUBIC)[..., None]
    gains = rng.uniform(0.88, 1.12, 3)
    source, target = (np.clip(v, 0, 255).astype(np.uint8) for v in (cloth / gains, cloth * shade))
    found = match_colours(source, target, np.full((360, 640), 255, np.uint8))
    white = np.broadcast_to((200 / gains).clip(0, 255), (16, 16, 3)).astype(np.uint8)
    made = planes_to_bgr(apply_colour(bgr_to_planes(white), found))[8, 8].astype(float)
    assert np.abs(made - 200).max() < 10
