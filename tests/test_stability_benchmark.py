"""The figures of `benchmarks.stability`, on films whose way is known."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from benchmarks.stability import STABILISERS, WIDTH, ffmpeg, low_frequencies, stabilised, stability

SIZE = (480, 270)


def film(way: list[tuple[float, float]], *, stretch: float = 1.0) -> list[np.ndarray]:
    """A texture whose places go that way, in pixels; the last frame stretched."""
    coarse = np.random.default_rng(2).integers(40, 220, (120, 160, 3)).astype(np.uint8)
    texture = cv2.resize(coarse, (960, 720), interpolation=cv2.INTER_CUBIC)
    made = []
    for n, (x, y) in enumerate(way):
        by = stretch if n == len(way) - 1 else 1.0
        matrix = np.array([[by, 0, x - 200 * by], [0, 1.0, y - 200]])
        made.append(cv2.warpAffine(texture, matrix, SIZE, flags=cv2.INTER_LINEAR))
    return made


def test_a_still_film_stands_still() -> None:
    found = stability(film([(0, 0)] * 8))
    assert found.drift < 0.05
    assert found.acceleration < 0.05
    assert found.anisotropy == pytest.approx(1, abs=1e-3)
    assert found.black == 0


def test_a_way_that_is_known_is_found() -> None:
    """Steady, then stopped: the acceleration is the speed before."""
    way = [(3.0 * min(n, 6), 1.0 * min(n, 6)) for n in range(12)]
    found, scale = stability(film(way)), WIDTH / SIZE[0]
    lengths = np.hypot(*np.array(way).T)
    assert found.drift == pytest.approx(scale * np.sqrt(np.mean(lengths**2)), rel=0.02)
    assert found.acceleration == pytest.approx(scale * np.hypot(3, 1), rel=0.05)


def test_a_stretch_and_black_are_told() -> None:
    assert stability(film([(0, 0)] * 4, stretch=1.05)).anisotropy == pytest.approx(1.05, abs=0.005)
    bare = film([(0, 0)] * 4)
    for picture in bare:
        picture[:, :120] = 0
    assert stability(bare).black == pytest.approx(0.25, abs=0.01)


def test_smooth_ways_have_low_frequencies() -> None:
    n = np.arange(40)
    assert low_frequencies(np.sin(2 * np.pi * 2 * n / 40)) == pytest.approx(1)
    assert low_frequencies(np.sin(2 * np.pi * 15 * n / 40)) == pytest.approx(0)
    assert low_frequencies(np.zeros(40)) == 1


def test_vidstab_as_a_standing_camera_holds_a_film_and_shows_black() -> None:
    """Its border, which is not black by itself, is no picture: all of the way is black at the end."""
    try:
        ffmpeg()
    except SystemExit as missing:
        pytest.skip(str(missing))
    own = film([(4.0 * min(max(n - 10, 0), 15), 0.0) for n in range(35)])
    held = stabilised(own, *STABILISERS["vid.stab, static"])
    assert len(held) == len(own)
    assert stability(held).drift < 0.1 * stability(own).drift
    assert stability(held[-5:]).black == pytest.approx(60 / SIZE[0], abs=0.005)
    assert stability(held[:5]).black == pytest.approx(0, abs=0.001)


def test_settings_that_vidstab_does_not_follow_are_told() -> None:
    try:
        ffmpeg()
    except SystemExit as missing:
        pytest.skip(str(missing))
    with pytest.raises(SystemExit, match="zoom budget"):
        stabilised(film([(0, 0)] * 5), "", "optzoom=0")
