"""The share of tests/kill_runs.py that needs a Blender: killed at random moments, it loses nothing."""

from __future__ import annotations

import random
from pathlib import Path

import kill_runs
import pytest

from mcsl_core.blender.installation import Blender


@pytest.fixture(scope="module")
def begun(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return kill_runs.analysed(tmp_path_factory.mktemp("killed") / "analysed")


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["timeline", "pull", "blender"])
def test_a_killed_run_of_blender_loses_nothing(
    kind: str, blender: Blender, begun: Path, tmp_path: Path, monkeypatch
) -> None:
    monkeypatch.setenv("MCSL_BLENDER", blender.command[0])
    killed, ended = kill_runs.kill(kind, 2, random.Random(), tmp_path, begun)
    assert killed + ended == 2
