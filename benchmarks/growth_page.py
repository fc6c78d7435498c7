"""The page and the picture of `benchmarks.growth`."""

from __future__ import annotations

import os
import platform
from collections.abc import Mapping, Sequence
from datetime import date
from typing import Any

import numpy as np
from attrs import frozen

from benchmarks.accuracy import table

STRAIGHT = 0.1
"""Of the line: a series that misses it nowhere by more is straight."""
SHOWN = 0.05  # of a command's CPU seconds: stages that have less at every point are summed up
MEASURES = {"cpu_s": "CPU s", "mib": "MiB"}
COLOURS = {"analyse": "#2a6fbb", "conform": "#bb4a2a"}
PANEL = (300, 230)  # pixels of the chart's panels

Figures = Mapping[str, Sequence[Mapping[str, Any]]]  # command -> what each point took, in order


@frozen
class Line:
    """A straight line through points of positive numbers, and how well it does.

    Attributes
    ----------
    at_zero, slope : float
        y = at_zero + slope x, by least squares.
    r2 : float
        Share of the variance of y that it explains.
    worst : float
        Most that it misses a point by, of its own value there.
    exponent : float
        k of y ~ x^k, by least squares on logarithms; less than 1 where a part of y does not grow.
    """

    at_zero: float
    slope: float
    r2: float
    worst: float
    exponent: float

    @property
    def straight(self) -> bool:
        """Whether it misses no point by more than `STRAIGHT`."""
        return self.worst <= STRAIGHT


def line(x: Sequence[float], y: Sequence[float]) -> Line:
    """The line through two points or more."""
    at, found = np.asarray(x, float), np.asarray(y, float)
    slope, at_zero = (float(v) for v in np.polyfit(at, found, 1))
    expected = at_zero + slope * at
    spread = float(np.square(found - found.mean()).sum())
    return Line(
        at_zero,
        slope,
        1 - float(np.square(found - expected).sum()) / spread if spread else 1.0,
        float(np.max(np.abs(found / expected - 1))),
        float(np.polyfit(np.log(at), np.log(found), 1)[0]),
    )


def stages(points: Sequence[Mapping[str, Any]]) -> dict[str, list[float]]:
    """CPU seconds of each stage at every point, and of "the rest"."""
    names = dict.fromkeys(name for p in points for name in p["stages"])
    found = {name: [p["stages"].get(name, 0.0) for p in points] for name in names}
    shown = {n: v for n, v in found.items() if any(s > SHOWN * p["cpu_s"] for s, p in zip(v, points, strict=True))}
    rest = [p["cpu_s"] - sum(v[i] for v in shown.values()) for i, p in enumerate(points)]
    return shown | {"the rest": rest}


def section(name: str, unit: str, x: Mapping[str, float], figures: Figures) -> list[str]:
    """A series' tables: what each point took, its lines, and where the CPU seconds went."""
    measured, fits, split = [], [], []
    at = list(x.values())
    for command, points in figures.items():
        for key, measure in MEASURES.items():
            y = [p[key] for p in points]
            measured.append([command, measure, *(f"{v:.0f}" for v in y)])
            fits.append([command, measure, *_fitted(line(at, y))])
        for stage, y in stages(points).items():
            fit = _fitted(line(at, y)) if min(y) > 0 else ["", "", "", "", ""]
            split.append([command, stage, *(f"{v:.1f}" for v in y), *fit[1:]])
    poses = [p["poses"] for p in figures["analyse"]]
    measured.append(["", "poses", *poses])
    how = ["exponent", "R²", "most off", "straight"]
    return [
        f"## {name.capitalize()}",
        "",
        table(["", "", *x], measured),
        "",
        table(["", "", f"a + b x, x in {unit}", *how], fits),
        "",
        "CPU seconds by stage:",
        "",
        table(["", "stage", *x, *how], split),
        "",
    ]


def _fitted(found: Line) -> list[str]:
    return [
        f"{found.at_zero:.0f} {'-' if found.slope < 0 else '+'} {abs(found.slope):.3g} x",
        f"{found.exponent:.2f}",
        f"{found.r2:.3f}",
        f"{found.worst:.0%}",
        "yes" if found.straight else "no",
    ]


def markdown(sections: Sequence[str], intro: Sequence[str]) -> str:
    """The page of all series."""
    made = (
        f"Made by `python -m benchmarks.growth FOLDER` on {date.today().isoformat()}, {platform.machine()}, "
        f"{os.cpu_count()} cores, Python {platform.python_version()}."
    )
    return "\n".join(["# Growth", "", made, *intro, "", "![Growth](growth.svg)", "", *sections])


def chart(series: Mapping[str, tuple[Mapping[str, float], Figures]]) -> str:
    """A row a measure, a panel a series: points, and the line through those of each command."""
    width, height = PANEL[0] * len(series), PANEL[1] * len(MEASURES)
    lines = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" font-family="sans-serif" '
        'font-size="11">',
        f'<rect width="{width}" height="{height}" fill="white"/>',
    ]
    for column, (name, (x, figures)) in enumerate(series.items()):
        for row, (key, measure) in enumerate(MEASURES.items()):
            lines.append(f'<g transform="translate({PANEL[0] * column},{PANEL[1] * row})">')
            lines += _panel(f"{measure}, by {name}", x, {c: [p[key] for p in ps] for c, ps in figures.items()})
            lines.append("</g>")
    return "\n".join([*lines, "</svg>", ""])


def _panel(title: str, x: Mapping[str, float], by_command: Mapping[str, Sequence[float]]) -> list[str]:
    width, height = PANEL
    left, right, top, bottom = 46, width - 16, 30, height - 34
    far, most = max(x.values()), 1.1 * max(v for y in by_command.values() for v in y)

    def place(at: float, value: float) -> tuple[float, float]:
        return left + (right - left) * at / far, bottom - (bottom - top) * value / most

    lines = [
        f'<text x="{left}" y="16" font-weight="bold">{title}</text>',
        f'<path d="M{left} {top}V{bottom}H{right}" fill="none" stroke="#888"/>',
        f'<text x="{left - 4}" y="{bottom}" text-anchor="end">0</text>',
        f'<text x="{left - 4}" y="{top + 8}" text-anchor="end">{most:.0f}</text>',
    ]
    for number, (label, at) in enumerate(x.items()):
        low = bottom + (14 if number % 2 == 0 else 26)  # so that names of near points do not touch
        lines.append(f'<text x="{place(at, 0)[0]:.1f}" y="{low}" text-anchor="middle">{label}</text>')
    for number, (command, y) in enumerate(by_command.items()):
        colour, found = COLOURS[command], line(list(x.values()), y)
        (x0, y0), (x1, y1) = (place(at, max(0.0, found.at_zero + found.slope * at)) for at in (min(x.values()), far))
        lines.append(
            f'<line x1="{x0:.1f}" y1="{y0:.1f}" x2="{x1:.1f}" y2="{y1:.1f}" stroke="{colour}" stroke-dasharray="4 3"/>'
        )
        for at, value in zip(x.values(), y, strict=True):
            cx, cy = place(at, value)
            lines.append(f'<circle cx="{cx:.1f}" cy="{cy:.1f}" r="3.5" fill="{colour}"/>')
        lines.append(f'<text x="{right - 60 * number}" y="16" text-anchor="end" fill="{colour}">{command}</text>')
    return lines
