"""Shifting the surgical field to the middle of the programme picture: a few keys, linear between them.

Offsets (dx, dy) are in programme pixels: a pixel that the anchor places at p is shown at p + (dx, dy).
"""

from __future__ import annotations

from collections.abc import Sequence
from math import ceil

import numpy as np
from attrs import field, frozen
from numpy.typing import NDArray

from mcsl_core.edl import CenteringKey
from mcsl_core.edl.resolve import ACCELERATION, EASE_S
from mcsl_core.timing import FrameRange

from .protocol import FieldPlace

_PIECES = 8  # straight pieces of one move: half of them speed up by equal steps, half slow down
_DIGITS, _SLACK_PX = 3, 0.04  # of the keys; what rounding them may add to a change of speed, as so much more way


def field_middle(mask: NDArray[np.bool_], scene_to_programme: NDArray[np.float64]) -> tuple[float, float] | None:
    """The median point of the field in programme pixels; None for an empty mask. ``mask``: (H, W) in scene pixels."""
    rows, columns = np.nonzero(mask)
    if not len(rows):
        return None
    x, y, w = scene_to_programme @ np.array([np.median(columns), np.median(rows), 1.0])
    return float(x / w), float(y / w)


@frozen
class FieldCenterer:
    """Brings the middle of the field near the middle of the picture, and moves as seldom and as little as that takes.

    A field within ``near`` of the middle stays where it is; one further off is brought to that distance. From one
    stretch to the next the picture glides, its speed never changing by more than `ACCELERATION` of the width from one
    frame to the next; a stretch too short for that keeps the offset of its neighbours.

    near, most: shares of the picture's width and height; a shift never takes more than ``most``, so that the view does
    not run out. ease_s: seconds that a move takes at least.
    """

    near: float = field(default=0.05)
    most: float = field(default=0.25)
    ease_s: float = field(default=EASE_S)
    name = "field"

    def centre(self, places: Sequence[FieldPlace], *, size: tuple[int, int], rate: float) -> tuple[CenteringKey, ...]:
        """Keys with rising frames; none where no stretch shows a field. ``size``: programme (width, height)."""
        held = [(place.range, self._offset(place.middle, size)) for place in places if place.middle is not None]
        held = [(piece, offset) for i, (piece, offset) in enumerate(held) if not i or offset != held[i - 1][1]]
        while held:
            moves = [_move(a, b, size[0], self.ease_s * rate) for a, b in zip(held, held[1:], strict=False)]
            late = next((i for i, move in enumerate(moves) if not _fits(i, moves, held)), None)
            if late is None:
                return _keys(held, moves)
            # The shorter of the two stretches that the move lies between gives way.
            gone = min(late, late + 1, key=lambda i: _length(i, held))
            del held[gone]
            held = [(piece, offset) for i, (piece, offset) in enumerate(held) if not i or offset != held[i - 1][1]]
        return ()

    def _offset(self, middle: tuple[float, float], size: tuple[int, int]) -> tuple[float, float]:
        dx, dy = (self._shift((extent - 1) / 2 - at, extent) for extent, at in zip(size, middle, strict=True))
        return dx, dy

    def _shift(self, away: float, extent: int) -> float:
        beyond = max(0.0, abs(away) - self.near * extent)
        # Even whole pixels: a picture that lies in place otherwise is then moved, not resampled, and keeps every bit.
        return float(np.sign(away) * (min(beyond, self.most * extent) // 2 * 2)) + 0.0  # no -0


Held = tuple[FrameRange, tuple[float, float]]


def _length(index: int, held: Sequence[Held]) -> int:
    """Frames until the next stretch begins."""
    stop = held[index + 1][0].start if index + 1 < len(held) else held[index][0].stop
    return stop - held[index][0].start


def _move(before: Held, after: Held, width: int, least: float) -> tuple[int, int]:
    """First and last frame of the move between two stretches, about the frame at which the second begins.

    With _PIECES pieces of n frames the speed changes by 4 / _PIECES**2 of the way over n frames each time.
    """
    way = max(abs(a - b) for a, b in zip(before[1], after[1], strict=True)) + _SLACK_PX
    frames = max(ceil(least / _PIECES), ceil(4 * way / _PIECES**2 / (ACCELERATION * width)), 1)
    start = after[0].start - frames * _PIECES // 2
    return start, start + frames * _PIECES


def _fits(index: int, moves: Sequence[tuple[int, int]], held: Sequence[Held]) -> bool:
    first = moves[index - 1][1] if index else held[0][0].start
    return moves[index][0] >= first and moves[index][1] < held[-1][0].stop


def _keys(held: Sequence[Held], moves: Sequence[tuple[int, int]]) -> tuple[CenteringKey, ...]:
    if not moves:
        return ((held[0][0].start, *held[0][1]),)
    keys: dict[int, tuple[float, float]] = {}
    for (_, a), (_, b), (start, stop) in zip(held, held[1:], moves, strict=False):
        for piece in range(_PIECES + 1):
            way = _way(piece)
            keys[start + (stop - start) * piece // _PIECES] = (
                round(a[0] + way * (b[0] - a[0]), _DIGITS),
                round(a[1] + way * (b[1] - a[1]), _DIGITS),
            )
    return tuple((frame, *keys[frame]) for frame in sorted(keys))


def _way(piece: int) -> float:
    """Share of the way after ``piece`` of the pieces: speeds 1, 3, 5, 7, 7, 5, 3, 1 and so on."""
    half = _PIECES // 2
    return piece**2 / (2 * half**2) if piece <= half else 1 - (_PIECES - piece) ** 2 / (2 * half**2)
