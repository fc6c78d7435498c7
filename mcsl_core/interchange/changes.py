"""What an editor changed in a cut, and the overrides that say the same in the EDL."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from itertools import pairwise
from typing import Literal, TypeVar

import attrs
from attrs import frozen

from mcsl_core.edl import Edl, Override
from mcsl_core.progress import counted
from mcsl_core.timing import FrameRange, cut_points, format_time, joined, merge_equal

from .found import FoundClip, FoundCut
from .model import Clip, Transform
from .model import Sequence as Cut
from .placing import Placed, Placer, shown

Layout = Literal["multicam", "layers", "single"]
"""How a format holds the angles: in a multicam clip, on tracks below the shots, or not at all."""

T = TypeVar("T")
Painted = list[tuple[FrameRange, T | None]]


@frozen
class Changes:
    """What was found changed.

    Attributes
    ----------
    cameras
        Where another camera is shown than the EDL says, and which; in order.
    removed
        Programme frames that are shown no more; in order.
    notes
        What else was found and is not read, for a person.
    """

    cameras: tuple[tuple[FrameRange, str], ...]
    removed: tuple[FrameRange, ...]
    notes: tuple[str, ...]


def find_changes(cut: Cut, found: FoundCut, layout: Layout) -> Changes:
    """What differs between the cut and what came back of it.

    Parameters
    ----------
    cut
        As the EDL has it.
    found
        As the editor left it.
    layout
        How the format holds angles.
    """
    placer = Placer(cut)
    seen = _Seen(cut, found, placer)
    exact = any(map(placer.is_conformed, found.clips))
    was = paint(cut.frames, _exported(cut, "multicam" if exact else layout))
    points = cut_points(cut.frames, [piece for piece, _ in (*was, *seen.painted)])
    cameras: list[tuple[FrameRange, str]] = []
    removed: list[FrameRange] = []
    for piece, before, now in zip(_pieces(points), _each(was, points), _each(seen.painted, points), strict=True):
        if now is None and before is not None:
            removed.append(piece)
        elif now is not None and now != before:
            cameras.append((piece, now))
    notes = (*found.notes, *seen.notes(), *_marker_notes(cut, found))
    return Changes(tuple(merge_equal(cameras)), tuple(joined(removed)), notes)


def with_cameras(edl: Edl, cameras: Iterable[tuple[FrameRange, str]]) -> Edl:
    """``edl`` with these cameras shown, as overrides; all else that overrides say stays.

    Where the automatic choice is the same again, what overruled it is taken back.
    """
    overrides = list(edl.overrides)
    automatic = merge_equal([(shot.range, shot.camera) for shot in edl.shots])
    for piece, camera in cameras:
        overrides = [part for override in overrides for part in _without_camera(override, piece)]
        differs = [both for span, name in automatic if name != camera and (both := span.intersection(piece))]
        overrides += [Override(stretch, camera=camera) for stretch in joined(differs)]
    return attrs.evolve(edl, overrides=tuple(_grown(overrides)))


def paint(frames: int, laid: Iterable[tuple[FrameRange, T]]) -> Painted[T]:
    """[0, frames) in pieces, each with the last that was laid over it, or None."""
    laid = list(laid)
    points = cut_points(frames, [piece for piece, _ in laid])
    index = {point: n for n, point in enumerate(points)}
    values: list[T | None] = [None] * (len(points) - 1)
    for piece, value in laid:
        first, last = min(piece.start, frames), min(piece.stop, frames)
        for n in range(index[first], index[last]):
            values[n] = value
    return merge_equal(list(zip(_pieces(points), values, strict=True)))


class _Seen:
    """What a viewer of the sequence sees of the programme."""

    def __init__(self, cut: Cut, found: FoundCut, placer: Placer) -> None:
        self._cut = cut
        placed = [(clip, placer.place(clip)) for clip in found.clips]
        self._placed = [(clip, where) for clip, where in placed if where is not None]
        self._foreign = [clip for clip, where in placed if where is None]
        self._parts = self._visible([(clip, where) for clip, where in self._placed if clip.enabled])
        by_layer = sorted(self._parts, key=lambda part: part[0].layer)
        self.painted = paint(cut.frames, [(piece, camera) for _, piece, camera in by_layer])

    def _visible(self, known: list[tuple[FoundClip, Placed]]) -> list[tuple[FoundClip, FrameRange, str]]:
        """(clip, programme frames, camera) of what is not covered, in the order of the sequence."""
        length = max((clip.range.stop for clip, _ in known), default=1)
        laid = sorted(known, key=lambda item: item[0].layer)
        parts = []
        for piece, top in paint(length, [(clip.range, (clip, where)) for clip, where in laid]):
            if top is None:
                continue
            clip, where = top
            frames = shown(clip, where, piece)
            if frames is not None:
                parts.append((clip, frames, where.camera))
        return parts

    def _is_moved(self, clip: FoundClip, where: Placed) -> bool:
        """Whether a clip's picture lies elsewhere than the export laid it."""
        if clip.transform is None:
            return False
        laid = next((c.transform for c in self._cut.angle(where.camera).clips if where.start in c.range), None)
        if where.conformed:
            laid = Transform(0, 0, 1, 0)
        return laid is not None and not _alike(laid, clip.transform)

    def notes(self) -> Iterator[str]:
        """What is seen and cannot be said in an EDL."""
        for clip in self._foreign:
            what = clip.path or clip.angle or clip.reel or "no file"
            yield f"{clip}: {what} is none of the programme's media"
        moved = [(clip, where) for clip, where in self._placed if self._is_moved(clip, where)]
        if moved:
            at = format_time(moved[0][0].range.start / self._cut.rate)
            yield f"{counted(len(moved), 'clips')} whose picture was moved, scaled or turned, the first at {at}"
        if any(piece.stop > self._cut.frames for _, piece, _ in self._parts):
            yield f"frames beyond the programme's end at {self._cut.frames}"
        highest = max((clip.layer for clip, _, _ in self._parts), default=0)
        top = [piece for clip, piece, _ in self._parts if clip.layer == highest]
        if any(after.start < before.start for before, after in pairwise(top)):
            yield "another order of the shots"
        twice = sum(map(len, top)) - sum(map(len, joined(top)))
        if twice:
            yield f"{twice} frames that are shown more than once"


def _alike(one: Transform, other: Transform) -> bool:
    """Whether two transforms are one but for how editors round."""
    shift = max(abs(one.x - other.x), abs(one.y - other.y))
    turn = (one.rotation - other.rotation + 180) % 360 - 180
    return shift < 0.1 and abs(one.scale - other.scale) < 3e-4 and abs(turn) < 0.02


def _exported(cut: Cut, layout: Layout) -> Iterator[tuple[FrameRange, str]]:
    """What an export that nobody touched shows, the lowest layer first."""
    if layout == "multicam":  # it lasts as long as the programme, as what is conformed does
        yield from ((shot.range, shot.camera) for shot in cut.shots)
        return
    below: Sequence[Clip] = [clip for angle in cut.angles for clip in angle.clips] if layout == "layers" else ()
    yield from ((clip.range, clip.camera) for clip in (*below, *cut.shown()))


def _marker_notes(cut: Cut, found: FoundCut) -> Iterator[str]:
    ours = Counter(" ".join(marker.name.split()) for marker in cut.markers)
    for frame, name in found.markers:
        plain = " ".join(name.split())
        known = plain if ours[plain] > 0 else None
        if known is None:  # an EDL has name and note in one
            known = next((own for own, left in ours.items() if left > 0 and own and plain.startswith(own)), None)
        if known is None:
            yield f"the marker {name!r} at {format_time(frame / cut.rate)}"
        else:
            ours[known] -= 1


def _pieces(points: Sequence[int]) -> list[FrameRange]:
    return [FrameRange(a, b) for a, b in pairwise(points)]


def _each(painted: Painted[T], points: Sequence[int]) -> Iterator[T | None]:
    """The value in each of the pieces between ``points``, which hold all ends of what is painted."""
    pieces = iter(painted)
    span, value = next(pieces)
    for start in points[:-1]:
        while start >= span.stop:
            span, value = next(pieces)
        yield value


def _without_camera(override: Override, piece: FrameRange) -> Iterator[Override]:
    """``override`` with no camera in ``piece``."""
    both = override.range.intersection(piece)
    if both is None or override.camera is None:
        yield override
        return
    start, stop = override.range.start, override.range.stop
    if start < both.start:
        yield attrs.evolve(override, range=FrameRange(start, both.start))
    rest = attrs.evolve(override, range=both, camera=None)
    if attrs.evolve(rest, note="") != Override(both):
        yield rest
    if both.stop < stop:
        yield attrs.evolve(override, range=FrameRange(both.stop, stop))


def _grown(overrides: Sequence[Override]) -> list[Override]:
    """Overrides that say one camera and nothing else, where they meet, made one; the others as they are."""
    result: list[Override] = []
    for override in overrides:
        before = next((n for n, one in enumerate(result) if _continues(one, override, result[n + 1 :])), None)
        if before is None:
            result.append(override)
        else:
            ends = (result[before].range, override.range)
            result[before] = attrs.evolve(override, range=FrameRange(min(ends).start, max(ends).stop))
    return result


def _continues(one: Override, other: Override, between: Sequence[Override]) -> bool:
    """Whether two are one decision, and no override between them in the list decides there."""
    meet = one.range.stop == other.range.start or other.range.stop == one.range.start
    if not meet or other.camera is None or attrs.evolve(one, range=other.range) != other:
        return False
    free = not any(b.camera is not None and b.range.intersection(other.range) for b in between)
    return free and other == Override(other.range, camera=other.camera)
