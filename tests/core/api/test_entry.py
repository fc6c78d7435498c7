"""A recording analysed from Python, with texts and paths, names and defaults."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import mcsl_core as mcsl
from mcsl_core.api.views import moved
from mcsl_core.errors import UsageError
from mcsl_core.evaluation.results import Conditions, Evaluation
from mcsl_core.progress import Silent
from mcsl_core.simulation import Scenario, simulate


@pytest.mark.slow
def test_a_recording_is_analysed_into_a_programme(tmp_path: Path) -> None:
    simulate(Scenario(seed=5, duration_s=6, movements=0, size=(320, 180), cameras=3), tmp_path / "rec", Silent())
    edl = tmp_path / "new" / "edl.json"
    without = mcsl.AnalysisSettings(cache=False, sync="none")
    made = mcsl.analyse(str(tmp_path / "rec"), str(edl), reference="cam2", settings=without, selector="fixed")
    assert made.is_saved
    assert made.edl == mcsl.open(edl).edl
    assert made.edl.reference == "cam2"
    assert made.edl.made_by is not None
    assert made.edl.made_by.plugins["selector"].startswith("fixed (mcsl ")
    assert {c.clock.method for c in made.edl.cameras} == {"none"}
    assert sorted(path.name for path in edl.parent.iterdir()) == ["edl.json", "edl.scores.npz"]
    assert made.frame(30).shape == (180, 320, 3)
    assert made.scores.cameras == ("cam1", "cam2", "cam3")


def test_a_stage_that_there_is_not_is_told_before_any_work(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match="there is no stage 'oclusion'"):
        mcsl.analyse(tmp_path, tmp_path / "e.json", oclusion="hue-area")
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("call", "told"),
    [
        (lambda: mcsl.open(None), 'an EDL is opened by its path, got None. Give it as mcsl.open("edl.json")'),
        (lambda: mcsl.evaluate("edl.json"), "a Programme is measured, got 'edl.json'. Give what mcsl.open"),
        (lambda: mcsl.analyse("r", "e.json", settings={"sync": "none"}), "settings are an AnalysisSettings, got dict"),
        (lambda: mcsl.analyse("r", "e.json", sync="none"), "Give settings=mcsl.AnalysisSettings(sync='none')"),
        (lambda: Evaluation(Conditions((16, 9), 1, 0), (), ()).row("auto"), "there is no variant 'auto'"),
        (lambda: moved(np.eye(3), "points"), "points are numbers, got 'points'. Give [[x, y], ...]"),
    ],
)
def test_a_wrong_call_is_told_in_words(call, told: str) -> None:
    with pytest.raises(UsageError) as refused:
        call()
    assert told in str(refused.value)
