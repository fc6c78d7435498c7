"""tools/audit.py: what is known, what nobody answered for, and what is said without a network."""

from __future__ import annotations

import os
import runpy
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

AUDIT = Path(__file__).parents[1] / "tools" / "audit.py"


def package(name: str, *holes: dict[str, Any]) -> dict[str, Any]:
    """As pip-audit 2.10 writes it."""
    return {"name": name, "version": "1.0", "vulns": list(holes)}


def hole(name: str, *fixed: str, aliases: tuple[str, ...] = ()) -> dict[str, Any]:
    return {"id": name, "fix_versions": list(fixed), "aliases": list(aliases), "description": ""}


SKIPPED = {"name": "a", "skip_reason": "Dependency not found on PyPI and could not be audited: a (1.0)"}


@pytest.mark.parametrize(
    ("answers", "told"),
    [
        ({"pypi": [package("a")], "osv": []}, ([], 1, [])),
        ({"pypi": [SKIPPED], "osv": []}, ([], 0, ["a"])),
        ({"pypi": [SKIPPED], "osv": [package("a")]}, ([], 1, [])),
        ({"pypi": [SKIPPED, package("b")], "osv": []}, ([], 1, ["a"])),
        (
            {"pypi": [package("a", hole("PYSEC-1", "1.1", "2.0", aliases=("CVE-1",)))], "osv": []},
            (["a 1.0: PYSEC-1, mended in 1.1 or 2.0"], 1, []),
        ),
        (
            {"pypi": [package("a", hole("PYSEC-1", aliases=("CVE-1",)))], "osv": [package("a", hole("CVE-1", "9"))]},
            (["a 1.0: PYSEC-1, mended in no version yet"], 1, []),
        ),
        (
            {"pypi": [package("a", hole("CVE-1")), package("b", hole("CVE-1"))]},  # one hole, in two packages
            (["a 1.0: CVE-1, mended in no version yet", "b 1.0: CVE-1, mended in no version yet"], 2, []),
        ),
        ({"pypi": [], "osv": []}, ([], 0, [])),
    ],
)
def test_holes_are_named_once_and_silence_is_no_answer(answers: dict[str, Any], told: object) -> None:
    assert runpy.run_path(str(AUDIT))["verdict"](answers) == told


def test_without_a_network_it_says_so_in_one_line(tmp_path: Path) -> None:
    offline = {**os.environ, "UV_OFFLINE": "1", "UV_CACHE_DIR": str(tmp_path)}
    done = subprocess.run([sys.executable, str(AUDIT)], env=offline, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert done.stderr == ""
    assert len(done.stdout.splitlines()) == 1
    assert done.stdout.startswith("nothing was audited: no database gives an answer here (pypi: ")
