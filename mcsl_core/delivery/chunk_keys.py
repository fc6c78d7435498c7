"""What conformed media are called: the programme in chunks of ten seconds, each under a hash of all it depends on.

The grid begins at frame 0. A chunk's name holds a hash of everything its pixels depend on: the effective decisions in
it, poses, colours, centering (`edl.dependencies`), the sources' content, filler, quality, and how pictures come out of
them (`code_keys`). So a
changed override makes again the chunks it touches and no others, an interrupted run loses the chunks it was at, runs
need no record of what they did, and media of different qualities lie beside each other. The grid does not follow the
shots: an editor moves cuts, and boundaries that moved along would orphan whole chunks beside the change; and Blender
takes 0.15 s and more for each movie strip, so that 2,000 shots must not become 2,000 files.
"""

from __future__ import annotations

import hashlib
from bisect import bisect_right
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import attrs
from attrs import frozen

from mcsl_core.code_keys import PICTURES
from mcsl_core.compositing.compositor import BLOCK_S, block_frames, remembered
from mcsl_core.compositing.placement import fully_covered
from mcsl_core.compositing.see_through import decided_within
from mcsl_core.documents import canonical_json
from mcsl_core.edl import Camera, Edl
from mcsl_core.edl.dependencies import (
    Offset,
    View,
    drift_over,
    drifting,
    fill_views,
    follows_centering,
    movement_over,
    offset_bounds,
    offsets_over,
    poses_filled_from,
    relief_of,
    sees_through,
    views_of,
)
from mcsl_core.edl.following import followed_over, poses_beside
from mcsl_core.edl.placement import still_range
from mcsl_core.edl.resolve import Decision, resolve_by_pose, shift_at
from mcsl_core.errors import MediaError
from mcsl_core.filling.footprint import FootprintFiller
from mcsl_core.filling.protocol import Filler
from mcsl_core.filling.see_through import VERSION
from mcsl_core.lru_cache import kept
from mcsl_core.media.fingerprint import FORMER, fingerprint
from mcsl_core.media.probing import conversions_of
from mcsl_core.timing import FrameRange, merge_equal

from .quality import QUALITIES, STANDARD, Quality

_FORM = 2  # of the key itself: stays, so that what was conformed by earlier versions holds
CHUNK_S = BLOCK_S
SUFFIX = ".mp4"


@frozen
class Chunk:
    """One file of conformed pictures: which programme frames, the hash they depend on, and the file's name."""

    range: FrameRange
    key: str

    @property
    def name(self) -> str:
        return f"{self.range.start:07d}-{self.range.stop:07d}-{self.key}{SUFFIX}"


def is_chunk(name: str) -> bool:
    parts = name.removesuffix(SUFFIX).split("-")
    return name.endswith(SUFFIX) and len(parts) == 3 and parts[0].isdigit() and parts[1].isdigit()


def media_fingerprints(camera: Camera, base: Path) -> list[str]:
    """Content keys of a camera's files as they are now, of the kind that the EDL has; InputError where one is gone."""
    return [fingerprint(base / media.path, like=media.fingerprint) for media in camera.media]


def with_former_keys(edl: Edl) -> Edl:
    """``edl`` as a version before would have had it: its plan has the names that chunks had then."""
    cameras = (attrs.evolve(c, media=tuple(attrs.evolve(m, fingerprint=FORMER) for m in c.media)) for c in edl.cameras)
    return attrs.evolve(edl, cameras=tuple(cameras))


def plan_chunks(
    edl: Edl, base: Path, *, filler: Filler | None = None, quality: Quality = STANDARD
) -> tuple[Chunk, ...]:
    """The chunks that tile the programme, and their keys. Decodes nothing; reads the sources that it has not seen
    in the state they are in.

    Chunks that no decision, pose or source distinguishes from the last plan's have the same key and name.
    """
    return tuple(_chunk(piece, content, quality) for piece, content in _contents(edl, base, filler))


def chunks_present(edl: Edl, base: Path, folder: Path, *, filler: Filler | None = None) -> tuple[Chunk, ...]:
    """The chunks of the EDL as it is that lie in ``folder``: of each stretch the one of the finest quality there is.

    So a timeline shows the best that was ever conformed, and a stretch conformed again as a draft only once its
    decisions have changed.
    """
    there = {path.name for path in folder.iterdir()}
    found = []
    for piece, content in _contents(edl, base, filler):
        chunks = (_chunk(piece, content, quality) for quality in reversed(QUALITIES.values()))
        best = next((chunk for chunk in chunks if chunk.name in there), None)
        if best is not None:
            found.append(best)
    return tuple(found)


def _chunk(piece: FrameRange, content: str, quality: Quality) -> Chunk:
    return Chunk(piece, _digest([content, attrs.asdict(quality.encoding), quality.group, quality.resampling]))


def _contents(edl: Edl, base: Path, filler: Filler | None) -> Iterator[tuple[FrameRange, str]]:
    """Each chunk's range and the digest of all that its pictures depend on before they are coded."""
    filler = filler or FootprintFiller()
    step = max(1, round(CHUNK_S * edl.rate))
    stretches = resolve_by_pose(edl)
    facts = _Facts(edl, base)
    for start in range(0, edl.frames, step):
        piece = FrameRange(start, min(start + step, edl.frames))
        block = start - start % block_frames(edl) if filler.remembers else start
        before = remembered(block) if filler.remembers else ()
        parts: list[tuple[FrameRange, tuple[str, bool, tuple[int, tuple[str, ...]] | None, str | None]]] = []
        for span in (*(FrameRange(frame, frame + 1) for frame in before), FrameRange(block, piece.stop)):
            first = bisect_right(stretches, span.start, key=lambda s: s[0].start) - 1
            for stretch, decision, pose_index in stretches[first:]:
                part = stretch.intersection(span)
                if part is None:
                    break
                drift = facts.drift(decision, pose_index)
                moves = facts.moves(part, decision, pose_index)
                parts.append((part, (facts.of(part, decision, pose_index), follows_centering(decision), drift, moves)))
        yield (
            piece,
            _digest(
                {
                    "versions": [_FORM, PICTURES, filler.name, filler.version],
                    "programme": [str(edl.rate), list(edl.size), edl.reference],
                    "range": [piece.start, piece.stop],
                    # merged, since it does not matter whether an editor or the analysis chose what is shown
                    "parts": [
                        [part.start, part.stop, digest, offsets_over(edl, part) if keyed else None]
                        + ([drift_over(edl, *drift, part)] if drift else [])
                        + ([moves] if moves else [])
                        for part, (digest, keyed, drift, moves) in merge_equal(parts)
                    ],
                }
            ),
        )


class _Facts:
    """Digests of what a part of the programme depends on, but for where it lies; each is worked out once."""

    def __init__(self, edl: Edl, base: Path) -> None:
        self.edl, self.base = edl, base

    def of(self, part: FrameRange, decision: Decision, pose_index: int) -> str:
        fixed = self._fixed(attrs.evolve(decision, overridden=False), pose_index)
        if not decision.fill:
            return fixed
        keyed = follows_centering(decision)
        offsets = self._bounds(pose_index) if keyed else (shift_at(self.edl, decision, part.start),)
        return fixed + self._filled(pose_index, offsets, decision.surface)

    @kept
    def drift(self, decision: Decision, pose_index: int) -> tuple[int, tuple[str, ...]] | None:
        """The pose, and the cameras that drift in it, where any does."""
        cameras = tuple(drifting(views_of(self.edl, self.edl.poses[pose_index], decision)))
        return (pose_index, cameras) if cameras else None

    def moves(self, part: FrameRange, decision: Decision, pose_index: int) -> str | None:
        """How the cameras lie where the lamp is followed in it; None where it is not."""
        if not sees_through(self.edl.poses[pose_index], decision):
            found = movement_over(self.edl, part)
            return _digest(found) if found else None
        on_either_side = decided_within(float(self.edl.rate))
        wide = FrameRange(max(0, part.start - on_either_side), part.stop + on_either_side)
        beside = self._beside_part(wide, pose_index)
        return _digest([movement_over(self.edl, wide), *beside]) if beside else None

    def _beside_part(self, part: FrameRange, pose_index: int) -> list[Any]:
        """Other poses in ``part``, and those from which it is known what there is behind heads while the lamp moves."""
        movements = followed_over(self.edl, part)
        near = {pose.range for movement in movements for pose in poses_beside(self.edl, movement)}
        poses = [i for i, pose in enumerate(self.edl.poses) if pose.range in near or pose.range.intersection(part)]
        if not movements and poses == [pose_index]:
            return []
        return [[self.edl.poses[i].perspective, self._beside(i, True)] for i in poses]

    @kept
    def _bounds(self, pose_index: int) -> tuple[Offset, Offset]:
        """Of all of a pose, as one answer for all its shots."""
        return offset_bounds(self.edl, self.edl.poses[pose_index].range)

    @kept
    def _fixed(self, decision: Decision, pose_index: int) -> str:
        """What the decision itself says, and the cameras that may be looked at at the frame's own time."""
        views = views_of(self.edl, self.edl.poses[pose_index], decision)
        shift = decision.offset if decision.centering and decision.offset else decision.centering
        colours = {view.camera.name: view.colour for view in views if view.colour is not None}
        relief = self._relief(pose_index, decision.surface)
        return _digest(
            {
                "decision": [decision.camera, shift, decision.fill, decision.colour],
                "eases": [[e.range.start, e.range.stop, e.rises, e.other] for e in decision.eases],
                "sources": [self._source(view) for view in views],
                "placed": {view.camera.name: view.placement for view in views},
                "colour": colours if decision.colour else None,
                **({"relief": relief} if relief else {}),
                **self._seen_through(pose_index, decision),
            }
        )

    def _seen_through(self, pose_index: int, decision: Decision) -> dict[str, Any]:
        """Nothing where the chosen camera is shown as it is, as all were before: those chunks keep their names."""
        if not sees_through(self.edl.poses[pose_index], decision):
            return {}
        seen = fill_views(self.edl, pose_index)  # it takes medians of any frames of the pose, without their drift
        colours = {view.camera.name: view.colour for view in seen.views if view.colour is not None}
        return {"see_through": [VERSION, seen.still.start, seen.still.stop, drifting(seen.views), colours]}

    @kept
    def _filled(self, pose_index: int, offsets: tuple[Offset, ...], surface: bool) -> str:
        """Where the fill may look beside the frame itself; at other poses only where this one leaves something open."""
        pose = self.edl.poses[pose_index]
        still = still_range(self.edl, pose)
        alone = fully_covered(self.edl, pose, offsets)
        if alone and self._relief(pose_index, surface) is not None:  # by planes first: a hundred times as fast
            alone = fully_covered(self.edl, pose, offsets, surface=True)
        others = poses_filled_from(self.edl, pose_index, alone=alone)
        own = drifting(fill_views(self.edl, pose_index).views)  # it takes medians of any frames of the pose
        beside = (self._beside(other, surface) for other in others)
        return _digest([[still.start, still.stop], *([own] if own else []), *beside])

    @kept
    def _beside(self, pose_index: int, surface: bool) -> list[Any]:
        seen = fill_views(self.edl, pose_index)
        places = {view.camera.name: view.placement for view in seen.views}
        colours = {view.camera.name: view.colour for view in seen.views if view.colour is not None}
        sources, drift = [self._source(view) for view in seen.views], drifting(seen.views)
        more = [fact for fact in (drift, self._relief(pose_index, surface)) if fact]
        return [[seen.still.start, seen.still.stop], places, colours, sources, *more]

    @kept
    def _relief(self, pose_index: int, surface: bool) -> str | None:
        """None where pictures are laid by planes, as all were before there were reliefs: their chunks keep names."""
        facts = relief_of(self.edl, self.edl.poses[pose_index], surface=surface)
        return None if facts is None else _digest(facts)

    def _source(self, view: View) -> list[Any]:
        return [view.camera.name, self._files(view.camera.name), list(view.camera.size), view.clock, view.gaps]

    @kept
    def _files(self, name: str) -> list[str]:
        camera = self.edl.camera(name)
        return [
            *media_fingerprints(camera, self.base),
            *(how for m in camera.media for how in _how_read(self.base / m.path)),
        ]


def _how_read(path: Path) -> tuple[str, ...]:
    """What is done to a file's pictures that is not done to all: nothing for most, whose chunks keep their names."""
    try:
        return conversions_of(path)
    except MediaError:  # told by whoever reads its pictures
        return ()


def _digest(value: Any) -> str:
    """A hash that an EDL keeps when it is saved and loaded: numbers as the document writes them."""
    return hashlib.sha256(canonical_json(_plain(value)).encode()).hexdigest()[:20]


def _plain(value: Any) -> Any:
    if isinstance(value, Mapping):
        return {str(k): _plain(value[k]) for k in sorted(value)}
    if isinstance(value, list | tuple):
        return [_plain(v) for v in value]
    return float(value) if isinstance(value, int) else value
