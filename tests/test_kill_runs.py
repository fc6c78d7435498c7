"""A share of tests/kill_runs.py: every command killed at random moments loses nothing."""

from __future__ import annotations

import random
from pathlib import Path

import kill_runs
import pytest

from mcsl_core.progress import Silent
from mcsl_core.simulation import simulate


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["analyse", "conform", "render"])
def test_a_killed_run_loses_nothing(kind: str, tmp_path: Path) -> None:
    simulate(kill_runs.SCENE, tmp_path / "recording", Silent())
    killed, ended = kill_runs.kill(kind, 3, random.Random(), tmp_path, tmp_path / "recording")
    assert killed + ended == 3
