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
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

from attrs import frozen

from mcsl_core.documents import canonical_json
from mcsl_core.edl import Edl
from mcsl_core.edl.dependencies import View, movement_over, relief_of, sees_through, views_of
from mcsl_core.edl.following import followed_over, poses_beside
from mcsl_core.edl.resolve import Decision, DecisionsByPose, resolve_by_pose
from mcsl_core.timing import FrameRange, joined, merge_equal, touching, without

from .moving import followed_ranges

Basis = tuple[tuple[FrameRange, str], ...]  # tiles the programme


class _Digests:
    """Hashes of what pictures are made from, kept from one decision to the next.

    What the analysis found and what was corrected stays the same object then, and is most of the work.
    """

    def __init__(self) -> None:
        self._of: tuple[Any, Any] = ((), ())
        self._found: dict[Any, str] = {}

    def open(self, edl: Edl) -> None:
        """From now on they are of ``edl``: those of an EDL with other parts are forgotten."""
        same = edl.cameras, edl.poses, edl.movements, edl.centering, edl.corrections, edl.made_by
        equal = edl.rate, edl.size, edl.frames, edl.reference
        before, self._of = self._of, (same, equal)
        if before[1] != equal or any(a is not b for a, b in zip(before[0], same, strict=True)):
            self._found = {}

    def of(self, key: Any, value: Callable[[], Any]) -> str:
        """The hash of ``value()``, which ``key`` stands for."""
        if key not in self._found:
            self._found[key] = _digest(value())
        return self._found[key]


_digests = _Digests()


def basis_of(edl: Edl, by_pose: DecisionsByPose | None = None) -> Basis:
    """What the exact pictures of ``edl`` are made from, frame by frame; a hash for each stretch of one answer.

    by_pose: what `resolve_by_pose` says of it, where that is known.
    """
    _digests.open(edl)
    followed, known, pieces = _Followed(edl), {}, []
    for span, decision, number in resolve_by_pose(edl) if by_pose is None else by_pose:
        if (number, decision) not in known:
            facts = _facts(edl, decision, number)
            known[number, decision] = facts, _digest(facts)
        facts, digest = known[number, decision]
        for part, eases in _eased(span, decision):  # a centre by hand glides in and out; between, it stands
            for p, moves in followed.over(part):
                if not eases and not moves:
                    pieces.append((p, digest))
                    continue
                own = [*facts, _centering(edl), eases] if eases else facts
                behind = _behind(edl, p) if moves and sees_through(edl.poses[number], decision) else []
                pieces.append((p, _digest([*own, moves, *behind] if moves else own)))
    return tuple(merge_equal(pieces))


def _facts(edl: Edl, decision: Decision, number: int) -> list[Any]:
    """What the pictures under a decision in a pose are made from, where no centre glides and the lamp stands."""
    pose, digest = edl.poses[number], _digests.of
    common = digest("common", lambda: [str(edl.rate), list(edl.size), edl.reference, _filler(edl)])
    centre: Any = _centering(edl) if decision.centering else None
    if decision.centering and decision.offset is not None:
        centre = list(decision.offset)
    through = sees_through(pose, decision)
    view = digest(
        ("view", number, decision.camera, decision.fill, decision.colour, through),
        lambda: [_source(view) for view in views_of(edl, pose, decision)],
    )
    facts = [common, decision.camera, centre, decision.fill, decision.colour, view]
    if decision.surface and pose.relief is not None:  # a pose without is as before there were any
        facts.append(digest(("relief", number), lambda: relief_of(edl, pose, surface=True)))
    return [*facts, "see through"] if through else facts


def _centering(edl: Edl) -> str:
    return _digests.of("centering", lambda: [list(key) for key in edl.centering])


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


class _Followed:
    """Where the lamp is followed, and how, as a hash."""

    def __init__(self, edl: Edl) -> None:
        self._spans = [span for span, _ in followed_ranges(edl)]
        self._how = {s: _digests.of(("moves", s), lambda s=s: movement_over(edl, s)) for s in self._spans}

    def over(self, part: FrameRange) -> list[tuple[FrameRange, str]]:
        """``part`` cut where the lamp begins and ends to be followed, and how it is in each piece; '' where not."""
        near = touching(self._spans, part.start, part.stop)
        if not near:
            return [(part, "")]
        moving = [(both, self._how[span]) for span in near if (both := span.intersection(part)) is not None]
        return sorted([*moving, *((piece, "") for piece in without([part], [both for both, _ in moving]))])


def _eased(span: FrameRange, decision: Decision) -> list[tuple[FrameRange, str]]:
    """``span`` cut where a glide begins or ends, and which glides there are in each part, as text."""
    near = [e for e in decision.eases if e.range.intersection(span) is not None]
    if not near:
        return [(span, "")]
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
    near = touching(gone, strip.start, strip.stop)
    keep = [Part(piece, True) for piece in without([strip], near)]
    lost = [Part(piece, False) for piece in without([strip], [part.range for part in keep])]
    return tuple(sorted([*keep, *lost], key=lambda part: part.range))
