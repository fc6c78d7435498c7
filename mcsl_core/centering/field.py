"""Shifting the surgical field to the middle of the programme picture: a few keys, linear between them.

Offsets (dx, dy) are in programme pixels: a pixel that the anchor lays at p is shown at p + (dx, dy).
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from math import ceil

import numpy as np
from attrs import field, frozen
from numpy.typing import NDArray

from mcsl_core.edl import CenteringKey
from mcsl_core.edl.resolve import ACCELERATION, EASE_S
from mcsl_core.timing import FrameRange

from .protocol import FieldPosition

_PARTS = 8  # straight parts of one move: half of them speed up by equal steps, half slow down
_DIGITS, _SLACK_PX = 3, 0.04  # of the keys; what rounding them may add to a change of speed, as so much more way


@frozen
class FieldCenterer:
    """Brings the middle of the field near the middle of the picture, and moves as seldom and as little as that takes.

    Attributes
    ----------
    near : float
        A field within this share of the picture's width and height of the middle stays where it is; one further off is
        brought to that distance.
    most : float
        A shift never takes more than this share of either, so that the picture does not run out.
    ease_s : float
        Seconds that a move takes at least.

    Notes
    -----
    From one range to the next the picture glides, its speed never changing by more than `ACCELERATION` of the width
    from one frame to the next; a range too short for that keeps the offset of its neighbours.

    References
    ----------
    The paper's section "Centering Surgical Field", which shifts every frame by gaze; keys are ours.
    """

    near: float = field(default=0.05)
    most: float = field(default=0.25)
    ease_s: float = field(default=EASE_S)
    name = "field"

    def centre(
        self, positions: Sequence[FieldPosition], *, size: tuple[int, int], rate: float
    ) -> tuple[CenteringKey, ...]:
        """Chooses the keys of the shift; see `Centerer.centre`. None where no range shows a field."""
        holds = [_Hold(p.range, self._offset(p.middle, size)) for p in positions if p.middle is not None]
        holds = _without_repeats(holds)
        while holds:
            moves = [_move(before, after, size[0], self.ease_s * rate) for before, after in pairwise(holds)]
            late = next((i for i in range(len(moves)) if not _fits(i, moves, holds)), None)
            if late is None:
                return _keys(holds, moves)
            # The shorter of the two ranges that the move lies between gives way.
            del holds[min(late, late + 1, key=lambda i: _length(i, holds))]
            holds = _without_repeats(holds)
        return ()

    def _offset(self, middle: tuple[float, float], size: tuple[int, int]) -> tuple[float, float]:
        x, y = middle
        width, height = size
        return self._shift((width - 1) / 2 - x, width), self._shift((height - 1) / 2 - y, height)

    def _shift(self, away: float, extent: int) -> float:
        beyond = max(0.0, abs(away) - self.near * extent)
        # Even whole pixels: a picture that lies as it is otherwise is then moved, not resampled, and keeps every bit.
        return float(np.sign(away) * (min(beyond, self.most * extent) // 2 * 2)) + 0.0  # no -0


def field_middle(mask: NDArray[np.bool_], to_programme: NDArray[np.float64]) -> tuple[float, float] | None:
    """The middle of the field in the programme.

    Parameters
    ----------
    mask : (H, W) bool array
        The field in aligned pixels.
    to_programme : (3, 3) array
        Aligned pixel -> programme pixel.

    Returns
    -------
    (float, float) or None
        (x, y) of its median point in programme pixels; None for an empty mask.
    """
    rows, columns = np.nonzero(mask)
    if not len(rows):
        return None
    x, y, w = to_programme @ np.array([np.median(columns), np.median(rows), 1.0])
    return float(x / w), float(y / w)


@frozen
class _Hold:
    """A range over which the offset stays."""

    range: FrameRange
    offset: tuple[float, float]


def _without_repeats(holds: Sequence[_Hold]) -> list[_Hold]:
    """Without those whose offset is that of the one before."""
    return [hold for i, hold in enumerate(holds) if i == 0 or hold.offset != holds[i - 1].offset]


def _length(index: int, holds: Sequence[_Hold]) -> int:
    """Frames until the next hold begins."""
    stop = holds[index + 1].range.start if index + 1 < len(holds) else holds[index].range.stop
    return stop - holds[index].range.start


def _move(before: _Hold, after: _Hold, width: int, least: float) -> tuple[int, int]:
    """First and last frame of the move between two holds, about the frame at which the second begins.

    With _PARTS parts of n frames the speed changes by 4 / _PARTS**2 of the way over n frames each time.
    """
    way = max(abs(a - b) for a, b in zip(before.offset, after.offset, strict=True)) + _SLACK_PX
    frames = max(ceil(least / _PARTS), ceil(4 * way / _PARTS**2 / (ACCELERATION * width)), 1)
    start = after.range.start - frames * _PARTS // 2
    return start, start + frames * _PARTS


def _fits(index: int, moves: Sequence[tuple[int, int]], holds: Sequence[_Hold]) -> bool:
    """Whether a move begins after the one before has ended, and ends within the programme."""
    start, stop = moves[index]
    free_from = moves[index - 1][1] if index else holds[0].range.start
    return start >= free_from and stop < holds[-1].range.stop


def _keys(holds: Sequence[_Hold], moves: Sequence[tuple[int, int]]) -> tuple[CenteringKey, ...]:
    if not moves:
        return ((holds[0].range.start, *holds[0].offset),)
    keys: dict[int, tuple[float, float]] = {}
    for (before, after), (start, stop) in zip(pairwise(holds), moves, strict=True):
        (x, y), (to_x, to_y) = before.offset, after.offset
        for part in range(_PARTS + 1):
            way = _way(part)
            offset = round(x + way * (to_x - x), _DIGITS), round(y + way * (to_y - y), _DIGITS)
            keys[start + (stop - start) * part // _PARTS] = offset
    return tuple((frame, *keys[frame]) for frame in sorted(keys))


def _way(part: int) -> float:
    """Share of the way after ``part`` of the parts: speeds 1, 3, 5, 7, 7, 5, 3, 1 and so on."""
    half = _PARTS // 2
    return part**2 / (2 * half**2) if part <= half else 1 - (_PARTS - part) ** 2 / (2 * half**2)
