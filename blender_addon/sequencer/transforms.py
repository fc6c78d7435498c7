# SPDX-License-Identifier: GPL-3.0-or-later
"""A strip's transform and its five numbers, and a camera strip set back to its automatic place."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from ..core.similarity import Transform
from .scene_properties import PLANNED_TRANSFORM, role_of

NUMBERS = ("offset_x", "offset_y", "scale_x", "scale_y", "rotation")  # of a strip's transform, in our order


def set_transform(strip: Any, transform: Transform) -> None:
    for name, number in zip(NUMBERS, transform_numbers(transform), strict=True):
        setattr(strip.transform, name, round(number, 9) + 0.0)  # far below a pixel, so that no field shows -0


def transform_numbers(transform: Transform) -> list[float]:
    """As the property PLANNED_TRANSFORM holds it, in the order of NUMBERS."""
    t = transform
    return [t.offset_x, t.offset_y, t.scale, t.height_scale, t.rotation]


def transform_from_numbers(numbers: Sequence[float]) -> Transform:
    """The inverse of `transform_numbers`."""
    x, y, scale, scale_y, rotation = map(float, numbers)
    return Transform(x, y, scale, rotation, None if scale == scale_y else scale_y)


def can_be_reset(strip: Any) -> bool:
    """Whether it is a camera strip that knows its automatic place."""
    return role_of(strip) == "camera" and strip.get(PLANNED_TRANSFORM) is not None


def reset_transform(strip: Any) -> None:
    """Back to where the analysis placed the camera: pulling then takes the correction away."""
    set_transform(strip, transform_from_numbers(strip[PLANNED_TRANSFORM]))
