# SPDX-License-Identifier: GPL-3.0-or-later
"""Overrides in the timeline seen from afar: marks that are never too narrow to be seen. No bpy."""

from __future__ import annotations

from collections.abc import Iterable

from mcsl_core.timing import FrameRange

LEAST_PX = 4


def marks(pieces: Iterable[FrameRange], left: float, scale: float, width: float) -> list[tuple[float, float]]:
    """Where marks over ``pieces`` begin and end in a window, those that touch joined.

    Parameters
    ----------
    pieces
        Programme frames, in order.
    left, scale
        Programme frame 0 in pixels from the window's left, and pixels a frame.
    width
        Of the window, in pixels: what lies outside is left out.
    """
    found: list[tuple[float, float]] = []
    for piece in pieces:
        begin = left + piece.start * scale
        end = max(left + piece.stop * scale, begin + LEAST_PX)
        if end < 0 or begin > width:
            continue
        if found and begin <= found[-1][1]:
            found[-1] = found[-1][0], max(end, found[-1][1])
        else:
            found.append((begin, end))
    return found
