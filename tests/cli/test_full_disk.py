"""A disk that is full while sound, samples, chunks or a video are written: one line, nothing half-written.

A limit to the size of files stands for the disk, whose end it is to whoever writes.
"""

from __future__ import annotations

import subprocess
import sys
import wave
from pathlib import Path

import av
import pytest

from mcsl_core.delivery.audio import AUDIO_RATE, wav_header
from mcsl_core.progress import Silent
from mcsl_core.simulation import Scenario, simulate

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="file sizes are limited by POSIX alone")
LIMITED = """
import resource, sys
limit = int(sys.argv.pop(1))
resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit))
from mcsl_core.cli.main import main
sys.exit(main())
"""


def mcsl(limit: int, *arguments: object) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-c", LIMITED, str(limit), *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, timeout=300, check=False)


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("full") / "recording"
    simulate(Scenario(seed=5, duration_s=6, movements=0, size=(320, 180), cameras=3), folder, Silent())
    return folder


@pytest.fixture(scope="module")
def edl(recording: Path) -> Path:
    assert mcsl(1 << 40, "analyse", recording, "-o", recording / "edl.json").returncode == 0
    return recording / "edl.json"


def told_in_one_line(done: subprocess.CompletedProcess[str], what: str) -> bool:
    last = done.stderr.strip().splitlines()[-1]
    return done.returncode in (3, 4) and "Traceback" not in done.stderr and what in done.stderr and "oom" in last


@pytest.mark.slow
@pytest.mark.parametrize("limit", [1000, 30_000])
def test_samples(recording: Path, tmp_path: Path, limit: int) -> None:
    done = mcsl(limit, "analyse", recording, "-o", tmp_path / "edl.json")
    assert told_in_one_line(done, "File too large"), done.stderr
    kept = [path.name for path in tmp_path.rglob("*") if path.is_file() and path.stat().st_size >= limit]
    assert kept == []
    assert not (tmp_path / "edl.json").exists()


@pytest.mark.parametrize("limit", [20, 100_000])
def test_the_programme_s_sound(edl: Path, tmp_path: Path, limit: int) -> None:
    done = mcsl(limit, "conform", edl, "-o", tmp_path / "out")
    assert told_in_one_line(done, "File too large"), done.stderr
    assert not list((tmp_path / "out").glob("*.wav")) + list((tmp_path / "out").glob(".*.part"))


@pytest.mark.parametrize("limit", [10, 20_000])
def test_the_video(edl: Path, tmp_path: Path, limit: int) -> None:
    done = mcsl(limit, "render", edl, "-o", tmp_path / "out.mp4", "--engine", "direct")
    assert told_in_one_line(done, f"{tmp_path / 'out.mp4'}: cannot be written (File too large)"), done.stderr
    assert ".mcsl-" not in done.stderr
    assert list(tmp_path.iterdir()) == []


def test_a_simulation(tmp_path: Path) -> None:
    words = ("--cameras", 1, "--duration", 1, "--movements", 0, "--size", "96x64")
    done = mcsl(10, "simulate", tmp_path / "made", *words)
    assert told_in_one_line(done, f"{tmp_path / 'made' / 'cam1.mp4'}: cannot be written (File too large)"), done.stderr
    assert list((tmp_path / "made").iterdir()) == []


@pytest.mark.parametrize(("hours", "kind"), [(3, b"RIFF"), (12, b"RIFF"), (13, b"RF64"), (30, b"RF64")])
def test_sound_of_any_length(tmp_path: Path, hours: int, kind: bytes) -> None:
    """Beyond 4 GiB a header of 32 bits would say another length; the file here is a hole."""
    samples = hours * 3600 * AUDIO_RATE
    path = tmp_path / "sound.wav"
    header = wav_header(samples)
    assert header[:4] == kind
    with path.open("wb") as stream:
        stream.write(header)
        stream.truncate(len(header) + 2 * samples)
    with av.open(str(path)) as container:
        sound = container.streams.audio[0]
        assert sound.duration * sound.time_base == hours * 3600
        container.seek(int((hours * 3600 - 2) * av.time_base))
        assert next(container.decode(sound)).time > hours * 3600 - 3
    if kind == b"RIFF":
        with wave.open(str(path)) as read:
            assert read.getnframes() == samples
