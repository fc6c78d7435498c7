"""A camera of the document: its files, their size and rate, and its clock against the programme's."""

from __future__ import annotations

from fractions import Fraction
from typing import Any

import attrs
from attrs import field, frozen

from mcsl_core.documents import Bounds, NotEmpty, doc
from mcsl_core.errors import Fault
from mcsl_core.timing import FrameRange, check_rate

from .checks import FRAMES, MOST_FILES, SECONDS, SIDES, UNIT, FileName


def check_rate_field(_: Any, attribute: attrs.Attribute[Any], value: Fraction) -> None:
    """Validator: frames per second that a camera or a programme may have."""
    try:
        check_rate(value)
    except Fault as fault:
        raise Fault(fault.what, f".{attribute.name}") from None


@frozen
class Media:
    """One file of a camera; a camera's files are played one after another."""

    path: str = field(
        validator=FileName(),
        metadata=doc("relative to the EDL's folder, or absolute; forward slashes"),
    )
    frames: int = field(validator=FRAMES, metadata=doc("pictures in the file"))
    fingerprint: str = field(default="", metadata=doc("content key: changes when the file does"))


@frozen
class Clock:
    """A camera's own time is ``(t - offset_s) * (1 + drift_ppm * 1e-6)`` at programme time t seconds."""

    offset_s: float = field(
        default=0.0, validator=SECONDS, metadata=doc("programme time in seconds at which the camera's time is 0")
    )
    drift_ppm: float = field(
        default=0.0,
        validator=Bounds(-100_000, 100_000),
        metadata=doc("how much faster the camera's clock runs, parts per million"),
    )
    method: str = field(default="none", metadata=doc("which sync found it: timecode, audio, motion, none, hand"))
    confidence: float = field(default=0.0, validator=UNIT, metadata=doc("0 (a guess) to 1 (certain)"))

    def camera_time(self, programme_s: float | Fraction) -> float:
        """The camera's own time in seconds at programme time ``programme_s``."""
        return (float(programme_s) - self.offset_s) * (1 + self.drift_ppm * 1e-6)

    def programme_time(self, camera_s: float | Fraction) -> float:
        """The programme time in seconds at the camera's own time ``camera_s``; the inverse of `camera_time`."""
        return float(camera_s) / (1 + self.drift_ppm * 1e-6) + self.offset_s


@frozen
class Camera:
    """One camera: its files, their size and rate, and its clock against the programme's."""

    name: str = field(validator=NotEmpty(), metadata=doc("unique; used everywhere else in this document"))
    media: tuple[Media, ...] = field(validator=NotEmpty(MOST_FILES), metadata=doc("played one after another"))
    size: tuple[int, int] = field(validator=SIDES, metadata=doc("displayed width and height in pixels"))
    rate: Fraction = field(validator=check_rate_field, metadata=doc("nominal frames per second"))
    clock: Clock = field(factory=Clock, metadata=doc("relation to the programme clock"))
    gaps: tuple[FrameRange, ...] = field(default=(), metadata=doc("programme ranges with no picture, in order"))
