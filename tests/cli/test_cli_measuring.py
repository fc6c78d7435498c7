"""`mcsl evaluate` and `mcsl report` as child processes, on a small simulated recording with a switch in it."""

from __future__ import annotations

import csv
import json
import subprocess
import sys
from pathlib import Path

import attrs
import pytest

from mcsl_core import edl as document
from mcsl_core.analysis.pipeline import analyse
from mcsl_core.analysis.settings import AnalysisSettings
from mcsl_core.edl import Shot
from mcsl_core.hooks.registry import discover
from mcsl_core.progress import Silent
from mcsl_core.simulation import Scenario, simulate
from mcsl_core.timing import FrameRange


def mcsl(*arguments: object) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "mcsl_core.cli", *(str(a) for a in arguments)]
    return subprocess.run(command, capture_output=True, text=True, timeout=300, check=False)


@pytest.fixture(scope="module")
def edl(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("measuring")
    simulate(Scenario(seed=306, duration_s=6, movements=0, size=(320, 180), cameras=3), folder / "recording", Silent())
    path = folder / "edl.json"
    made = analyse([folder / "recording"], path, settings=AnalysisSettings(), plugins=discover(), progress=Silent())
    parts = ((0, 60, made.reference), (60, made.frames, made.cameras[1].name))
    shots = tuple(Shot(FrameRange(a, b), camera) for a, b, camera in parts)
    document.save(attrs.evolve(made, shots=shots), path)
    return path


def test_evaluate_tells_writes_and_repeats(edl: Path, tmp_path: Path) -> None:
    by_hand = tmp_path / "hand.json"
    entries = [{"camera": f"cam{n}", "transform": {"scale": 1.1, "offset_x": 4}} for n in (2, 3)]
    by_hand.write_text(json.dumps({"alignments": entries}))
    files = [tmp_path / name for name in ("a.json", "a.csv", "b.json")]
    done = mcsl("evaluate", edl, "--every", 50, "--manual", by_hand, "--json", files[0], "--csv", files[1])
    assert done.returncode == 0, done.stderr
    for words in ("No-alignment", "Manual-alignment", "Auto + centered + filled", "Auto against Manual", "320x180"):
        assert words in done.stdout
    rows = list(csv.DictReader(files[1].read_text().splitlines()))
    surface = {"surface"} if any("relief" in pose for pose in json.loads(edl.read_text("utf-8"))["poses"]) else set()
    assert {r["variant"] for r in rows} == {
        "no",
        "manual",
        "plane",
        "auto",
        "centered",
        "filled",
        "delivered",
    } | surface
    again = mcsl("--progress", "json", "evaluate", edl, "--every", 50, "--manual", by_hand, "--json", files[2])
    assert again.returncode == 0, again.stdout
    assert files[0].read_bytes() == files[2].read_bytes()
    said = json.loads(again.stdout.splitlines()[-1])["result"]
    assert said["measured"][0]["name"] == "no"


def test_evaluate_a_study(tmp_path: Path) -> None:
    ratings = tmp_path / "ratings.csv"
    lines = [f"p{n},1,comfort,{m},{r}" for n in range(7) for m, r in (("manual", 2), ("auto", 4 + n % 2))]
    ratings.write_text("participant,video,factor,method,rating\n" + "\n".join(lines))
    done = mcsl("evaluate", "--study", ratings, "--csv", tmp_path / "tests.csv")
    assert done.returncode == 0, done.stderr
    assert "0.0156*" in done.stdout
    assert "0.015625" in (tmp_path / "tests.csv").read_text()
    ratings.write_text("participant,video,factor,method,rating\np1,1,comfort,auto,9\n")
    refused = mcsl("evaluate", "--study", ratings)
    assert refused.returncode == 3
    assert "line 2: the rating is '9'" in refused.stderr


@pytest.mark.parametrize("arguments", [[], ["e.json", "--study", "r.csv"]])
def test_evaluate_takes_an_edl_or_a_study(arguments: list[str]) -> None:
    done = mcsl("evaluate", *arguments)
    assert done.returncode == 2
    assert "takes an EDL, or --study" in done.stderr


def test_report_writes_a_page(edl: Path, tmp_path: Path) -> None:
    done = mcsl("report", edl, "-o", tmp_path / "deep" / "r.html")
    assert done.returncode == 0, done.stderr
    assert "open it in a browser" in done.stdout
    assert (tmp_path / "deep" / "r.html").read_text("utf-8").startswith("<!doctype html>")
    missing = mcsl("report", tmp_path / "none.json", "-o", tmp_path / "r.html")
    assert missing.returncode == 3
    assert "none.json: does not exist" in missing.stderr


@pytest.mark.parametrize("command", ["evaluate", "report"])
def test_help_fits_a_terminal(command: str) -> None:
    done = mcsl(command, "--help")
    assert done.returncode == 0
    assert max(map(len, done.stdout.splitlines())) <= 100
