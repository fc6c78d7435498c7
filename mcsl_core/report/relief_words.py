"""What the report says of a pose's relief: which cameras it is of, how much it is sure of, or why there is none."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from mcsl_core.edl import Edl, Pose
from mcsl_core.edl.resolve import resolve

SURE = 0.5  # of confidence, 0..1: there the surface counts for more than the plane


def relief_words(edl: Edl, pose: Pose) -> str:
    """Which cameras the relief is of, how much of the picture it is sure of, or why the pose is a plane."""
    if pose.relief is None:
        return f"The scene is taken as a plane{_why_plane(edl, pose)}."
    of = [c.name for c in edl.cameras if c.name in pose.relief.projections]
    others = [c.name for c in edl.cameras if c.name in pose.homographies and c.name not in pose.relief.projections]
    sure = float((np.array(pose.relief.confidence) >= 100 * SURE).mean())
    told = f"The scene's relief, from {_listed(of)}, is known in {sure:.0%} of the picture"
    kept = f"; {_listed(others)} keep{'s' if len(others) == 1 else ''} the plane" if others else ""
    looks = {decision.surface for piece, decision in resolve(edl) if piece.intersection(pose.range)}
    unused = {True: "", False: " The look has surface off: pictures go by the plane."}[any(looks)]
    partly = " The look has surface off in a part of it." if len(looks) == 2 else ""
    return f"{told}{kept}.{unused}{partly}"


def _why_plane(edl: Edl, pose: Pose) -> str:
    plugins = edl.made_by.plugins if edl.made_by else {}
    if len(pose.homographies) < 2:
        return ": fewer than two cameras are aligned"
    if not plugins:
        return ""
    if "relief" not in plugins:
        return ": the analysis did not look for a relief"
    if plugins["relief"].split(" ")[0] == "plane":
        return ": the analysis was told to (--relief plane)"
    return ": the cameras show no relief that they agree on"


def _listed(names: Iterable[str]) -> str:
    *first, last = names
    return f"{', '.join(first)} and {last}" if first else last
