"""Which of a decoder's frames are whole, and None in the place of those that are not."""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction
from typing import Any

from attrs import define, field
from av.video.frame import PictureType

from .opening import timestamp_of


@define
class WholeFrames:
    """Which of a decoder's frames are whole.

    After damage decoders go on with what is left of the references, and smear until the next keyframe without saying so
    again; lost packets they do not notice at all.

    Attributes
    ----------
    step_s
        From one frame to the next.
    broken
        Packets before the next frame were left out.
    keys
        Timestamps of the keyframes that were sent to the decoder and have not come: not every decoder says of a frame
        that it is one.
    """

    step_s: Fraction
    broken: bool = False
    keys: set[int] = field(factory=set)
    _smears: bool = False
    _entered: bool = False  # a keyframe was shown: before the first one, pictures lack what lies before the seek
    _last_s: Fraction | None = None

    def sent(self, packet: Any) -> None:
        """``packet`` goes to the decoder."""
        stamp = timestamp_of(packet)
        if packet.is_keyframe and stamp is not None:  # frames without a time would all be its own
            self.keys.add(stamp)

    def cut(self) -> None:
        """A packet is left out, and what was sent before has come."""
        self.broken = True
        self.keys.clear()

    def end(self) -> Iterator[tuple[Fraction, None]]:
        """None from where the last frame ends, where more of them were left out."""
        if self.broken and self._last_s is not None:
            yield self._last_s + self.step_s, None

    def judged(self, time_s: Fraction, frame: Any) -> Iterator[tuple[Fraction, Any | None]]:
        """The next frame, None in its place where it is not whole; before it, None where others are missing."""
        last_s, broken = self._last_s, self.broken
        stamp = timestamp_of(frame)
        is_key = stamp in self.keys
        self.keys.discard(stamp)  # pyright: ignore[reportArgumentType]
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
