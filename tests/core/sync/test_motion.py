"""Clocks found from motion: on tracks whose lag is known, on films, and on simulated recordings without sound."""

from fractions import Fraction

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from notes import Notes
from scipy import ndimage

from mcsl_core.edl import Camera, Media
from mcsl_core.errors import Cancelled
from mcsl_core.media.writing import VideoWriter
from mcsl_core.progress import Silent
from mcsl_core.simulation import Scenario, simulate
from mcsl_core.sync.motion import Peak, best_lag, solve_offsets
from mcsl_core.sync.motion_energy import MotionTrack
from mcsl_core.sync.synchronise import synchronise

RATE = 25.0


def bustle(seconds, seed, fine=16):
    """How much moves, ``fine`` times RATE a second: strokes of a fraction of a second to seconds, now and then none."""
    rng = np.random.default_rng(seed)
    total = np.zeros(int(seconds * RATE * fine))
    at = 0.0
    while at < seconds - 4:
        length = rng.uniform(0.2, 1.5)
        first, count = int(at * RATE * fine), int(length * RATE * fine)
        total[first : first + count] += rng.uniform(0.5, 3) * np.hanning(count)
        at += rng.exponential(0.6)
    return total


def track(moved, start_s, seconds, seed, own=0.5, fine=16):
    """What a camera that begins at ``start_s`` makes of it, with ``own`` as much that only it sees."""
    rng = np.random.default_rng(seed)
    first = round(start_s * RATE * fine)
    common = moved[first : first + int(seconds * RATE * fine)]
    seen = common.reshape(-1, fine).mean(axis=1)
    alone = bustle(seconds, seed + 1000, 1)[: len(seen)]
    level = np.log(0.05 + seen + own * alone + rng.uniform(0, 0.02, len(seen)))
    level = level - ndimage.uniform_filter1d(level, 201, mode="nearest")
    return MotionTrack(np.array([level, level]), 0.0, RATE)


@settings(max_examples=15)
@given(st.floats(-40, 40), st.integers(0, 999))
def test_a_lag_is_found_to_within_a_picture(lag_s, seed):
    lag_s = round(lag_s * RATE * 16) / (RATE * 16)
    moved = bustle(220, seed)
    peak = best_lag(track(moved, 45, 120, seed, own=0.2), track(moved, 45 + lag_s, 120, seed + 1, own=0.2))
    assert peak.clear
    assert peak.lag_s == pytest.approx(lag_s, abs=1 / RATE)


@given(st.integers(0, 10_000), st.sampled_from([40, 120]))
@settings(max_examples=40)
def test_strangers_do_not_fit(seed, seconds):
    a = track(bustle(seconds + 10, seed), 0, seconds, seed)
    b = track(bustle(seconds + 10, seed + 20_000), 0, seconds, seed + 1)
    assert not best_lag(a, b).clear


def test_what_repeats_is_not_clear():
    """A ventilator's stroke every four seconds."""
    stroke = np.tile(np.hanning(64 * 16), 220 * 25 // 100 + 1)
    stroke = np.pad(stroke.reshape(-1, 64 * 16), ((0, 0), (0, 36 * 16))).ravel()
    peak = best_lag(track(stroke, 0, 120, 1, own=0.1), track(stroke, 6, 120, 2, own=0.1))
    assert not peak.clear


def test_nothing_that_moves_and_too_little_of_it_are_not_clear():
    still = MotionTrack(np.zeros((2, 3000)), 0.0, RATE)
    moved = bustle(60, 3)
    assert not best_lag(still, track(moved, 0, 50, 1)).clear
    assert not best_lag(track(moved, 0, 20, 1), track(moved, 0, 20, 2)).clear
    assert not best_lag(MotionTrack(np.zeros((2, 0)), 0.0, RATE), still).clear


def test_a_camera_is_tied_in_through_the_others():
    """The reference and c never fit by themselves; by way of b they do, and one pair that lies is outvoted."""
    clear, dull = (9.0, 2.0), (3.0, 1.0)
    peaks = {
        ("a", "b"): Peak(1.0, *clear),
        ("a", "c"): Peak(40.0, *dull),
        ("a", "d"): Peak(0.5, *clear),
        ("b", "c"): Peak(2.0, *clear),
        ("b", "d"): Peak(33.0, 6.5, 1.6),
        ("c", "d"): Peak(-2.5, *clear),
        ("a", "e"): Peak(1.0, *dull),
    }
    offsets = solve_offsets(peaks, "a")
    assert offsets == pytest.approx({"a": 0.0, "b": 1.0, "c": 3.0, "d": 0.5})


def film(path, seconds, *, seed, start_s=0.0, rate=10, side=0):
    """A hand, a big square, that wanders as ``seed`` says from ``start_s`` on, seen from one of several sides."""
    rng = np.random.default_rng(seed)
    ticks = 2000
    way = np.cumsum(np.where(rng.random((ticks, 1)) < 0.4, rng.normal(0, 9, (ticks, 2)), 0), axis=0)
    noise = np.random.default_rng(side)
    with VideoWriter(path, size=(128, 72), rate=Fraction(rate)) as writer:
        for number in range(round(seconds * rate)):
            x, y = way[round(start_s * rate) + number]
            picture = np.clip(noise.normal(90, 3, (72, 128, 3)), 0, 255).astype(np.uint8)
            at = np.array([20 + (x + 11 * side) % 88, 10 + (y * (1 - 0.2 * side)) % 52]).astype(int)
            cv2.rectangle(picture, (int(at[0]), int(at[1])), (int(at[0]) + 24, int(at[1]) + 20), (60, 80, 200), -1)
            writer.write(picture)
    return Camera(path.stem, (Media(path.name, round(seconds * rate)),), (128, 72), Fraction(rate))


@pytest.mark.slow
def test_films_without_sound_are_tied_by_what_moves_and_a_stranger_is_refused(tmp_path):
    cameras = [
        film(tmp_path / "a.mp4", 100, seed=1),
        film(tmp_path / "b.mp4", 90, seed=1, start_s=7.0, side=1),
        film(tmp_path / "stranger.mp4", 100, seed=2, side=2),
        film(tmp_path / "short.mp4", 15, seed=1, side=2),
    ]
    progress = Notes()
    clocks = synchronise("auto", cameras, tmp_path, progress)
    assert [c.method for c in clocks] == ["motion", "motion", "none", "none"]
    assert clocks[1].offset_s == pytest.approx(7.0, abs=0.05)
    assert 0.3 < clocks[1].confidence <= 0.8
    assert [note.split(" ")[0] for note in progress.notes] == ["stranger", "short"]
    assert "fits no other camera" in progress.notes[0]
    assert "too short" in progress.notes[1]


def test_few_pictures_a_second_are_refused(tmp_path):
    cameras = [film(tmp_path / f"{n}.mp4", 5, seed=1, rate=2) for n in "ab"]
    progress = Notes()
    assert synchronise("motion", cameras, tmp_path, progress)[1].method == "none"
    assert "too few" in progress.notes[0]


def test_it_can_be_stopped(tmp_path):
    class Stop(Silent):
        def advance(self, done):
            raise Cancelled

    cameras = [film(tmp_path / f"{n}.mp4", 5, seed=1) for n in "abc"]
    with pytest.raises(Cancelled):
        synchronise("motion", cameras, tmp_path, Stop())


@pytest.mark.slow
def test_a_simulated_recording_without_sound(tmp_path):
    """Within half a picture of 100 ms over the whole of it."""
    scenario = Scenario(
        seed=338, duration_s=130, size=(192, 108), rate=10, movements=1, audio=False, clock_offset_s=6, drift_ppm=40
    )
    truth = simulate(scenario, tmp_path, Silent())
    cameras = [
        Camera(name, (Media(file, frames),), truth.size, truth.rate)
        for name, file, frames in zip(truth.cameras, truth.files, truth.camera_frames, strict=True)
    ]
    clocks = synchronise("auto", cameras, tmp_path)
    for clock, true in zip(clocks[1:], truth.clocks[1:], strict=True):
        assert clock.method == "motion"
        for at in (0.0, 65.0, 130.0):
            assert clock.programme_time(true.own(at)) == pytest.approx(at, abs=0.05)
