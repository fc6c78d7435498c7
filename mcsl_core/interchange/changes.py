"""What an editor changed in a cut, and the overrides that say the same in the EDL."""

from __future__ import annotations

from bisect import bisect_right
from collections import Counter, defaultdict
from collections.abc import Iterable, Iterator, Sequence
from itertools import islice, pairwise
from typing import Literal

import attrs
from attrs import frozen

from mcsl_core.edl import Edl, Override
from mcsl_core.errors import DocumentError
from mcsl_core.progress import counted
from mcsl_core.timing import FrameRange, format_time, joined, merge_equal

from .found import FoundClip, FoundCut
from .model import OVERRIDE, Transform
from .model import Sequence as Cut
from .origin import pairs
from .painting import beside, paint
from .placing import Placed, Placer, shown

Layout = Literal["multicam", "layers", "single"]
"""How a format holds the angles: in a multicam clip, on tracks below the shots, or not at all."""


@frozen
class Changes:
    """What was found changed.

    Attributes
    ----------
    cameras
        Where another camera is shown than the cut says, and which; in order.
    removed
        Programme frames that are shown no more; in order.
    brought_back
        Programme frames that the cut had removed and that are shown; in order.
    notes
        What else was found and is not read, for a person.
    """

    cameras: tuple[tuple[FrameRange, str], ...]
    removed: tuple[FrameRange, ...]
    brought_back: tuple[FrameRange, ...]
    notes: tuple[str, ...]


def find_changes(cut: Cut, found: FoundCut, layout: Layout) -> Changes:
    """What differs between the cut and what came back of it.

    Parameters
    ----------
    cut
        As it was exported, or as the EDL has it.
    found
        As the editor left it.
    layout
        How the format holds angles.

    Raises
    ------
    DocumentError
        Where no clip that came back is of the cut's media.
    """
    placer = Placer(cut)
    seen = _Seen(cut, found, placer)
    exact = any(map(placer.is_conformed, found.clips))
    was = paint(cut.frames, _exported(cut, "multicam" if exact else layout))
    if not seen.known and any(camera for _, camera in was):
        remedy = "Relink them to the cameras' files, or hand in the EDL that it was exported from with --edl"
        raise DocumentError("none of its clips is of this EDL's media", remedy=remedy)
    cameras: list[tuple[FrameRange, str]] = []
    removed: list[FrameRange] = []
    brought_back: list[FrameRange] = []
    out = paint(cut.frames, ((piece, "") for piece in cut.removed))
    whole = paint(cut.frames, pairs(cut.shots))
    for piece, (before, now, retimed, gone, decided) in beside(cut.frames, was, seen.painted, seen.retimed, out, whole):
        if now is not None and gone is not None:
            brought_back.append(piece)
            before = decided
        if now is not None and now != before:
            cameras.append((piece, now))
        elif now is None and before is not None and retimed is None:
            removed.append(piece)
    new = joined(removed)
    holes = joined([*removed, *(p for p, gone in out if gone is not None)])  # what is missing in one place
    covered = [piece for piece in new if seen.may_be_covered(next(h for h in holes if piece.start in h))]
    notes = (*found.notes, *seen.notes(), *map(_cover_note, covered), *_marker_notes(cut, found))
    left = tuple(piece for piece in new if piece not in covered)
    return Changes(tuple(merge_equal(cameras)), left, tuple(joined(brought_back)), notes)


def with_cameras(edl: Edl, cameras: Iterable[tuple[FrameRange, str]]) -> Edl:
    """``edl`` with these cameras shown, as overrides; all else that overrides say stays.

    Where the automatic choice is the same again, what overruled it is taken back.
    """
    painted = paint(edl.frames, cameras)
    decided = [piece for piece, camera in painted if camera is not None]
    if not decided:
        return edl
    overrides = [part for override in edl.overrides for part in _without_camera(override, decided)]
    both = beside(edl.frames, painted, [(shot.range, shot.camera) for shot in edl.shots])
    differs = merge_equal([(piece, camera) for piece, (camera, automatic) in both if camera not in (None, automatic)])
    overrides += [Override(piece, camera=camera) for piece, camera in differs]
    return attrs.evolve(edl, overrides=tuple(_grown(overrides)))


class _Seen:
    """What a viewer of the sequence sees of the programme."""

    def __init__(self, cut: Cut, found: FoundCut, placer: Placer) -> None:
        self._cut = cut
        placed = [(clip, placer.place(clip)) for clip in found.clips]
        self._placed = [(clip, where) for clip, where in placed if where is not None]
        self._foreign = [clip for clip, where in placed if where is None]
        self._shown: list[tuple[FrameRange, FrameRange]] = []  # where in the sequence which programme frames are seen
        self._parts = self._visible([(clip, where) for clip, where in self._placed if clip.enabled])
        by_layer = sorted(self._parts, key=lambda part: part[0].layer)
        self.painted = paint(cut.frames, [(piece, camera) for clip, piece, camera in by_layer if not clip.retimed])
        self.retimed = paint(cut.frames, [(piece, camera) for clip, piece, camera in by_layer if clip.retimed])

    @property
    def known(self) -> bool:
        """Whether any clip is of the programme."""
        return bool(self._placed)

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
                self._shown.append((piece, frames))
        return parts

    def may_be_covered(self, gone: FrameRange) -> bool:
        """Whether a foreign clip lies where programme frames that are seen no more would be: it stands for them."""
        before = [at.stop for at, frames in self._shown if frames.stop == gone.start]
        after = [at.start for at, frames in self._shown if frames.start == gone.stop]
        start, stop = max(before, default=0), min(after, default=None)
        return any(
            clip.enabled and clip.range.stop > start and (stop is None or clip.range.start < stop)
            for clip in self._foreign
        )

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


def _cover_note(piece: FrameRange) -> str:
    return f"frames {piece}, in whose place lies what is none of the programme's media: they are not removed"


def _exported(cut: Cut, layout: Layout) -> Iterator[tuple[FrameRange, str]]:
    """What an export that nobody touched shows, the lowest layer first."""
    if layout == "multicam":  # it lasts as long as the programme, as what is conformed does
        yield from pairs(cut.held_shots())
        return
    below = cut.held(clip for angle in cut.angles for clip in angle.clips) if layout == "layers" else ()
    yield from ((clip.range, clip.camera) for clip in (*below, *cut.shown()))


def _marker_notes(cut: Cut, found: FoundCut) -> Iterator[str]:
    ours = Counter(" ".join(marker.name.split()) for marker in cut.markers)
    for frame, name in found.markers:
        plain = " ".join(name.split())
        if plain.startswith(OVERRIDE):  # of one that the EDL has no more: nobody else writes so
            continue
        known = plain if ours[plain] > 0 else None
        if known is None:  # an EDL has name and note in one
            known = next((own for own, left in ours.items() if left > 0 and own and plain.startswith(own)), None)
        if known is None:
            yield f"the marker {name!r} at {format_time(frame / cut.rate)}"
        else:
            ours[known] -= 1


def _without_camera(override: Override, pieces: Sequence[FrameRange]) -> Iterator[Override]:
    """``override`` with no camera in ``pieces``, which are in order."""
    if override.camera is None:
        yield override
        return
    at, stop = override.range.start, override.range.stop
    for piece in pieces[bisect_right(pieces, at, key=lambda one: one.stop) :]:
        both = piece.intersection(override.range)
        if both is None:
            break
        if at < both.start:
            yield attrs.evolve(override, range=FrameRange(at, both.start))
        rest = attrs.evolve(override, range=both, camera=None)
        if attrs.evolve(rest, note="") != Override(both):
            yield rest
        at = both.stop
    if at < stop:
        yield attrs.evolve(override, range=FrameRange(at, stop))


def _grown(overrides: Sequence[Override]) -> list[Override]:
    """Overrides that say one camera and nothing else, where they meet, made one; the others as they are."""
    result: list[Override] = []
    ends: dict[int, set[int]] = defaultdict(set)  # frame -> which of them begin or end there
    for override in overrides:
        beside_it = sorted(ends[override.range.start] | ends[override.range.stop])
        number = next((n for n in beside_it if _continues(result[n], override, result, n + 1)), len(result))
        if number == len(result):
            result.append(override)
        else:
            both = (result[number].range, override.range)
            result[number] = attrs.evolve(override, range=FrameRange(min(both).start, max(both).stop))
        for end in (result[number].range.start, result[number].range.stop):
            ends[end].add(number)
    return result


def _continues(one: Override, other: Override, overrides: Sequence[Override], after: int) -> bool:
    """Whether two are one decision, and none of the overrides from number ``after`` on decides there."""
    meet = one.range.stop == other.range.start or other.range.stop == one.range.start
    if not meet or other.camera is None or attrs.evolve(one, range=other.range) != other:
        return False
    if other != Override(other.range, camera=other.camera):
        return False
    between = islice(overrides, after, None)
    return not any(b.camera is not None and b.range.intersection(other.range) for b in between)
