"""Decoded frames as pictures and back: colours to BT.709 limited, upright, square pixels."""

from __future__ import annotations

import threading
from typing import Any

import av
import numpy as np
from av.video.reformatter import Colorspace, VideoReformatter

from mcsl_core.imaging.planes import Planes, mirror_planes, resize_planes, turn_planes

from .colours import BT709, FULL, LIMITED, is_full_range, matrix_of, to_bt709_rgb, wide_colours
from .facts import MediaFacts

_per_thread = threading.local()


def to_planes(frame: Any, facts: MediaFacts) -> Planes:
    """The upright, square-pixel picture of a decoded frame, in BT.709 limited range.

    Parameters
    ----------
    frame
        An `av.VideoFrame` of any pixel format.
    facts
        The file it comes from.

    Returns
    -------
    Planes
        Of ``facts.size``. They share the decoder's memory where nothing has to be converted: treat as read-only.

    Notes
    -----
    What colours it has, and what becomes of HDR, `colours` says.
    """
    upright = facts.size if facts.rotation % 180 == 0 else (facts.size[1], facts.size[0])
    wide = wide_colours(frame)
    if wide is not None:
        frame = to_bt709_rgb(frame, wide)
    matrix, full = matrix_of(frame), is_full_range(frame)
    odd = frame.width % 2 or frame.height % 2
    if frame.format.name != "yuv420p" or matrix is not Colorspace.ITU709 or full or odd:
        frame = _reformatter().reformat(
            frame,
            width=frame.width + frame.width % 2,
            height=frame.height + frame.height % 2,
            format="yuv420p",
            src_colorspace=matrix,
            dst_colorspace=Colorspace.ITU709,
            src_color_range=FULL if full else LIMITED,
            dst_color_range=LIMITED,
        )
    y, u, v = (
        np.frombuffer(p, np.uint8)[: p.height * p.line_size].reshape(p.height, p.line_size)[:, : p.width]
        for p in frame.planes
    )
    planes = resize_planes(Planes(y, u, v), upright)
    if facts.mirrored:
        planes = mirror_planes(planes)
    return turn_planes(planes, facts.rotation) if facts.rotation else planes


def _reformatter() -> VideoReformatter:
    """One per thread: it keeps its tables, and is not safe to share."""
    if not hasattr(_per_thread, "reformatter"):
        _per_thread.reformatter = VideoReformatter()
    return _per_thread.reformatter


def frame_from_planes(planes: Planes) -> Any:
    """An `av.VideoFrame`, yuv420p tagged BT.709 limited, holding a copy of ``planes``."""
    width, height = planes.size
    frame: Any = av.VideoFrame(width, height, "yuv420p")
    for target, source in zip(frame.planes, planes, strict=True):
        rows = np.frombuffer(target, np.uint8).reshape(target.height, target.line_size)
        rows[:, : source.shape[1]] = source
    frame.colorspace = frame.color_primaries = frame.color_trc = BT709
    frame.color_range = LIMITED
    return frame
