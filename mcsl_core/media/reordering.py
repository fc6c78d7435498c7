"""Timestamps for the pictures of files that have them in decoding order only, such as H.264 with B-frames in AVI."""

from __future__ import annotations

from bisect import bisect_left
from typing import Any

from .opening import timestamp_of


class ShownOrder:
    """Gives every decoded picture its timestamp: the n-th that is shown has the n-th smallest of the file.

    A picture's own packet has one of decoding order, by which it is recognised. Whatever stands before a keyframe in
    decoding order is shown before it; of what stands after it, its leading pictures are as well. So a keyframe's place
    is known once those were counted, and every picture's after it.

    Parameters
    ----------
    from_start
        Whether decoding begins with the file. Else the leading pictures of the first keyframe may be lost, and nothing
        is known before the second.
    """

    def __init__(self, *, from_start: bool) -> None:
        self._stamps: list[int] = []  # of the packets in decoding order, in which they rise
        self._keys: set[int] = set()
        self._leading: list[int] = []  # own stamps of what was shown since the last keyframe
        self._place: int | None = -1 if from_start else None
        self._keys_shown = 0

    def feed(self, packet: Any) -> None:
        """Called with each packet before it is decoded."""
        packet.pts = timestamp_of(packet)
        if packet.size and packet.pts is not None:
            self._stamps.append(packet.pts)
            if packet.is_keyframe:
                self._keys.add(packet.pts)

    def stamp(self, frame: Any) -> int | None:
        """The timestamp of the next picture that the decoder gave; None where it cannot be known yet."""
        own = frame.pts
        if own in self._keys:
            self._keys_shown += 1
            if self._place is not None or self._keys_shown > 1:
                self._place = bisect_left(self._stamps, own) + sum(stamp > own for stamp in self._leading)
            self._leading = []
        elif self._place is not None:
            self._place += 1
        if own is not None:
            self._leading.append(own)
        known = self._place is not None and self._place < len(self._stamps)
        return self._stamps[self._place] if known and self._place is not None else None
