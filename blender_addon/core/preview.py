# SPDX-License-Identifier: GPL-3.0-or-later
"""Which previews corners and centres can be clicked in, and what a click there leaves to Blender. No bpy."""

from __future__ import annotations

from enum import Enum

_MOVES = frozenset(
    ("MIDDLEMOUSE", "WHEELUPMOUSE", "WHEELDOWNMOUSE", "TRACKPADPAN", "TRACKPADZOOM", "MOUSEROTATE", "HOME")
)


class Shows(Enum):
    """What a preview region shows."""

    NOTHING = "nothing"
    PROGRAMME = "programme"
    CHANNEL = "channel"


def shows(view: str, size: tuple[int, int], channel: int, centering: int | None) -> Shows:
    """What a preview shows.

    Parameters
    ----------
    view
        The editor's view type. In plain timeline view the preview is there as well, hidden.
    size
        The region's width and height.
    channel
        The channel it shows, with those below; 0 shows all.
    centering
        The channel of the Centering strip; None without one. Below it pictures lie where cameras saw them, not where
        the programme has them.
    """
    if view == "SEQUENCER" or min(size) <= 1:
        return Shows.NOTHING
    if channel != 0 and centering is not None and channel < centering:
        return Shows.CHANNEL
    return Shows.PROGRAMME


def moves_view(event: str) -> bool:
    """Whether an event of this type zooms or pans."""
    return event in _MOVES or event.startswith("NDOF_")
