"""How a coded picture is turned and mirrored for display."""

from __future__ import annotations

import struct
from math import atan2, degrees
from typing import Any

from av.sidedata.sidedata import SideDataContainer


def orientation_of(frame: Any) -> tuple[int, bool]:
    """What the display matrix of a decoded frame says, from the container or from the stream's own messages (SEI).

    Returns
    -------
    rotation, mirrored
        Degrees counter-clockwise, a multiple of 90; whether the coded picture is mirrored, left to right, before that.
    """
    # Not `frame.side_data`: that is kept in the frame and refers to it, and the two wait for the garbage collector.
    found = SideDataContainer(frame).get("DISPLAYMATRIX")  # pyright: ignore[reportCallIssue] its stub lacks the argument
    if found is None:
        return 0, False
    # Sixteen-bit fixed-point numbers a, b, u, c, d, v, x, y, w: a coded pixel right goes (a, b), one down goes (c, d).
    a, b, _, c, d, *_ = struct.unpack("=9i", bytes(found))
    mirrored = a * d - b * c < 0
    right, down = (-a, -b) if mirrored else (a, b)
    return round(degrees(atan2(-down, right)) / 90) * 90 % 360, mirrored
