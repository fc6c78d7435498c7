"""Times as people write them on the command line: read, or refused at once; never a decision in the wrong place."""

from __future__ import annotations

from pathlib import Path

import pytest
from builders import small_edl
from click.testing import CliRunner

from mcsl_core import edl as edls
from mcsl_core.cli.main import cli
from mcsl_core.errors import UsageError
from mcsl_core.timing import FrameRange


def look(edl: Path, *arguments: str) -> None:
    done = CliRunner().invoke(cli, ["look", str(edl), *arguments], standalone_mode=False)
    if done.exception is not None:
        raise done.exception


@pytest.fixture
def edl(tmp_path: Path) -> Path:
    path = tmp_path / "edl.json"
    edls.save(small_edl(300), path)
    return path


@pytest.mark.parametrize("start", ["0:00:02", "0:02.0", "2", "2,0", " 2 ", "00:00:02,000"])
def test_a_stretch_begins_where_its_time_says(edl: Path, start: str) -> None:
    look(edl, "--from", start, "--no-fill")
    now = edls.load(edl)
    assert now.overrides[-1].range == FrameRange(round(2 * now.rate), 300)


@pytest.mark.parametrize("option", ["--from", "--to"])
@pytest.mark.parametrize(
    "text", ["1e999999999", "1e999999", "1/3", "1_0", "1:-30", "nan", "", "soon", "1:2:3:4", "9" * 5000]
)
def test_what_is_no_time_is_refused_at_once(edl: Path, option: str, text: str) -> None:
    """The first of these never came back, the second was an internal error."""
    before = edl.read_bytes()
    with pytest.raises(UsageError, match=r"is no time. Write 1:02:03.5, 2:30 or seconds"):
        look(edl, f"{option}={text}", "--no-fill")
    assert edl.read_bytes() == before
