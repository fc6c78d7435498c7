# SPDX-License-Identifier: GPL-3.0-or-later
"""Where the conformed pictures still show what was decided, and how many seconds are outstanding. No bpy.

A basis says, for every programme frame, what its exact picture was made from, as far as the EDL says it: the camera,
the look, the centre, where the cameras lie, their colours, files and clocks. The timeline keeps the basis its conformed
pictures were made for; where today's differs, they no longer hold. That goes by frames, not by files: of a file of ten
seconds only the changed stretch falls away, and it comes back by itself when the decision does.

What `mcsl conform` makes anew is decided by its own keys, which are stricter: a file is made again when anything in it
changed, and where the fill takes from earlier pictures a change reaches some frames further, and a sixth of a second
where heads are seen through about a movement. Those frames differ from the exact ones by that alone until then.
"""

from __future__ import annotations

import hashlib
import json
from bisect import bisect_left, bisect_right
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from attrs import frozen

from mcsl_core.documents import canonical_json
from mcsl_core.edl import Edl
from mcsl_core.edl.dependencies import View, movement_over, relief_of, sees_through, views_of
from mcsl_core.edl.following import followed_over, poses_beside
from mcsl_core.edl.resolve import Decision, resolve_by_pose
from mcsl_core.timing import FrameRange, joined, merge_equal

from .moving import followed_ranges

Basis = tuple[tuple[FrameRange, str], ...]  # tiles the programme


def basis_of(edl: Edl) -> Basis:
    """What the exact pictures of ``edl`` are made from, frame by frame; a hash for each stretch of one answer."""
    common = _digest([str(edl.rate), list(edl.size), edl.reference, _filler(edl)])
    centering = _digest([list(key) for key in edl.centering])
    followed = {span: _digest(movement_over(edl, span)) for span, _ in followed_ranges(edl)}
    views: dict[Any, str] = {}
    reliefs: dict[Any, str] = {}
    pieces = []
    for span, decision, number in resolve_by_pose(edl):
        centre: Any = centering if decision.centering else None
        if decision.centering and decision.offset is not None:
            centre = list(decision.offset)
        through = sees_through(edl.poses[number], decision)
        key = (number, decision.camera, decision.fill, decision.colour, through)
        if key not in views:
            views[key] = _digest([_source(view) for view in views_of(edl, edl.poses[number], decision)])
        facts = [common, decision.camera, centre, decision.fill, decision.colour, views[key]]
        relief = number, decision.surface
        if relief not in reliefs:
            known = relief_of(edl, edl.poses[number], surface=decision.surface)
            reliefs[relief] = "" if known is None else _digest(known)
        facts += [reliefs[relief]] if reliefs[relief] else []  # a pose without is as before there were any
        facts += ["see through"] if through else []
        for part, eases in _eased(span, decision):  # a centre by hand glides in and out; between, it stands
            own = [*facts, centering, eases] if eases else facts
            for p, moves in _moving(part, followed):
                behind = _behind(edl, p) if through and moves else []
                pieces.append((p, _digest([*own, moves, *behind] if moves else own)))
    return tuple(merge_equal(pieces))


def _behind(edl: Edl, span: FrameRange) -> list[Any]:
    """The poses beside movements in ``span``, from which it is known what there is behind heads meanwhile."""
    near = {pose.range: pose for movement in followed_over(edl, span) for pose in poses_beside(edl, movement)}
    return [
        [
            pose.homographies,
            {name: colour.matrix for name, colour in pose.colour.items()},
            relief_of(edl, pose, surface=True),
        ]
        for pose in near.values()
    ]


def _moving(part: FrameRange, followed: Mapping[FrameRange, str]) -> list[tuple[FrameRange, str]]:
    """``part`` cut where the lamp begins and ends to be followed, and how it is in each piece; '' where it is not."""
    moving = [(both, moves) for span, moves in followed.items() if (both := span.intersection(part)) is not None]
    return sorted([*moving, *((piece, "") for piece in without([part], [both for both, _ in moving]))])


def _eased(span: FrameRange, decision: Decision) -> list[tuple[FrameRange, str]]:
    """``span`` cut where a glide begins or ends, and which glides there are in each part, as text."""
    near = [e for e in decision.eases if e.range.intersection(span) is not None]
    points = {span.start, span.stop}
    points |= {p for e in near for p in (e.range.start, e.range.stop) if span.start < p < span.stop}
    cuts = sorted(points)
    parts = [FrameRange(a, b) for a, b in zip(cuts, cuts[1:], strict=False)]
    return [(part, "".join(repr(e) for e in near if e.range.intersection(part))) for part in parts]


def _source(view: View) -> list[Any]:
    """One camera's part: its files as the EDL names them, on its clock, where they lie, in which colours."""
    camera = view.camera
    media = [[media.path, media.frames, media.fingerprint] for media in camera.media]
    lie = [view.clock, view.gaps, view.placement, view.colour, *([view.colour_keys] if view.colour_keys else [])]
    return [camera.name, media, list(camera.size), str(camera.rate), *lie]


def _filler(edl: Edl) -> str:
    return "" if edl.made_by is None else str(edl.made_by.plugins.get("filler", ""))


def _digest(value: Any) -> str:
    return hashlib.sha256(canonical_json(_plain(value)).encode()).hexdigest()[:12]


def _plain(value: Any) -> Any:
    if isinstance(value, Mapping):
        return [[name, _plain(value[name])] for name in sorted(value)]
    return [_plain(v) for v in value] if isinstance(value, list | tuple) else value


def to_text(basis: Basis) -> str:
    """For the scene: [[stop, hash], ...], because the stretches tile from 0."""
    return json.dumps([[stretch.stop, digest] for stretch, digest in basis])


def from_text(text: str) -> Basis:
    """The inverse of `to_text`; () for a text that is not of its making, so that nothing is taken to hold."""
    pieces, start = [], 0
    try:
        for stop, digest in json.loads(text):
            pieces.append((FrameRange(start, stop), str(digest)))
            start = stop
    except (ValueError, TypeError):
        return ()
    return tuple(pieces)


def changed(now: Basis, then: Basis) -> tuple[FrameRange, ...]:
    """Where the two differ, as few ranges as can be; where one of them ends early, the rest of the other."""
    frames = max((basis[-1][0].stop for basis in (now, then) if basis), default=0)
    differing, at, i, j = [], 0, 0, 0
    while at < frames:
        a = now[i] if i < len(now) else None
        b = then[j] if j < len(then) else None
        stop = min(piece[0].stop for piece in (a, b) if piece is not None)
        if a is None or b is None or a[1] != b[1]:
            differing.append((FrameRange(at, stop), True))
        at = stop
        i += a is not None and a[0].stop == at
        j += b is not None and b[0].stop == at
    return tuple(joined(piece for piece, _ in differing))


def without(pieces: Iterable[FrameRange], holes: Iterable[FrameRange]) -> tuple[FrameRange, ...]:
    """The frames of ``pieces`` that no hole has, in as few ranges as can be."""
    result: list[FrameRange] = []
    gaps = joined(holes)
    for piece in joined(pieces):
        at = piece.start
        for gap in _touching(gaps, piece):
            if gap.start > at:
                result.append(FrameRange(at, gap.start))
            at = gap.stop
        if at < piece.stop:
            result.append(FrameRange(at, piece.stop))
    return tuple(result)


def _touching(ordered: Sequence[FrameRange], piece: FrameRange) -> Sequence[FrameRange]:
    """Those of ``ordered`` (ranges in order that do not overlap) that share frames with ``piece``."""
    first = bisect_right(ordered, piece.start, key=lambda other: other.stop)
    return ordered[first : bisect_left(ordered, piece.stop, key=lambda other: other.start)]


def outstanding(frames: int, covered: Iterable[FrameRange]) -> tuple[FrameRange, ...]:
    """The stretches of the programme without an exact picture. covered: what conformed strips show that hold."""
    return without([FrameRange(0, frames)], covered)


@frozen
class Part:
    """A stretch of a conformed strip, and whether its pictures hold."""

    range: FrameRange
    holds: bool


def parts(strip: FrameRange, gone: Sequence[FrameRange]) -> tuple[Part, ...]:
    """A conformed strip cut at what is ``gone`` (as `changed` gives it): its stretches in order."""
    near = _touching(gone, strip)
    keep = [Part(piece, True) for piece in without([strip], near)]
    lost = [Part(piece, False) for piece in without([strip], [part.range for part in keep])]
    return tuple(sorted([*keep, *lost], key=lambda part: part.range))
