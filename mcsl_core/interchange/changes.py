"""What an editor changed in a cut, and the overrides that say the same in the EDL."""

from __future__ import annotations

from bisect import bisect_right
from collections import Counter, defaultdict
from collections.abc import Iterable, Iterator, Sequence
from itertools import islice
from typing import Literal

import attrs
from attrs import frozen

from mcsl_core.edl import Edl, Override
from mcsl_core.errors import DocumentError
from mcsl_core.timing import FrameRange, format_time, joined, merge_equal

from .found import FoundCut
from .heard import sound_notes
from .model import OVERRIDE
from .model import Sequence as Cut
from .origin import CONFORMED, pairs, sound_in
from .painting import beside, paint
from .placing import Placer
from .seen import Seen

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
    heard = sound_in(found.origin, [angle.camera for angle in cut.angles])
    placer = Placer(cut, exact=heard == CONFORMED)
    seen = Seen(cut, found, placer, layers=layout == "layers")
    exact = any(placer.is_conformed(clip) for clip in found.clips if not clip.unread)
    was = paint(cut.frames, _exported(cut, "multicam" if exact else layout))
    if not seen.known and any(camera for _, camera in was):
        remedy = "Relink them to the cameras' files, or hand in the EDL that it was exported from with --edl"
        if any(clip.unread for clip in found.clips):
            remedy = f"Take nested and compound clips apart. {remedy}"
        raise DocumentError("none of its clips is of this EDL's media", remedy=remedy)
    cameras: list[tuple[FrameRange, str]] = []
    removed: list[FrameRange] = []
    brought_back: list[FrameRange] = []
    out = paint(cut.frames, ((piece, "") for piece in cut.removed))
    whole = paint(cut.frames, pairs(cut.shots))
    for piece, (before, now, gone, decided) in beside(cut.frames, was, seen.painted, out, whole):
        if now is not None and gone is not None:
            brought_back.append(piece)
            before = decided
        if now is not None and now != before:
            cameras.append((piece, now))
        elif now is None and before is not None:
            removed.append(piece)
    new = joined(removed)
    holes = joined([*removed, *(p for p, gone in out if gone is not None)])  # what is missing in one place
    covered = [piece for piece in new if seen.may_be_covered(next(h for h in holes if piece.start in h))]
    heard = sound_notes(cut, found, placer, seen, [piece for piece, camera in was if camera is not None])
    notes = (*found.notes, *seen.notes(), *heard, *map(_cover_note, covered), *_marker_notes(cut, found))
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


def _cover_note(piece: FrameRange) -> str:
    return f"frames {piece}, in whose place lies what is not read: they stay as the EDL has them"


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
