#!/usr/bin/env python3
"""Makes sure that mcsl finds a Blender and that the system has the libraries it links against.

    python tools/bring_blender.py             where none is found, one as a Python module (`mcsl blender install`)
    python tools/bring_blender.py --oldest    the oldest supported one beside it, for the tests that run in both

Run in the project's environment; `python3 dev.py setup` does so. Quick when all is there.
"""

from __future__ import annotations

import ctypes
import os
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
if str(ROOT) not in sys.path:
    sys.path.insert(0, str(ROOT))

import dev  # noqa: E402
from mcsl_core.blender.installation import PACKAGES, find  # noqa: E402
from mcsl_core.errors import BlenderError  # noqa: E402

OLDEST = "4.5"


def say(text: str) -> None:
    print(f"tools/bring_blender.py: {text}", flush=True)


def kind_found() -> str:
    """How the Blender that mcsl finds is run (a binary, a Python module); nothing where it finds none."""
    try:
        return find().kind
    except BlenderError:
        return ""


def lacking() -> list[str]:
    """The Debian packages of the shared objects that do not load here."""
    packages = set()
    for library, package in PACKAGES.items():
        try:
            ctypes.CDLL(library)
        except OSError:
            packages.add(package)
    return sorted(packages)


def install(*arguments: str) -> bool:
    mcsl = Path(sys.executable).with_name("mcsl")
    return subprocess.run([str(mcsl), "blender", "install", *arguments]).returncode == 0


def bring() -> int:
    kind = kind_found()
    linked = sys.platform == "linux" and kind != "binary"  # a binary came with a package of its own
    packages = lacking() if linked else []
    if packages:
        try:
            dev.install_system_packages(packages, "Blender needs system libraries")
        except dev.Failure as failure:  # it may do without some of them; where it does not, it says so itself
            say(str(failure))
    if not kind:
        say("bringing Blender as a Python module (several hundred megabytes, once)")
        if not install():
            say("Blender could not be brought; `python3 dev.py mcsl blender` says more")
            return 1
    say(f"ready: {Path(sys.executable).parent}")
    return 0


def bring_oldest() -> int:
    """Without it the tests that want it are skipped (where MCSL_TESTS_BOTH_BLENDERS=1 they fail): never an error."""
    if not os.environ.get("MCSL_BLENDER_OLDEST") and not install("--version", OLDEST):
        say(f"without Blender {OLDEST} the tests that want it are skipped")
    return 0


if __name__ == "__main__":
    sys.exit(bring_oldest() if sys.argv[1:] == ["--oldest"] else bring())
