"""A damaged camera through the real command line: the EDL, the summary, the selection and the report know its gap."""

from __future__ import annotations

import random
import subprocess
import sys
from pathlib import Path

import attrs
import av
import numpy as np
import pytest

from mcsl_core import edl as document
from mcsl_core.analysis.measurements import load_measurements
from mcsl_core.edl import Edl, Override
from mcsl_core.edl.resolve import resolve_by_pose
from mcsl_core.progress import Silent
from mcsl_core.report.facts import gather
from mcsl_core.simulation import Scenario, simulate

pytestmark = pytest.mark.slow

BEST = "cam2"  # damaged where it would be chosen
HIT = "cam3"  # inside one keyframe, of which no packet tells


def run(*arguments: object) -> str:
    command = [sys.executable, "-m", "mcsl_core.cli", *(str(a) for a in arguments)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=500, check=False)
    assert done.returncode == 0, done.stderr
    return done.stdout + done.stderr


def _second_keyframe(path: Path) -> int:
    with av.open(str(path)) as container:
        return [packet.pos for packet in container.demux(video=0) if packet.is_keyframe and packet.size > 1000][1]


@pytest.fixture(scope="module")
def analysed(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Edl, str]:
    folder = tmp_path_factory.mktemp("damaged")
    scenario = Scenario(seed=7, duration_s=24, movements=0, cameras=3, size=(320, 180), clock_offset_s=0.0)
    simulate(scenario, folder / "recording", Silent())
    for name in scenario.camera_names:
        path = folder / "recording" / f"{name}.mp4"
        data = bytearray(path.read_bytes())
        if name == BEST:
            data[len(data) // 2 : len(data) // 2 + len(data) // 8] = bytes(len(data) // 8)
        if name == HIT:
            at = _second_keyframe(path)
            data[at + 400 : at + 700] = random.Random(1).randbytes(300)
        path.write_bytes(data)
    told = run("analyse", folder / "recording", "-o", folder / "edl.json")
    return folder, document.load(folder / "edl.json"), told


def test_the_edl_and_the_notes_say_where_there_is_no_picture(analysed):
    folder, edl, told = analysed
    (gap,) = edl.camera(BEST).gaps
    assert 20 < len(gap) < 300
    assert f"{BEST} has no picture in {BEST}.mp4" in told
    assert f"no picture: {BEST} from" in told
    (hit,) = edl.camera(HIT).gaps
    assert 2 < len(hit) < 300
    assert f"{HIT} has no picture in {HIT}.mp4" in told
    assert all(not camera.gaps for camera in edl.cameras if camera.name not in (BEST, HIT))
    again = run("--progress", "json", "analyse", folder / "recording", "-o", folder / "edl.json")
    assert BEST in again, "from the cache it is told again"
    assert document.load(folder / "edl.json") == edl


def test_the_camera_is_not_chosen_in_its_gap(analysed):
    folder, edl, _ = analysed
    (gap,) = edl.camera(BEST).gaps
    assert all(shot.camera != BEST for shot in edl.shots if shot.range.intersection(gap))
    table = load_measurements(folder / edl.scores).scores
    inside = [i for i, frame in enumerate(table.frames) if frame in gap]
    column = table.cameras.index(BEST)
    assert inside
    assert not table.usable[inside, column].any()
    assert np.isnan(table.visible[inside, column]).all()


def test_an_override_into_the_gap_is_conformed_with_another_camera(analysed, tmp_path):
    folder, edl, _ = analysed
    (gap,) = edl.camera(BEST).gaps
    forced = attrs.evolve(edl, overrides=(Override(gap, camera=BEST),))
    assert any(decision.camera == BEST for _, decision, _ in resolve_by_pose(forced))
    document.save(forced, folder / "forced.json")
    run("conform", folder / "forced.json", "-o", tmp_path / "out", "--quality", "draft")
    assert sorted((tmp_path / "out").glob("*.mp4"))


def test_the_report_shows_it(analysed):
    _, edl, _ = analysed
    facts = gather(edl, None)
    assert facts.gaps
    assert [bool(lane.gaps) for lane in facts.lanes] == [camera.name in (BEST, HIT) for camera in edl.cameras]
