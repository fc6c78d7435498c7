"""A small archive as a hospital's might be, and mcsl as a person runs it."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

from mcsl_core.simulation import Scenario

SCENE = Scenario(seed=3, duration_s=4, size=(128, 72), rate=10, cameras=2, movements=0)
ODD = "Fall 3 {Süd} $x"


def mcsl(*words: object, cwd: Path | None = None) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "mcsl_core.cli", *(str(word) for word in words)]
    return subprocess.run(command, cwd=cwd, capture_output=True, text=True, timeout=500, check=False)
