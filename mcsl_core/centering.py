"""Shifting the surgical field to the middle of the programme picture: a few keys, linear between them.

Offsets (dx, dy) are in programme pixels: a pixel that the anchor places at p is shown at p + (dx, dy).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from attrs import field, frozen
from numpy.typing import NDArray

from .edl import CenteringKey
from .timing import FrameRange


@frozen(eq=False)
class FieldPlace:
    """Where the field lies in the programme during a pose: (x, y) of its middle in programme pixels, or None."""

    range: FrameRange
    middle: tuple[float, float] | None


def field_middle(mask: NDArray[np.bool_], scene_to_programme: NDArray[np.float64]) -> tuple[float, float] | None:
    """The median point of the field in programme pixels; None for an empty mask. ``mask``: (H, W) in scene pixels."""
    rows, columns = np.nonzero(mask)
    if not len(rows):
        return None
    x, y, w = scene_to_programme @ np.array([np.median(columns), np.median(rows), 1.0])
    return float(x / w), float(y / w)


@frozen
class FieldCenterer:
    """Centres the middle of the field, once per pose, easing from one to the next where poses meet.

    most: share of the picture's width and height that a shift may at most take, so that the view never runs out.
    ease_s: seconds from one pose's offset to the next's.
    """

    most: float = field(default=0.25)
    ease_s: float = field(default=2.0)
    name = "field"

    def centre(self, places: Sequence[FieldPlace], *, size: tuple[int, int], rate: float) -> tuple[CenteringKey, ...]:
        """Keys with rising frames; none where no pose shows a field. ``size``: programme (width, height)."""
        offsets: list[tuple[FrameRange, float, float]] = []
        for place in places:
            if place.middle is not None:
                dx, dy = (
                    float(np.clip((extent - 1) / 2 - at, -self.most * extent, self.most * extent))
                    for extent, at in zip(size, place.middle, strict=True)
                )
                offsets.append((place.range, round(dx, 2), round(dy, 2)))
        keys: list[CenteringKey] = []
        ease = self.ease_s * rate / 2
        for piece, dx, dy in offsets:
            room = min(ease, len(piece) / 2 - 1)
            for frame in (round(piece.start + room), round(piece.stop - 1 - room)):
                if not keys or frame > keys[-1][0]:
                    keys.append((frame, dx, dy))
        return tuple(_thinned(keys))


def _thinned(keys: Sequence[CenteringKey]) -> list[CenteringKey]:
    """Without keys that hold what their neighbours already say."""
    kept: list[CenteringKey] = []
    for i, key in enumerate(keys):
        same_before = not kept or kept[-1][1:] == key[1:]
        same_after = i + 1 >= len(keys) or keys[i + 1][1:] == key[1:]
        if not (kept and same_before and same_after):
            kept.append(key)
    return kept
