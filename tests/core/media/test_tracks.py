"""Sound tracks that no decoder knows and channels in orders of their own: no process is killed, and sound is heard.

Each file is opened in a process of its own: what goes wrong here does so in native code.
"""

from __future__ import annotations

import subprocess
import sys
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
from coded_video import DATA
from sound_files import RATE, Track, voice, with_channel_labels, without_decoder, write_film

from mcsl_core.media.audio import read_audio
from mcsl_core.media.probing import probe

FILMS = (".mp4", ".mov", ".mkv", ".ts", ".avi", ".webm")
READ = """
import sys
from fractions import Fraction
from pathlib import Path
from mcsl_core.errors import MediaError
from mcsl_core.media.audio import read_audio
from mcsl_core.media.probing import probe
for name in sys.argv[1:]:
    try:
        facts = probe(Path(name))
    except MediaError:  # told, not a crash
        continue
    for track in facts.audio_tracks:
        if track.can_be_decoded:
            blocks = [samples for _, samples in read_audio(facts, track, Fraction(0), 48000)]
            print(track.channels, sum(b.shape[1] for b in blocks), max(float(abs(b).max()) for b in blocks))
        else:
            print("none")
"""


def read_in_a_process(*paths: Path) -> list[str]:
    done = subprocess.run([sys.executable, "-c", READ, *map(str, paths)], capture_output=True, text=True, check=False)
    assert done.returncode == 0, (paths, done.returncode, done.stderr)
    return done.stdout.splitlines()


@pytest.mark.parametrize(
    ("layout", "labels", "codec"),
    [
        ("stereo", (2, 1), "pcm_s16le"),
        ("stereo", (1, 2), "pcm_s16le"),
        ("stereo", (2, 1), "pcm_s24le"),
        ("stereo", (2, 1), "pcm_f32le"),
        ("stereo", (2, 1), "alac"),
        ("stereo", (2, 1), "aac"),
        ("5.1", (3, 1, 2, 5, 6, 4), "pcm_s16le"),
        ("7.1", (2, 1, 3, 4, 5, 6, 33, 34), "pcm_s16le"),
        ("stereo", (400, 401), "pcm_s16le"),  # "discrete 0" and so on
    ],
)
def test_any_order_of_channels_is_read(tmp_path, layout, labels, codec):
    sound = np.vstack([voice(2, seed) for seed in range(len(labels))])
    path = write_film(tmp_path / "a.mov", [Track(sound, layout, codec)], 2)
    channels, samples, level = read_in_a_process(with_channel_labels(path, labels))[0].split()
    assert int(channels) == len(labels)
    assert int(samples) == pytest.approx(2 * RATE, abs=2048)
    assert 0.15 < float(level) < 0.5


@pytest.mark.parametrize(
    ("suffix", "channels", "layout", "codec"),
    [
        (".mkv", 3, "3 channels", "pcm_s16le"),
        (".mkv", 8, "7.1", "pcm_s16le"),
        (".mov", 8, "7.1", "pcm_s24le"),
        (".mkv", 16, "hexadecagonal", "pcm_s16le"),
        (".mkv", 32, "32 channels", "pcm_s16le"),
        (".mov", 24, "22.2", "pcm_s24le"),
        (".mp4", 6, "5.1", "aac"),
        (".mkv", 8, "7.1", "flac"),
    ],
)
def test_any_number_of_channels_is_read(tmp_path, suffix, channels, layout, codec):
    """Of eight planes and more PyAV reads beyond the end."""
    sound = np.vstack([voice(1, seed) for seed in range(channels)])
    path = write_film(tmp_path / f"a{suffix}", [Track(sound, layout, codec)], 1)
    assert read_in_a_process(path)[0].split()[0] == str(channels)
    facts = probe(path)
    blocks = [samples for _, samples in read_audio(facts, facts.audio_tracks[0], Fraction(0), RATE)]
    heard = np.concatenate(blocks, axis=1)[:, :RATE]
    if codec != "aac":
        assert np.abs(heard - sound[:, : heard.shape[1]]).max() < 1e-3


def test_a_track_without_a_decoder_is_told_from_its_neighbour(tmp_path):
    path = write_film(tmp_path / "a.mp4", [Track(voice(2), codec="aac"), Track(voice(2), codec="aac")], 2)
    first, second = read_in_a_process(without_decoder(path))
    assert first == "none"
    assert second.split()[0] == "1"
    facts = probe(path)
    assert [track.can_be_decoded for track in facts.audio_tracks] == [False, True]
    assert facts.has_audio


@pytest.mark.skipif(not DATA.is_dir(), reason="the folder ../shared/data is not here")
def test_every_real_file_is_probed_and_heard_in_one_process():
    """What corrupts the memory at one file kills the process at another."""
    films = sorted(path for path in DATA.rglob("*") if path.suffix in FILMS)
    assert len(read_in_a_process(*films)) >= 20
