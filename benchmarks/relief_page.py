"""The page of `benchmarks.relief`: figures of recordings as tables."""

from __future__ import annotations

import platform
from collections.abc import Mapping, Sequence
from datetime import date
from typing import Any

import numpy as np

from benchmarks.accuracy import table
from benchmarks.ideal_geometry import DRILL_S, SHIFT_WIDTH
from benchmarks.relief_baselines import CONSENSUS, FLOOR, SIGMA_PX, STIFFNESS, WIDTH

WAYS = ("plane", "best plane", "APAP", "spline", "flow", "surface")
FLAT = ("planar", "board")
VARIANTS = ("no", "manual", "best plane", "plane", "surface")
MOST_S = 7  # of CPU a pose, after the matches
ITF_PERCENT, SPEED_PERCENT = 20, -70  # over manual
Figures = Sequence[Mapping[str, Any]]


def markdown(found: Figures) -> str:
    """The page."""
    hilly = [f for f in found if f["name"] not in FLAT]
    flat = [f for f in found if f["name"] in FLAT]
    sections = [_head(hilly), _pooled(hilly), _worst(hilly), _flat(flat), _cost(hilly), _steadiness(hilly)]
    return "\n".join(line for section in sections if section for line in (*section, ""))


def goal(name: str) -> tuple[float, float, float]:
    """Median, rms and 95th percentile that the surface is to reach."""
    if name == "suturing":
        return 1.0, 2.5, 5.0
    return (0.7, 1.5, 3.0) if ":" in name else (0.4, 0.9, 2.0)


def reaches(figures: Mapping[str, Any]) -> bool:
    """Whether the surface does, over all views."""
    return all(a <= b for a, b in zip(figures["pooled"]["surface"], goal(figures["name"]), strict=True))


def worse(figures: Mapping[str, Any]) -> list[str]:
    """The views that the surface lays worse than the plane does, by rms."""
    rows = [v for v in figures["views"] if v["surface"][1] > v["plane"][1]]
    return [f"{v['camera']} in pose {v['pose']} ({v['plane'][1]:.2f} to {v['surface'][1]:.2f})" for v in rows]


def _three(values: Sequence[float]) -> str:
    return " / ".join(f"{v:.2f}" for v in values)


def _head(found: Figures) -> list[str]:
    rows = [[f["name"], f["scene"], len(f["reliefs"]), len(f["views"])] for f in found]
    reached = sum(map(reaches, found))
    bad = sum(len(worse(f)) for f in found)
    return [
        "# The relief against planes and other warps",
        "",
        f"Made by `python -m benchmarks.relief FOLDER` on {date.today().isoformat()}, {platform.machine()}, Python "
        f"{platform.python_version()}. Simulated recordings: 640x360, 10 frames a second, five cameras; plain ones "
        "have seeds alone, families theirs.",
        "",
        f"**{reached} of {len(found)} recordings reach their goals; {bad} of {sum(len(f['views']) for f in found)} "
        "views are worse than their plane.**",
        "",
        table(["", "scene", "poses", "views"], rows),
    ]


def _pooled(found: Figures) -> list[str]:
    rows = []
    for f in found:
        cells = [_three(f["pooled"][way]) if way in f["pooled"] else "–" for way in WAYS]
        cells[-1] = f"**{cells[-1]}**" if reaches(f) else cells[-1]
        rows.append([f["name"], *cells, _three(goal(f["name"])), "; ".join(worse(f)) or "none"])
    return [
        "## Displacement",
        "",
        "How far the field's true points lie from their place, the lamp standing, all views but the reference's own in "
        f"the first pose: median / rms / 95th percentile in pixels at {SHIFT_WIDTH} px width, the goal beside them "
        "(bold: reached). A view that a way has nothing for is laid by its plane.",
        "",
        "Plane: the analysis's homographies. Best plane: the single one that fits the truth best. APAP "
        "(as-projective-as-possible, Zaragoza et al. 2013) and spline (thin-plate, SciPy's): by the very matches of "
        "each camera with the reference that the relief's cameras are solved from, those within "
        f"{CONSENSUS:.0%} of the width of their plane; poses after the first over it by matches of every camera's own "
        f"views then and now. APAP: sigma {SIGMA_PX:g} px at {WIDTH}, floor {FLOOR:g}. Spline: over what the "
        f"homography leaves, smoothing {STIFFNESS:g} in half widths. Flow: pairwise, between medians, as the fill "
        "bends what has no relief. Surface: the programme's, by its relief.",
        "",
        table(["", *WAYS, "goal", "views worse than their plane (rms)"], rows),
    ]


def _worst(found: Figures) -> list[str]:
    rows = []
    for f in found:
        cells = []
        for way in WAYS:
            view = max(f["views"], key=lambda v, way=way: v[way][1], default=None)
            cells.append("–" if view is None else _three(view[way]))
        rows.append([f["name"], *cells])
    return ["## The worst view", "", "Of each way, by rms.", "", table(["", *WAYS], rows)]


def _flat(found: Figures) -> list[str]:
    if not found:
        return []
    rows = []
    for f in found:
        tied = len({v["camera"] for v in f["views"]})
        moved = [v["moved"] for v in f["views"]]
        far = _three(np.max(moved, axis=0)) if moved else "nothing is laid"
        plane, surface = (_three(f["pooled"][way]) if way in f["pooled"] else "–" for way in ("plane", "surface"))
        if f["name"] == "board":  # the board is moved about: no one plane of the pose
            plane = surface = "–"
        rows.append([f["name"], f["scene"], f"{tied} of {f['cameras'] - 1}", sum(f["reliefs"]), far, plane, surface])
    return [
        "## A plane stays a plane",
        "",
        "Real pictures. Moved: how far the surface lays points from where the plane does, the worst view; then how far "
        "either lays them from their true place.",
        "",
        table(["", "", "cameras tied", "with a relief", "moved by the surface", "plane", "surface"], rows),
    ]


def _cost(found: Figures) -> list[str]:
    known = [f for f in found if f["cost"]["seconds"]]
    rows = []
    for f in known:
        seconds, yardstick = np.array(f["cost"]["seconds"]), f["cost"]["yardstick"]
        times = f"{seconds.mean():.1f} / {seconds.max():.1f}"
        rows.append([f["name"], len(seconds), times, f"{yardstick:.2f}", f"{seconds.mean() / yardstick:.0f}"])
    return [
        "## Cost",
        "",
        "CPU seconds that the relief of a pose takes once its matches are found (adjustment of the cameras, tying to "
        f"the pose before, surface), mean / most (goal: {MOST_S} at most), and as a multiple of the yardstick: "
        "OpenCV's StereoSGBM, eight paths, 128 levels, of one pair of pictures of 960x540.",
        "",
        table(["", "poses", "CPU s", "yardstick", "times the yardstick"], rows),
    ]


def _steadiness(found: Figures) -> list[str]:
    known = [f for f in found if "steadiness" in f and f["steadiness"]["switches"]]
    if not known:
        return []
    rows = []
    for f in known:
        own = f["steadiness"]["rows"]
        cells = [_itf_speed(own.get(name)) for name in VARIANTS]
        rows.append([f["name"], f["steadiness"]["switches"], *cells, *(gain(f, which) for which in (0, 1))])
    return [
        "## At switches, by the paper's measures",
        "",
        f"ITF in dB / AvSpeed in pixels a frame at 640 px width, about the field (`mcsl evaluate`), in a cut that goes "
        f"every {DRILL_S} s to the next camera that sees it, the lamp standing. Manual: similarities from four clicked "
        f"pairs, 2 px off. Gain: surface over manual (goals: ITF {ITF_PERCENT:+} %, AvSpeed {SPEED_PERCENT:+} %). "
        "AvSpeed follows all points about the field, hands and instruments above it among them.",
        "",
        table(["", "switches", *VARIANTS, "ITF gain", "AvSpeed gain"], rows),
    ]


def _itf_speed(values: Sequence[float | None] | None) -> str:
    if values is None:
        return "–"
    itf, speed = (None if v is None else f"{v:.1f}" for v in values[:2])
    return f"{itf or 'no data'} / {speed or 'no data'}"


def gain(figures: Mapping[str, Any], which: int) -> str:
    """Surface over manual in per cent."""
    rows = figures["steadiness"]["rows"]
    manual, surface = (rows.get(name, [None] * 2)[which] for name in ("manual", "surface"))
    return "–" if not manual or surface is None else f"{100 * (surface / manual - 1):+.0f} %"
