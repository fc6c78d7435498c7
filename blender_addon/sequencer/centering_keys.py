# SPDX-License-Identifier: GPL-3.0-or-later
"""The keys of the Centering strip."""

from __future__ import annotations

import hashlib
from array import array
from collections.abc import Sequence
from typing import Any

from ..core.strip_plan import OffsetKey
from .compat import ends
from .curves import curve_at, keys_in, make_curve, path_of, set_keys
from .scene_properties import CENTERING_KEYS_HASH, role_of

AXES = ("x", "y")


def set_centering_keys(scene: Any, keys: Sequence[OffsetKey]) -> None:
    """The Centering strip's keys, in place of those it has: the preview moves at once."""
    for strip in centering_strips(scene):
        _set_keys(scene, strip, keys)
    scene[CENTERING_KEYS_HASH] = centering_keys_hash(scene)


def _set_keys(scene: Any, strip: Any, keys: Sequence[OffsetKey]) -> None:
    for axis in AXES:
        path = path_of(strip, f"offset_{axis}")
        curve = make_curve(scene, path) if keys else curve_at(scene, path)
        if curve is not None:
            set_keys(curve, [k.frame for k in keys], [getattr(k, axis) for k in keys], [k.hold for k in keys])
    if not keys:
        strip.transform.offset_x = strip.transform.offset_y = 0.0


def centering_strips(scene: Any) -> list[Any]:
    """The Centering strip, or the pieces an editor cut it to, in order of time."""
    return sorted((s for s in scene.sequence_editor.strips if role_of(s) == "centering"), key=ends)


def keyed_by_hand(scene: Any) -> bool:
    """Whether the keys are others than those that were written."""
    return scene.get(CENTERING_KEYS_HASH, "") not in ("", centering_keys_hash(scene))


def centering_keys_hash(scene: Any) -> str:
    """A hash of the Centering strip's keys; '' without any."""
    values = array("f")
    for strip in centering_strips(scene):
        for axis in AXES:
            curve = curve_at(scene, path_of(strip, f"offset_{axis}"))
            if curve is not None:
                values.extend(keys_in(curve))
    return hashlib.sha256(values.tobytes()).hexdigest()[:16] if values else ""
