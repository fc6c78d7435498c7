"""What stands in a document that came back from an editor: clips, before it is said whose they are."""

from __future__ import annotations

from fractions import Fraction
from typing import TypeVar

from attrs import field, frozen

from mcsl_core.errors import Fault
from mcsl_core.timing import FrameRange

from .model import Transform

N = TypeVar("N", int, Fraction)


MOST = 1 << 40  # frames or seconds: whatever is more is damage, and too much to count with


def bounded(value: N) -> N:
    """``value``; `Fault`, a ValueError, where no programme reaches so far."""
    if abs(value) >= MOST:
        raise Fault(f"it says a time of more than {MOST} frames or seconds")
    return value


@frozen
class Reference:
    """A file that a clip may show, and the timecode of its first picture in seconds; None where it is not said."""

    path: str
    zero_s: Fraction | None


@frozen(kw_only=True)
class FoundClip:
    """A clip of pictures, or of sound.

    Attributes
    ----------
    name
        As the editor shows it.
    range
        Where it lies in the sequence, in frames from its start.
    layer
        What lies on a higher one covers it.
    enabled
        Whether it is shown.
    angle
        Of a multicam clip, the angle that it shows, empty where that has no name; else None.
    path
        Of its file; empty where it is not said.
    reel
        The tape; empty where it is not said.
    source_s
        Where it begins, in seconds: in its file's own timecode, or in the multicam clip's.
    zero_s
        The timecode of the file's or multicam clip's first picture in seconds; None where it is not said.
    active
        What it shows in truth, where its own place is said in the time of another file; else None.
    retimed
        Whether it runs at another speed, or backwards.
    unread
        Whether it is of a kind that is not read, nested or a title: who found it has named it.
    channel
        Of sound, which of the file's is heard, from 1; 0 for all.
    transform
        Where its picture lies; None where it is not said.
    """

    name: str
    range: FrameRange
    layer: int
    enabled: bool = True
    angle: str | None = None
    path: str = ""
    reel: str = ""
    source_s: Fraction = Fraction(0)
    zero_s: Fraction | None = None
    active: Reference | None = None
    retimed: bool = False
    unread: bool = False
    channel: int = 0
    transform: Transform | None = None

    @property
    def taken_from(self) -> str:
        """What it is taken from, for a person."""
        return self.path or self.angle or self.reel or "what bears no file"

    def __str__(self) -> str:
        return f"the clip {self.name!r} at {self.range}"


@frozen(kw_only=True)
class FoundCut:
    """A sequence as found.

    Attributes
    ----------
    rate
        Frames a second.
    clips
        Of pictures.
    sounds
        Clips of sound.
    markers
        (frame, name) of each, in frames from the sequence's start.
    origin
        What the export said of the decisions it shows; empty where the editor lost it.
    notes
        What was seen and is not read, for a person.
    """

    rate: Fraction
    clips: tuple[FoundClip, ...]
    sounds: tuple[FoundClip, ...] = ()
    markers: tuple[tuple[int, str], ...] = ()
    origin: str = ""
    notes: tuple[str, ...] = field(default=())
