"""Which track of a camera is heard, and how its channels become one; the films are written without mcsl."""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
from sound_files import RATE, Track, silence, voice, without_decoder, write_film

from mcsl_core.edl import Camera, Media
from mcsl_core.media.probing import probe
from mcsl_core.recording.footage import Footage
from mcsl_core.recording.sound_track import sound_track

SECONDS = 6


def footage(*paths: Path) -> Footage:
    camera = Camera("cam1", tuple(Media(path.name, SECONDS * 10) for path in paths), (64, 48), Fraction(10))
    return Footage([camera], rate=Fraction(10), frames=60 * len(paths), base=paths[0].parent)


def heard(*paths: Path) -> np.ndarray:
    return footage(*paths).audio("cam1", 0, SECONDS * len(paths), RATE)


def quiet_noise(seconds: float, level: float) -> np.ndarray:
    return np.random.default_rng(5).normal(0, level, (1, int(seconds * RATE))).astype(np.float32)


@pytest.mark.parametrize("suffix", [".mkv", ".mov"])
@pytest.mark.parametrize("position", [1, 2])
def test_a_track_that_nothing_is_plugged_into_is_passed_over_by_name(tmp_path, suffix, position):
    tracks = [Track(silence(SECONDS)) for _ in range(3)]
    tracks[position] = Track(voice(SECONDS), language="eng")
    path = write_film(tmp_path / f"a{suffix}", tracks, SECONDS)
    chosen = footage(path).sound_track("cam1")
    assert chosen.position == position
    assert f"sound track {position + 1} (pcm_s16le, eng) is heard" in chosen.notes[0]
    assert "sound track 1 (pcm_s16le" in chosen.notes[0]
    assert "is silent" in chosen.notes[0]
    assert np.abs(heard(path) - voice(SECONDS)[0]).max() < 1e-3


@pytest.mark.parametrize(("level", "position"), [(1e-3, 1), (0.1, 0)])
def test_hiss_is_no_sound_beside_a_voice_but_a_scratch_track_is(tmp_path, level, position):
    """A first track of the same voice, 6 dB fainter, stays; the hiss of an open input does not."""
    first = voice(SECONDS, level=level) if position == 0 else quiet_noise(SECONDS, level)
    path = write_film(tmp_path / "a.mkv", [Track(first, language="jpn"), Track(voice(SECONDS))], SECONDS)
    chosen = footage(path).sound_track("cam1")
    assert chosen.position == position
    assert bool(chosen.notes) == (position == 1)


def test_hum_is_no_sound_beside_a_voice(tmp_path):
    hum = (0.5 * np.sin(2 * np.pi * 50 * np.arange(SECONDS * RATE) / RATE)).astype(np.float32)[None] + 0.2
    path = write_film(tmp_path / "a.mkv", [Track(hum), Track(voice(SECONDS, level=0.05))], SECONDS)
    assert footage(path).sound_track("cam1").position == 1


def test_a_track_without_a_decoder_is_left_out_by_name(tmp_path):
    tracks = [Track(voice(SECONDS), codec="aac"), Track(voice(SECONDS, level=0.3), codec="aac")]
    path = without_decoder(write_film(tmp_path / "a.mp4", tracks, SECONDS))
    chosen = footage(path).sound_track("cam1")
    assert chosen.notes == ("sound track 2 (aac) is heard: sound track 1 (without a decoder) cannot be decoded",)
    assert 0.2 < np.abs(heard(path)).max() < 1


def test_a_film_with_nothing_but_a_track_without_a_decoder_has_no_sound_and_says_why(tmp_path):
    path = without_decoder(write_film(tmp_path / "a.mp4", [Track(voice(2), codec="aac")], 2))
    assert not footage(path).has_sound("cam1")
    assert footage(path).sound_track("cam1").notes == (
        "it has no sound: sound track 1 (without a decoder) cannot be decoded",
    )
    assert not heard(path).any()


@pytest.mark.parametrize("live", [0, 1])
def test_one_dead_channel_of_two_does_not_halve_the_other(tmp_path, live):
    sound = np.vstack([voice(SECONDS) if n == live else silence(SECONDS) for n in range(2)])
    path = write_film(tmp_path / "a.mkv", [Track(sound, "stereo")], SECONDS)
    assert footage(path).sound_track("cam1").notes == (f"of its 2 channels only {live + 1} has sound",)
    assert np.abs(heard(path) - voice(SECONDS)[0]).max() < 1e-3


@pytest.mark.parametrize("live", [0, 3, 5])
def test_of_six_channels_the_one_with_sound_is_heard(tmp_path, live):
    """The low channel too, which a downmix leaves out."""
    sound = silence(SECONDS, 6)
    sound[live] = voice(SECONDS)[0]
    path = write_film(tmp_path / "a.mkv", [Track(sound, "5.1")], SECONDS)
    assert np.abs(heard(path) - voice(SECONDS)[0]).max() < 1e-3


@pytest.mark.parametrize("gain", [0.98, 0.6])
def test_channels_that_cancel_each_other_out_are_not_summed(tmp_path, gain):
    sound = np.vstack([gain * voice(SECONDS), -voice(SECONDS) + quiet_noise(SECONDS, 1e-4)])
    path = write_film(tmp_path / "a.mkv", [Track(sound, "stereo")], SECONDS)
    assert footage(path).sound_track("cam1").notes == (
        "its channels cancel each other out, so channel 2 alone is heard",
    )
    assert np.abs(heard(path) + voice(SECONDS)[0]).max() < 2e-3


def test_two_microphones_are_both_heard(tmp_path):
    sound = np.vstack([voice(SECONDS, 1), voice(SECONDS, 2)])
    path = write_film(tmp_path / "a.mkv", [Track(sound, "stereo")], SECONDS)
    assert footage(path).sound_track("cam1").notes == ()
    assert np.abs(heard(path) - sound.mean(axis=0)).max() < 1e-3


def test_all_files_of_a_camera_are_heard_alike(tmp_path):
    """The first file's second track is silent as well; the third has one track only, and that is taken."""
    files = [
        write_film(tmp_path / "a0.mkv", [Track(silence(SECONDS)), Track(silence(SECONDS))], SECONDS),
        write_film(tmp_path / "a1.mkv", [Track(silence(SECONDS)), Track(voice(SECONDS))], SECONDS),
        write_film(tmp_path / "a2.mkv", [Track(voice(SECONDS, 7))], SECONDS),
    ]
    sound = heard(*files).reshape(3, -1)
    assert not sound[0].any()
    assert np.abs(sound[1] - voice(SECONDS)[0]).max() < 1e-3
    assert np.abs(sound[2] - voice(SECONDS, 7)[0]).max() < 1e-3


def test_a_word_said_once_is_found_and_silence_everywhere_is_the_first_track(tmp_path):
    seconds = 120
    word = silence(seconds)
    word[:, 60 * RATE : 60 * RATE + 9600] = voice(0.2)
    path = write_film(tmp_path / "a.mkv", [Track(silence(seconds)), Track(word)], seconds)
    assert sound_track([probe(path)]).position == 1
    path = write_film(tmp_path / "b.mkv", [Track(silence(2)), Track(silence(2))], 2)
    chosen = sound_track([probe(path)])
    assert (chosen.position, chosen.notes) == (0, ())


def test_one_track_with_one_channel_is_taken_without_listening(tmp_path, monkeypatch):
    path = write_film(tmp_path / "a.mkv", [Track(silence(2))], 2)
    monkeypatch.setattr("mcsl_core.recording.sound_track.read_audio", None)
    assert sound_track([probe(path)]).position == 0
