"""A camera's drift is followed to the stated bound with few keys; hands, heads and noise make none of it."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from mcsl_core.alignment.drift import DriftSettings, GainTrack, gain_track, usual_exposure
from mcsl_core.edl.colour import gains_at
from mcsl_core.timing import FrameRange

SIZE = (320, 180)
SETTINGS = DriftSettings()
VISIBLE = 1.0  # codes a second at mid grey, by which a still scene may change at most


def cloth(seed: int, colour=(90, 120, 60)) -> np.ndarray:
    """(180, 320, 3) float: cloth with folds."""
    rng = np.random.default_rng(seed)
    folds = cv2.GaussianBlur(rng.normal(0, 60, SIZE[::-1]).astype(np.float32), (0, 0), 3)
    return np.array(colour, np.float32) + folds[..., None]


def seen(picture: np.ndarray, gain=1.0, seed: int = 0) -> np.ndarray:
    noise = np.random.default_rng(seed).normal(0, 2, picture.shape)
    return np.clip(picture * np.array(gain) + noise, 0, 255).astype(np.uint8)


def with_head(picture: np.ndarray, x: int, radius: int = 80) -> np.ndarray:
    """With a head before it that is as plain as a cap, and blue."""
    shown = picture.copy()
    inside = cv2.circle(np.zeros(SIZE[::-1], np.uint8), (x, 90), radius, 1, -1) > 0
    shown[inside] = cloth(9, (160, 110, 60))[inside]
    return shown


def tracked(pictures: list[np.ndarray], step: int = 1) -> GainTrack:
    usual = usual_exposure(pictures[:: max(1, len(pictures) // 20)])
    assert usual is not None
    return gain_track(usual, ((n * step, picture) for n, picture in enumerate(pictures)), SETTINGS.share)


def followed(track: GainTrack) -> np.ndarray:
    """(T, 3) gains of B, G, R by the track's keys."""
    keys = track.keys(SETTINGS.exact)
    return np.array([gains_at(keys, int(frame))[::-1] for frame in track.frames])


def test_a_pump_is_followed_when_a_head_comes_in_and_the_head_is_not_taken_for_light() -> None:
    """From the tenth picture on a head is before half of the view, and the camera answers by a quarter."""
    gains = np.interp(np.arange(40), [0, 10, 14, 26, 30], [1, 1, 1.25, 1.25, 1])
    scene = cloth(1)
    shown = [with_head(scene, 60 + 3 * n) if 10 <= n < 30 else scene for n in range(40)]
    track = tracked([seen(picture, float(g), n) for n, (picture, g) in enumerate(zip(shown, gains, strict=True))])
    level = followed(track) * gains[track.frames][:, None]
    assert len(track.frames) > 36
    assert np.abs(level / np.median(level, axis=0) - 1).max() < 0.02
    assert len(track.keys(SETTINGS.exact)) < 12


@pytest.mark.parametrize("colour", [(160, 110, 60), (90, 120, 190), (235, 235, 230)])
def test_a_hand_that_comes_and_stays_makes_no_drift(colour) -> None:
    scene = cloth(2)
    pictures = []
    for n in range(40):
        shown = scene.copy()
        if n >= 15:
            x = min(20 * (n - 15), 140)
            shown[30:150, x : x + 140] = cloth(5, colour)[30:150, x : x + 140]
        pictures.append(seen(shown, 1.0, n))
    assert not tracked(pictures).drifts(SETTINGS.least)


def test_white_balance_that_drifts_is_followed_channel_by_channel() -> None:
    t = np.arange(60)
    gains = np.exp(0.14 * np.stack([np.sin(t / 9), np.zeros(60), np.cos(t / 14)], axis=1))
    track = tracked([seen(cloth(3), g, n) for n, g in enumerate(gains)], step=10)
    level = followed(track) * gains
    assert np.abs(level / np.median(level, axis=0) - 1).max() < 0.02
    assert len(track.keys(SETTINGS.exact)) < 30


def test_noise_makes_no_visible_flicker_in_a_still_scene() -> None:
    """Exposure settles once; before and after it nothing changes but noise and a hand, a picture a second."""
    gains = np.interp(np.arange(80), [0, 30, 33], [0.8, 0.8, 1.0])
    pictures = []
    for n, gain in enumerate(gains):
        shown = with_head(cloth(4), int(160 + 120 * np.sin(n / 3)), 45)
        pictures.append(seen(shown, float(gain), n))
    codes = 128 * followed(tracked(pictures)) * gains[:, None]
    still = np.r_[0:28, 36:79]
    assert np.abs(np.diff(codes, axis=0))[still].max() < VISIBLE


def test_without_drift_there_are_no_keys_and_no_closer_look() -> None:
    track = tracked([seen(cloth(6), 1.0, n) for n in range(30)], step=30)
    assert not track.drifts(SETTINGS.least)
    assert track.fast(SETTINGS.fast, 3) == []


def test_a_view_of_nothing_steady_says_nothing() -> None:
    assert usual_exposure([]) is None
    black = [np.zeros((180, 320, 3), np.uint8)] * 5
    usual = usual_exposure(black)
    assert usual is None or not tracked(black).drifts(SETTINGS.least)


def track_of(values: list[float], step: int = 10) -> GainTrack:
    return GainTrack(np.arange(len(values)) * step, np.repeat(np.array(values)[:, None], 3, axis=1))


def test_keys_are_few_and_exact_to_the_bound() -> None:
    values = [1.0] * 10 + [1.0 + 0.02 * n for n in range(10)] + [1.2] * 10
    keys = track_of(values).keys(0.001)
    assert [key[0] for key in keys] == [0, 100, 200, 290]
    noisy = (np.array(values) + np.random.default_rng(0).normal(0, 0.002, 30)).tolist()
    keys = track_of(noisy).keys(0.01)
    assert len(keys) <= 5
    lines = [gains_at(keys, n * 10)[0] for n in range(30)]
    assert np.abs(np.array(lines) / noisy - 1).max() <= 0.0101


def test_it_is_looked_closer_where_gains_change_fast_and_samples_lie_apart() -> None:
    track = track_of([1.0, 1.0, 1.1, 1.2, 1.2, 1.2, 1.15, 1.15])
    assert track.fast(0.02, 3) == [FrameRange(10, 31), FrameRange(50, 61)]
    assert track.fast(0.02, 10) == []
    empty = GainTrack(np.zeros(0, np.int64), np.zeros((0, 3)))
    assert empty.fast(0.02, 3) == []
    assert not empty.drifts(0.02)
