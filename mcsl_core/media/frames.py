"""Decoded frames as pictures and back: colours to BT.709 limited, upright, square pixels."""

from __future__ import annotations

import threading
from typing import Any

import av
import numpy as np
from av.video.reformatter import Colorspace, VideoReformatter

from mcsl_core.imaging.planes import Planes, mirror_planes, resize_planes, turn_planes

from .facts import MediaFacts

BT709 = 1  # the same number for primaries, transfer and matrix in ITU-T H.273
LIMITED = 1  # AVCOL_RANGE_MPEG

_BT601 = (5, 6)  # BT.470BG, SMPTE 170M
_BT2020 = (9, 10)
_FULL = 2  # AVCOL_RANGE_JPEG
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
    Pictures without a colour tag are BT.709 from 720 rows or 1280 columns up and BT.601 below, as players take them.
    """
    upright = facts.size if facts.rotation % 180 == 0 else (facts.size[1], facts.size[0])
    bt601 = frame.colorspace in _BT601 or (frame.colorspace not in (0, BT709, *_BT2020) and _is_small(frame))
    full = frame.color_range == _FULL or frame.format.name.startswith("yuvj")
    odd = frame.width % 2 or frame.height % 2
    if frame.format.name != "yuv420p" or bt601 or full or odd:
        rgb = frame.format.is_rgb
        frame = _reformatter().reformat(
            frame,
            width=frame.width + frame.width % 2,
            height=frame.height + frame.height % 2,
            format="yuv420p",
            src_colorspace=_matrix_of(frame, bt601=bt601 and not rgb),
            dst_colorspace=Colorspace.ITU709,
            src_color_range=_FULL if full or rgb else LIMITED,
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


def _matrix_of(frame: Any, *, bt601: bool) -> Colorspace:
    if bt601:
        return Colorspace.ITU601
    return Colorspace.BT2020 if frame.colorspace in _BT2020 else Colorspace.ITU709


def _is_small(frame: Any) -> bool:
    return max(frame.width, frame.height) < 1280 and min(frame.width, frame.height) < 720


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
