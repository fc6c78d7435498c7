"""Clocks from SMPTE start timecodes: the label of a file's first frame, counted by all cameras from one midnight.

Exact to the picture: two labels differ by whole pictures, in fractions of a second. What lies between two pictures
no label says, so a clock is certain to within one picture. Two recorders that both begin on the same hour, to the
picture, were never set: 01:00:00:00 is what many come with. Only labels are read: the date in a file's header
(creation_time) is in whole seconds, and with many recorders it is the time at which the file was *closed*.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from fractions import Fraction
from math import ceil

import numpy as np
from attrs import frozen

from mcsl_core.edl import Clock
from mcsl_core.progress import Progress
from mcsl_core.recording.decoder import Part
from mcsl_core.recording.footage import Footage

from .clock_fit import MAX_DRIFT, ClockResults, Refusal, length_s

_LABEL = re.compile(r"(\d{1,2}):(\d{2}):(\d{2})([:;.,])(\d{2,3})")
DAY_S = 86400
SURE = 0.95  # a label is certain, that the cameras' generators were set alike is not


@frozen
class Timecode:
    """A label as a count of frames since midnight.

    Attributes
    ----------
    count
        Frames since midnight.
    rate
        The nominal whole number of frames that is counted to in a second.
    drop
        Drop-frame: two labels are left out in every minute but each tenth (four where 60 are counted), so that at 29.97
        frames a second labels and the time of day agree to 0.1 s a day.

    References
    ----------
    SMPTE ST 12-1.
    """

    count: int
    rate: int
    drop: bool

    @property
    def day(self) -> int:
        """Frames from one midnight to the next."""
        return DAY_S * self.rate - (_dropped_labels(24 * 60, self.rate) if self.drop else 0)


def _dropped_labels(minutes: int, rate: int) -> int:
    return rate // 15 * (minutes - minutes // 10)


def parse_timecode(label: str, rate: Fraction) -> Timecode:
    """Reads a label.

    Parameters
    ----------
    label
        As FFmpeg writes it: "10:11:12:13", or "10:11:12;13" for drop-frame.
    rate
        The file's frames per second.

    Raises
    ------
    Refusal
        Where it is no timecode at that rate.

    Examples
    --------
    >>> parse_timecode("00:00:02:05", Fraction(25)).count
    55
    """
    match = _LABEL.fullmatch(label.strip())
    nominal = ceil(rate)
    if match is None:
        raise Refusal(f"{label!r} is no timecode")
    hours, minutes, seconds, picture = (int(match[i]) for i in (1, 2, 3, 5))
    if hours > 23 or minutes > 59 or seconds > 59 or picture >= nominal:
        raise Refusal(f"{label} is no timecode at {float(rate):.6g} pictures a second")
    drop = match[4] != ":"
    if drop and (nominal % 30 or rate.denominator == 1):
        raise Refusal(f"{label} drops labels, which does not fit {float(rate):.6g} pictures a second")
    count = ((hours * 60 + minutes) * 60 + seconds) * nominal + picture
    if drop:
        count -= _dropped_labels(hours * 60 + minutes, nominal)
    return Timecode(count, nominal, drop)


@frozen
class _CameraTimecode:
    """One camera: its own time 0 on the generator's day, and how much faster its own clock runs."""

    zero: Fraction  # seconds since midnight
    rate: Fraction
    day_s: Fraction
    drop: bool
    drift: float
    label: str  # of its first picture
    preset: bool  # on the hour to the picture, as recorders come from the factory
    picture: int  # within its second


def clocks_from_timecode(footage: Footage, reference: str, wanted: Sequence[str], progress: Progress) -> ClockResults:
    """The clocks of the cameras ``wanted`` against ``reference``, each by its timecode or refused.

    Parameters
    ----------
    footage
        The cameras with default clocks.
    reference
        The camera whose clock is the programme's.
    wanted
        The cameras to be found.
    progress
        Not used: labels are read in no time.

    Returns
    -------
    ClockResults
        Camera -> its clock, or why there is none.
    """
    read: dict[str, _CameraTimecode | Refusal] = {}
    for camera in (reference, *wanted):
        try:
            read[camera] = _camera_timecode(footage.parts(camera), camera)
        except Refusal as refusal:
            read[camera] = refusal
    found: dict[str, Clock | Refusal] = {}
    every_frame = _every_frame_labelled(read)
    for camera in wanted:
        try:
            found[camera] = _clock(read, reference, camera, footage, every_frame)
        except Refusal as refusal:
            found[camera] = refusal
    return found


def _clock(
    read: Mapping[str, _CameraTimecode | Refusal], reference: str, camera: str, footage: Footage, every_frame: bool
) -> Clock:
    a, b = read[reference], read[camera]
    for one in (a, b):
        if isinstance(one, Refusal):
            raise one
    assert isinstance(a, _CameraTimecode)
    assert isinstance(b, _CameraTimecode)
    if (a.rate, a.drop) != (b.rate, b.drop):
        kinds = [f"{float(x.rate):.6g} pictures a second{', drop-frame' if x.drop else ''}" for x in (a, b)]
        raise Refusal(f"{reference} counts {kinds[0]}, {camera} {kinds[1]}")
    if a.preset and b.preset and a.label == b.label:
        raise Refusal(f"all begin at {a.label}, as files do whose timecode nobody has set since the factory")
    if not every_frame and a.picture != b.picture:
        raise Refusal(f"it cannot be told whether the labels count all {float(a.rate):.6g} pictures or every other one")
    offset = (b.zero - a.zero + a.day_s / 2) % a.day_s - a.day_s / 2  # the shorter way round midnight
    if not -length_s(footage, camera) < offset < length_s(footage, reference):
        raise Refusal(f"by their timecodes {camera} begins {float(offset):.0f} s after {reference}: never together")
    # Both run against the generator; the programme's time is the reference's.
    drift = (1 + b.drift) / (1 + a.drift) - 1
    return Clock(
        offset_s=float(offset * Fraction(1 + a.drift)), drift_ppm=drift * 1e6, method="timecode", confidence=SURE
    )


def _camera_timecode(parts: Sequence[Part], camera: str) -> _CameraTimecode:
    """The timecode of a camera; Refusal where its files have none or contradict each other."""
    if parts[0].facts.timecode is None:
        raise Refusal(f"{camera} has no timecode")
    rate = parts[0].facts.rate
    first = parse_timecode(parts[0].facts.timecode, rate)
    day_s = first.day / rate
    start = first.count / rate
    points: list[tuple[float, float]] = []  # (own time, how much later the generator says it is) from the first label
    for part in parts:
        if part.facts.timecode is None:
            continue
        label = parse_timecode(part.facts.timecode, rate)
        since = (label.count / rate - start) % day_s
        own = part.begin_s + part.facts.start_s - parts[0].facts.start_s
        late = (since - own + day_s / 2) % day_s - day_s / 2
        points.append((float(own), float(late)))
    drift = _drift(points, float(1 / rate), camera)
    label = parts[0].facts.timecode.strip()
    minutes, seconds, picture = (int(_LABEL.fullmatch(label)[i]) for i in (2, 3, 5))  # pyright: ignore[reportOptionalSubscript]
    # Labels of further files are told apart by the sound alone: a clock that runs on has them as well.
    on_the_hour = minutes == seconds == picture == 0 and len(points) == 1
    zero = start - parts[0].facts.start_s
    return _CameraTimecode(zero, rate, day_s, first.drop, drift, label, on_the_hour, picture)


def _drift(points: Sequence[tuple[float, float]], picture_s: float, camera: str) -> float:
    """How much faster the camera's clock runs than the generator, from the labels of its further files.

    A label is rounded to a frame: where no file is off by more, nothing is known and it is 0.
    """
    own, late = np.array(points).T
    if np.abs(late).max() <= 1.5 * picture_s:
        return 0.0
    slope = float((own * late).sum() / max((own * own).sum(), 1e-9))
    apart = np.abs(late - slope * own)
    if abs(slope) > MAX_DRIFT or apart.max() > 1.5 * picture_s:
        gap = float(np.abs(np.diff(late)).max())
        raise Refusal(f"the files of {camera} do not follow each other: {gap:.1f} s are missing between two of them")
    return 1 / (1 + slope) - 1


def _every_frame_labelled(read: Mapping[str, _CameraTimecode | Refusal]) -> bool:
    """Whether every frame has its own label. Above 30 a second some generators label every other frame (ST 12-1); a
    label in the upper half of its second proves that they do not."""
    known = [r for r in read.values() if isinstance(r, _CameraTimecode)]
    return all(r.rate <= 30 for r in known) or any(r.picture >= ceil(r.rate) // 2 for r in known)
