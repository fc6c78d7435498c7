"""An archive worked through by Snakemake, as a person runs it: real recordings, real processes."""

from __future__ import annotations

import csv
import json
import os
import shutil
from pathlib import Path

import attrs
import av
import pytest
from archive_desk import ODD, mcsl

from mcsl_core import edl as edls
from mcsl_core.archive.run import survey
from mcsl_core.edl import Override
from mcsl_core.outputs.locks import alone
from mcsl_core.progress import Silent
from mcsl_core.timing import FrameRange

pytestmark = [pytest.mark.slow, pytest.mark.timeout(1800)]
KEY = "Fall_3__Süd___x"


@pytest.fixture(autouse=True)
def needs_snakemake() -> None:
    pytest.importorskip("snakemake", reason="the extra `archive` is not installed")


def times(out: Path) -> dict[str, int]:
    """When what jobs make was last written; logs of the engine itself are no results."""
    files = (path for path in out.rglob("*") if path.is_file() and ".snakemake" not in path.parts)
    return {
        path.relative_to(out).as_posix(): path.stat().st_mtime_ns
        for path in files
        if path.parent != out and path.parent != out / "log" and not path.name.endswith("outputs.json")
    }


def rows(out: Path) -> dict[str, dict[str, str]]:
    with (out / "operations.csv").open(encoding="utf-8") as stream:
        return {row["operation"]: row for row in csv.DictReader(stream)}


def frames(path: Path) -> int:
    with av.open(str(path)) as container:
        return sum(1 for _ in container.decode(video=0))


def test_an_archive_is_worked_through_and_again_only_what_is_new(archive: Path, tmp_path: Path) -> None:
    out, table = tmp_path / "out", tmp_path / "table.csv"
    table.write_text("operation,preset,parts\nop1,review,2\n", "utf-8")
    told = mcsl("archive", archive, "-o", out, "--table", table, "--dry-run")
    assert told.returncode == 0, told.stderr
    assert "3 operations: 1 refused, 2 waiting" in told.stdout
    assert "to do: 2 operations, 11 jobs at most, 0:00:08" in told.stdout
    assert not (out / "op1" / "edl.json").exists()

    done = mcsl("archive", archive, "-o", out, "--table", table)
    assert done.returncode == 0, done.stderr
    found = rows(out)
    assert {name: row["state"] for name, row in found.items()} == {"op1": "done", ODD: "done", "op3-lost": "refused"}
    assert "only one camera" in found["op3-lost"]["why"]
    for key in ("op1", KEY):
        edl = edls.read(out / key / "edl.json")
        assert frames(out / key / "programme.mp4") == edl.frames
        assert (out / key / "report.html").stat().st_size > 10_000
        assert (out / key / "picture.jpg").is_file()
        assert int(found["op1" if key == "op1" else ODD]["shots"]) == len(edl.shots)
    marks = [path for path in (out / "op1" / "done").iterdir() if path.suffix != ".began"]
    assert len(marks) == 6
    for mark in marks:
        assert mark.with_suffix(".began").stat().st_mtime_ns < mark.stat().st_mtime_ns

    before = times(out)
    again = mcsl("archive", archive, "-o", out, "--table", table)
    assert again.returncode == 0, again.stderr
    assert times(out) == before

    edl = edls.read(out / "op1" / "edl.json")
    decided = Override(FrameRange(5, 15), camera="cam2", note="by hand")
    edls.save(attrs.evolve(edl, overrides=(decided,)), out / "op1" / "edl.json")
    shutil.copytree(archive / "op1", archive / "op4")
    shutil.rmtree(archive / "op3-lost")
    third = mcsl("archive", archive, "-o", out, "--table", table)
    assert third.returncode == 0, third.stderr
    after = times(out)
    assert {name for name in before if before[name] != after[name] and not name.startswith("op1/")} == set()
    assert after["op1/done/analyse"] == before["op1/done/analyse"]
    assert after["op1/done/render"] > before["op1/done/render"]
    assert decided in edls.read(out / "op1" / "edl.json").overrides
    assert {name: row["state"] for name, row in rows(out).items()} == {"op1": "done", ODD: "done", "op4": "done"}


def test_a_recording_that_cannot_be_analysed_stops_no_other_and_is_not_tried_again(
    archive: Path, tmp_path: Path
) -> None:
    out, table = tmp_path / "out", tmp_path / "table.csv"
    table.write_text(f'operation,reference\n"{ODD}",nobody\n', "utf-8")
    log, tried = out / KEY / "log" / "analyse.jsonl", list[int]()
    for _ in range(2):
        done = mcsl("archive", archive, "-o", out, "--table", table, "--cores", "2")
        assert done.returncode == 0, done.stderr
        found = rows(out)
        assert (found["op1"]["state"], found[ODD]["state"], found[ODD]["step"]) == ("done", "refused", "analyse")
        assert "nobody" in found[ODD]["why"]
        tried.append(log.stat().st_mtime_ns)
    assert tried[0] == tried[1]
    table.write_text("operation,reference\nop1,\n", "utf-8")
    assert mcsl("archive", archive, "-o", out, "--table", table).returncode == 0
    assert rows(out)[ODD]["state"] == "done"


def test_jobs_that_cannot_even_start_are_a_failure_that_says_why(archive: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    done = mcsl("archive", archive, "-o", out, "--mcsl", "no${HOME:+}such")
    assert done.returncode == 4
    assert "2 operations failed" in done.stderr
    assert "nosuch: command not found" in rows(out)["op1"]["why"]


def test_who_comes_second_touches_nothing(archive: Path, tmp_path: Path) -> None:
    out, table = tmp_path / "out", tmp_path / "table.csv"
    survey(archive, out, progress=Silent())
    before = (out / "op1" / "job.json").read_bytes()
    table.write_text("operation,quality\nop1,draft\n", "utf-8")
    with alone(out / "archive.json", "archive"):
        done = mcsl("archive", archive, "-o", out, "--table", table)
    assert done.returncode == 4
    assert "is at work on it" in done.stderr
    assert (out / "op1" / "job.json").read_bytes() == before


def test_no_log_page_or_table_names_anonymous_operations(archive: Path, tmp_path: Path) -> None:
    (archive / "op1").rename(archive / "Meier-1961")
    (archive / "op3-lost").rename(archive / "Schulz")
    (archive / "Schulz" / "cam1.mp4").rename(archive / "Schulz" / "Schulz.mp4")
    (archive / "Schulz" / "bad.mp4").write_bytes(b"no film")
    shutil.rmtree(archive / ODD)
    out = tmp_path / "out"
    done = mcsl("--progress", "lines", "archive", archive, "-o", out, "--anonymous")
    assert done.returncode == 0, done.stderr
    shown = [out / name for name in ("triage.html", "operations.csv", "log/snakemake.txt", "log/workflow.json")]
    shown += [out / "000001" / "report.html", *(out / ".snakemake" / "log").iterdir()]
    texts = [path.read_text("utf-8") for path in shown] + [done.stdout, done.stderr]
    texts.append((out / "operations.parquet").read_bytes().decode("latin-1"))
    assert "000001" in texts[0]
    assert "000002" in texts[0]
    for text in texts:
        assert not [word for word in ("Meier", "1961", "Schulz", "bad.mp4", str(archive)) if word in text]
    assert json.loads((out / "archive.json").read_text())["keys"] == {"Meier-1961": "000001", "Schulz": "000002"}


def test_without_snakemake_it_says_what_to_install(
    archive: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "sitecustomize.py").write_text(
        "import importlib.util as u\nf = u.find_spec\n"
        "u.find_spec = lambda name, *a: None if name == 'snakemake' else f(name, *a)\n"
    )
    monkeypatch.setenv("PYTHONPATH", str(tmp_path), prepend=os.pathsep)
    done = mcsl("archive", archive, "-o", tmp_path / "out")
    assert done.returncode == 4
    assert 'pip install "mcsl[archive]"' in done.stderr


def test_what_snakemake_itself_refuses_is_told(archive: Path, tmp_path: Path) -> None:
    done = mcsl("archive", archive, "-o", tmp_path / "out", "--profile", "no such profile")
    assert done.returncode == 4
    assert "Snakemake ended with" in done.stderr
    assert "snakemake.txt" in done.stderr
