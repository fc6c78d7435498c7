"""Which camera a clip that came back shows, and which programme frames: by what it is taken from, not where it lies."""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections import Counter
from fractions import Fraction
from math import ceil, floor
from pathlib import PurePosixPath, PureWindowsPath
from unicodedata import normalize

import attrs
from attrs import frozen

from mcsl_core.timing import FrameRange

from .cmx_writing import PROGRAMME_REEL, reels_of
from .conformed import MARK
from .found import FoundClip, Reference
from .model import Angle, Clip, Medium, Sequence
from .timecode import day_s
from .xml_text import plain


@frozen
class Placed:
    """Programme frames that a clip shows.

    Attributes
    ----------
    start
        The first of them; it may lie before 0.
    camera
        Whose pictures.
    conformed
        Whether they are the conformed programme's.
    """

    start: int
    camera: str
    conformed: bool = False


class Placer:
    """Finds clips in a cut.

    Parameters
    ----------
    cut
        As it was exported, or would be now.
    exact
        Whether it was exported with conformed media.
    """

    def __init__(self, cut: Sequence, *, exact: bool = False) -> None:
        self._cut, self._exact = cut, exact
        self._cameras = {_alike_name(angle.camera): angle.camera for angle in cut.angles}
        self._owner = {medium: angle.camera for angle in cut.angles for medium in _media(angle)}
        reels = reels_of([angle.camera for angle in cut.angles])
        self._reels = {reel: camera for camera, reel in reels.items()}
        laid = [*cut.shown(), *cut.held(clip for angle in cut.angles for clip in angle.clips)]
        self._stops = [shot.range.stop for shot in cut.shots]
        self._begins = {(clip.camera, clip.range.start) for clip in laid}

    def is_conformed(self, clip: FoundClip) -> bool:
        """Whether a clip is of the conformed programme: its file bears the name's mark and is no camera's.

        Of a list that lost its files, those of an exact export that are called as a camera and have no camera's reel.
        """
        if not clip.path and clip.reel:
            foreign = self._exact and clip.reel not in self._reels and self._camera(clip.name) is not None
            if clip.reel == PROGRAMME_REEL or foreign:
                return True
        return _stem(clip.path or clip.name).endswith(MARK) and self._medium(clip) is None

    def place(self, clip: FoundClip) -> Placed | None:
        """Where the clip stands in the programme; None where it is of other media."""
        chosen = self._camera(clip.angle) if clip.angle is not None else None
        if clip.angle is not None and not clip.path:  # of the multicam clip, whose time is the programme's
            camera = self._camera(clip.name) if clip.angle == "" else chosen
            return None if camera is None else Placed(self._programme_frame(clip), camera)
        active = clip if clip.active is None else self._active(clip, clip.active)
        own = self._medium(active)
        if own is not None and clip.active is not None:  # the file says more than what it is called
            chosen = self._owner[own]
        if self.is_conformed(clip):
            if own is None and not self.is_conformed(active):
                return None
            start = self._programme_frame(clip)
            named = chosen or self._camera(clip.name)
            return Placed(start, named or self._camera_in(start, start + len(clip.range)), conformed=True)
        medium = self._medium(clip)
        if medium is None or own is None:
            return None
        start, lies = self._frame_of(clip, medium), self._cut.frame_at(clip.range.start)
        if start != lies and self._frame_of(active, own) == lies:
            start = lies  # it was made to fit the medium that is shown
        return Placed(start, chosen or self._owner[medium])

    def _camera(self, name: str) -> str | None:
        return self._cameras.get(_alike_name(name))

    def _active(self, clip: FoundClip, active: Reference) -> FoundClip:
        """The clip with the medium that it shows; of two that are called alike, the one of the chosen angle."""
        name = clip.angle if clip.angle and self._camera(clip.angle) else clip.name
        return attrs.evolve(clip, name=name, path=active.path, zero_s=active.zero_s, active=None)

    def _programme_frame(self, clip: FoundClip) -> int:
        return round((clip.source_s - (clip.zero_s or 0)) * self._cut.rate)

    def _camera_in(self, start: int, stop: int) -> str:
        """Whom the cut shows most there: what a conformed clip says whose name was changed."""
        first = min(bisect_right(self._stops, start), len(self._stops) - 1)
        frames: Counter[str] = Counter({self._cut.shots[first].camera: 0})
        for shot in self._cut.shots[first : bisect_left(self._stops, stop) + 1]:
            frames[shot.camera] += max(0, min(stop, shot.range.stop) - max(start, shot.range.start))
        return frames.most_common(1)[0][0]

    def _medium(self, clip: FoundClip) -> Medium | None:
        """The camera file that a clip is of: the one whose path ends most alike, else the one that is called so."""
        said = _parts(clip.path)
        alike = {medium: _alike(said, _parts(str(medium.path))) for medium in self._owner}
        most = max(alike.values(), default=0)
        best = [medium for medium, count in alike.items() if count == most and most > 0]
        if not best and not clip.path:
            name = _alike_name(clip.name)
            best = [m for m in self._owner if name in (_alike_name(m.path.name), _alike_name(m.path.stem))]
        named = self._camera(clip.name) or self._reels.get(clip.reel)
        if len(best) != 1 and named is not None and not (clip.path and not best):
            best = [medium for medium in best or self._owner if self._owner[medium] == named]
        at_s = clip.source_s
        if len(best) > 1 and clip.zero_s is None:
            best = [m for m in best if self._zero_s(clip, m) - 1 <= at_s < self._zero_s(clip, m) + m.duration_s]
        if len(best) > 1:  # files without a timecode: the one whose pictures belong where the clip lies
            lies = self._cut.frame_at(clip.range.start)
            best = [medium for medium in best if self._frame_of(clip, medium) == lies]
        return best[0] if best else None

    def _frame_of(self, clip: FoundClip, medium: Medium) -> int:
        """The programme frame at which the clip's first picture stands."""
        picture = (clip.source_s - self._zero_s(clip, medium)) * medium.rate
        camera = self._owner[medium]
        pieces = [piece for piece in self._cut.angle(camera).clips if piece.medium == medium]
        if pieces[0].speed != 1:
            return self._nearest(clip, pieces, picture)
        within = [piece for piece in pieces if piece.source <= picture < piece.source_stop]
        nearest = min(pieces, key=lambda p: max(p.source - picture, picture - p.source_stop))
        frames = [round(piece.range.start + picture - piece.source) for piece in within or [nearest]]
        known = [n for n in frames if (camera, n) in self._begins]
        lies = self._cut.frame_at(clip.range.start)
        return lies if lies in frames else (known or frames)[0]

    def _zero_s(self, clip: FoundClip, medium: Medium) -> Fraction:
        """The timecode of the medium's first picture; a day less where its labels went past midnight."""
        if clip.zero_s is not None:
            return clip.zero_s
        past = clip.source_s < medium.start_s - 1
        return medium.start_s - past * day_s(self._cut.rate, drop=medium.drop)

    def _nearest(self, clip: FoundClip, pieces: list[Clip], picture: Fraction) -> int:
        """The frame of a camera of another rate, of which a picture stands for more or less than one.

        Formats that count in whole pictures or frames are off by one of them. What would be written as the picture that
        was found comes first; of that, where the clip lies or where one began when it was exported.
        """
        camera, speed = pieces[0].camera, pieces[0].speed
        off = max(1 / speed, Fraction(1))
        exact = [
            piece.range.start + (picture - piece.source) / speed
            for piece in pieces
            if piece.source - off * speed < picture < piece.source_stop
        ]
        if not exact:
            nearest = min(pieces, key=lambda p: max(p.source - picture, picture - p.source_stop))
            return round(nearest.range.start + (picture - nearest.source) / speed)
        around = sorted({floor(e) + n for e in exact for n in range(-1, ceil(off) + 2)})
        close = [n for n in around if any(abs(n - e) <= off for e in exact)]
        written = [n for n in close if any(self._writes(piece, n, picture) for piece in pieces if n in piece.range)]
        lies = self._cut.frame_at(clip.range.start)
        begun = [n for n in written if (camera, n) in self._begins]
        if lies in written or (not begun and any(abs(lies - e) <= 2 * off for e in exact)):
            return lies  # of a cut that was moved there, the picture was rounded twice
        known = begun or [n for n in close if (camera, n) in self._begins]
        return (known or written or [round(exact[0])])[0]

    def _writes(self, piece: Clip, frame: int, picture: Fraction) -> bool:
        """Whether an export says ``picture`` of a clip that begins at ``frame``: in pictures, frames, or exactly."""
        source = piece.source + (frame - piece.range.start) * piece.speed
        if picture in (source, floor(source)):
            return True
        begin, frames = piece.medium.start, self._cut.rate / piece.medium.rate
        return (begin + picture) * frames == floor((begin + source) * frames)


def shown(clip: FoundClip, placed: Placed, piece: FrameRange) -> FrameRange | None:
    """The programme frames that the part of ``clip`` lying at ``piece`` of the sequence shows; None before frame 0."""
    start = placed.start + piece.start - clip.range.start
    stop = start + len(piece)
    return FrameRange(max(start, 0), stop) if stop > 0 else None


def _media(angle: Angle) -> list[Medium]:
    return list(dict.fromkeys(clip.medium for clip in angle.clips))


def _alike_name(name: str) -> str:
    """A name as documents hold it, whether its letters and their accents are written in one or apart, as Macs do."""
    return normalize("NFC", plain(name))


def _parts(path: str) -> tuple[str, ...]:
    """A path's names, of whatever system."""
    kind = PureWindowsPath if "\\" in path and "/" not in path else PurePosixPath
    return tuple(part.casefold() for part in kind(path).parts)


def _alike(one: tuple[str, ...], other: tuple[str, ...]) -> int:
    """How many names two paths have in common at their end."""
    count = 0
    for a, b in zip(reversed(one), reversed(other), strict=False):
        if _alike_name(a) != _alike_name(b):
            break
        count += 1
    return count


def _stem(path: str) -> str:
    return path.replace("\\", "/").rsplit("/", 1)[-1].rsplit(".", 1)[0]
