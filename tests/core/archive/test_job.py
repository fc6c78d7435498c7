"""What is planned for an operation, and how far it is by the marks and logs in its folder."""

from __future__ import annotations

import json
import os
import shutil
from pathlib import Path

import pytest

from mcsl_core.archive.job import Job, load_job, planned
from mcsl_core.archive.operations import Operation
from mcsl_core.archive.outcome import nameless, outcome_of, steps


def plan(archive: Path, folder: Path, **options: str) -> Job:
    return planned(Operation("op1", "op1", options), archive, folder)


def test_the_headers_are_told_and_read_once(archive: Path, tmp_path: Path) -> None:
    folder = tmp_path / "out" / "op1"
    job = plan(archive, folder)
    facts = job.facts
    assert (facts.cameras, facts.files, facts.size, facts.rate, facts.fault) == (2, 2, (128, 72), 10.0, "")
    assert facts.seconds == pytest.approx(4, abs=0.2)
    assert facts.bytes == sum(path.stat().st_size for path in (archive / "op1").glob("*.mp4"))
    assert (folder / "recording").resolve() == (archive / "op1").resolve()
    assert load_job(folder / "job.json") == job
    written = (folder / "job.json").stat().st_mtime_ns
    files = list((archive / "op1").glob("*.mp4"))
    for file in files:  # the same sizes and times: nobody looks into them
        stat = file.stat()
        file.write_bytes(bytes(stat.st_size))
        os.utime(file, ns=(stat.st_atime_ns, stat.st_mtime_ns))
    assert plan(archive, folder) == job
    assert (folder / "job.json").stat().st_mtime_ns == written
    os.utime(files[0])
    assert plan(archive, folder).facts.fault


def test_options_become_those_of_the_commands(archive: Path, tmp_path: Path) -> None:
    options = {"reference": "cam2", "occlusion": "hue-area", "movement-view": "hold", "quality": "draft"}
    job = plan(archive, tmp_path / "op1", **options, preset="prores", audio="none", parts="3")
    assert job.analyse == ("--reference", "cam2", "--movement-view", "hold", "--occlusion", "hue-area")
    assert job.conform == ("--quality", "draft", "--audio", "none")
    assert job.render == ("--preset", "prores", "--quality", "draft", "--audio", "none")
    assert (job.parts, job.video) == (3, "programme.mov")
    assert steps(job)[1:4] == ("conform-1-of-3", "conform-2-of-3", "conform-3-of-3")


@pytest.mark.parametrize("wrong", [{"preset": "vhs"}, {"quality": "best"}])
def test_a_wrong_option_is_a_row_that_says_so(archive: Path, tmp_path: Path, wrong: dict[str, str]) -> None:
    job = plan(archive, tmp_path / "op1", **wrong)
    assert next(iter(wrong.values())) in job.facts.fault
    assert outcome_of(tmp_path / "op1", job).state == "refused"


def test_a_folder_that_is_no_recording_says_why(archive: Path, tmp_path: Path) -> None:
    for name, said in (("op3-lost", "only one camera"), ("empty", "holds no video files")):
        (archive / name).mkdir(exist_ok=True)
        job = planned(Operation(name, name, {}), archive, tmp_path / name)
        assert said in job.facts.fault
        assert str(tmp_path) not in job.facts.fault
    (archive / "op1" / "cam2.mp4").write_bytes(b"no film at all")
    assert plan(archive, tmp_path / "op1").facts.fault.startswith("cam2.mp4: ")


def done(folder: Path, step: str, at_ns: int, seconds: str = "2") -> None:
    mark = folder / "done" / step
    mark.parent.mkdir(exist_ok=True)
    mark.write_text(seconds)
    os.utime(mark, ns=(at_ns, at_ns))


def test_marks_say_how_far_it_is_and_what_is_outdated(archive: Path, tmp_path: Path) -> None:
    folder = tmp_path / "op1"
    job = plan(archive, folder)
    now = (folder / "job.json").stat().st_mtime_ns
    assert outcome_of(folder, job).state == "waiting"
    for number, step in enumerate(steps(job), start=1):
        assert outcome_of(folder, job).step == step
        done(folder, step, now + number)
    assert outcome_of(folder, job).state == "done"
    assert outcome_of(folder, job).seconds == 2 * len(steps(job))
    (folder / "edl.json").write_text("{}")  # an editor decided something
    os.utime(folder / "edl.json", ns=(now + 100, now + 100))
    assert (outcome_of(folder, job).state, outcome_of(folder, job).step) == ("waiting", "conform-1-of-1")
    os.utime(folder / "job.json", ns=(now + 200, now + 200))
    assert outcome_of(folder, job).step == "analyse"
    shutil.rmtree(folder / "done")
    assert outcome_of(folder, job).seconds == 0


@pytest.mark.parametrize(("code", "state"), [(2, "refused"), (3, "refused"), (4, "failed"), (130, "failed")])
def test_the_last_words_of_a_job_say_why(archive: Path, tmp_path: Path, code: int, state: str) -> None:
    folder = tmp_path / "op1"
    job = plan(archive, folder)
    (folder / "log").mkdir()
    where = str((archive / "op1" / "cam1.mp4").resolve())
    error = {"what": "ends too early", "where": where, "remedy": "Copy it again", "exit_code": code}
    lines = [json.dumps({"stage": "Reading"}), json.dumps({"error": error})]
    (folder / "log" / "analyse.jsonl").write_text("\n".join(lines) + "\n")
    found = outcome_of(folder, job)
    assert (found.state, found.step, found.why) == (state, "analyse", "cam1.mp4: ends too early. Copy it again")
    assert nameless(found.why, job) == "...: ends too early. Copy it again"
    assert "op1" not in nameless("op1/cam2: camera cam1 is op1's", job)
    (folder / "log" / "analyse.jsonl").write_text(lines[0] + '\n{"done": ')
    assert (outcome_of(folder, job).state, outcome_of(folder, job).step) == ("failed", "analyse")
    later = (folder / "log" / "analyse.jsonl").stat().st_mtime_ns + 1
    os.utime(folder / "job.json", ns=(later, later))  # what is to be done has changed
    assert outcome_of(folder, job).state == "waiting"
