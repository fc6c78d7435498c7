"""No output replaces an input, by whatever name, nor what somebody else wrote: the commands as a person types them."""

from __future__ import annotations

import hashlib
import os
import shutil
from pathlib import Path

import pytest
from click.testing import CliRunner, Result
from two_cameras import make, write_sources

from mcsl_core import edl as edls
from mcsl_core.cli.main import cli
from mcsl_core.delivery.presets import presets_folder
from mcsl_core.errors import InputError, UsageError

RATINGS = "participant,video,factor,method,rating\n" + "".join(
    f"{person},v,f,{method},{2 + person % 2 + (method == 'b')}\n" for person in range(8) for method in "ab"
)


def mcsl(*arguments: object) -> Result:
    return CliRunner().invoke(cli, ["--progress", "none", *(str(a) for a in arguments)])


@pytest.fixture(scope="session")
def filmed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("filmed")
    write_sources(folder)
    return folder


@pytest.fixture
def desk(filmed: Path, tmp_path: Path) -> Path:
    """A folder with a recording, its EDL, a preset, ratings, gaze and a picture of somebody else."""
    for file in filmed.iterdir():
        shutil.copy2(file, tmp_path / file.name)
    edls.save(make(), tmp_path / "edl.json")
    shutil.copy2(presets_folder() / "review.json", tmp_path / "own.json")
    (tmp_path / "ratings.csv").write_text(RATINGS)
    (tmp_path / "gaze.csv").write_text("time_s,x,y\n0,1,1\n1,2,2\n")
    (tmp_path / "other.mp4").write_bytes(b"somebody's holiday")
    (tmp_path / "notes.html").write_text("somebody's notes")
    return tmp_path


def contents(folder: Path) -> dict[str, str]:
    return {p.name: hashlib.sha256(p.read_bytes()).hexdigest() for p in folder.iterdir() if p.is_file()}


# command -> its words, and the suffix that its output must have; OUT is the output
RENDER = ("render", "edl.json", "--engine", "direct", "--preset", "review", "-o")
CALLS = {
    "render": (RENDER, ".mp4"),
    "render by its own preset": (("render", "edl.json", "--engine", "direct", "--preset", "own.json", "-o"), ".mp4"),
    "report": (("report", "edl.json", "-o"), ""),
    "evaluate csv": (("evaluate", "edl.json", "--every", "0", "--csv"), ""),
    "evaluate json": (("evaluate", "edl.json", "--every", "0", "--json"), ""),
    "study": (("evaluate", "--study", "ratings.csv", "--csv"), ""),
    "timeline": (("timeline", "edl.json", "-o"), ".blend"),
    "analyse": (("analyse", "a.mp4", "b.mp4", "--gaze", "gaze.csv", "-o"), ""),
}


def by_another_name(way: str, file: Path, suffix: str) -> Path:
    """A way to ``file`` that ends in ``suffix``."""
    name = file.with_name(f"another{suffix or file.suffix}")
    if way == "hard link":
        os.link(file, name)
    elif way == "link":
        name.symlink_to(file)
    elif way == "link to a link":
        file.with_name("between").symlink_to(file.name)
        name.symlink_to("between")
    elif way == "linked folder":
        file.with_name("beside").symlink_to(".")
        return file.with_name("beside") / file.name
    elif way == "dots":
        return file.parent / ".." / file.parent.name / "." / file.name
    elif way == "relative":
        return Path(os.path.relpath(file, Path.cwd()))
    return name if name.exists() else file


@pytest.mark.parametrize("force", [False, True], ids=["", "forced"])
@pytest.mark.parametrize("way", ["itself", "hard link", "link", "link to a link", "linked folder", "dots", "relative"])
@pytest.mark.parametrize(
    ("call", "given"),
    [
        ("render", "a.mp4"),
        ("render", "b.mp4"),
        ("render", "edl.json"),
        ("render by its own preset", "own.json"),
        ("report", "a.mp4"),
        ("report", "edl.json"),
        ("evaluate csv", "b.mp4"),
        ("evaluate csv", "edl.json"),
        ("evaluate json", "edl.json"),
        ("study", "ratings.csv"),
        ("timeline", "a.mp4"),
        ("timeline", "edl.json"),
        ("analyse", "a.mp4"),
        ("analyse", "gaze.csv"),
    ],
)
def test_an_input_is_never_written_over(
    desk: Path, monkeypatch: pytest.MonkeyPatch, call: str, given: str, way: str, force: bool
) -> None:
    monkeypatch.chdir(desk)
    words, suffix = CALLS[call]
    if suffix and way in ("itself", "linked folder", "dots", "relative") and Path(given).suffix != suffix:
        pytest.skip("its name is refused already")
    out = by_another_name(way, desk / given, suffix)
    before = contents(desk)
    done = mcsl(*words, out, *(["--force"] if force else []))
    assert done.exit_code != 0
    assert "what this run reads" in str(done.exception)
    assert contents(desk) == before


@pytest.mark.parametrize("call", ["render", "report", "evaluate csv", "study", "analyse"])
def test_what_somebody_else_wrote_stays_without_force(desk: Path, monkeypatch: pytest.MonkeyPatch, call: str) -> None:
    monkeypatch.chdir(desk)
    words, suffix = CALLS[call]
    out = "other.mp4" if suffix else "notes.html"
    before = contents(desk)
    done = mcsl(*words, out)
    assert "is there already" in str(done.exception)
    assert "--force" in str(done.exception)
    assert contents(desk) == before


@pytest.mark.parametrize("call", ["render", "evaluate csv", "study"])
def test_what_mcsl_wrote_is_written_again_until_somebody_changes_it(
    desk: Path, monkeypatch: pytest.MonkeyPatch, call: str
) -> None:
    monkeypatch.chdir(desk)
    words, suffix = CALLS[call]
    out = Path(f"out{suffix or '.csv'}")
    assert mcsl(*words, out).exit_code == 0
    first = out.read_bytes()
    assert mcsl(*words, out).exit_code == 0, "a server renders every night"
    assert out.read_bytes() == first
    out.write_bytes(first + b" and a remark")
    assert "is there already" in str(mcsl(*words, out).exception)
    assert out.read_bytes() == first + b" and a remark"
    assert mcsl(*words, out, "--force").exit_code == 0
    assert out.read_bytes() == first
    assert mcsl(*words, out).exit_code == 0


@pytest.mark.parametrize("call", ["render", "report", "evaluate csv", "study", "timeline", "analyse"])
@pytest.mark.parametrize("place", ["folder", "no folder", "fifo", "nul", "long", "protected", "locked"])
def test_a_place_that_cannot_be_written_is_told_before_any_work(
    desk: Path, monkeypatch: pytest.MonkeyPatch, call: str, place: str
) -> None:
    monkeypatch.chdir(desk)
    words, suffix = CALLS[call]
    out = f"out{suffix or '.json'}"
    if place == "folder":
        Path(out).mkdir()
    elif place == "no folder":
        out = f"notes.html/{out}"
    elif place == "fifo":
        os.mkfifo(out)
    elif place == "nul":
        out = f"a\0{out}"
    elif place == "long":
        out = "x" * 300 + out
    elif place == "protected":
        Path(out).write_text("mine")
        Path(out).chmod(0o444)
    elif place == "locked":
        if not Path("/sys/kernel").is_dir():
            pytest.skip("there is no folder here that root cannot write to either")
        out = f"/sys/kernel/{out}"
    before = contents(desk) if place != "fifo" else None
    done = mcsl(*words, out)
    told = done.exit_code == 2 and "Error: " in done.output  # by click, a wrong call
    assert told or isinstance(done.exception, InputError | UsageError), done.exception
    assert place != "locked" or "Choose a place you may write to" in str(done.exception)
    assert before is None or contents(desk) == before
    assert not [p for p in desk.iterdir() if p.name.startswith(".mcsl")]


def test_two_outputs_of_one_run_are_two_files(desk: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(desk)
    done = mcsl("evaluate", "--study", "ratings.csv", "--csv", "same", "--json", "./same", "--force")
    assert done.exit_code != 0
    assert not Path("same").exists()


def test_a_simulation_leaves_a_recording_alone(desk: Path) -> None:
    shutil.copy2(desk / "a.mp4", desk / "cam2.mp4")
    before = contents(desk)
    words = ("simulate", desk, "--duration", "5", "--size", "160x120", "--cameras", "2", "--movements", "0")
    assert "is there already" in str(mcsl(*words).exception)
    assert contents(desk) == before
    (desk / "cam2.mp4").unlink()
    assert mcsl(*words).exit_code == 0
    made = contents(desk)
    assert mcsl(*words).exit_code == 0
    assert contents(desk).keys() == made.keys()
