"""The generated pages are what the code says, and the example in them is a valid EDL."""

from __future__ import annotations

import json
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from mcsl_core.edl import dumps, loads

ROOT = Path(__file__).parents[1]
DOCS = ROOT / "docs"


def generate(folder: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, str(folder / "docs" / "generate.py"), *arguments]
    return subprocess.run(command, capture_output=True, text=True, check=False)


def test_the_pages_are_up_to_date():
    checked = generate(ROOT, "--check")
    assert checked.returncode == 0, checked.stderr


@pytest.fixture
def copy(tmp_path: Path) -> Path:
    shutil.copytree(DOCS, tmp_path / "docs", ignore=shutil.ignore_patterns("images", "__pycache__"))
    shutil.copytree(ROOT / "mcsl_core", tmp_path / "mcsl_core", ignore=shutil.ignore_patterns("__pycache__"))
    for folder in ("examples", "render_presets"):
        shutil.copytree(ROOT / folder, tmp_path / folder)
    assert generate(tmp_path).returncode == 0  # these tests start from fresh pages, whatever lies in the tree
    return tmp_path


@pytest.mark.parametrize(
    "page",
    [
        "decisions/index.md",
        "hooks.md",
        "how-to/compare-detectors.md",
        "reference/command-line.md",
        "reference/edl.md",
        "reference/edl.schema.json",
        "reference/front-door.md",
        "reference/presets.md",
        "tutorials/notebook.md",
    ],
)
def test_a_page_changed_by_hand_or_missing_is_stale_and_is_written_again(copy: Path, page: str):
    path = copy / "docs" / page
    right = path.read_text("utf-8")
    changed = right[:-3] + "!" + right[-3:]
    for spoil in (lambda: path.write_text(changed, "utf-8"), path.unlink):
        if page == "hooks.md" and spoil == path.unlink:
            continue  # its introduction is written by hand: git has it
        spoil()
        checked = generate(copy, "--check")
        assert checked.returncode == 1
        assert checked.stderr == f"docs/{page} is stale: run python docs/generate.py\n"
        assert not path.exists() or path.read_text("utf-8") == changed, "--check writes nothing"
        written = generate(copy)
        assert (written.returncode, written.stdout) == (0, f"written: docs/{page}\n")
        assert path.read_text("utf-8") == right
        assert generate(copy, "--check").returncode == 0


def test_a_field_changed_in_the_classes_makes_the_pages_stale(copy: Path):
    source = copy / "mcsl_core" / "edl" / "schema.py"
    text = source.read_text("utf-8")
    assert "length of the programme" in text
    source.write_text(text.replace("length of the programme", "how long it is"), "utf-8")
    checked = generate(copy, "--check")
    assert checked.returncode == 1
    assert checked.stderr.splitlines() == [
        f"docs/reference/{name} is stale: run python docs/generate.py" for name in ("edl.md", "edl.schema.json")
    ]


def test_a_method_changed_in_a_protocol_makes_the_page_stale(copy: Path):
    source = copy / "mcsl_core" / "movement" / "protocol.py"
    text = source.read_text("utf-8")
    assert "-> Detection:" in text
    source.write_text(text.replace("-> Detection:", "-> list[Movement]:"), "utf-8")
    checked = generate(copy, "--check")
    assert (checked.returncode, checked.stderr) == (1, "docs/hooks.md is stale: run python docs/generate.py\n")


def test_the_example_is_a_valid_edl_in_canonical_form():
    text = re.findall(r"```json\n(.*?)```", (DOCS / "reference" / "edl.md").read_text("utf-8"), re.DOTALL)[-1]
    edl = loads(text)
    assert dumps(edl) == text
    assert edl.overrides
    assert edl.movements
    assert edl.poses[1].weak


def test_every_field_has_a_line_with_its_meaning():
    page = (DOCS / "reference" / "edl.md").read_text("utf-8")
    schema = json.loads((DOCS / "reference" / "edl.schema.json").read_text("utf-8"))
    for name, part in [("Edl", schema), *schema["$defs"].items()]:
        if name == "FrameRange":
            continue
        section = page.split(f"### {name}\n")[1].split("\n#")[0]
        for field in part["properties"]:
            row = next(line for line in section.splitlines() if line.startswith(f"| `{field}` |"))
            assert all(cell.strip() for cell in row.split("|")[1:5])


def test_a_changed_help_text_preset_or_notebook_makes_its_page_stale(copy: Path):
    changes = {
        "mcsl_core/cli/commands/report.py": ("The page (.html).", "Where the page goes.", "reference/command-line.md"),
        "render_presets/review.json": ("Small and quick", "Quick and small", "reference/presets.md"),
        "examples/compare_detectors.ipynb": (
            "One recording proves",
            "A recording proves",
            "how-to/compare-detectors.md",
        ),
    }
    for name, (before, after, _) in changes.items():
        text = (copy / name).read_text("utf-8")
        assert before in text
        (copy / name).write_text(text.replace(before, after), "utf-8")
    checked = generate(copy, "--check")
    assert checked.returncode == 1
    stale = {line.split()[0] for line in checked.stderr.splitlines()}
    assert stale == {f"docs/{page}" for _, _, page in changes.values()}
