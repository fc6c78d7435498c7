"""What a release says of itself in several files is the same in all of them, and its notes are where they belong."""

from __future__ import annotations

import re
import subprocess
import sys
import tomllib
from pathlib import Path

from mcsl_core import __version__

ROOT = Path(__file__).parents[1]


def newest() -> str:
    """The newest release in the changelog."""
    found = re.search(r"^## \[(.+?)\] - \d{4}-\d\d-\d\d$", (ROOT / "CHANGELOG.md").read_text("utf-8"), re.MULTILINE)
    assert found
    return found[1]


def test_the_version_is_the_same_wherever_it_is_written():
    """mcsl_core/__init__.py has it; the wheel takes it from there, these say it again."""
    manifest = tomllib.loads((ROOT / "blender_addon" / "blender_manifest.toml").read_text("utf-8"))
    citation = re.search(r"^version: (\S+)$", (ROOT / "CITATION.cff").read_text("utf-8"), re.MULTILINE)
    said = {
        "blender_addon/blender_manifest.toml": manifest["version"],
        "CITATION.cff": citation and citation[1],
        "CHANGELOG.md, the newest": newest(),
    }
    assert said == dict.fromkeys(said, __version__)


def test_a_fragment_becomes_a_line_of_the_changelog(tmp_path):
    """towncrier with our own settings, in a copy: the note stands under its heading, above the release before."""
    for name in ("pyproject.toml", "CHANGELOG.md"):
        (tmp_path / name).write_text((ROOT / name).read_text("utf-8"), "utf-8")
    (tmp_path / "changelog.d").mkdir()
    (tmp_path / "changelog.d" / "+louder.fixed.md").write_text("The sound is no longer too quiet.\n")
    command = [sys.executable, "-m", "towncrier", "build", "--yes", "--version", "9.8.7", "--date", "2030-01-02"]
    subprocess.run(command, cwd=tmp_path, check=True, capture_output=True)
    text = (tmp_path / "CHANGELOG.md").read_text("utf-8")
    release, before = text.index("## [9.8.7] - 2030-01-02"), text.index(f"## [{newest()}]")
    assert text[release:before].split("\n\n")[1:3] == ["### Fixed", "- The sound is no longer too quiet."]


def test_every_note_is_of_a_kind_that_towncrier_knows():
    """towncrier passes over any other in silence."""
    settings = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["tool"]["towncrier"]
    kinds = {kind["directory"] for kind in settings["type"]}
    names = [path.name for path in (ROOT / "changelog.d").iterdir() if path.name != "README.md"]
    assert not [name for name in names if not re.fullmatch(rf"[+\w-]+\.({'|'.join(kinds)})\.md", name)]


def test_decisions_are_numbered_once_and_without_a_gap():
    numbers = [path.name[:3] for path in sorted((ROOT / "docs" / "decisions").glob("[0-9]*.md"))]
    assert numbers == [f"{number:03}" for number in range(1, len(numbers) + 1)]
    for path in (ROOT / "docs" / "decisions").glob("[0-9]*.md"):
        assert path.read_text("utf-8").startswith(f"# {path.name[:3]}: "), path.name
