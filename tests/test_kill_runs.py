"""A share of tests/kill_runs.py: every command killed at random moments loses nothing."""

from __future__ import annotations

import random
from pathlib import Path

import kill_runs
import pytest


@pytest.fixture(scope="module")
def begun(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return kill_runs.analysed(tmp_path_factory.mktemp("killed") / "analysed")


@pytest.mark.slow
@pytest.mark.parametrize(("kind", "times"), [("analyse", 1), ("conform", 3), ("render", 3)])
def test_a_killed_run_loses_nothing(kind: str, times: int, begun: Path, tmp_path: Path) -> None:
    killed, ended = kill_runs.kill(kind, times, random.Random(), tmp_path, begun)
    assert killed + ended == times
