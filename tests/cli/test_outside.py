"""EDLs whose media lie outside of their folder, as commands meet them: made here, allowed once, or from elsewhere."""

from pathlib import Path

import pytest
from click.testing import CliRunner

import mcsl_core as mcsl
from mcsl_core import edl as edls
from mcsl_core.cli.main import cli
from mcsl_core.errors import InputError
from mcsl_core.progress import Silent
from mcsl_core.simulation import Scenario, simulate


@pytest.fixture(scope="module")
def place(tmp_path_factory):
    """rec/ with the recording, edit/ with its EDL: the ordinary way of working."""
    top = tmp_path_factory.mktemp("place")
    simulate(Scenario(seed=5, duration_s=4, movements=0, size=(320, 180), cameras=2), top / "rec", Silent())
    done = run("analyse", top / "rec", "-o", top / "edit" / "edl.json")
    assert done.exit_code == 0
    return top


def run(*arguments):
    return CliRunner().invoke(cli, ["--progress", "none", *map(str, arguments)])


@pytest.fixture
def foreign(place, tmp_path):
    """The same document under another name, as one that somebody sent: it names the recording all the same."""
    path = tmp_path / "edl.json"
    films = {"../rec/": f"{place}/rec/"}
    text = (place / "edit" / "edl.json").read_text("utf-8")
    for old, new in films.items():
        text = text.replace(old, new)
    path.write_text(text, "utf-8")
    return path


def commands(edl: Path, out: Path):
    yield "look", edl
    yield "look", edl, "--no-fill"
    yield "remove", edl, "--range", "0:3"
    yield "conform", edl, "-o", out / "conformed"
    yield "export", edl, "-o", out / "cut.otio"
    yield "pull", out / "cut.otio", "--edl", edl
    yield "report", edl, "-o", out / "page.html"
    yield "evaluate", edl, "--json", out / "figures.json"
    yield "timeline", edl, "-o", out / "edit.blend"
    yield "render", edl, "-o", out / "film.mp4", "--engine", "direct"
    yield "render", edl, "-o", out / "film.mp4"


def test_what_was_analysed_here_goes_on_without_a_word(place):
    edl = place / "edit" / "edl.json"
    assert edls.load(edl).cameras[0].media[0].path.startswith("../rec/")
    assert run("look", edl).exit_code == 0
    assert mcsl.open(edl).frame(3).shape == (180, 320, 3)
    (place / "by link").symlink_to(place / "edit")
    assert run("look", place / "by link" / "edl.json").exit_code == 0


def test_every_command_refuses_one_from_elsewhere(foreign, tmp_path):
    before, text = set(tmp_path.rglob("*")), foreign.read_bytes()
    for command in commands(foreign, tmp_path / "out"):
        refused = run(*command)
        assert isinstance(refused.exception, InputError), command
        assert "leads out of the EDL's folder" in refused.exception.what
        assert "--allow-outside" in refused.exception.remedy
    with pytest.raises(InputError, match="leads out"):
        mcsl.open(foreign)
    assert set(tmp_path.rglob("*")) == before, "nothing is written"
    assert foreign.read_bytes() == text


def test_allowed_once_it_is_remembered(foreign):
    assert run("look", foreign, "--allow-outside").exit_code == 0
    assert run("look", foreign).exit_code == 0
    assert mcsl.open(foreign).frame(3).shape == (180, 320, 3)


def test_from_python(foreign):
    with mcsl.open(foreign, allow_outside=True) as programme:
        programme.frame(3)
        copy = programme.save(foreign.parent / "deeper" / "copy.json")
    assert mcsl.open(copy).edl.frames == mcsl.open(foreign).edl.frames


def test_the_old_edl_in_its_place_does_not_keep_a_new_analysis(place, tmp_path):
    foreign = tmp_path / "edl.json"
    foreign.write_text((place / "edit" / "edl.json").read_text("utf-8").replace("../rec/", "/nowhere/"), "utf-8")
    assert run("analyse", place / "rec", "-o", foreign).exit_code == 0
    assert run("look", foreign).exit_code == 0
