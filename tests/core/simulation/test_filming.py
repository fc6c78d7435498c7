"""Filming in processes of their own: the same files as in threads, and nothing left of one that was stopped."""

from __future__ import annotations

import os
import re
import time
from functools import partial

import attrs
import child_work
import pytest

from mcsl_core.children import in_child
from mcsl_core.errors import Cancelled, InputError
from mcsl_core.progress import CancelToken, Silent
from mcsl_core.simulation import Recorder, Scenario, filming, simulate
from mcsl_core.simulation.filming import Film
from mcsl_core.simulation.ground import Ground
from mcsl_core.simulation.scene import Scene

BUSY = Scenario(seed=8, duration_s=3.0, size=(160, 90), cameras=2, movements=((1.0, 0.5),), heads=3, hands=2, crf=30)


class Counts(Silent):
    def __init__(self) -> None:
        super().__init__()
        self.seen: list[int] = []

    def advance(self, done: int) -> None:
        self.seen.append(done)
        super().advance(done)


def test_processes_make_the_same_files_as_threads(tmp_path, monkeypatch):
    """Pictures, sound and truth, byte for byte."""
    progress = Counts()
    for name, least in (("threads", 1e12), ("processes", 0.0)):
        monkeypatch.setattr(filming, "WORTH_A_PROCESS", least)
        monkeypatch.setattr(filming.os, "cpu_count", lambda: 2)
        truth = simulate(BUSY, tmp_path / name, progress if name == "processes" else Silent(), Recorder(vfr=True))
    assert progress.seen[-1] == sum(truth.camera_frames)
    assert progress.seen == sorted(progress.seen)
    files = sorted(path.name for path in (tmp_path / "threads").iterdir() if path.name != "mcsl-outputs.json")
    assert files == ["cam1.mp4", "cam2.mp4", "truth.json", "truth.npz"]
    for file in files:
        assert (tmp_path / "threads" / file).read_bytes() == (tmp_path / "processes" / file).read_bytes(), file


@pytest.mark.skipif(
    not hasattr(os, "sched_setaffinity") or len(os.sched_getaffinity(0)) < 2, reason="needs cores to take away"
)
def test_the_machines_cores_do_not_show_in_the_files(tmp_path):
    """x264's own choice of threads, of the cores that there are, is seen in its bytes."""
    scenario = attrs.evolve(BUSY, size=(320, 180), duration_s=1.0, movements=0, cameras=1)
    simulate(scenario, tmp_path / "all", Silent(), ideal=True)
    in_child(partial(child_work.films_on_one_core, tmp_path / "one", scenario), child_work.ignore)
    for file in ("cam1.mp4", "ideal/ideal.mp4", "truth.npz"):
        assert (tmp_path / "all" / file).read_bytes() == (tmp_path / "one" / file).read_bytes(), file


@pytest.fixture(scope="module")
def film(tmp_path_factory: pytest.TempPathFactory) -> Film:
    """An hour that nobody waits for: on a busy machine a minute of so small pictures was filmed before the stop."""
    scenario = attrs.evolve(BUSY, duration_s=3600)
    scene = Scene.of(scenario)
    return Film(scene, Ground.of(scenario, scene.surface, scene.rig), Recorder(), tmp_path_factory.mktemp("film"))


def test_a_stop_ends_every_process(film):
    token = CancelToken()

    class StopsLater(Silent):
        def advance(self, done: int) -> None:
            if done > 3:
                token.cancel()
            token.check()

    with pytest.raises(Cancelled):
        film.run(StopsLater(), apart=True)
    # How far each camera had come is the machine's affair: what counts is that nobody writes any more.
    left = {path.name: path.stat().st_size for path in film.out.iterdir()}
    assert left  # in the folder that `simulate` takes away
    time.sleep(1)
    assert left == {path.name: path.stat().st_size for path in film.out.iterdir()}


def test_what_a_camera_cannot_write_is_told_as_here(film, tmp_path):
    nowhere = attrs.evolve(film, out=tmp_path / "a file")
    nowhere.out.write_text("in the way")
    told = []
    for apart in (True, False):
        with pytest.raises(InputError) as caught:
            nowhere.run(Silent(), apart=apart)
        told.append(re.sub(r"cam\d", "a camera", str(caught.value)))
    assert told[0] == told[1]
    assert "a file/a camera.mp4: cannot be written" in told[0]
    assert nowhere.out.read_text() == "in the way"
