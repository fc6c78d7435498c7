"""Exposure that settles or pumps is no occlusion, and what covers the field is not levelled away."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from mcsl_core.alignment.aligned_views import AlignedPose
from mcsl_core.imaging.exposure import Exposure, changed, common_gains, levelled, small
from mcsl_core.occlusion.consensus import Consensus

SIZE = (240, 136)
FIELD = (slice(40, 96), slice(80, 160))
NAMES = ("cam1", "cam2", "cam3")


def scene(seed: int = 0) -> np.ndarray:
    """Drapes with folds, skin in the middle."""
    rng = np.random.default_rng(seed)
    picture = np.full((SIZE[1], SIZE[0], 3), (90, 120, 60), np.float32)
    picture[FIELD] = (95, 120, 170)
    folds = cv2.GaussianBlur(rng.normal(0, 90, picture.shape[:2]).astype(np.float32), (0, 0), 4)
    return picture + folds[..., None]


def seen(picture: np.ndarray, gain: float | tuple[float, ...] = 1.0, seed: int = 1) -> np.ndarray:
    noise = np.random.default_rng(seed).normal(0, 2, picture.shape)
    return np.clip(picture * np.array(gain) + noise, 0, 255).astype(np.uint8)


def pose() -> AlignedPose:
    field = np.zeros((SIZE[1], SIZE[0]), bool)
    field[FIELD] = True
    return AlignedPose(SIZE, "cam1", {name: np.eye(3) for name in NAMES}, dict.fromkeys(NAMES, SIZE), field)


def exposure() -> Exposure:
    pictures = [small(seen(scene(), seed=i)) for i in range(9)]
    return Exposure.of(pictures, np.ones((SIZE[1], SIZE[0]), bool))


@pytest.mark.parametrize("gain", [0.6, 0.85, 1.2, (0.9, 1.0, 1.15)])
def test_a_gain_is_found_and_taken_back(gain) -> None:
    picture = seen(scene(), gain)
    found = exposure().gain(small(picture))
    np.testing.assert_allclose(found, 1 / np.broadcast_to(gain, 3), rtol=0.03)
    assert found is not None
    off = np.abs(levelled(picture, found).astype(int) - seen(scene()).astype(int))
    assert np.median(off) <= 4


def test_a_picture_as_usual_is_left_as_it_is() -> None:
    picture = seen(scene())
    assert levelled(picture, changed(exposure().gain(small(picture)), 0.02)) is picture


def test_a_head_before_most_of_the_picture_is_no_exposure() -> None:
    picture = seen(scene())
    cv2.circle(picture, (120, 68), 110, (150, 110, 60), -1)
    assert exposure().gain(small(picture)) is None


@pytest.mark.parametrize(("gain", "believed"), [(0.75, True), ((0.75, 1.0, 1.2), False), (1.0, True)])
def test_beside_a_head_before_much_of_the_picture_exposure_is_found_but_no_colour(gain, believed: bool) -> None:
    rng = np.random.default_rng(3)
    picture = seen(scene(), gain)
    picture[:, :170] = rng.integers(20, 230, (SIZE[1], 1, 3))  # hair and cap: many ratios, seven tenths of the picture
    found = exposure().gain(small(picture))
    if believed:
        np.testing.assert_allclose(found, np.full(3, 1 / np.max(gain)), rtol=0.04)
    else:
        assert found is None


def test_clear_cameras_read_clear_while_their_exposure_settles() -> None:
    """Each camera begins dark and settles at a time of its own; in the end a glove lies over all of one's field."""
    aligned = pose()
    samples = []
    for at in range(24):
        gains = {name: 1 - 0.4 * np.exp(-at / (3 + 2 * number)) for number, name in enumerate(NAMES)}
        samples.append(aligned.views({name: seen(scene(), gain, at) for name, gain in gains.items()}))
    scorer = Consensus().scorer(aligned, samples)
    for at in (0, 2, 20):
        scores = scorer.score(samples[at])
        assert min(scores.values()) > 0.9, (at, scores)
    covered = seen(scene(), 0.7)
    covered[FIELD] = (150, 110, 60)
    pictures = {"cam1": covered, "cam2": seen(scene(), 0.7), "cam3": seen(scene())}
    scores = scorer.score(aligned.views(pictures))
    assert scores["cam1"] < 0.1
    assert min(scores["cam2"], scores["cam3"]) > 0.9


def test_a_head_that_wanders_before_half_of_every_picture_does_not_hide_its_gain() -> None:
    """The first and the last picture have next to nothing in common; the light grows meanwhile."""
    gains = np.linspace(0.8, 1.25, 12)
    pictures = []
    for at, gain in enumerate(gains):
        picture = scene()
        cv2.circle(picture, (round(20 + 18 * at), 68), 80, (150, 110, 60), -1)
        pictures.append(small(seen(picture, float(gain), at)))
    found = common_gains(pictures, np.ones(pictures[0].shape[:2], bool))
    assert all(gain is not None for gain in found)
    level = np.array(found) * gains[:, None]
    assert np.ptp(level, axis=0).max() < 0.02 * level.mean()


def test_pictures_that_have_nothing_in_common_have_no_gain() -> None:
    pictures = [small(seen(scene(seed), seed=seed)) for seed in range(4)]
    pictures = [np.roll(picture, 9 * n, axis=(0, 1)) for n, picture in enumerate(pictures)]
    assert common_gains(pictures, np.ones(pictures[0].shape[:2], bool)) == [None] * 4
    assert common_gains(pictures[:1], np.ones(pictures[0].shape[:2], bool)) == [None]
