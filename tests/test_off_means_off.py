"""Without following, relief and seeing through a programme is what it was before there were any, frame by frame."""

from __future__ import annotations

import types
from collections.abc import Sequence
from pathlib import Path

import attrs
import av
import numpy as np
import pytest
import recorded_programme as recorded
import relief_scene

from mcsl_core.alignment.tracking.following import BackgroundTracker
from mcsl_core.analysis.pipeline import analyse
from mcsl_core.analysis.settings import AnalysisSettings
from mcsl_core.delivery.conform import conform
from mcsl_core.delivery.source import ProgrammeSource
from mcsl_core.edl import Edl, Look, MovementView
from mcsl_core.errors import UsageError
from mcsl_core.hooks.registry import discover
from mcsl_core.hooks.specs import hookimpl
from mcsl_core.progress import Silent
from mcsl_core.simulation import Scenario, simulate

OFF = Look(surface=False, see_through=False)


def bare(edl: Edl) -> Edl:
    """Without anything that following and the relief add to a document."""
    movements = tuple(attrs.evolve(movement, views=()) for movement in edl.movements)
    poses = tuple(attrs.evolve(pose, relief=None) for pose in edl.poses)
    return attrs.evolve(edl, movements=movements, poses=poses, made_by=None)


def conformed(edl: Edl, base: Path, out: Path) -> tuple[list[str], np.ndarray]:
    """The chunks' names, which hold their keys, and the luma of all their pictures."""
    done = conform(ProgrammeSource(edl, base, audio_from="none"), out, jobs=1)
    assert done.made == len(done.chunks)
    pictures = []
    for chunk in done.chunks:
        with av.open(str(done.path(chunk))) as container:
            pictures += [frame.to_ndarray(format="gray") for frame in container.decode(video=0)]
    assert len(pictures) == edl.frames
    return [chunk.name for chunk in done.chunks], np.stack(pictures)


def same(one: tuple[list[str], np.ndarray], other: tuple[list[str], np.ndarray]) -> tuple[bool, bool]:
    """Whether two programmes have the same keys, and the same pictures."""
    return one[0] == other[0], bool((one[1] == other[1]).all())


def test_a_relief_that_is_off_leaves_keys_and_pictures_as_they_were(tmp_path: Path) -> None:
    """Three cameras, two poses, a movement between them; fill, colours and centering on."""
    recorded.write_media(tmp_path)
    relief = relief_scene.pose_of(recorded.FRAMES, recorded.SIZE).relief
    plain = recorded.edl_of(OFF)
    edl = attrs.evolve(plain, poses=tuple(attrs.evolve(pose, relief=relief) for pose in plain.poses))
    assert bare(edl) == plain
    expected = conformed(plain, tmp_path, tmp_path / "plain")
    assert same(conformed(edl, tmp_path, tmp_path / "off"), expected) == (True, True)
    on = attrs.evolve(edl, look=attrs.evolve(OFF, surface=True))
    assert same(conformed(on, tmp_path, tmp_path / "on"), expected) == (False, False)
    views = [MovementView(frame, edl.poses[index].homographies) for index, frame in enumerate((28, 31))]
    followed = attrs.evolve(edl, movements=(attrs.evolve(edl.movements[0], views=tuple(views)),))
    assert same(conformed(followed, tmp_path, tmp_path / "followed"), expected) == (False, False)


class Counted:
    """The built-in tracker, and how often it is asked."""

    name = "counted"

    def __init__(self) -> None:
        self.prepared = 0
        self.instants: list[int] = []

    def prepare(self) -> None:
        self.prepared += 1

    def follow(self, lamp, before, after, instants: Sequence):
        self.instants.append(len(instants))
        return BackgroundTracker().follow(lamp, before, after, instants)


def offering(tracker: Counted) -> types.ModuleType:
    """A plugin's module."""
    module = types.ModuleType("theirs")
    vars(module)["register_trackers"] = hookimpl(specname="register_trackers")(lambda: [tracker])
    return module


@attrs.frozen(eq=False)
class Analysed:
    """One recording, analysed by ``--movement-view follow`` and ``hold``, and what its tracker did each time."""

    folder: Path
    follow: Edl
    hold: Edl
    trackers: dict[str, Counted]


@pytest.fixture(scope="module")
def analysed(tmp_path_factory: pytest.TempPathFactory) -> Analysed:
    folder = tmp_path_factory.mktemp("moved")
    scenario = Scenario(seed=7, duration_s=16, size=(320, 180), rate=10, cameras=3, heads=0, movements=((8.0, 1.5),))
    simulate(scenario, folder / "recording", Silent())
    made, trackers = {}, {}
    for how in ("follow", "hold"):  # into one EDL: what both have in common comes from its cache
        trackers[how] = Counted()
        settings = AnalysisSettings(sync="none", movement_view=how, stages={"tracker": "counted"})
        plugins = discover([(offering(trackers[how]), "their-package", "1.2")])
        recording, out = folder / "recording", folder / "edl.json"
        made[how] = analyse([recording], out, settings=settings, plugins=plugins, progress=Silent())
    return Analysed(folder, made["follow"], made["hold"], trackers)


@pytest.mark.slow
def test_a_plugin_follows_the_lamp(analysed: Analysed) -> None:
    """About a minute: the recording is simulated and analysed."""
    tracker, edl = analysed.trackers["follow"], analysed.follow
    assert [len(movement.views) > 1 for movement in edl.movements] == [True]
    assert tracker.prepared == len(tracker.instants) == 1
    assert tracker.instants[0] > 15
    assert edl.made_by is not None
    assert edl.made_by.plugins["tracker"] == "counted (their-package 1.2)"


@pytest.mark.slow
def test_held_nobody_follows(analysed: Analysed) -> None:
    tracker, edl = analysed.trackers["hold"], analysed.hold
    assert [movement.range for movement in edl.movements] == [movement.range for movement in analysed.follow.movements]
    assert [movement.views for movement in edl.movements] == [()]
    assert (tracker.prepared, tracker.instants) == (0, [])
    assert edl.made_by is not None
    assert "tracker" not in edl.made_by.plugins
    settings = AnalysisSettings(movement_view="hold", stages={"tracker": "nosuch"})
    with pytest.raises(UsageError, match=r"there is no lamp tracker named 'nosuch'\. Choose one of background"):
        analyse([analysed.folder], analysed.folder / "x.json", settings=settings, plugins=discover(), progress=Silent())


@pytest.mark.slow
def test_what_is_held_by_planes_is_as_if_nothing_could_be_followed(analysed: Analysed, tmp_path: Path) -> None:
    edl = attrs.evolve(analysed.hold, look=OFF)
    assert any(pose.relief is not None for pose in edl.poses)
    assert bare(edl) != edl
    expected = conformed(bare(edl), analysed.folder, tmp_path / "bare")
    assert same(conformed(edl, analysed.folder, tmp_path / "off"), expected) == (True, True)
    moved = attrs.evolve(edl, movements=analysed.follow.movements)
    assert same(conformed(moved, analysed.folder, tmp_path / "moved"), expected) == (False, False)
