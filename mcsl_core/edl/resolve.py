"""What holds after the editor's decisions: the EDL's analysis below, overrides and corrections on top.

Conventions as in `edl`: half-open frame ranges, pixel centres at integers, row-major 3x3 matrices.
"""

from __future__ import annotations

from bisect import bisect_right
from heapq import heappop, heappush
from itertools import pairwise
from math import ceil, sqrt
from typing import Any

import attrs
from attrs import frozen

from mcsl_core.timing import FrameRange, cut_points, merge_equal

from .checks import NO_SOUND
from .schema import CenteringKey, Edl

# No more than this may the centering's speed change from one frame to the next, as a share of the picture's width: 0.77
# pixels a frame at 1920. A shift of a tenth of the width then takes five seconds at 25 frames/s as keys, two by hand.
ACCELERATION = 4e-4
_DECIDED = ("camera", "centering", "fill", "colour", "surface", "see_through", "offset")
EASE_S = 2.0  # a change of the centering takes at least this long

Centering = tuple[bool, tuple[float, float] | None]  # on or off, and the offset by hand


@frozen
class Ease:
    """Frames over which centering by hand takes over from its neighbour's, or gives way to that again.

    Attributes
    ----------
    range
        The frames.
    rises
        Whether the centering by hand sets in; else it gives way.
    other
        The neighbour's offset (dx, dy) in programme pixels; None for the automatic centering.
    """

    range: FrameRange
    rises: bool
    other: tuple[float, float] | None


@frozen
class Decision:
    """What the viewer gets over a range of frames, after the overrides.

    Attributes
    ----------
    camera
        Whose picture.
    centering, fill, colour, surface, see_through
        The look.
    overridden
        Whether an override says any of it.
    offset
        Centering by hand, (dx, dy) in programme pixels.
    eases
        Of the centering by hand, where it begins or ends without a cut.
    """

    camera: str
    centering: bool
    fill: bool
    colour: bool
    surface: bool
    overridden: bool
    offset: tuple[float, float] | None = None
    eases: tuple[Ease, ...] = ()
    see_through: bool = False


Decisions = tuple[tuple[FrameRange, Decision], ...]  # tile the programme
DecisionsByPose = tuple[tuple[FrameRange, Decision, int], ...]  # as well, with a pose's index


def resolve(edl: Edl) -> Decisions:
    """The effective shots and look: the analysis below, overrides on top.

    Returns
    -------
    tuple
        (range, decision); the ranges tile [0, frames), and neighbours with the same decision are one.

    Notes
    -----
    Cost grows with shots plus overrides, however many of them hold at one frame.

    Examples
    --------
    >>> for piece, decision in resolve(load("edl.json")):  # doctest: +SKIP
    ...     print(piece, decision.camera)
    """
    points = cut_points(edl.frames, [s.range for s in edl.shots] + [o.range for o in edl.overrides])
    pieces: list[tuple[FrameRange, Decision]] = []
    look = {name: getattr(edl.look, name) for name in ("centering", "fill", "colour", "surface", "see_through")}
    shots = iter(edl.shots)
    shot = next(shots)
    beginning: dict[int, list[int]] = {}
    for index, override in enumerate(edl.overrides):
        beginning.setdefault(override.range.start, []).append(index)
    # field -> minus the indices of overrides that say it, the latest first; those that have ended are dropped on top.
    said = {name for name in _DECIDED if any(getattr(override, name) is not None for override in edl.overrides)}
    saying: dict[str, list[int]] = {name: [] for name in _DECIDED if name in said}
    for start, stop in pairwise(points):
        while start not in shot.range:
            shot = next(shots)
        for index in beginning.get(start, ()):
            for name, heap in saying.items():
                if getattr(edl.overrides[index], name) is not None:
                    heappush(heap, -index)
        decided: dict[str, Any] = {"camera": shot.camera, **look}
        for name, heap in saying.items():
            while heap and edl.overrides[-heap[0]].range.stop <= start:
                heappop(heap)
            if heap:
                decided[name] = getattr(edl.overrides[-heap[0]], name)
        pieces.append((FrameRange(start, stop), Decision(**decided, overridden=any(saying.values()))))
    return tuple(_eased(edl, merge_equal(pieces)))


def resolve_by_pose(edl: Edl, decisions: Decisions | None = None) -> DecisionsByPose:
    """As `resolve`, cut also where poses meet: (range, decision, pose index). The ranges tile [0, frames).

    decisions: what `resolve` says, where that is known already.
    """
    found, pose_index = [], 0
    for piece, decision in resolve(edl) if decisions is None else decisions:
        while edl.poses[pose_index].range.stop <= piece.start:
            pose_index += 1
        if piece.stop <= edl.poses[pose_index].range.stop:
            found.append((piece, decision, pose_index))
            continue
        for at in range(pose_index, len(edl.poses)):
            part = piece.intersection(edl.poses[at].range)
            if part is None:
                break
            found.append((part, decision, at))
    return tuple(found)


def offset_at(keys: tuple[CenteringKey, ...], frame: float) -> tuple[float, float]:
    """Centering offset (dx, dy) in programme pixels at ``frame``: linear between keys, held outside, 0 without keys."""
    if not keys:
        return 0.0, 0.0
    after = bisect_right(keys, frame, key=lambda k: k[0])
    if after in (0, len(keys)):
        _, x, y = keys[0 if after == 0 else -1]
        return x, y
    (f0, x0, y0), (f1, x1, y1) = keys[after - 1], keys[after]
    part = (frame - f0) / (f1 - f0)
    return x0 + part * (x1 - x0), y0 + part * (y1 - y0)


def shift_at(edl: Edl, decision: Decision, frame: float) -> tuple[float, float]:
    """Centering (dx, dy) in programme pixels at ``frame`` under ``decision``: by hand, else the EDL's keys, or none."""
    if not decision.centering:
        return 0.0, 0.0
    if decision.offset is None:
        return offset_at(edl.centering, frame)
    x, y = decision.offset
    for ease in decision.eases:
        start, stop = ease.range.start, ease.range.stop
        if start <= frame < stop:
            part = (frame - start + 1) / (stop - start + 1)
            part = part if ease.rises else 1 - part
            part = part * part * (3 - 2 * part)
            a, b = offset_at(edl.centering, frame) if ease.other is None else ease.other
            x, y = a + part * (x - a), b + part * (y - b)
    return x, y


def _eased(edl: Edl, pieces: list[tuple[FrameRange, Decision]]) -> list[tuple[FrameRange, Decision]]:
    """Every range centred by hand with its eases: inside it, at its ends where neither camera nor pose changes."""
    if all(override.offset is None for override in edl.overrides):
        return pieces
    shifts = merge_equal([(piece, (d.centering, d.offset)) for piece, d in pieces])
    cuts = {pose.range.start for pose in edl.poses}
    cuts |= {b.start for (_, a), (b, now) in pairwise(pieces) if a.camera != now.camera}
    eases: dict[int, tuple[Ease, ...]] = {}
    for i, (piece, (on, offset)) in enumerate(shifts):
        if not on or offset is None:
            continue
        sets_in = i > 0 and piece.start not in cuts
        # Between two ranges by hand the later one eases; what follows with the automatic centering or none does not.
        gives_way = i + 1 < len(shifts) and piece.stop not in cuts and not _by_hand(shifts[i + 1][1])
        room = len(piece) // (2 if sets_in and gives_way else 1)
        found = []
        if sets_in:
            found.append(_ease(edl, shifts[i - 1][1], offset, piece.start, room, rises=True))
        if gives_way:
            found.append(_ease(edl, shifts[i + 1][1], offset, piece.stop, room, rises=False))
        eases[piece.start] = tuple(ease for ease in found if ease is not None)
    starts = sorted(eases)
    return [
        (piece, attrs.evolve(d, eases=eases[starts[bisect_right(starts, piece.start) - 1]]) if _hand(d) else d)
        for piece, d in pieces
    ]


def _ease(
    edl: Edl, beside: Centering, offset: tuple[float, float], edge: int, room: int, *, rises: bool
) -> Ease | None:
    """The ease between ``offset`` and the centering ``beside`` it, within ``room`` frames of ``edge``."""
    other = beside[1] if beside[0] else (0.0, 0.0)
    x, y = offset_at(edl.centering, edge) if other is None else other
    way = max(abs(x - offset[0]), abs(y - offset[1]))
    # A smooth step of T frames speeds up by 6 / T**2 of its way a frame, at most.
    frames = min(room, ceil(max(EASE_S * edl.rate, sqrt(6 * way / (ACCELERATION * edl.size[0])))))
    if not frames:
        return None
    return Ease(FrameRange(edge, edge + frames) if rises else FrameRange(edge - frames, edge), rises, other)


def _hand(decision: Decision) -> bool:
    return _by_hand((decision.centering, decision.offset))


def _by_hand(centering: Centering) -> bool:
    on, offset = centering
    return on and offset is not None


def sound_camera(edl: Edl, wanted: str | None = None) -> str | None:
    """The camera whose sound the programme has: the one that is wanted, else the EDL's, else the reference; or none."""
    name = wanted or edl.audio_from or edl.reference
    return None if name == NO_SOUND else name
