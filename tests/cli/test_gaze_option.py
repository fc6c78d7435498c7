"""Gaze through the whole analysis: what is centred, and how many looks of how many that rests on."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from mcsl_core.cli.main import main
from mcsl_core.progress import Silent
from mcsl_core.simulation import Scenario, simulate


@pytest.mark.slow
def test_how_many_looks_are_used_is_told_and_kept(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    scenario = Scenario(seed=5, duration_s=12, rate=10, movements=0, size=(320, 180), cameras=2, audio=False)
    simulate(scenario, tmp_path / "rec", Silent())
    rows = [f"{n / 60:.3f},{'100,75' if n % 3 else '-1,-1'}" for n in range(720)]
    (tmp_path / "g.csv").write_text("\n".join(["time,x,y", *rows]))
    call = ["analyse", str(tmp_path / "rec"), "-o", str(tmp_path / "e.json"), "--sync", "none", "--no-cache"]
    assert main(["--progress", "json", *call, "--gaze", str(tmp_path / "g.csv")]) == 0
    messages = [json.loads(line) for line in capsys.readouterr().out.splitlines()]
    notes = [m["note"] for m in messages if "note" in m]
    assert f"{tmp_path / 'g.csv'}: 480 of 720 looks are used (240 without eyes)" in notes
    told = [{"file": "g.csv", "samples": 720, "used": 480}]
    assert messages[-1]["result"]["gaze"] == told
    edl = json.loads((tmp_path / "e.json").read_text())
    assert edl["made_by"]["settings"]["gaze"] == told
    ((_, dx, dy),) = edl["centering"]
    assert (dx, dy) == pytest.approx((159.5 - 100, 89.5 - 75), abs=21)  # the centering keeps the picture in the frame
