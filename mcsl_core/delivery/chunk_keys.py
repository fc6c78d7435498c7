"""What conformed media are called: the programme in chunks of ten seconds, each under a hash of all it depends on.

The grid begins at frame 0. A chunk's name holds a hash of everything its pixels depend on: the effective decisions in
it, poses, colours, centering, the sources' content, clocks, filler, quality and the versions of the algorithms. So a
changed override makes again the chunks it touches and no others, an interrupted run loses the chunks it was at, runs
need no record of what they did, and media of different qualities lie beside each other. The grid does not follow the
shots: an editor moves cuts, and boundaries that moved along would orphan whole chunks beside the change; and Blender
takes 0.15 s and more for each movie strip, so that 2,000 shots must not become 2,000 files.
"""

from __future__ import annotations

import hashlib
from bisect import bisect_right
from collections.abc import Iterator, Mapping
from functools import cache, lru_cache
from pathlib import Path
from typing import Any

import attrs
from attrs import frozen

from mcsl_core.compositing.compositor import BLOCK_S, COMPOSITOR_VERSION, block_frames, remembered
from mcsl_core.compositing.placement import fully_covered
from mcsl_core.documents import canonical_json
from mcsl_core.edl import Camera, Edl, Pose
from mcsl_core.edl.placement import first_of_perspective, other_poses, placement_matrix, still_range
from mcsl_core.edl.resolve import Decision, offset_at, resolve_by_pose, shift_at
from mcsl_core.filling.footprint import FootprintFiller
from mcsl_core.filling.protocol import Filler
from mcsl_core.media.facts import fingerprint
from mcsl_core.timing import FrameRange, merge_equal

from .quality import QUALITIES, STANDARD, Quality

VERSION = 2  # rises when chunks come out differently for a reason that no key holds
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


@lru_cache(maxsize=256)
def _content(path: Path, _size: int, _changed_ns: int) -> str:
    return fingerprint(path)


def media_fingerprints(camera: Camera, base: Path) -> list[str]:
    """Content keys of a camera's files as they are now; InputError where one is gone."""
    keys = []
    for media in camera.media:
        path = base / media.path
        if path.is_file():
            state = path.stat()
            keys.append(_content(path, state.st_size, state.st_mtime_ns))
        else:
            keys.append(fingerprint(path))  # says what is wrong
    return keys


def plan_chunks(
    edl: Edl, base: Path, *, filler: Filler | None = None, quality: Quality = STANDARD
) -> tuple[Chunk, ...]:
    """The chunks that tile the programme, and their keys. Reads three blocks of each source, decodes nothing.

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


def cameras_of(edl: Edl, pose: Pose, decision: Decision) -> tuple[str, ...]:
    """The cameras that may be looked at under ``decision``: the shot's, the reference, and for the fill all known."""
    names = {decision.camera, edl.reference}
    if decision.fill:
        names |= {camera.name for camera in edl.cameras if placement_matrix(edl, pose, camera.name) is not None}
    return tuple(camera.name for camera in edl.cameras if camera.name in names)


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
        parts: list[tuple[FrameRange, tuple[str, bool]]] = []
        for span in (*(FrameRange(frame, frame + 1) for frame in before), FrameRange(block, piece.stop)):
            first = bisect_right(stretches, span.start, key=lambda s: s[0].start) - 1
            for stretch, decision, pose_index in stretches[first:]:
                part = stretch.intersection(span)
                if part is None:
                    break
                parts.append((part, (facts.of(part, decision, pose_index), _follows_keys(decision))))
        yield (
            piece,
            _digest(
                {
                    "versions": [VERSION, COMPOSITOR_VERSION, filler.name, filler.version],
                    "programme": [str(edl.rate), list(edl.size), edl.reference],
                    "range": [piece.start, piece.stop],
                    # merged, since it does not matter whether an editor or the analysis chose what is shown
                    "parts": [
                        [part.start, part.stop, digest, _offsets(edl, part) if keyed else None]
                        for part, (digest, keyed) in merge_equal(parts)
                    ],
                }
            ),
        )


def _follows_keys(decision: Decision) -> bool:
    return decision.centering and (decision.offset is None or any(ease.other is None for ease in decision.eases))


class _Facts:
    """Digests of what a part of the programme depends on, but for where it lies; each is worked out once."""

    def __init__(self, edl: Edl, base: Path) -> None:
        self.edl, self.base = edl, base
        self._source, self._beside = cache(self._source_now), cache(self._beside_now)
        self._still, self._fixed, self._swept = cache(self._still_now), cache(self._fixed_now), cache(self._swept_now)

    def of(self, part: FrameRange, decision: Decision, pose_index: int) -> str:
        fixed = self._fixed(attrs.evolve(decision, overridden=False), pose_index)
        if not decision.fill:
            return fixed
        offsets = self._swept(pose_index) if _follows_keys(decision) else (shift_at(self.edl, decision, part.start),)
        return fixed + self._still(pose_index, offsets)

    def _swept_now(self, pose_index: int) -> tuple[tuple[float, float], ...]:
        """The least and the greatest offsets of the centering's keys in a pose, as one answer for all its shots."""
        x, y = zip(*(row[1:] for row in _offsets(self.edl, self.edl.poses[pose_index].range)), strict=True)
        return (min(x), min(y)), (max(x), max(y))

    def _fixed_now(self, decision: Decision, pose_index: int) -> str:
        edl, pose = self.edl, self.edl.poses[pose_index]
        names = cameras_of(edl, pose, decision)
        shift = decision.offset if decision.centering and decision.offset else decision.centering
        return _digest(
            {
                "decision": [decision.camera, shift, decision.fill, decision.colour],
                "eases": [[e.range.start, e.range.stop, e.rises, e.other] for e in decision.eases],
                "sources": [self._source(name) for name in names],
                "placed": {name: placement_matrix(edl, pose, name) for name in names},
                "colour": {n: pose.colour[n].matrix for n in names if n in pose.colour} if decision.colour else None,
            }
        )

    def _still_now(self, pose_index: int, offsets: tuple[tuple[float, float], ...]) -> str:
        """Where the fill may look beside the frame itself; at other poses only where this one leaves something open."""
        pose = self.edl.poses[pose_index]
        still = still_range(self.edl, pose)
        others = () if fully_covered(self.edl, pose, offsets) else other_poses(self.edl, pose_index)
        first = first_of_perspective(self.edl, pose_index)  # whose parallax is that of the perspective
        return _digest([[still.start, still.stop], *(self._beside(other) for other in (first, *others))])

    def _beside_now(self, pose_index: int) -> Any:
        pose = self.edl.poses[pose_index]
        still = still_range(self.edl, pose)
        names = [c.name for c in self.edl.cameras if placement_matrix(self.edl, pose, c.name) is not None]
        colours = {n: pose.colour[n].matrix for n in names if n in pose.colour}
        places = {n: placement_matrix(self.edl, pose, n) for n in names}
        return [[still.start, still.stop], places, colours, [self._source(n) for n in names]]

    def _source_now(self, name: str) -> Any:
        camera = self.edl.camera(name)
        clock = [camera.clock.offset_s, camera.clock.drift_ppm]
        gaps = [[g.start, g.stop] for g in camera.gaps]
        return [name, media_fingerprints(camera, self.base), list(camera.size), clock, gaps]


def _offsets(edl: Edl, part: FrameRange) -> list[Any]:
    """The centering over ``part``: its ends and the keys between, which is all that linear motion depends on."""
    inside = [key[0] for key in edl.centering if part.start < key[0] < part.stop - 1]
    return [[frame, *offset_at(edl.centering, frame)] for frame in (part.start, *inside, part.stop - 1)]


def _digest(value: Any) -> str:
    """A hash that an EDL keeps when it is saved and loaded: numbers as the document writes them."""
    return hashlib.sha256(canonical_json(_plain(value)).encode()).hexdigest()[:20]


def _plain(value: Any) -> Any:
    if isinstance(value, Mapping):
        return {str(k): _plain(value[k]) for k in sorted(value)}
    if isinstance(value, list | tuple):
        return [_plain(v) for v in value]
    return float(value) if isinstance(value, int) else value
