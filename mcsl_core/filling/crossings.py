"""What moves across the chosen picture's edge goes on beyond it as one thing.

Another camera, whose live picture fills beyond the edge, shows a hand above the relief from its own side: laid by the
relief it comes to lie beside where the chosen camera's ends (by up to 6 % of the width for an arm), and the hand breaks
in two. Along the edge both cameras see it. So what moves there is cut out of either picture, against its median, and
the shift is looked for that lays one on the other: the parallax of its own height. It is moved by that; the background
behind it stays. Where no shift does (an arm seen from above and from the side, a head that one of them alone sees) it
stays where it is, and `occluders` decides.
"""

from __future__ import annotations

from collections.abc import Iterator

import cv2
import numpy as np
from attrs import frozen
from numpy.typing import NDArray

from mcsl_core.imaging.planes import U8, Planes
from mcsl_core.imaging.rect import Rect

from .cells import Weight, shown_in, touched

_COLUMNS = 240  # at least, of the grid on which movers are compared; even pixels between
_SCALES = (64, 32, 32)
_MOVES = (10.0, 24.0)  # codes of difference from the median: nothing moves, something does
_FARTHEST = 0.07  # of the width: how far a mover may lie off
_STRIP = 0.1  # of the width: so far inside the edge both cameras' movers are compared
_LEAST = 5e-4  # share of the grid that a mover must take up on either side
_REACHES = 0.02  # of the width, twice: along so much of the edge the chosen camera's mover ends
_MOST = 4  # movers looked at, the largest
_SHORTER = 0.1  # what the farthest shift costs more than none: along an arm all fit alike
_FITS = (0.4, 0.6)  # what is left of both movers after the best shift: they are one, they are not
_IN_PLACE = 4.0  # programme pixels, of 1920: less is no break


@frozen(eq=False)
class Crossing:
    """One thing that crosses the edge, in the other camera's picture.

    Attributes
    ----------
    hidden, shown : (ceil(height / cell), ceil(width / cell)) float32
        How much of each cell it leaves, and how much it takes up where it belongs.
    cell : int
        Programme pixels.
    shift : (float, float)
        From where the picture has it to where it belongs, programme pixels.
    """

    hidden: Weight
    shown: Weight
    cell: int
    shift: tuple[float, float]

    def within(self, rect: Rect) -> Rect | None:
        """The part of ``rect`` outside of which nothing changes; None without any."""
        return touched(np.maximum(self.hidden, self.shown), self.cell, rect)

    def laid(self, picture: Planes, median: Planes, moved: Planes, rect: Rect) -> Iterator[U8]:
        """The planes of ``picture`` with the thing where it belongs; all are the same part, ``rect``."""
        for index, (live, behind, there) in enumerate(zip(picture, median, moved, strict=True)):
            hidden, shown = (shown_in(c, self.cell, rect, 2 if index else 1) for c in (self.hidden, self.shown))
            without = cv2.blendLinear(behind, live, hidden, 1 - hidden)
            yield np.asarray(cv2.blendLinear(there, without, shown, 1 - shown), np.uint8)


def grid_cell(width: int) -> int:
    """Programme pixels in a cell on which movers are compared."""
    return max(2, width // _COLUMNS // 2 * 2)


def find_crossings(
    own: tuple[Planes, Planes], other: tuple[Planes, Planes], inside: NDArray, reach: NDArray
) -> tuple[Crossing, ...]:
    """What crosses the edge of the chosen camera's picture.

    Parameters
    ----------
    own, other : pair of Planes
        The chosen camera's and the other one's programme picture now, and its median.
    inside, reach : (height / 2, width / 2) uint8
        The footprints of both.

    Returns
    -------
    tuple of Crossing
        Those that lie where they belong are not among them.
    """
    cell = grid_cell(own[0].size[0])
    size = (-(-own[0].size[0] // cell), -(-own[0].size[1] // cell))
    within = cv2.resize(inside, size, interpolation=cv2.INTER_AREA) > 250
    seen = cv2.erode(cv2.resize(reach, size, interpolation=cv2.INTER_AREA), np.ones((3, 3), np.uint8)) > 250
    both = within & seen
    depth = cv2.distanceTransform(np.pad(within, 1, mode="edge").astype(np.uint8), cv2.DIST_L2, 5)[1:-1, 1:-1]
    strip = both & (depth < _STRIP * size[0])
    mine, theirs = _movers(*own, size), _movers(*other, size) * seen[..., None]
    things = _things(mine[..., 3], theirs[..., 3], within, strip)
    found = (_crossing(mine, theirs, thing, seen, where, cell) for thing, where in things)
    return tuple(crossing for crossing in found if crossing is not None)


def _movers(now: Planes, median: Planes, size: tuple[int, int]) -> NDArray[np.float32]:
    """(h, w, 4): brightness and colour of what moves, nothing elsewhere; how much moves, 0..1."""
    pictures = [
        [cv2.resize(plane, size, interpolation=cv2.INTER_AREA).astype(np.float32) for plane in planes]
        for planes in (now, median)
    ]
    change = np.max([cv2.absdiff(a, b) for a, b in zip(*pictures, strict=True)], axis=0)
    moves = np.clip((cv2.blur(change, (3, 3)) - _MOVES[0]) / (_MOVES[1] - _MOVES[0]), 0, 1)
    levels = [(plane - 128) / scale for plane, scale in zip(pictures[0], _SCALES, strict=True)]
    return np.stack([*(moves * level for level in levels), moves], axis=-1).astype(np.float32)


def _things(
    mine: NDArray, theirs: NDArray, within: NDArray, strip: NDArray
) -> Iterator[tuple[NDArray[np.bool_], NDArray[np.bool_]]]:
    """Each thing beyond the edge that moves there in both pictures, the largest first, and where it is looked for."""
    moves = cv2.morphologyEx((theirs > 0.5).astype(np.uint8), cv2.MORPH_CLOSE, np.ones((5, 5), np.uint8)) > 0
    count, labels, stats, _ = cv2.connectedComponentsWithStats((moves & ~within).astype(np.uint8))
    edge = strip & ~(cv2.erode(within.astype(np.uint8), np.ones((9, 9), np.uint8)) > 0)
    wide = round(_STRIP * moves.shape[1])
    for n in sorted(range(1, count), key=lambda n: -stats[n, cv2.CC_STAT_AREA])[:_MOST]:
        thing = np.asarray(labels == n)
        touching = thing & (cv2.dilate(within.astype(np.uint8), np.ones((7, 7), np.uint8)) > 0)
        near = cv2.dilate(touching.astype(np.uint8), np.ones((2 * wide + 1,) * 2, np.uint8)) > 0
        ends = (mine[edge & near] > 0.5).sum()  # of what the chosen camera shows up to the edge
        if thing.sum() >= _LEAST * moves.size and ends >= _REACHES * moves.shape[1]:
            yield thing | (moves & strip & near), strip & near


def _crossing(
    mine: NDArray, theirs: NDArray, thing: NDArray, seen: NDArray, where: NDArray, cell: int
) -> Crossing | None:
    around = cv2.dilate(thing.astype(np.uint8), np.ones((7, 7), np.uint8)).astype(np.float32)
    only = theirs * around[..., None]
    (x, y), left = _best_shift(mine, only, where, round(_FARTHEST * thing.shape[1]))
    one = float(np.clip((_FITS[1] - left) / (_FITS[1] - _FITS[0]), 0, 1))
    if one == 0 or np.hypot(x, y) < _IN_PLACE * thing.shape[1] / 1920:
        return None
    hidden = one * cv2.GaussianBlur(cv2.dilate(only[..., 3], np.ones((3, 3), np.uint8)), (0, 0), 1.0)
    move, ends = np.array([[1, 0, x], [0, 1, y]]), cv2.GaussianBlur(seen.astype(np.float32), (0, 0), 2.0)
    known = hidden * np.clip(2 * ends - 1, 0, 1)  # up to where its picture ends, softly
    shown = cv2.GaussianBlur(cv2.warpAffine(known, move, hidden.shape[::-1]), (0, 0), 1.0)
    return Crossing(np.asarray(hidden, np.float32), shown.astype(np.float32), cell, (x * cell, y * cell))


def _best_shift(mine: NDArray, theirs: NDArray, where: NDArray, farthest: int) -> tuple[tuple[float, float], float]:
    """The shift, in cells, that lays ``theirs`` on ``mine`` best, and which share of both is left then: 0..1."""
    x, y, width, height = cv2.boundingRect(where.astype(np.uint8))
    part = np.s_[y : y + height, x : x + width]
    mask = where[part].astype(np.float32)
    sought = mine[part] * mask[..., None]
    wide = np.pad(theirs, ((farthest, farthest), (farthest, farthest), (0, 0)), mode="edge")
    wide = np.ascontiguousarray(wide[y : y + height + 2 * farthest, x : x + width + 2 * farthest])
    products = cv2.matchTemplate(wide, np.ascontiguousarray(sought), cv2.TM_CCORR)
    powers = cv2.matchTemplate(np.square(wide).sum(axis=2), mask, cv2.TM_CCORR)
    total = float(np.square(sought).sum()) + powers
    left = 1 - 2 * products / np.maximum(total, 1e-3)
    rows, columns = np.indices(left.shape) - farthest
    cost = left + _SHORTER * (rows**2 + columns**2) / farthest**2
    best = divmod(int(np.argmin(cost)), cost.shape[1])
    row, column = (best[i] + _vertex(np.moveaxis(cost, i, 0)[:, best[1 - i]], best[i]) for i in (0, 1))
    return (farthest - column, farthest - row), float(left[best])


def _vertex(costs: NDArray, at: int) -> float:
    """Where between its neighbours the least of three costs lies."""
    if not 0 < at < len(costs) - 1:
        return 0.0
    before, least, after = (float(costs[at + n]) for n in (-1, 0, 1))
    bend = before - 2 * least + after
    return 0.5 * (before - after) / bend if bend > 1e-9 else 0.0
