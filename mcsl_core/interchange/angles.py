"""A camera's files in programme time: which picture of which file stands at which programme frame.

An editor's clip runs at its own speed and begins on a whole picture. So a camera whose clock drifts is cut where its
pictures have run ahead of the programme, or behind it, by one: by parts it stays in time to the picture.
"""

from __future__ import annotations

import contextlib
from collections.abc import Iterator, Sequence
from fractions import Fraction
from math import ceil, floor

import attrs

from mcsl_core.edl import Camera, Edl
from mcsl_core.errors import UsageError
from mcsl_core.media.facts import MediaFacts
from mcsl_core.recording.decoder import Part
from mcsl_core.timing import FrameRange, without

from .model import Angle, Clip, Medium
from .similarity import nearest_transform
from .timecode import count_of


def medium_of(facts: MediaFacts) -> Medium:
    """A camera file as editors see it."""
    start, drop = 0, False
    if facts.timecode is not None:
        with contextlib.suppress(UsageError):  # no label of its rate: editors begin at 0 then
            start, drop = count_of(facts.timecode, facts.rate)
    track = next((track for track in facts.audio_tracks if track.channels), None)
    return Medium(
        path=facts.path.absolute(),
        rate=facts.rate,
        frames=_pictures(facts),
        start=start,
        drop=drop,
        size=facts.size,
        channels=track.channels if track else 0,
        audio_rate=track.rate if track else 0,
    )


def _pictures(facts: MediaFacts) -> int:
    """How many whole pictures can be shown at the nominal rate; of a file cut short, what is there."""
    if facts.frames and not facts.variable_rate and not facts.truncated:
        return facts.frames
    lasts_s = min(facts.end_s, facts.usable_s) - facts.start_s + facts.tolerance_s
    return max(1, floor(lasts_s * facts.rate))


def laid_files(edl: Edl, camera: Camera, parts: Sequence[Part]) -> tuple[Clip, ...]:
    """The camera's files over the programme, cut where its clock has drifted by a picture, without its gaps.

    Parameters
    ----------
    edl
        The programme.
    camera
        One of its cameras.
    parts
        Its files, and where each begins in its own time.
    """
    clips: list[Clip] = []
    for index, part in enumerate(parts):
        ahead = _first_frame(edl, camera, parts[index + 1]) if index + 1 < len(parts) else edl.frames
        for clip in _laid(edl, camera, part, min(ahead, edl.frames)):
            clips += [piece for free in without([clip.range], camera.gaps) if (piece := clip.part(free))]
    return tuple(clips)


def posed_angle(edl: Edl, camera: Camera, laid: Sequence[Clip]) -> Angle:
    """The angle of ``camera``: its files cut where the lamp moved, in each pose under the nearest transform."""
    clips = []
    for pose in edl.poses:
        transform = nearest_transform(edl, camera, pose)
        parts = (clip.part(pose.range) for clip in laid)
        clips += [attrs.evolve(part, transform=transform) for part in parts if part is not None]
    return Angle(camera.name, tuple(clips))


def _line(edl: Edl, camera: Camera, part: Part) -> tuple[Fraction, Fraction]:
    """(a, b): at programme frame n the file is at its picture a + b n, counted from its first."""
    faster = 1 + Fraction(repr(camera.clock.drift_ppm)) / 1_000_000
    rate, tolerance = part.facts.rate, part.facts.tolerance_s
    own_s = -Fraction(repr(camera.clock.offset_s)) * faster - part.first_s + tolerance
    return own_s * rate, faster * rate / edl.rate


def _first_frame(edl: Edl, camera: Camera, part: Part) -> int:
    """The first programme frame that shows the file's first picture."""
    a, b = _line(edl, camera, part)
    return ceil(-a / b)


def _laid(edl: Edl, camera: Camera, part: Part, stop: int) -> Iterator[Clip]:
    """One file's clips before programme frame ``stop``."""
    medium = medium_of(part.facts)
    a, b = _line(edl, camera, part)
    speed = medium.rate / edl.rate
    drift = b - speed
    at, end = max(0, ceil(-a / b)), min(stop, ceil((medium.frames - a) / b))
    while at < end:
        ahead = floor(a + drift * at)  # pictures by which the file is ahead of one that begins with the programme
        until = end
        if drift > 0:
            until = min(end, ceil((ahead + 1 - a) / drift))
        elif drift < 0:
            until = min(end, floor((ahead - a) / drift) + 1)
        first = max(at, ceil(-ahead / speed))
        last = min(until, floor((medium.frames - ahead) / speed))
        if first < last:
            yield Clip(camera.name, FrameRange(first, last), medium, first * speed + ahead, edl.rate)
        at = until
