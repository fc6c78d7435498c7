"""Progress: JSON lines that a program can read, and the token that stops the work."""

from __future__ import annotations

import io
import json
import threading

import pytest

from mcsl_core.errors import Cancelled
from mcsl_core.progress import CancelToken, JsonLines, Progress, Silent, Steps, counted


def lines(stream: io.StringIO) -> list[dict]:
    return [json.loads(line) for line in stream.getvalue().splitlines()]


@pytest.mark.parametrize(
    ("count", "plural", "said"),
    [(0, "shots", "0 shots"), (1, "shots", "1 shot"), (2, "shots", "2 shots"), (1, "MiB", "1 MiB"), (1, "", "1 ")],
)
def test_one_is_no_plural(count, plural, said):
    assert counted(count, plural) == said


def test_every_message_is_one_json_object_a_line():
    stream = io.StringIO()
    progress = JsonLines(stream)
    progress.stage("Finding movements", 2, "samples")
    progress.advance(2)
    progress.note("camera 手\nis weak")
    progress.stage("Writing")
    progress.result({"edl": "edl.json"})
    progress.error("is silent", where="cam1.mp4", remedy="Use --sync motion", exit_code=3)
    assert lines(stream) == [
        {"stage": "Finding movements", "total": 2, "unit": "samples"},
        {"done": 2},
        {"note": "camera 手\nis weak"},
        {"stage": "Writing", "total": None, "unit": ""},
        {"result": {"edl": "edl.json"}},
        {"error": {"what": "is silent", "where": "cam1.mp4", "remedy": "Use --sync motion", "exit_code": 3}},
    ]


def test_a_step_is_told_by_its_place_in_the_list_and_those_left_out_keep_theirs():
    stream = io.StringIO()
    steps = Steps(JsonLines(stream), ["files", "sound", "pictures"])
    steps.begin("files")  # it has begun already
    steps.begin("pictures")
    assert lines(stream) == [{"step": 1, "of": 3}, {"step": 3, "of": 3}]
    with pytest.raises(ValueError, match="tuple"):
        steps.begin("colours")
    Steps(Silent(), ["files", "sound"]).begin("sound")  # who does not count is told nothing


def test_the_lines_pass_a_pipe_of_any_encoding():
    pipe = io.BytesIO()
    stream = io.TextIOWrapper(pipe, encoding="ascii")
    JsonLines(stream).note("手術 – caf\udce9")
    assert json.loads(pipe.getvalue()) == {"note": "手術 – caf\udce9"}


def test_counts_are_rare_but_the_first_and_the_last_of_a_stage_always_come(monkeypatch):
    now = 100.0
    monkeypatch.setattr("mcsl_core.progress.time.monotonic", lambda: now)
    stream = io.StringIO()
    progress = JsonLines(stream, per_second=10)
    for name in ("one", "two"):
        progress.stage(name, 1000)
        for done in range(1, 1001):
            now += 0.001
            progress.advance(done)
    counts = [m["done"] for m in lines(stream) if "done" in m]
    assert counts.count(1) == 2
    assert counts.count(1000) == 2
    # 2 s at 10 a second, and the first and last of each stage
    assert 18 <= len(counts) <= 24


@pytest.mark.parametrize("kind", ["silent", "json"])
def test_once_cancelled_every_report_stops_the_work(kind):
    token = CancelToken()
    stream = io.StringIO()
    progress: Progress = Silent(token) if kind == "silent" else JsonLines(stream, token)
    progress.stage("a", 1)
    progress.advance(1)
    progress.note("b")
    before = stream.getvalue()
    thread = threading.Thread(target=token.cancel)
    thread.start()
    thread.join()
    for report in (lambda: progress.stage("c"), lambda: progress.advance(2), lambda: progress.note("d"), token.check):
        with pytest.raises(Cancelled):
            report()
    assert stream.getvalue() == before, "nothing is said after the stop but the error"


def test_after_a_stop_the_error_can_still_be_told():
    token = CancelToken()
    stream = io.StringIO()
    progress = JsonLines(stream, token)
    token.cancel()
    stopped = Cancelled()
    progress.error(stopped.what, stopped.where, stopped.remedy, stopped.exit_code)
    assert lines(stream)[0]["error"]["exit_code"] == 130
