#!/usr/bin/env python3
"""Asks public databases whether what requirements.lock pins has known holes.

    python tools/audit.py         (`nox -s audit` calls it)

pip-audit asks PyPI and OSV, by the names and versions of the packages alone. It ends with 1 where a hole is known. What
nobody answered for is named: a mirror of PyPI may have the packages without what is known of them, and pip-audit calls
that "no known vulnerabilities". Without a network it says so and ends with 0.
"""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
SERVICES = ("pypi", "osv")
ASK = (
    "-m",
    "uv",
    "tool",
    "run",
    "pip-audit",
    "--no-deps",
    "--disable-pip",
    "--format",
    "json",
    "-r",
    "requirements.lock",
)


def answer_of(service: str) -> tuple[list[dict[str, Any]], str]:
    """(what is known of each package, why nothing is)."""
    command = [sys.executable, *ASK, "--progress-spinner", "off", "--vulnerability-service", service]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True)
    try:
        known = json.loads(done.stdout)["dependencies"]
        return known, "" if any("vulns" in package for package in known) else "knows none of these versions"
    except (ValueError, KeyError):
        if "ConnectionError" in done.stderr:
            return [], "cannot be reached"
        lines = [line.strip() for line in done.stderr.splitlines() if line.strip()]
        return [], next((line for line in lines if line.startswith("error")), (lines or ["nothing was said"])[-1])


def verdict(answers: Mapping[str, list[dict[str, Any]]]) -> tuple[list[str], int, list[str]]:
    """(known holes, for how many packages there was an answer, the names of those without one)."""
    holes: dict[str, set[tuple[str, str]]] = {}
    answered, asked = set(), set()
    for packages in answers.values():
        for package in packages:
            asked.add(package["name"])
            if "vulns" not in package:
                continue
            answered.add(package["name"])
            for hole in package["vulns"]:
                mended = " or ".join(hole["fix_versions"]) or "no version yet"
                known_as = {(package["name"], name) for name in (hole["id"], *hole.get("aliases", []))}
                if not any(known_as & names for names in holes.values()):  # two databases, two names
                    holes[f"{package['name']} {package['version']}: {hole['id']}, mended in {mended}"] = known_as
    return sorted(holes), len(answered), sorted(asked - answered)


def main() -> int:
    answers, reasons = {}, []
    for service in SERVICES:
        answers[service], reason = answer_of(service)
        reasons += [f"{service}: {reason[:200]}"] * bool(reason)
    holes, answered, unanswered = verdict(answers)
    for line in holes:
        print(line)
    if not answered:
        print(f"nothing was audited: no database gives an answer here ({'; '.join(reasons)})")
    else:
        print(f"{len(holes)} known holes in {answered} packages")
        if unanswered:
            print(f"no answer for {len(unanswered)}: {', '.join(unanswered)}")
    return 1 if holes else 0


if __name__ == "__main__":
    sys.exit(main())
