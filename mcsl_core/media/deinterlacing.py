"""Interlaced pictures made whole: of each its first field, and the other rows from what stood still and its neighbours.

A frame's two fields were taken half a frame apart, and shown as one picture they comb. FFmpeg's bwdif makes one picture
a frame, as of its first field: the file's rate, times and number of pictures stay as they are. 1.2 ms at 1080p.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator
from fractions import Fraction
from typing import Any

from av.error import BlockingIOError as NothingYet
from av.error import EOFError as AtEnd
from av.filter import Graph

from .facts import Scan

Shown = tuple[Fraction, Any]


def is_woven(frame: Any, scan: Scan) -> bool:
    """Whether a frame holds two fields that were taken one after the other."""
    return scan in ("top", "bottom") or (scan != "progressive" and frame.interlaced_frame)


def deinterlaced(frames: Iterator[Shown], scan: Scan, *, from_start: bool) -> Iterator[Shown]:
    """Decoded frames as they come, the interlaced among them made whole.

    Parameters
    ----------
    frames
        Times and `av.VideoFrame`, in presentation order; None where there is no whole picture.
    scan
        Which of them are interlaced.
    from_start
        Whether the first is the file's first. Else it was read for its followers' sake and, interlaced, is left out:
        its rows depend on the frame before, and a picture must not depend on where reading began.

    Notes
    -----
    Up to the first interlaced frame nothing is held back or copied; from it on a frame is handed out once the next is
    decoded. A change of size or format begins anew.
    """
    before: Any = None
    fields: _Fields | None = None
    for time, frame in frames:
        if fields is not None and (frame is None or fields.form != _form(frame)):
            yield from fields.rest()
            fields, before, from_start = None, None, True
        if frame is None:  # a picture that is not whole is no neighbour either
            yield time, None
            before, from_start = None, True
            continue
        if fields is None and is_woven(frame, scan):
            fields = _Fields(frame, scan)
            if before is not None:
                fields.push(None, before)
            elif not from_start:
                fields.push(None, frame)
                continue
        if fields is None:
            yield time, frame
            before, from_start = frame, True
        else:
            yield from fields.push(time, frame)
    if fields is not None:
        yield from fields.rest()


def _form(frame: Any) -> tuple:
    return frame.width, frame.height, frame.format.name, frame.colorspace, frame.color_range


class _Fields:
    """The filter, and the times of the frames that are in it; it hands out as many frames as it is given."""

    def __init__(self, frame: Any, scan: Scan) -> None:
        self.form = width, height, pixels, colours, levels = _form(frame)
        self._times: deque[Fraction | None] = deque()
        self._count = 0
        self._graph = Graph()
        self._graph.threads = 1
        source = f"video_size={width}x{height}:pix_fmt={pixels}:time_base=1/1000:colorspace={colours}:range={levels}"
        nodes = [self._graph.add("buffer", source)]
        if scan in ("top", "bottom"):
            nodes.append(self._graph.add("setfield", "tff" if scan == "top" else "bff"))
        which = "all" if scan in ("top", "bottom") else "interlaced"
        nodes.append(self._graph.add("bwdif", f"mode=send_frame:parity=auto:deint={which}"))
        self._graph.link_nodes(*nodes, self._graph.add("buffersink")).configure()

    def push(self, time: Fraction | None, frame: Any) -> list[Shown]:
        """The frames that this one completes. Without a time it is a neighbour only."""
        frame.pts, frame.time_base = self._count, Fraction(1, 1000)
        self._times.append(time)
        self._count += 1
        self._graph.push(frame)
        return self._ready()

    def rest(self) -> list[Shown]:
        """What is left at the end."""
        self._graph.push(None)
        return self._ready()

    def _ready(self) -> list[Shown]:
        ready = []
        while True:
            try:
                frame = self._graph.pull()
            except (NothingYet, AtEnd):
                return ready
            time = self._times.popleft()
            if time is not None:
                ready.append((time, frame))
