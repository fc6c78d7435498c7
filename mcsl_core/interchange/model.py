"""The cut, whatever it is written as: a sequence of shots over synchronised angles, in exact numbers.

Frames are the programme's, counted from 0; what the first of them is called is the sequence's `start`. A place in a
medium is a number of its own pictures from its first one, whatever timecode that bears.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Iterable, Iterator
from fractions import Fraction
from functools import cached_property
from itertools import accumulate, islice
from pathlib import Path
from typing import Literal

import attrs
from attrs import field, frozen

from mcsl_core.errors import Fault
from mcsl_core.fades import FADE_FRAMES
from mcsl_core.timing import FrameRange, without

OVERRIDE = "override: "  # what a marker of one begins with
MarkerKind = Literal["movement", "pose", "weak", "shot", "override"]


@frozen
class Medium:
    """A file that clips are taken from.

    Attributes
    ----------
    path
        Absolute.
    rate
        Pictures a second; of a file without pictures the programme's, and its frames are counted in that.
    frames
        How many there are: no clip reaches beyond them.
    start
        What its first picture is called, counted in pictures from midnight; 0 where it bears no timecode.
    drop
        Whether that timecode is drop-frame.
    size
        Displayed (width, height); None of a file without pictures.
    channels
        Of its sound; 0 without.
    audio_rate
        Samples a second; 0 without sound.
    """

    path: Path
    rate: Fraction
    frames: int
    start: int = 0
    drop: bool = False
    size: tuple[int, int] | None = None
    channels: int = 0
    audio_rate: int = 0

    @property
    def start_s(self) -> Fraction:
        """Its first picture's timecode, in seconds."""
        return self.start / self.rate

    @property
    def duration_s(self) -> Fraction:
        return self.frames / self.rate


@frozen
class Transform:
    """A picture scaled about its middle, turned, and its middle moved.

    Attributes
    ----------
    x, y
        Of its middle from the programme's, in programme pixels, right and down.
    scale
        Programme pixels a camera pixel.
    rotation
        Degrees, clockwise.
    """

    x: float
    y: float
    scale: float
    rotation: float


@frozen
class Clip:
    """Programme frames ``range`` show ``medium`` from its picture ``source`` on, at its own speed.

    Raises
    ------
    Fault
        Where the medium has no such pictures.
    """

    camera: str
    range: FrameRange
    medium: Medium
    source: Fraction
    rate: Fraction = field(repr=False)  # the programme's
    transform: Transform | None = None

    def __attrs_post_init__(self) -> None:
        if not 0 <= self.source <= self.source_stop <= self.medium.frames:
            raise Fault(
                f"{self.range} would show pictures {self.source} to {self.source_stop} of {self.medium.path.name}, "
                f"which has {self.medium.frames}"
            )

    @property
    def speed(self) -> Fraction:
        """Pictures of the medium a programme frame."""
        return self.medium.rate / self.rate

    @property
    def source_stop(self) -> Fraction:
        return self.source + len(self.range) * self.speed

    def part(self, piece: FrameRange) -> Clip | None:
        """What of it lies in ``piece``, or None."""
        both = self.range.intersection(piece)
        if both is None:
            return None
        return attrs.evolve(self, range=both, source=self.source + (both.start - self.range.start) * self.speed)


@frozen
class Angle:
    """A camera's own pictures in programme time, in order; where none lies the camera shows nothing."""

    camera: str
    clips: tuple[Clip, ...]

    def within(self, piece: FrameRange) -> Iterator[Clip]:
        """Its clips in ``piece``, cut to it."""
        return (part for clip in self.clips if (part := clip.part(piece)) is not None)


@frozen
class Shot:
    """A stretch that shows one camera, as the EDL has it with its overrides."""

    range: FrameRange
    camera: str


@frozen(order=True)
class Marker:
    """What stands at a place of the programme, for the editor to see."""

    range: FrameRange
    kind: MarkerKind
    name: str
    note: str = ""


@frozen(kw_only=True, slots=False)
class Sequence:
    """The whole cut.

    Attributes
    ----------
    name
        What the editor sees.
    rate, frames, size
        The programme's.
    start
        What frame 0 is called, counted in frames from midnight.
    drop
        Whether timecodes are drop-frame.
    origin
        What the shots rest on, and what was decided on it, as `origin_of` says it.
    shots
        They tile [0, frames).
    angles
        The cameras, the reference camera last; the lowest first where they are laid over each other.
    markers
        In order.
    programme
        The conformed programme; None where shots show the angles themselves.
    sound
        What is heard, in order: of one camera, or conformed; none where the programme is silent.
    removed
        What of the programme the sequence does not hold; it closes up there.

    Notes
    -----
    All frames here are the programme's, also those of clips. Where something lies in the sequence says `moved`.
    """

    name: str
    rate: Fraction
    frames: int
    size: tuple[int, int]
    start: int
    drop: bool
    origin: str
    shots: tuple[Shot, ...]
    angles: tuple[Angle, ...]
    markers: tuple[Marker, ...] = ()
    programme: Medium | None = None
    sound: tuple[Clip, ...] = ()
    removed: tuple[FrameRange, ...] = ()

    @cached_property
    def kept(self) -> tuple[FrameRange, ...]:
        """The programme frames that the sequence holds, in order."""
        return without([FrameRange(0, self.frames)], self.removed)

    @cached_property
    def _starts(self) -> list[int]:
        """Where in the sequence each of `kept` begins, and where the last ends."""
        return list(accumulate(map(len, self.kept), initial=0))

    @property
    def length(self) -> int:
        """Frames of the sequence."""
        return self._starts[-1]

    def position(self, frame: int) -> int:
        """Where in the sequence a programme frame lies that it holds."""
        index = bisect_right(self.kept, frame, key=lambda piece: piece.start) - 1
        return self._starts[index] + frame - self.kept[index].start

    def frame_at(self, position: int) -> int:
        """The programme frame that lies at a place of the sequence; beyond its end they are counted on."""
        index = min(max(bisect_right(self._starts, position) - 1, 0), len(self.kept) - 1)
        return self.kept[index].start + position - self._starts[index]

    def moved(self, clip: Clip) -> Clip:
        """A clip of frames that the sequence holds one after another, at its place there."""
        at = self.position(clip.range.start)
        return attrs.evolve(clip, range=FrameRange(at, at + len(clip.range)))

    def parts(self, span: FrameRange) -> Iterator[FrameRange]:
        """What of ``span`` the sequence holds, in order."""
        first = bisect_right(self.kept, span.start, key=lambda piece: piece.stop)
        for piece in islice(self.kept, first, None):
            if (both := piece.intersection(span)) is None:
                return
            yield both

    def fades(self, span: FrameRange) -> tuple[int, int]:
        """(frames over which sound comes back, and falls silent) in ``span`` where it begins and ends at a seam."""
        most = min(FADE_FRAMES, len(span) // 2)
        rises = any(piece.start == span.start for piece in self.kept[1:])
        falls = any(piece.stop == span.stop for piece in self.kept[:-1])
        return most * rises, most * falls

    def held(self, clips: Iterable[Clip]) -> Iterator[Clip]:
        """What of clips the sequence holds; those at a seam are two."""
        for clip in clips:
            yield from filter(None, map(clip.part, self.parts(clip.range)))

    def held_shots(self) -> Iterator[Shot]:
        """What of the shots the sequence holds; those at a seam are two."""
        for shot in self.shots:
            yield from (Shot(part, shot.camera) for part in self.parts(shot.range))

    def held_markers(self) -> Iterator[Marker]:
        """The markers that begin in what the sequence holds, at their places there; they end where it is cut."""
        for marker in self.markers:
            part = next(self.parts(marker.range), None)
            if part is not None and part.start == marker.range.start:
                at = self.position(part.start)
                yield attrs.evolve(marker, range=FrameRange(at, at + len(part)))

    def angle(self, camera: str) -> Angle:
        """The angle of that camera; KeyError where there is none."""
        for angle in self.angles:
            if angle.camera == camera:
                return angle
        raise KeyError(camera)

    def seconds(self, frame: int) -> Fraction:
        """How long after frame 0 programme frame ``frame`` stands."""
        return frame / self.rate

    @property
    def start_s(self) -> Fraction:
        """The timecode of frame 0 in seconds."""
        return self.start / self.rate

    def shown(self) -> tuple[Clip, ...]:
        """The clips that make the picture, in order: a clip a shot of the conformed programme, else of the angles."""
        return tuple(clip for shot in self.held_shots() for clip in self.shown_in(shot))

    def shown_in(self, shot: Shot) -> Iterator[Clip]:
        """The clips that make the picture of one shot, in order."""
        if self.programme is None:
            return self.angle(shot.camera).within(shot.range)
        return iter((Clip(shot.camera, shot.range, self.programme, Fraction(shot.range.start), self.rate),))

    def media(self) -> tuple[Medium, ...]:
        """Every file, once, in the order of their first use."""
        used = [clip.medium for angle in self.angles for clip in angle.clips]
        used += [self.programme] if self.programme else []
        used += [clip.medium for clip in self.sound]
        return tuple(dict.fromkeys(used))
