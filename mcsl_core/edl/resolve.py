"""What holds after the editor's decisions: the EDL's analysis below, overrides and corrections on top.

Conventions as in `edl`: half-open frame ranges, pixel centres at integers, row-major 3x3 matrices.
"""

from __future__ import annotations

from bisect import bisect_right
from itertools import pairwise
from math import ceil, sqrt

import attrs
from attrs import frozen

from mcsl_core.timing import FrameRange, cut_points, merge_equal

from .schema import CenteringKey, Edl


def resolve_by_pose(edl: Edl) -> tuple[tuple[FrameRange, Decision, int], ...]:
    """What the viewer gets, cut also where poses meet: range, decision, pose index. They tile [0, frames)."""
    found, pose_index = [], 0
    for piece, decision in resolve(edl):
        while edl.poses[pose_index].range.stop <= piece.start:
            pose_index += 1
        for at in range(pose_index, len(edl.poses)):
            part = piece.intersection(edl.poses[at].range)
            if part is None:
                break
            found.append((part, decision, at))
    return tuple(found)


# No more than this may the centering's speed change from one frame to the next, as a share of the picture's width: 0.77
# pixels a frame at 1920. A shift of a tenth of the width then takes five seconds at 25 frames/s as keys, two by hand.
ACCELERATION = 4e-4
EASE_S = 2.0  # a change of the centering takes at least this long


@frozen
class Ease:
    """Frames over which centering by hand takes over from what stands beside it, or gives way to that again."""

    range: FrameRange
    rises: bool  # the centering by hand sets in; else it gives way
    other: tuple[float, float] | None  # what stands beside it: an offset, or None for the automatic centering


@frozen
class Decision:
    """What the viewer gets over a stretch, after the overrides."""

    camera: str
    centering: bool
    fill: bool
    colour: bool
    overridden: bool
    offset: tuple[float, float] | None = None  # centering by hand, programme pixels
    eases: tuple[Ease, ...] = ()  # of the centering by hand, where it begins or ends without a cut


def resolve(edl: Edl) -> tuple[tuple[FrameRange, Decision], ...]:
    """The effective shots and looks: the analysis below, overrides on top. The ranges tile [0, frames).

    Neighbours with the same decision are one stretch. Cost grows with shots plus overrides, times the overrides
    that hold at one moment.
    """
    points = cut_points(edl.frames, [s.range for s in edl.shots] + [o.range for o in edl.overrides])
    pieces: list[tuple[FrameRange, Decision]] = []
    shots = iter(edl.shots)
    shot = next(shots)
    beginning: dict[int, list[int]] = {}
    for index, override in enumerate(edl.overrides):
        beginning.setdefault(override.range.start, []).append(index)
    holding: list[int] = []  # indices of the overrides that hold, in the list's order
    for start, stop in pairwise(points):
        while start not in shot.range:
            shot = next(shots)
        holding = sorted([i for i in holding if start in edl.overrides[i].range] + beginning.get(start, []))
        decision = Decision(shot.camera, edl.look.centering, edl.look.fill, edl.look.colour, overridden=False)
        for override in (edl.overrides[i] for i in holding):
            given = {
                name: value
                for name in ("camera", "centering", "fill", "colour", "offset")
                if (value := getattr(override, name)) is not None
            }
            decision = attrs.evolve(decision, **given, overridden=decision.overridden or bool(given))
        pieces.append((FrameRange(start, stop), decision))
    return tuple(_eased(edl, merge_equal(pieces)))


def _eased(edl: Edl, pieces: list[tuple[FrameRange, Decision]]) -> list[tuple[FrameRange, Decision]]:
    """Each stretch centred by hand with its eases: over its ends, inside it, where neither camera nor pose changes."""
    shifts = merge_equal([(piece, (d.centering, d.offset)) for piece, d in pieces])
    if all(offset is None for _, (_, offset) in shifts):
        return pieces
    cuts = {pose.range.start for pose in edl.poses}
    cuts |= {b.start for (_, a), (b, now) in pairwise(pieces) if a.camera != now.camera}
    eases: dict[int, tuple[Ease, ...]] = {}
    for i, (piece, (on, offset)) in enumerate(shifts):
        if not on or offset is None:
            continue
        sets_in = i > 0 and piece.start not in cuts
        # Between two stretches by hand the later one eases; what follows with the automatic centering or none does not.
        gives_way = i + 1 < len(shifts) and piece.stop not in cuts and not _by_hand(shifts[i + 1][1])
        room = len(piece) // (2 if sets_in and gives_way else 1)
        found = []
        for there, rises, beside in ((sets_in, True, i - 1), (gives_way, False, i + 1)):
            if there:
                on_there, other = shifts[beside][1]
                other = other if on_there else (0.0, 0.0)
                edge = piece.start if rises else piece.stop
                x, y = offset_at(edl.centering, edge) if other is None else other
                way = max(abs(x - offset[0]), abs(y - offset[1]))
                # A smooth step of T frames speeds up by 6 / T**2 of its way a frame, at most.
                frames = min(room, ceil(max(EASE_S * edl.rate, sqrt(6 * way / (ACCELERATION * edl.size[0])))))
                if frames:
                    span = FrameRange(edge, edge + frames) if rises else FrameRange(edge - frames, edge)
                    found.append(Ease(span, rises, other))
        eases[piece.start] = tuple(found)
    starts = sorted(eases)
    return [
        (piece, attrs.evolve(d, eases=eases[starts[bisect_right(starts, piece.start) - 1]]) if _hand(d) else d)
        for piece, d in pieces
    ]


def _hand(decision: Decision) -> bool:
    return _by_hand((decision.centering, decision.offset))


def _by_hand(shift: tuple[bool, tuple[float, float] | None]) -> bool:
    return shift[0] and shift[1] is not None


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
