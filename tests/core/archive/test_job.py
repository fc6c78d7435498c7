"""What is planned for an operation, and how far it is by the marks and logs in its folder."""

from __future__ import annotations

import json
import os
import shutil
from pathlib import Path

import pytest

from mcsl_core.archive.job import Job, load_job, planned
from mcsl_core.archive.operations import Operation
from mcsl_core.archive.outcome import forget_outdated, nameless, outcome_of, steps

PRESETS = Path(__file__).parents[3] / "render_presets"


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


def test_what_was_refused_is_looked_at_again(archive: Path, tmp_path: Path) -> None:
    """A table that was mended, a file that could not be read: neither its time nor its size has changed."""
    folder = tmp_path / "op1"
    assert plan(archive, folder, preset="vhs").facts.fault
    assert not plan(archive, folder).facts.fault
    file = archive / "op1" / "cam1.mp4"
    right, stat = file.read_bytes(), file.stat()
    file.write_bytes(bytes(len(right)))
    os.utime(file, ns=(stat.st_atime_ns, stat.st_mtime_ns + 1))
    assert plan(archive, folder).facts.fault
    file.write_bytes(right)
    os.utime(file, ns=(stat.st_atime_ns, stat.st_mtime_ns + 1))
    assert not plan(archive, folder).facts.fault


def test_a_look_writes_nothing(archive: Path, tmp_path: Path) -> None:
    job = planned(Operation("op1", "op1", {"preset": "review"}), archive, tmp_path / "op1", write=False)
    assert job.video == "programme.mp4"
    assert not (tmp_path / "op1").exists()


def test_one_that_cannot_be_worked_on_is_a_row_that_says_so(archive: Path, tmp_path: Path) -> None:
    (archive / "op1" / "cam3.mp4").symlink_to(tmp_path / "gone.mp4")
    assert plan(archive, tmp_path / "op1").facts.fault.startswith("cam3.mp4: ")
    (archive / "op1" / "cam3.mp4").unlink()
    (tmp_path / "copied" / "recording").mkdir(parents=True)  # by what follows links
    assert "recording: is no link" in plan(archive, tmp_path / "copied").facts.fault


def test_a_preset_of_ones_own_is_found_from_wherever_jobs_run(archive: Path, tmp_path: Path) -> None:
    shutil.copy(PRESETS / "review.json", tmp_path / "own.json")
    job = plan(archive, tmp_path / "op1", preset=os.path.relpath(tmp_path / "own.json"))
    assert job.render[:2] == ("--preset", str(tmp_path / "own.json"))


def test_an_anonymous_operations_folder_is_its_owners_alone(archive: Path, tmp_path: Path) -> None:
    planned(Operation("op1", "000001", {}), archive, tmp_path / "000001", anonymous=True)
    if os.name != "nt":
        assert (tmp_path / "000001").stat().st_mode & 0o077 == 0
        assert (tmp_path / "000001" / "job.json").stat().st_mode & 0o077 == 0


def test_an_edl_that_was_mended_is_tried_again(archive: Path, tmp_path: Path) -> None:
    folder = tmp_path / "op1"
    job = plan(archive, folder)
    now = (folder / "job.json").stat().st_mtime_ns
    done(folder, "analyse", now + 1)
    (folder / "log").mkdir()
    log, edl = folder / "log" / "conform-1-of-1.jsonl", folder / "edl.json"
    error = {"what": "there is no camera cam9", "where": "edl.json", "remedy": "Take another", "exit_code": 3}
    log.write_text(json.dumps({"error": error}))
    edl.write_text("{}")
    os.utime(edl, ns=(now + 2, now + 2))
    os.utime(log, ns=(now + 3, now + 3))
    assert outcome_of(folder, job).state == "refused"
    os.utime(edl, ns=(now + 4, now + 4))
    assert outcome_of(folder, job).state == "waiting"


def test_what_was_decided_while_a_job_was_at_work_it_has_not_seen(archive: Path, tmp_path: Path) -> None:
    folder = tmp_path / "op1"
    job = plan(archive, folder)
    now = (folder / "job.json").stat().st_mtime_ns
    for number, step in enumerate(steps(job), start=1):
        done(folder, step, now + 10 * number)
    evaluated = folder / "done" / "evaluate"
    evaluated.with_suffix(".began").touch()
    os.utime(evaluated.with_suffix(".began"), ns=(now + 12, now + 12))
    (folder / "edl.json").write_text("{}")
    os.utime(folder / "edl.json", ns=(now + 5, now + 5))
    assert outcome_of(folder, job).state == "done"
    os.utime(folder / "edl.json", ns=(now + 15, now + 15))
    assert (outcome_of(folder, job).state, outcome_of(folder, job).step) == ("waiting", "evaluate")
    forget_outdated(folder, job)
    assert not evaluated.exists()
    assert (folder / "done" / "report").exists()


def test_what_a_shell_said_is_told(archive: Path, tmp_path: Path) -> None:
    folder = tmp_path / "op1"
    job = plan(archive, folder)
    (folder / "log").mkdir()
    (folder / "log" / "analyse.jsonl").write_text("bash: line 1: nosuch: command not found\n")
    assert "nosuch: command not found" in outcome_of(folder, job).why


def test_no_camera_of_numbered_files_and_no_option_is_told_of_an_anonymous_one(archive: Path, tmp_path: Path) -> None:
    for number in (1, 2):
        (archive / "op1" / f"cam{number}.mp4").rename(archive / "op1" / f"Specht_00{number}.mp4")
    job = plan(archive, tmp_path / "op1", reference="Meise", audio="Amsel")
    assert nameless("there is no Meise: choose one of specht, Amsel", job) == "there is no ...: choose one of ..., ..."
