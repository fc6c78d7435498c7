"""Which of a decoder's frames are whole, and None in the place of those that are not."""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction
from typing import Any

from attrs import define
from av.video.frame import PictureType


@define
class WholeFrames:
    """Which of a decoder's frames are whole.

    After damage decoders go on with what is left of the references, and smear until the next keyframe without saying so
    again; lost packets they do not notice at all.
    """

    step_s: Fraction
    broken: bool = False  # packets before the next frame were left out
    _smears: bool = False
    _entered: bool = False  # a keyframe was shown: before the first one, pictures lack what lies before the seek
    _last_s: Fraction | None = None

    def end(self) -> Iterator[tuple[Fraction, None]]:
        """None from where the last frame ends, where more of them were left out."""
        if self.broken and self._last_s is not None:
            yield self._last_s + self.step_s, None

    def judged(self, time_s: Fraction, frame: Any, *, is_key: bool) -> Iterator[tuple[Fraction, Any | None]]:
        """The next frame, None in its place where it is not whole; before it, None where others are missing.

        ``is_key``: whether its packet is a keyframe's, which not every decoder says of the frame.
        """
        last_s, broken = self._last_s, self.broken
        if not frame.is_corrupt and (is_key or frame.key_frame or frame.pict_type == PictureType.I):
            self._smears, self._entered = False, True
        elif broken or (frame.is_corrupt and self._entered):
            self._smears = True
        self.broken = False
        if last_s is not None and time_s <= last_s and (broken or self._smears):  # the damage upset the order
            return
        if broken and last_s is not None and time_s - last_s > self.step_s * 3 / 2:
            yield last_s + self.step_s, None
        self._last_s = time_s
        yield time_s, None if self._smears or frame.is_corrupt else frame
