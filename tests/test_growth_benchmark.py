"""The arithmetic of `benchmarks.growth`, and what it reads of processes that really run."""

from __future__ import annotations

import subprocess
import sys
import xml.etree.ElementTree as ET
from pathlib import Path

import pytest

from benchmarks.growth import family
from benchmarks.growth_page import chart, line, section, stages

X = {"1 h": 1.0, "2 h": 2.0, "3 h": 3.0, "4 h": 4.0}
SPAWNS = """
import subprocess, sys
child = subprocess.Popen([sys.executable, "-c", "sum(range(20_000_000)); print(1, flush=True); input()"])
child.wait()
"""


def figures(cpu_s: list[float]) -> dict:
    """Of an analysis with a stage that takes 10 s, one that takes the rest, and one that hardly takes anything."""
    points = [
        {"cpu_s": s, "mib": 200.0, "poses": n, "stages": {"A": 10.0, "B": s - 10.1, "C": 0.1}}
        for n, s in enumerate(cpu_s)
    ]
    return {"analyse": points}


def test_a_line_is_found_and_straight() -> None:
    found = line([1, 2, 3, 4], [12, 14, 16, 18])
    assert (found.at_zero, found.slope) == pytest.approx((10, 2))
    assert found.r2 == pytest.approx(1)
    assert found.worst == pytest.approx(0, abs=1e-9)
    assert found.straight
    assert 0 < found.exponent < 1  # of what it has at zero


@pytest.mark.parametrize("power", [1.0, 2.0, 3.0])
def test_a_power_is_found_and_only_the_first_is_straight(power: float) -> None:
    x = [3, 4, 5, 6, 7, 8]
    found = line(x, [2 * v**power for v in x])
    assert found.exponent == pytest.approx(power)
    assert found.straight == (power == 1)


def test_how_far_a_point_is_off_the_line() -> None:
    """By hand: (0, 3, 3) off 1, 2, 3 has the line 1.5 x - 1, so 0.5, 2 and 3.5."""
    found = line([1, 2, 3], [0.001, 3, 3])
    assert found.worst == pytest.approx(0.998, abs=1e-3)
    assert found.r2 == pytest.approx(0.75, abs=1e-3)


def test_small_stages_are_the_rest_and_nothing_is_lost() -> None:
    points = figures([20, 40, 80])["analyse"]
    found = stages(points)
    assert list(found) == ["A", "B", "the rest"]
    assert found["the rest"] == pytest.approx([0.1] * 3)
    assert [sum(s) for s in zip(*found.values(), strict=True)] == pytest.approx([20, 40, 80])


def test_the_page_says_which_stage_is_not_straight() -> None:
    text = "\n".join(section("length", "hours", X, figures([20, 40, 120, 400])))
    rows = [[cell.strip() for cell in row.split("|")[1:-1]] for row in text.splitlines() if row.startswith("| analyse")]
    verdicts = {row[1]: row[-1] for row in rows if row[1] in "AB"}
    assert verdicts == {"A": "yes", "B": "no"}
    assert ["analyse", "CPU s", "20", "40", "120", "400"] in rows


def test_the_chart_has_every_point_where_it_belongs() -> None:
    root = ET.fromstring(chart({"length": (X, figures([20, 40, 60, 80]))}))
    own = "{http://www.w3.org/2000/svg}"
    time, memory = root.findall(f"{own}g")
    circles = [(float(c.attrib["cx"]), float(c.attrib["cy"])) for c in time.findall(f"{own}circle")]
    (x0, y0), *_, (x1, y1) = circles
    for n, (x, y) in enumerate(circles):  # straight: evenly from the first to the last
        assert (x, y) == pytest.approx((x0 + (x1 - x0) * n / 3, y0 + (y1 - y0) * n / 3), abs=0.1)
    assert y1 < y0
    assert len({c.attrib["cy"] for c in memory.findall(f"{own}circle")}) == 1


@pytest.mark.skipif(not Path("/proc/self/stat").exists(), reason="reads Linux's /proc")
def test_what_a_process_has_started_counts() -> None:
    process = subprocess.Popen([sys.executable, "-c", SPAWNS], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
    assert process.stdout is not None
    assert process.stdout.readline() == "1\n"  # of the child
    (own, _), (child, used) = family(process.pid)
    assert own == process.pid != child
    assert used > 0.1
    process.communicate("\n")
    assert family(process.pid) == []
