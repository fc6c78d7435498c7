"""The figures of an operation, each counted by hand on a small EDL."""

from __future__ import annotations

from pathlib import Path

import attrs
import pytest
from builders import R, small_edl

from mcsl_core import edl as document
from mcsl_core.archive.figures import figures_of
from mcsl_core.archive.job import Facts, Job
from mcsl_core.archive.outcome import Outcome
from mcsl_core.edl import Clock, FieldStretch, Movement, Override, Pose, Weak

FACTS = Facts(cameras=3, files=3, seconds=10.0, rate=30.0, size=(320, 180), bytes=1000)
JOB = Job("mcsl.archive-job/1", "a/b", "/nowhere", "", FACTS, (), (), (), 1, "programme.mp4")
BOX = (((10.0, 10.0), (100.0, 10.0), (100.0, 90.0)),)


def written(folder: Path):
    edl = small_edl()
    one, two, three = edl.cameras
    first = Pose(R(0, 100), edl.poses[0].homographies, residual_px={"cam2": 1.5, "cam3": 2.5})
    second = Pose(R(100, 300), edl.poses[0].homographies, perspective=1, weak=(Weak("cam3", "no places match"),))
    edl = attrs.evolve(
        edl,
        cameras=(
            one,
            attrs.evolve(two, clock=Clock(0.1, method="audio", confidence=0.9), gaps=(R(0, 45),)),
            attrs.evolve(three, clock=Clock(confidence=0.2)),
        ),
        poses=(first, second),
        movements=(Movement(R(90, 120)), Movement(R(200, 215))),
        fields=(FieldStretch(R(0, 225), "pictures", BOX), FieldStretch(R(225, 300), "middle", BOX)),
        overrides=(
            Override(R(30, 60), camera="cam2"),  # has no picture for half of it
            Override(R(60, 90), camera="cam2"),
            Override(R(150, 180), camera="cam3"),  # weak there
            Override(R(200, 210), fill=False),
        ),
    )
    document.save(edl, folder / "edl.json")
    return edl


def test_every_figure_is_what_the_edl_says(tmp_path: Path) -> None:
    written(tmp_path)
    row = figures_of("a/b", tmp_path, JOB, Outcome("done", seconds=12.34))
    assert (row.operation, row.results, row.state, row.work_s) == ("a/b", tmp_path.name, "done", 12.3)
    assert (row.cameras, row.recorded_bytes, row.width, row.seconds) == (3, 1000, 320, 10.0)
    assert (row.shots, row.movements, row.poses, row.perspectives, row.overrides) == (3, 2, 2, 2, 4)
    assert (row.movement_s, row.longest_movement_s) == (1.5, 1.0)
    assert (row.weak_cameras, row.weak_share) == (1, pytest.approx(200 / 900))
    assert row.gap_share == pytest.approx(45 / 900)
    assert (row.clock_confidence, row.unsure_clocks) == (0.2, 1)
    assert row.field_unknown_share == pytest.approx(0.25)
    assert row.overrides_without_picture == 2
    assert row.overridden_s == pytest.approx(100 / 30)
    # cam1 to 30, cam2 to 90, cam1 to 100, cam2 to 150, cam3 to 180, cam2 to 200, cam3
    assert row.switches == 6
    assert row.residual_px == 2.5
    assert (row.visible, row.itf_db) == (None, None)


def test_they_are_kept_until_the_edl_changes(tmp_path: Path) -> None:
    edl = written(tmp_path)
    figures_of("a/b", tmp_path, JOB, Outcome("done"))
    kept = (tmp_path / "row.json").stat().st_mtime_ns
    assert figures_of("a/b", tmp_path, JOB, Outcome("done")).overrides == 4
    assert (tmp_path / "row.json").stat().st_mtime_ns == kept
    document.save(attrs.evolve(edl, overrides=edl.overrides[:1]), tmp_path / "edl.json")
    assert figures_of("a/b", tmp_path, JOB, Outcome("done")).overrides == 1
    (tmp_path / "row.json").write_text("{")
    assert figures_of("a/b", tmp_path, JOB, Outcome("done")).overrides == 1


def test_without_an_edl_nothing_is_claimed(tmp_path: Path) -> None:
    row = figures_of("x", tmp_path, JOB, Outcome("failed", "analyse", "why"))
    assert (row.shots, row.visible, row.step, row.why) == (None, None, "analyse", "why")
    (tmp_path / "edl.json").write_text("{}")
    assert figures_of("x", tmp_path, JOB, Outcome("failed")).shots is None
