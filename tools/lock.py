#!/usr/bin/env python3
"""Writes requirements.lock: every package of mcsl, its plugins and the tools, pinned with the hashes of its files.

    python tools/lock.py          (`python3 dev.py lock` calls it)

One file for all systems and Pythons we support; pip installs it with --require-hashes. It names no index, so that
it installs from whichever one pip is set up with. bpy has an environment of its own and is not in it.
"""

from __future__ import annotations

import subprocess
import sys
import tomllib
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
LOCK = ROOT / "requirements.lock"
EXTRAS = ("test", "archive", "docs", "examples", "dev")
HEAD = "# Written by tools/lock.py (`python3 dev.py lock`); what is wanted stands in pyproject.toml.\n"


def main() -> int:
    projects = [ROOT / "pyproject.toml", *sorted(ROOT.glob("plugins/*/pyproject.toml"))]
    wanted = [
        f"-e .[{','.join(EXTRAS)}]",
        *(f"-e ./{path.parent.relative_to(ROOT).as_posix()}" for path in projects[1:]),
    ]
    command = [sys.executable, "-m", "uv", "pip", "compile", "-", "--universal", "--python-version", "3.11"]
    command += ["--fork-strategy", "fewest"]  # one version for all Pythons: what CI tests is what everybody has
    command += ["--upgrade", "--generate-hashes", "--no-header", "--no-annotate", "--no-emit-index-url", "--quiet"]
    for path in projects:
        command += ["--no-emit-package", tomllib.loads(path.read_text("utf-8"))["project"]["name"]]
    done = subprocess.run(command, input="\n".join(wanted), cwd=ROOT, stdout=subprocess.PIPE, text=True)
    if done.returncode:
        print(f"tools/lock.py: {LOCK.name} stays as it was (uv's words stand above)", file=sys.stderr)
        return 1
    LOCK.write_text(HEAD + done.stdout, "utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
