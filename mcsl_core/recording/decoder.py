"""A camera's files one after another, and a decoder that seeks in them by the camera's own time.

Times are Fractions of a second: the camera's own time, in which its files follow each other, or a file's own time.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from fractions import Fraction
from typing import Any

from attrs import frozen

from mcsl_core.edl import Camera
from mcsl_core.media.facts import MediaFacts
from mcsl_core.media.reading import VideoReader


@frozen
class Part:
    """One file of a camera.

    Attributes
    ----------
    facts
        The file, as `probe` describes it.
    begin_s
        The camera's own time at the file's own time 0.
    """

    facts: MediaFacts
    begin_s: Fraction

    @property
    def first_s(self) -> Fraction:
        """The camera's own time of the file's first picture."""
        return self.begin_s + self.facts.start_s

    @property
    def end_s(self) -> Fraction:
        """The camera's own time at the end of the file's last picture."""
        return self.begin_s + self.facts.end_s

    def file_time(self, camera_s: Fraction) -> Fraction | None:
        """The file's own time at ``camera_s`` of the camera's; None where the file has no picture then."""
        facts, time = self.facts, camera_s - self.begin_s
        if time + facts.tolerance_s >= facts.usable_s:
            return None
        if time + facts.tolerance_s < facts.start_s:
            return facts.start_s if facts.start_s <= 2 / facts.rate + facts.tolerance_s else None
        return time


@frozen(eq=False)
class DecodedFrame:
    """A decoded frame.

    Attributes
    ----------
    camera_s
        The camera's own time of its timestamp.
    frame
        An `av.VideoFrame`.
    facts
        The file it comes from.
    """

    camera_s: Fraction
    frame: Any
    facts: MediaFacts


class Decoder:
    """Decodes a camera's files by the camera's own time: cheap going forward, exact anywhere. For one thread.

    Parameters
    ----------
    parts
        The camera's files in order.
    how
        ``threads``, ``skip``, ``loop_filter`` and ``hwaccel``, as `VideoReader` takes them.
    """

    def __init__(self, parts: Sequence[Part], **how: Any) -> None:
        self._parts, self._how = parts, how
        self._part: Part | None = None
        self._reader: VideoReader | None = None
        self._pictures: Iterator[tuple[Fraction, Any]] = iter(())
        self._now: tuple[Fraction, Any | None] | None = None
        self._next: tuple[Fraction, Any | None] | None = None
        self.damaged = False  # whether what was asked for last is in a file, but not whole
        self.broken_key_s: Fraction | None = None  # the damaged keyframe that was met on the way, the camera's own time

    def close(self) -> None:
        """Closes the file that is open, and lets go of its frames."""
        if self._reader is not None:
            self._reader.close()
        self._reader, self._part = None, None
        self._pictures, self._now, self._next = iter(()), None, None

    def _enter(self, camera_s: Fraction) -> Fraction | None:
        """Opens the file of ``camera_s``; its own time then, or None without picture."""
        part = part_at(self._parts, camera_s)
        file_time = part.file_time(camera_s) if part is not None else None
        if part is None or file_time is None:
            return None
        if part is not self._part:
            self.close()
            self._part, self._reader = part, VideoReader(part.facts, **self._how)
        return file_time

    def at(self, camera_s: Fraction) -> DecodedFrame | None:
        """The frame shown at ``camera_s`` of the camera's own time; None without a whole picture."""
        self.damaged = False
        file_time = self._enter(camera_s)
        if file_time is None or self._part is None or self._reader is None:
            return None
        facts = self._part.facts
        goal = file_time + facts.tolerance_s
        # Going forward costs the pictures between, a seek on average half a keyframe interval and a cold decoder.
        stride = max(Fraction(facts.keyframe_interval_s), 4 / facts.rate)
        if self._now is None or goal < self._now[0] or goal - self._now[0] > stride:
            self._pictures = self._reader.read(file_time)
            self._now, self._next = next(self._pictures, None), next(self._pictures, None)
        while self._next is not None and self._next[0] <= goal:
            self._now, self._next = self._next, next(self._pictures, None)
        begun = self._now is not None and self._now[0] <= goal + 2 / facts.rate
        shown = self._shown(self._now) if begun else None
        self.damaged = shown is None
        return shown

    def keyframe(self, camera_s: Fraction, within_s: Fraction) -> DecodedFrame | None:
        """As `at`, but the nearest keyframe where there is one within ``within_s`` seconds."""
        self.broken_key_s = None
        file_time = self._enter(camera_s)
        if file_time is None or self._part is None or self._reader is None:
            return None
        found, broken_s = self._reader.keyframe(file_time), self._reader.broken_key_s
        self.broken_key_s = None if broken_s is None else self._part.begin_s + broken_s
        self._now, self.damaged = None, False  # the reader has seeked elsewhere
        if found is None or abs(found[0] - file_time) > within_s:
            return self.at(camera_s)
        return self._shown(found)

    def _shown(self, picture: tuple[Fraction, Any | None] | None) -> DecodedFrame | None:
        if picture is None or picture[1] is None or self._part is None:
            return None
        return DecodedFrame(self._part.begin_s + picture[0], picture[1], self._part.facts)


def part_at(parts: Sequence[Part], camera_s: Fraction) -> Part | None:
    """The file of ``camera_s``, the camera's own time: the last whose first picture has come. None before the first.

    Sound may lead in a file, so that its own time 0 lies before the end of the file before.
    """
    begun = sum(part.begin_s + part.facts.start_s <= camera_s + part.facts.tolerance_s for part in parts)
    # A first picture that is late by rounding stands from the beginning, where nothing else does any more.
    ended = begun == 0 or parts[begun - 1].file_time(camera_s) is None
    if ended and begun < len(parts) and parts[begun].begin_s <= camera_s + parts[begun].facts.tolerance_s:
        return parts[begun]
    return parts[begun - 1] if begun else None


def exact_programme_time(camera: Camera, camera_s: Fraction) -> Fraction:
    """The inverse of `exact_camera_time`."""
    clock = camera.clock
    return camera_s / (1 + Fraction(repr(clock.drift_ppm)) / 1_000_000) + Fraction(repr(clock.offset_s))


def exact_camera_time(camera: Camera, programme_s: Fraction) -> Fraction:
    """`Clock.camera_time` in exact arithmetic: its decimal numbers are taken as written (0.2 s is 1/5 s)."""
    clock = camera.clock
    return (programme_s - Fraction(repr(clock.offset_s))) * (1 + Fraction(repr(clock.drift_ppm)) / 1_000_000)
