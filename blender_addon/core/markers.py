# SPDX-License-Identifier: GPL-3.0-or-later
"""Markers where the lamp begins and ends to move, and where perspectives begin. No bpy."""

from __future__ import annotations

from itertools import pairwise

from attrs import frozen

from mcsl_core.edl import Edl, Pose


@frozen
class MarkerPlan:
    """A marker and its text."""

    frame: int
    name: str


def markers_of(edl: Edl) -> tuple[MarkerPlan, ...]:
    """A label stands where the lamp has come to rest, the others have none.

    Blender cuts labels off at the next marker: there is no room where the lamp begins to move, nor while it does.
    """
    new = {after.range.start: after.perspective for before, after in pairwise(edl.poses) if _other(before, after)}
    names = dict.fromkeys(new, "")
    alone = dict(new)
    for movement in edl.movements:
        turned = [start for start in new if movement.range.start <= start <= movement.range.stop]
        last = movement.range.stop if movement.range.stop < edl.frames else movement.range.start
        names[movement.range.start] = ""
        names[last] = f"perspective {new[turned[-1]]}" if turned else "lamp moved"
        for start in turned:
            alone.pop(start, None)
    names |= {start: f"perspective {number}" for start, number in alone.items()}
    return tuple(MarkerPlan(frame, names[frame]) for frame in sorted(names))


def _other(before: Pose, after: Pose) -> bool:
    return after.perspective != before.perspective
