"""Clocks found from cameras whose sound is not in the first place to look: other tracks, odd channels, odd samples."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest
from notes import Notes
from scipy import signal
from sound_files import RATE, Track, silence, with_channel_labels, without_decoder, write_film
from sync_sound import heard, room

from mcsl_core.edl import Camera, Media
from mcsl_core.media.probing import probe
from mcsl_core.sync.synchronise import synchronise

SECONDS = 60
OFFSETS_S = {"ref": 0.0, "late": 2.5}


@pytest.fixture(scope="module")
def sounds():
    source = room(SECONDS + 20)
    return {
        name: heard(source, (10 + offset, 0), SECONDS, seed) for seed, (name, offset) in enumerate(OFFSETS_S.items())
    }


def camera(path):
    return Camera(path.stem, (Media(path.name, SECONDS * 10),), (64, 48), Fraction(10))


def plain(tmp_path, sounds):
    return camera(write_film(tmp_path / "ref.mkv", [Track(sounds["ref"][None])], SECONDS))


def resampled(sound, rate):
    return signal.resample_poly(sound, rate, RATE).astype(np.float32)[None]


def in_another_track(tmp_path, sound):
    return write_film(tmp_path / "late.mkv", [Track(silence(SECONDS)), Track(sound[None])], SECONDS)


def without_a_decoder_before_it(tmp_path, sound):
    tracks = [Track(sound[None], codec="aac"), Track(sound[None], codec="aac")]
    return without_decoder(write_film(tmp_path / "late.mp4", tracks, SECONDS))


def in_channels_that_cancel(tmp_path, sound):
    return write_film(tmp_path / "late.mkv", [Track(np.vstack([sound, -0.9 * sound]), "stereo")], SECONDS)


def in_channels_right_before_left(tmp_path, sound):
    path = write_film(tmp_path / "late.mov", [Track(np.vstack([sound, sound]), "stereo")], SECONDS)
    return with_channel_labels(path, (2, 1))


def in_the_low_channel_of_six(tmp_path, sound):
    six = silence(SECONDS, 6)
    six[3] = sound
    return write_film(tmp_path / "late.mkv", [Track(six, "5.1")], SECONDS)


def in_eight_bits(tmp_path, sound):
    return write_film(tmp_path / "late.mkv", [Track(sound[None], codec="pcm_u8")], SECONDS)


def at_8_kilohertz(tmp_path, sound):
    return write_film(tmp_path / "late.mkv", [Track(resampled(sound, 8000), rate=8000)], SECONDS)


def at_192_kilohertz_in_24_bits(tmp_path, sound):
    return write_film(tmp_path / "late.mov", [Track(resampled(sound, 192000), rate=192000, codec="pcm_s24le")], SECONDS)


def as_floats_beyond_full_scale(tmp_path, sound):
    return write_film(tmp_path / "late.mov", [Track(30 * sound[None], codec="pcm_f32le")], SECONDS)


def clipped_and_off_zero(tmp_path, sound):
    return write_film(tmp_path / "late.mkv", [Track(np.clip(20 * sound[None], -0.2, 0.2) + 0.6)], SECONDS)


def with_a_hole(tmp_path, sound):
    gap = (20 * RATE, 32 * RATE)
    return write_film(tmp_path / "late.mkv", [Track(sound[None], gap=gap)], SECONDS)


def that_starts_late(tmp_path, sound):
    start = 7.3
    track = Track(sound[None, round(start * RATE) :], start_s=Fraction(73, 10))
    return write_film(tmp_path / "late.mkv", [track], SECONDS)


@pytest.mark.parametrize(
    "film",
    [
        in_another_track,
        without_a_decoder_before_it,
        in_channels_that_cancel,
        in_channels_right_before_left,
        in_the_low_channel_of_six,
        in_eight_bits,
        at_8_kilohertz,
        at_192_kilohertz_in_24_bits,
        as_floats_beyond_full_scale,
        clipped_and_off_zero,
        with_a_hole,
        that_starts_late,
    ],
    ids=lambda film: film.__name__,
)
def test_the_clock_is_found(tmp_path, sounds, film):
    cameras = [plain(tmp_path, sounds), camera(film(tmp_path, sounds["late"]))]
    clock = synchronise("audio", cameras, tmp_path)[1]
    assert clock.method == "audio"
    assert clock.offset_s == pytest.approx(OFFSETS_S["late"], abs=0.005)


def test_what_was_chosen_and_what_has_no_sound_is_told_by_name(tmp_path, sounds):
    progress = Notes()
    other = write_film(
        tmp_path / "other.mkv", [Track(silence(SECONDS)), Track(heard(room(80, 9), (5, 0), 60, 1)[None])], 60
    )
    cameras = [
        plain(tmp_path, sounds),
        camera(in_another_track(tmp_path, sounds["late"])),
        camera(other),
        camera(write_film(tmp_path / "dumb.mkv", [], SECONDS)),
        camera(without_decoder(write_film(tmp_path / "deaf.mp4", [Track(sounds["ref"][None], codec="aac")], SECONDS))),
    ]
    clocks = synchronise("audio", cameras, tmp_path, progress)
    assert [clock.method for clock in clocks] == ["audio", "audio", "none", "none", "none"]
    told = {note.partition(":")[0].partition(" ")[0]: [] for note in progress.notes}
    for note in progress.notes:
        told[note.partition(":")[0].partition(" ")[0]].append(note)
    assert "late: sound track 2 (pcm_s16le) is heard: sound track 1 (pcm_s16le) is silent" in told["late"]
    assert "nothing in their sound fits" in told["other"][-1]
    assert "dumb has no sound" in told["dumb"][0]
    assert "deaf: it has no sound: sound track 1 (without a decoder) cannot be decoded" in told["deaf"]


@pytest.mark.parametrize("hertz", [50, 60, 1000])
def test_hum_is_refused(tmp_path, hertz):
    hum = 0.3 * np.sin(2 * np.pi * hertz * np.arange(SECONDS * RATE) / RATE)
    rng = np.random.default_rng(0)
    films = [
        write_film(
            tmp_path / f"{name}.mkv", [Track((hum + rng.normal(0, 0.003, hum.shape)).astype(np.float32)[None])], 60
        )
        for name in "ab"
    ]
    assert [c.method for c in synchronise("audio", [camera(f) for f in films], tmp_path)] == ["none", "none"]


@pytest.fixture(scope="module")
def half_a_second_apart():
    source = room(45)
    return {name: heard(source, (5 + offset, 0), 31, 3)[None] for name, offset in (("a", 0.0), ("b", 0.5))}


@pytest.mark.parametrize("beyond_ms", ["0", "0.1", "1", "5", "9.9", "10", "15"])
def test_a_last_block_of_any_length(tmp_path, half_a_second_apart, beyond_ms):
    """Sound is read in blocks of ten seconds; what is left at the end may be shorter than one step of loudness."""
    seconds = Fraction(30) + Fraction(beyond_ms) / 1000
    rate = 300 / seconds
    cameras = []
    for name, sound in half_a_second_apart.items():
        path = write_film(tmp_path / f"{name}.mp4", [Track(sound, codec="aac")], float(seconds), rate=rate)
        cameras.append(Camera(name, (Media(path.name, 300),), (64, 48), rate))
    assert probe(tmp_path / "a.mp4").end_s == pytest.approx(float(seconds), abs=1e-4)
    assert synchronise("audio", cameras, tmp_path)[1].offset_s == pytest.approx(0.5, abs=0.005)
