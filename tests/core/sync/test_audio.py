"""Clocks found from sound against clocks that were put in; the sound is made here, without the simulator."""

from fractions import Fraction

import numpy as np
import pytest
from coded_video import write_coded
from hypothesis import given, settings
from hypothesis import strategies as st
from notes import Notes
from scipy import signal
from sync_sound import RATE, heard, room

from mcsl_core.edl import Camera, Media
from mcsl_core.errors import UsageError
from mcsl_core.sync.audio import band_loudness, coarse_lag
from mcsl_core.sync.clock_fit import Refusal, robust_line
from mcsl_core.sync.synchronise import synchronise


def record(tmp_path, name, sound, suffix=".mp4"):
    frames = max(2, len(sound) // RATE)
    path = write_coded(
        tmp_path / f"{name}{suffix}", range(frames), rate=Fraction(1), size=(64, 36), gop=30, bframes=0, sound=sound
    )
    return Camera(name, (Media(path.name, frames),), (64, 36), Fraction(1))


@pytest.mark.parametrize("suffix", [".mp4", pytest.param(".mkv", marks=pytest.mark.slow)])
def test_offset_and_drift_are_found(tmp_path, suffix):
    """Five milliseconds and three parts per million over two minutes and a half."""
    source = room(190)
    truth = {"ref": (0.0, 0.0), "b": (-3.217, -35.0), "c": (17.9, 60.0)}
    cameras = [
        record(tmp_path, n, heard(source, (o + 10, d), 150, i), suffix) for i, (n, (o, d)) in enumerate(truth.items())
    ]
    clocks = synchronise("audio", cameras, tmp_path)
    assert (clocks[0].offset_s, clocks[0].drift_ppm) == (0, 0)
    for clock, (offset, drift) in zip(clocks[1:], list(truth.values())[1:], strict=True):
        assert clock.method == "audio"
        assert clock.confidence > 0.7
        assert clock.offset_s == pytest.approx(offset, abs=0.005)
        assert clock.drift_ppm == pytest.approx(drift, abs=3)


def test_another_reference_turns_the_clocks_round(tmp_path):
    source = room(110)
    cameras = [
        record(tmp_path, "a", heard(source, (5, 0), 90, 1)),
        record(tmp_path, "b", heard(source, (7.5, 0), 90, 2)),
    ]
    first, second = synchronise("auto", cameras, tmp_path, reference="b")
    assert second.offset_s == 0
    assert first.offset_s == pytest.approx(-2.5, abs=0.005)


def test_strangers_silence_and_films_without_sound_are_refused_with_the_reason(tmp_path):
    cameras = [
        record(tmp_path, "ref", heard(room(100), (0, 0), 90, 1)),
        record(tmp_path, "stranger", heard(room(100, seed=9), (0, 0), 90, 2)),
        record(tmp_path, "quiet", np.zeros(90 * RATE, np.float32)),
        Camera("mute", (Media(write_coded(tmp_path / "m.mp4", range(5)).name, 5),), (256, 144), Fraction(30)),
    ]
    progress = Notes()
    clocks = synchronise("auto", cameras, tmp_path, progress)
    assert [c.method for c in clocks] == ["none", "none", "none", "none"]
    assert all(c.confidence == 0 and c.offset_s == 0 for c in clocks)
    assert [n.split(" ")[0] for n in progress.notes] == ["stranger", "quiet", "mute"]
    assert "nothing in their sound fits together" in progress.notes[0]
    assert "silent" in progress.notes[1]
    assert "mute has no sound" in progress.notes[2]


def test_a_beep_that_fits_every_second_is_refused(tmp_path):
    t = np.arange(60 * 16000) / 16000
    beeps = np.where(t % 1.0 < 0.1, 0.3 * np.sin(2 * np.pi * 800 * t), 0.0)
    cameras = [record(tmp_path, n, heard(beeps, (o, 0), 50, i)) for i, (n, o) in enumerate((("a", 0.0), ("b", 2.0)))]
    progress = Notes()
    clocks = synchronise("audio", cameras, tmp_path, progress)
    assert clocks[1].method == "none"
    assert "several ways" in progress.notes[0]


def loudness(sound, seed, noise=0.01):
    """The loudness track of a 16 kHz sound as a camera of its own noise hears it."""
    rng = np.random.default_rng(seed)
    return band_loudness([signal.resample_poly(sound, 1, 2) + rng.normal(0, noise, len(sound) // 2)])


@settings(max_examples=4)
@given(st.integers(0, 1000), st.integers(30, 90))
def test_the_sounds_of_two_rooms_never_fit(seed, seconds):
    with pytest.raises(Refusal, match="nothing in their sound"):
        coarse_lag(loudness(room(seconds, seed), 1), loudness(room(seconds, seed + 5000), 2))


@settings(max_examples=4)
@given(st.integers(0, 1000), st.floats(-15, 15))
def test_one_room_fits_where_it_is(seed, lag_s):
    sound = room(80, seed)
    start = round((20 + lag_s) * 16000)
    lag, lead = coarse_lag(loudness(sound[20 * 16000 : 60 * 16000], 1), loudness(sound[start : start + 40 * 16000], 2))
    assert lag == pytest.approx(lag_s, abs=0.02)
    assert lead > 1.25


@pytest.mark.parametrize("period_s", [0.4, 0.75, 1.0, 2.5, 6.0])
def test_what_repeats_is_refused_whatever_its_period(period_s):
    t = np.arange(60 * 16000) / 16000
    beeps = np.where(t % period_s < 0.1, 0.3 * np.sin(2 * np.pi * 800 * t), 0.0)
    with pytest.raises(Refusal):
        coarse_lag(loudness(beeps[: 50 * 16000], 1), loudness(beeps[5 * 16000 : 55 * 16000], 2))


@pytest.mark.parametrize(("seconds", "offset_s", "seed"), [(24, 0.29, 3), (24, -0.31, 4), (18, 1.7, 5), (12, -2.4, 6)])
def test_short_recordings_are_synchronised_although_they_share_less_than_three_long_windows(
    tmp_path, seconds, offset_s, seed
):
    source = room(seconds + 12, seed=seed)
    cameras = [
        record(tmp_path, "ref", heard(source, (5, 0), seconds, 1)),
        record(tmp_path, "late", heard(source, (5 + offset_s, 20), seconds, 2)),
        record(tmp_path, "stranger", heard(room(seconds + 12, seed=seed + 50), (5, 0), seconds, 3)),
    ]
    _, late, stranger = synchronise("audio", cameras, tmp_path)
    assert late.method == "audio"
    assert late.offset_s == pytest.approx(offset_s, abs=0.005)
    assert stranger.method == "none"


def test_too_little_in_common_is_refused(tmp_path):
    """Fifteen seconds that both heard: enough to find the place, too little to trust it."""
    source = room(110)
    cameras = [record(tmp_path, n, heard(source, (o, 0), 50, i)) for i, (n, o) in enumerate((("a", 2.0), ("b", 37.0)))]
    progress = Notes()
    clocks = synchronise("audio", cameras, tmp_path, progress)
    assert (clocks[1].method, clocks[1].offset_s) == ("none", 0)
    assert progress.notes[0].startswith("b is taken to start with a (audio: ")


def test_a_line_is_what_half_of_the_windows_agree_on():
    rng = np.random.default_rng(0)
    good = [(t, 0.004 + 30e-6 * t + rng.normal(0, 2e-4)) for t in range(0, 600, 60)]
    wild = [(t, rng.uniform(-0.1, 0.1)) for t in range(30, 600, 100)]
    level, slope, share = robust_line(good + wild, len(good + wild), 2e-3)
    assert level == pytest.approx(0.004, abs=5e-4)
    assert slope == pytest.approx(30e-6, abs=1e-6)
    assert share == pytest.approx(10 / 16)
    with pytest.raises(Refusal, match="agree on one clock"):
        robust_line(wild, len(wild), 2e-3)
    with pytest.raises(Refusal, match="only 2 of 9"):
        robust_line(good[:2], 9, 2e-3)


def test_none_and_unknown(tmp_path):
    camera = Camera("a", (Media("nothing.mp4", 1),), (64, 36), Fraction(1))
    assert [c.method for c in synchronise("none", [camera, camera], tmp_path)] == ["none", "none"]
    with pytest.raises(UsageError, match="guess"):
        synchronise("guess", [camera], tmp_path)
