"""The page of `benchmarks.ideal`: figures of recordings as tables."""

from __future__ import annotations

import platform
from collections.abc import Mapping, Sequence
from datetime import date
from typing import Any

import numpy as np

from benchmarks.accuracy import table
from benchmarks.ideal_distance import HEADS
from benchmarks.ideal_geometry import AROUND, DRILL_S, JUMP_WIDTH, RAISED_MM, SHIFT_WIDTH

VARIANTS = ("no", "manual", "best plane", "plane", "surface", "see_through", "floor")
OCCASIONS = ("all", "standing", "moving", "switches", "heads")
PLACES = {
    "surface": "The field's surface alone, without hands (the ideal programme's, the chosen camera's), heads and arms",
    "bare": "The field without hands, heads and arms over it counted",
    "field": "The whole field, with the hands over it, which no alignment of the surface lays right",
}
WAYS = ("plane", "best plane", "surface")
Figures = Sequence[Mapping[str, Any]]


def markdown(found: Figures) -> str:
    """The page."""
    sections = [
        _head(found),
        _distance(found),
        _by_recording(found),
        _jumps(found),
        _moving(found),
        _displacements(found),
    ]
    return "\n".join(line for section in sections for line in (*section, ""))


def _there(found: Figures, key: str, names: Sequence[str]) -> list[str]:
    return [name for name in names if any(name in f[key] for f in found)]


def _head(found: Figures) -> list[str]:
    rows = [[f["name"], f["scene"], f["perspectives"], f["weak"]] for f in found]
    return [
        "# Distance to the ideal programme",
        "",
        f"Made by `python -m benchmarks.ideal FOLDER` on {date.today().isoformat()}, {platform.machine()}, Python "
        f"{platform.python_version()}. 640x360, 10 frames a second, five cameras, 12 s a pose.",
        "",
        "The ideal programme is what a camera would show that hung still where the reference camera stands in the "
        "first pose, with hands and instruments, without heads and arms (`mcsl simulate --ideal`). Variants are made "
        "by the compositor, without centering and fill, colours matched. Manual: similarities from four clicked pairs, "
        "2 px off. Best plane: fitted to the truth. Plane: the analysis's homographies. Floor: the truth's own surface "
        "and cameras with the same resampling, in movements, too; what it leaves is resampling, gloss and shade that "
        "each camera sees otherwise, heads that nobody looks past, and hands above the surface.",
        "",
        table(["", "scene", "perspectives", "weak"], rows),
    ]


def _distance(found: Figures) -> list[str]:
    lines = [
        "## Distance",
        "",
        "PSNR in dB / structure (SSIM after gain and offset are fitted), means over frames and then over recordings. "
        f"Switches: {AROUND} frames on either side of one, in a cut that goes every {DRILL_S} s to the next camera "
        "that sees the field, the lamp standing; the other columns are the analysis's own cut. Heads: frames in which "
        f"heads and arms leave less than {HEADS:.0%} of the chosen camera's field, the lamp standing.",
    ]
    for place, words in PLACES.items():
        rows = []
        for name in _variants(found):
            values = [[f["distance"][place].get(name, {}).get(o) for f in found] for o in OCCASIONS]
            rows.append([name, *map(_pair, values)])
        lines += ["", f"{words}:", "", table(["", *OCCASIONS], rows)]
    return lines


def _variants(found: Figures) -> list[str]:
    return [name for name in VARIANTS if any(name in f["distance"]["field"] for f in found)]


def _pair(values: Sequence[Sequence[float] | None]) -> str:
    known = [value for value in values if value]
    if not known:
        return "–"
    psnr, ssim = np.mean(known, axis=0)
    return f"{psnr:.1f} / {ssim:.3f}"


def _by_recording(found: Figures) -> list[str]:
    names, rows = _variants(found), []
    for f in found:
        cells = (f["distance"]["surface"].get(name, {}).get("switches") for name in names)
        rows.append([f["name"], f["distance"]["frames"]["switches"], *(f"{c[0]:.1f}" if c else "–" for c in cells)])
    return [
        "## At switches, by recording",
        "",
        "PSNR in dB of the field's surface.",
        "",
        table(["", "frames", *names], rows),
    ]


def _jumps(found: Figures) -> list[str]:
    rows = []
    for name in _there(found, "jumps", VARIANTS):
        every = np.array([jump for f in found for jump in f["jumps"].get(name, [])])
        if len(every):
            at, above = every.T
            rows.append([name, len(every), *(f"{v:.2f}" for v in (np.median(at), at.max(), np.median(above)))])
    return [
        "## Jumps at switches",
        "",
        f"How far the field's true points jump in the programme from the last frame before a switch to the first after "
        f"it in that cut, pixels at {JUMP_WIDTH} px width: of each switch the median. The floor is 0. Above: "
        f"points {RAISED_MM:.0f} mm above the field, as hands are.",
        "",
        table(["", "switches", "median", "largest", "above, median"], rows),
    ]


def _moving(found: Figures) -> list[str]:
    names, rows = _there(found, "moving", VARIANTS), []
    for f in found:
        if f["moving"]:
            rows.append([f["name"], *(" / ".join(f"{x:.1f}" for x in f["moving"].get(name, [])) for name in names)])
    return [
        "## Displacement while the lamp moves",
        "",
        "Of the field's true points in the chosen camera's picture, in every third frame of movements: median / rms / "
        f"95th percentile in pixels at {SHIFT_WIDTH} px width.",
        "",
        table(["", *names], rows),
    ]


def _displacements(found: Figures) -> list[str]:
    ways = _there(found, "pooled", WAYS)
    rows = []
    for f in found:
        worse = [v for v in f["views"] if "surface" in v and v["surface"][1] > v["plane"][1]]
        names = ", ".join(f"{v['camera']} in pose {v['pose']}" for v in worse) or "none"
        spreads = [" / ".join(f"{x:.2f}" for x in f["pooled"][way]) if way in f["pooled"] else "–" for way in ways]
        rows.append([f["name"], len(f["views"]), *spreads, *([names] if "surface" in ways else [])])
    heads = ["", "views", *ways, *(["worse than its plane"] if "surface" in ways else [])]
    return [
        "## Displacement",
        "",
        f"Of the field's true points from their place, the lamp standing: median / rms / 95th percentile in pixels at "
        f"{SHIFT_WIDTH} px width, all views but the reference's own in the first pose. By view: the figures in FOLDER.",
        "",
        table(heads, rows),
    ]
