"""Results of stages beside the EDL: used where nothing they depend on has changed, made again where something has."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pytest
from fresh_import import fresh_import
from notes import Notes

from mcsl_core import edl
from mcsl_core.alignment.aligned_views import AlignedPose
from mcsl_core.alignment.observations import SolvedPose
from mcsl_core.analysis import pipeline
from mcsl_core.analysis.cache import CLOCKS, POSES, Deferred, StageCache
from mcsl_core.analysis.pipeline import cache_folder
from mcsl_core.analysis.settings import AnalysisSettings
from mcsl_core.hooks import registry as plugins
from mcsl_core.hooks.stages import STAGES
from mcsl_core.progress import Silent
from mcsl_core.simulation import Scenario, simulate
from mcsl_core.timing import FrameRange

LOOKING = "Looking closer"
SAMPLING = "Sampling the recording"


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("cached") / "recording"
    simulate(Scenario(seed=5, duration_s=6, size=(320, 180), rate=10, cameras=3, movements=0), folder, Silent())
    return folder


def analyse(recording: Path, out: Path, *, cache: bool = True, offered=None, **stages: str) -> list[str]:
    """Analyses and returns the stages and notes that were reported."""
    seen = Notes()
    settings = AnalysisSettings(sync="none", stages=stages, cache=cache)
    pipeline.analyse([recording], out, settings=settings, plugins=offered or plugins.discover(), progress=seen)
    return seen.stages + seen.notes


def test_a_changed_selector_samples_and_scores_nothing_again(recording: Path, tmp_path: Path) -> None:
    out = tmp_path / "edl.json"
    first = analyse(recording, out)
    assert SAMPLING in first
    before = out.read_bytes()
    again = analyse(recording, out)
    assert SAMPLING not in again
    assert "Aligning the views" not in again
    assert out.read_bytes() == before, "what comes from the cache is what was made"
    greedy = analyse(recording, out, selector="least-occluded")
    assert SAMPLING not in greedy
    assert "Scoring the views" not in greedy
    made = edl.load(out).made_by
    assert made is not None
    assert made.plugins["selector"].startswith("least-occluded")
    assert LOOKING in first
    assert LOOKING not in analyse(recording, out, selector="fixed"), "no look depends on what it chooses"


def test_a_changed_detector_scores_again_but_decodes_nothing(recording: Path, tmp_path: Path) -> None:
    out = tmp_path / "edl.json"
    analyse(recording, out)
    others = [o.name for o in plugins.discover().offers if o.stage == "occlusion"]
    stages = analyse(recording, out, occlusion=next(n for n in others if n != STAGES["occlusion"].default))
    assert "Scoring the views" in stages
    assert SAMPLING not in stages
    assert "Aligning the views" not in stages


def test_changed_media_are_looked_at(recording: Path, tmp_path: Path) -> None:
    own = tmp_path / "recording"
    shutil.copytree(recording, own)
    out = tmp_path / "edl.json"
    analyse(own, out)
    shutil.copy(own / "cam2.mp4", own / "cam3.mp4")
    assert SAMPLING in analyse(own, out)


def test_without_the_cache_nothing_is_kept_or_used(recording: Path, tmp_path: Path) -> None:
    out = tmp_path / "edl.json"
    assert SAMPLING in analyse(recording, out, cache=False)
    assert not cache_folder(out).exists()
    kept = out.read_bytes()
    analyse(recording, out)
    assert out.read_bytes() == kept
    assert SAMPLING in analyse(recording, out, cache=False)


def test_what_cannot_be_read_is_made_again_and_said_so(recording: Path, tmp_path: Path) -> None:
    out = tmp_path / "edl.json"
    analyse(recording, out)
    before = out.read_bytes()
    for path in cache_folder(out).iterdir():
        path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])
    said = analyse(recording, out)
    assert SAMPLING in said
    assert any("cannot be used" in text for text in said)
    assert out.read_bytes() == before


def test_a_plugin_that_is_being_written_is_asked_again(
    recording: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    module = tmp_path / "halves.py"
    source = (
        "from mcsl_core.hooks.specs import hookimpl\n"
        "class Halves:\n"
        "    name = 'halves'\n"
        "    def scorer(self, *scene):\n"
        "        return self\n"
        "    def score(self, views):\n"
        "        return {v.camera: 0.5 for v in views}\n"
        "@hookimpl\n"
        "def register_occlusion_detectors():\n"
        "    return [Halves()]\n"
    )
    monkeypatch.syspath_prepend(str(tmp_path))
    out = tmp_path / "edl.json"
    scored = []
    for share in ("0.5", "0.25"):
        module.write_text(source.replace("0.5", share))
        offered = plugins.discover([(fresh_import("halves", monkeypatch), "halves", "1")])
        stages = analyse(recording, out, offered=offered, occlusion="halves")
        assert "Scoring the views" in stages
        scored.append({round(s.score, 2) for s in edl.load(out).shots})
    assert scored == [{0.5}, {0.25}]


def test_a_stage_keeps_its_latest_results_only(tmp_path: Path) -> None:
    cache = StageCache(tmp_path, Silent())
    for number in range(9):
        cache.remember(CLOCKS, str(number), lambda n: (edl.Clock(offset_s=n),), number)
    assert sorted(p.name for p in tmp_path.iterdir()) == [f"clocks-{n}.npz" for n in (5, 6, 7, 8)]
    assert cache.remember(CLOCKS, "8", pytest.fail, "made again") == (edl.Clock(offset_s=8),)
    assert cache.remember(CLOCKS, "0", lambda: (edl.Clock(),)) == (edl.Clock(),)


def test_what_a_step_needs_is_made_for_the_first_step_that_runs_and_for_none_that_does_not(tmp_path: Path) -> None:
    made: list[str] = []
    whole = Deferred(lambda name: made.append(name) or 3, "samples")
    half = Deferred(lambda of, by: made.append("half") or of / by, whole, by=2)
    cache = StageCache(tmp_path, Silent())
    step = lambda offset, more=0: (edl.Clock(offset_s=offset + more),)  # noqa: E731
    assert made == []
    assert cache.remember(CLOCKS, "a", step, 1) == (edl.Clock(offset_s=1),)
    assert made == []
    for _ in range(2):
        assert cache.remember(CLOCKS, "b", step, half, more=whole) == (edl.Clock(offset_s=4.5),)
        assert made == ["samples", "half"]
    assert cache.remember(CLOCKS, "c", step, whole) == (edl.Clock(offset_s=3),)
    assert made == ["samples", "half"]
    assert StageCache(None, Silent()).remember(CLOCKS, "a", step, half) == (edl.Clock(offset_s=1.5),)


def test_of_poses_all_is_kept_that_detectors_are_told(tmp_path: Path) -> None:
    """Whatever `AlignedPose` has, or a second analysis would score otherwise than the first."""
    rng, sizes = np.random.default_rng(1), {"cam1": (640, 360), "a / b": (1920, 1080)}
    masks = {name: rng.random((9, 16)) > 0.5 for name in ("field", *sizes)}
    planes = {"cam1": np.eye(3), "a / b": np.diag([0.5, 0.5, 1.0])}
    hands = {name: masks[name] for name in sizes}
    aligned = AlignedPose((16, 9), "cam1", planes, sizes, masks["field"], hands)
    matrices = {name: tuple(map(tuple, h.tolist())) for name, h in planes.items()}
    pose = edl.Pose(range=FrameRange(0, 10), homographies=matrices, solved_from=(1, 2))
    made = [SolvedPose(pose, aligned, (3, 4), {})]
    StageCache(tmp_path, Silent()).remember(POSES, "key", lambda: made)
    (kept,) = StageCache(tmp_path, Silent()).remember(POSES, "key", list)
    assert kept.pose == pose
    for name in ("size", "reference", "camera_sizes"):
        assert getattr(kept.aligned, name) == getattr(aligned, name)
    np.testing.assert_array_equal(kept.aligned.field, masks["field"])
    for found, given in ((kept.aligned.homographies, planes), (kept.aligned.hands, hands)):
        assert found.keys() == given.keys()
        for name in given:
            np.testing.assert_array_equal(found[name], given[name])
