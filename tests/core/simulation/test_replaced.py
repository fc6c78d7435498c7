"""Simulating over an earlier simulation: the folder holds one recording, whole, whatever happens meanwhile."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from mcsl_core.errors import InputError
from mcsl_core.outputs import locks
from mcsl_core.progress import Silent
from mcsl_core.simulation import Recorder, Scenario, load_truth, simulate

SCENE = Scenario(duration_s=1, movements=0, size=(96, 64), cameras=2, hands=0, heads=0)


def names(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.iterdir() if path.name != "mcsl-outputs.json")


def test_no_file_of_an_earlier_form_or_of_more_cameras_stays(tmp_path: Path) -> None:
    whole = ["cam1.mp4", "cam2.mp4", "truth.json", "truth.npz"]
    simulate(Scenario(duration_s=1, movements=0, size=(96, 64), cameras=3), tmp_path, Silent())
    simulate(SCENE, tmp_path, Silent())
    assert names(tmp_path) == whole
    simulate(SCENE, tmp_path, Silent(), Recorder(split_s=0.5))
    assert "cam1.mp4" not in names(tmp_path)
    assert load_truth(tmp_path).files[0] in names(tmp_path)
    simulate(SCENE, tmp_path, Silent(), Recorder(split_s=0.5, continuing_clock=True))
    assert not list(tmp_path.glob("*.mp4"))
    simulate(SCENE, tmp_path, Silent())
    assert names(tmp_path) == whole


def test_files_of_others_stay(tmp_path: Path) -> None:
    simulate(Scenario(duration_s=1, movements=0, size=(96, 64), cameras=3), tmp_path, Silent())
    (tmp_path / "notes.txt").write_text("mine")
    with (tmp_path / "cam3.mp4").open("ab") as file:
        file.write(b"\0\0\0\x08free")
    simulate(SCENE, tmp_path, Silent(), force=True)
    assert names(tmp_path) == ["cam1.mp4", "cam2.mp4", "cam3.mp4", "notes.txt", "truth.json", "truth.npz"]


def test_a_second_one_at_the_same_time_is_refused(tmp_path: Path) -> None:
    with locks.alone(tmp_path / "truth.json", "simulation"), pytest.raises(InputError, match="is at work on it"):
        simulate(SCENE, tmp_path, Silent())


@pytest.mark.skipif(os.name == "nt", reason="POSIX kills")
@pytest.mark.parametrize("after_s", [0.3, 0.8])
def test_a_killed_one_leaves_the_earlier_and_asks_nothing_of_the_next(tmp_path: Path, after_s: float) -> None:
    simulate(SCENE, tmp_path, Silent())
    before = {name: (tmp_path / name).read_bytes() for name in names(tmp_path)}
    words = ["simulate", str(tmp_path), "--cameras", "2", "--movements", "0", "--size", "96x64", "--duration", "60"]
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
    child = subprocess.Popen([sys.executable, "-m", "mcsl_core.cli", *words], env=environment, stderr=subprocess.PIPE)
    assert child.stderr is not None
    while b"film" not in child.stderr.readline():
        pass
    time.sleep(after_s)
    child.send_signal(signal.SIGKILL)
    child.wait()
    child.stderr.close()
    assert {name: (tmp_path / name).read_bytes() for name in before} == before
    simulate(SCENE, tmp_path, Silent())
    assert names(tmp_path) == sorted(before)
