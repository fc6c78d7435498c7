"""What an editor changed in the sound: nothing of it is read, and all of it is named with where it stands."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Iterator, Sequence

from attrs import frozen

from mcsl_core.timing import FrameRange, joined

from .found import FoundClip, FoundCut
from .model import Sequence as Cut
from .origin import CONFORMED, sound_in
from .painting import beside, paint
from .placing import Placer
from .seen import Seen


@frozen
class _Sound:
    """A clip of sound of the programme's media: of which camera or conformed, and its first programme frame."""

    clip: FoundClip
    of: str
    start: int

    @property
    def shift(self) -> int:
        """Programme frame less place in the sequence."""
        return self.start - self.clip.range.start


def sound_notes(cut: Cut, found: FoundCut, placer: Placer, seen: Seen, was: Sequence[FrameRange]) -> Iterator[str]:
    """What is heard otherwise than it was exported, for a person.

    Parameters
    ----------
    cut
        As it was exported.
    found
        As it came back.
    placer, seen
        Of both.
    was
        Programme frames that were shown when it was exported, in order.
    """
    own = sound_in(found.origin, [angle.camera for angle in cut.angles])
    sounds: list[_Sound] = []
    for clip in (clip for clip in found.sounds if clip.enabled and not clip.unread):
        where = placer.place(clip)
        if where is None:
            yield f"the sound {clip.name!r} at {clip.range}: {clip.taken_from} is none of the programme's media"
        elif where.conformed:
            sounds.append(_Sound(clip, CONFORMED, where.start))
        else:  # an angle that has no name any more tells no other sound from the exported one
            sounds.append(_Sound(clip, own or where.camera if clip.angle == "" else where.camera, where.start))
    if own is None:  # the note is lost
        own = _most_heard(sounds)
    others = defaultdict(list)
    for sound in sounds:
        if sound.of != own:
            others[sound.of].append(sound.clip.range)
    for of, pieces in others.items():
        yield from (f"{_named(of)} at frames {piece}" for piece in joined(pieces))
    if own:
        yield from _own_notes(cut, own, [sound for sound in sounds if sound.of == own], seen, was)


def _own_notes(cut: Cut, own: str, sounds: list[_Sound], seen: Seen, was: Sequence[FrameRange]) -> Iterator[str]:
    """Where the sound that was exported is not heard, not with its picture, or without one."""
    there = _has_sound(cut, own)
    channels = sorted({sound.clip.channel for sound in sounds} | set(there))
    if not any(sound.clip.channel for sound in sounds):
        channels = [0]
    told: dict[str, list[FrameRange]] = defaultdict(list)
    tolerance = 0 if _is_of_the_programmes_rate(cut, own) else 1
    laid = (*(sound.clip.range for sound in sounds), *(at for _, at, _, _ in seen.parts))
    length = max((piece.stop for piece in laid), default=1)
    pictures = paint(length, ((at, frames.start - at.start) for _, at, frames, _ in seen.parts))
    unknown = paint(length, ((clip.range, True) for clip in seen.unknown))
    for channel in channels:
        of = _named(own) if channel < 2 else f"channel {channel} of {_named(own)}"
        heard = paint(length, ((s.clip.range, s.shift) for s in sounds if s.clip.channel == channel))
        wanted = paint(length, _in_sequence(there[max(channel, 1)], seen))
        for piece, (sound, picture, due, hidden) in beside(length, heard, pictures, wanted, unknown):
            if sound is None:
                if due:
                    told[f"{of} is not heard"].append(piece)
            elif picture is not None:
                if abs(sound - picture) > tolerance:
                    told[f"{of} is of another moment than the picture"].append(piece)
            elif not hidden and _shown(was, FrameRange(max(piece.start + sound, 0), max(piece.stop + sound, 1))):
                told[f"{of} is heard without its picture"].append(piece)
    for what, pieces in told.items():
        yield from (f"{what} at frames {piece}" for piece in joined(pieces))


def _has_sound(cut: Cut, own: str) -> dict[int, list[FrameRange]]:
    """Channel -> the programme frames for which the medium has it, in order."""
    found: dict[int, list[FrameRange]] = defaultdict(list)
    if own == CONFORMED:
        found[1] = [FrameRange(0, cut.frames)]
        return found
    for clip in cut.angle(own).clips:
        for channel in range(1, clip.medium.channels + 1):
            found[channel].append(clip.range)
    return defaultdict(list, {channel: joined(pieces) for channel, pieces in found.items()})


def _in_sequence(there: Sequence[FrameRange], seen: Seen) -> Iterator[tuple[FrameRange, bool]]:
    """Where in the sequence pictures are seen of programme frames ``there``."""
    if not there:
        return
    has = paint(there[-1].stop, ((piece, True) for piece in there))
    for _, at, frames, _ in seen.parts:
        for piece, true in has:
            both = piece.intersection(frames) if true else None
            if both is not None:
                first = at.start + both.start - frames.start
                yield FrameRange(first, first + len(both)), True


def _shown(was: Iterable[FrameRange], frames: FrameRange) -> bool:
    return any(piece.intersection(frames) for piece in was)


def _most_heard(sounds: Iterable[_Sound]) -> str:
    frames: dict[str, int] = defaultdict(int)
    for sound in sounds:
        frames[sound.of] += len(sound.clip.range)
    return max(frames, key=frames.__getitem__, default="")


def _is_of_the_programmes_rate(cut: Cut, own: str) -> bool:
    return own == CONFORMED or all(clip.medium.rate == cut.rate for clip in cut.angle(own).clips)


def _named(of: str) -> str:
    return "the conformed sound" if of == CONFORMED else f"the sound of {of}"
