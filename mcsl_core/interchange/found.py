"""What stands in a document that came back from an editor: clips, before it is said whose they are."""

from __future__ import annotations

from fractions import Fraction

from attrs import field, frozen

from mcsl_core.timing import FrameRange

from .model import Transform


@frozen(kw_only=True)
class FoundClip:
    """A clip of pictures.

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
        Of a multicam clip, the angle that it shows; else None.
    path
        Of its file; empty where it is not said.
    reel
        The tape; empty where it is not said.
    source_s
        Where it begins, in seconds: in its file's own timecode, or in the multicam clip's.
    zero_s
        The timecode of the file's or multicam clip's first picture in seconds; None where it is not said.
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
    source_s: Fraction
    zero_s: Fraction | None = None
    transform: Transform | None = None

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
    markers
        (frame, name) of each, in frames from the sequence's start.
    origin
        What the export said of the decisions it shows; empty where the editor lost it.
    notes
        What was seen and is not read, for a person.
    """

    rate: Fraction
    clips: tuple[FoundClip, ...]
    markers: tuple[tuple[int, str], ...] = ()
    origin: str = ""
    notes: tuple[str, ...] = field(default=())
