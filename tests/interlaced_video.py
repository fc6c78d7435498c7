"""Interlaced test films: pictures of a known motion taken field by field; written without mcsl."""

from __future__ import annotations

from fractions import Fraction
from functools import lru_cache
from pathlib import Path

import av
import cv2
import numpy as np
from av.filter import Graph

SIZE = (352, 288)
CODINGS = {
    "h264": ("libx264", "yuv420p", {"x264-params": "{first}=1:keyint=12:bframes=2:scenecut=0", "crf": "12"}),
    "h264-open-gop": ("libx264", "yuv420p", {"x264-params": "{first}=1:keyint=12:open-gop=1:bframes=3", "crf": "12"}),
    "mpeg2": ("mpeg2video", "yuv420p", {"flags": "+ildct+ilme", "b": "9M", "g": "12", "bf": "2"}),
    "mpeg2-422": ("mpeg2video", "yuv422p", {"flags": "+ildct+ilme", "b": "12M", "g": "12", "bf": "2"}),
    "prores": ("prores_ks", "yuv422p10le", {"flags": "+ildct"}),
    "ffv1": ("ffv1", "yuv420p", {}),
}


@lru_cache(maxsize=256)
def true_picture(field: int, size=SIZE) -> np.ndarray:
    """What stood before the camera at ``field``, (H, W, 3): still texture, a patterned disc moving over it."""
    width, height = size
    rng = np.random.default_rng(5)
    still = cv2.resize(rng.integers(60, 190, (36, 44, 3), dtype=np.uint8), size, interpolation=cv2.INTER_CUBIC)
    x, y = width * 0.2 + 2.6 * field % (width * 0.6), height / 2 + height / 6 * np.sin(field / 9)
    disc = np.zeros((height, width), np.uint8)
    cv2.circle(disc, (round(x * 8), round(y * 8)), height // 5 * 8, 255, -1, cv2.LINE_AA, 3)
    stripes = 128 + 90 * np.sin((np.arange(width) - x) / 5)
    pattern = np.repeat(np.stack([stripes, stripes[::-1], 255 - stripes], 1)[None], height, 0)
    share = cv2.GaussianBlur(disc, (0, 0), 1)[..., None] / 255
    return (still * (1 - share) + pattern * share).astype(np.uint8)


def woven_picture(k: int, first: str = "top", size=SIZE) -> np.ndarray:
    """Frame ``k``: rows of the field at 2k and of that at 2k + 1."""
    early, late = true_picture(2 * k, size), true_picture(2 * k + 1, size)
    top, bottom = (early, late) if first == "top" else (late, early)
    picture = top.copy()
    picture[1::2] = bottom[1::2]
    return picture


def planes_of(picture: np.ndarray, form: str) -> av.VideoFrame:
    """The frame of a woven picture; chroma of each field made of its own rows."""
    fields = [
        av.VideoFrame.from_ndarray(np.ascontiguousarray(picture[at::2]), format="bgr24").reformat(
            format=form, dst_colorspace="ITU709", dst_color_range="MPEG"
        )
        for at in (0, 1)
    ]
    frame = av.VideoFrame(picture.shape[1], picture.shape[0], form)
    wide = np.uint16 if "10" in form else np.uint8
    for target, *sources in zip(frame.planes, *(f.planes for f in fields), strict=True):
        rows = np.frombuffer(target, wide).reshape(target.height, -1)
        for at, source in enumerate(sources):
            rows[at::2, : target.width] = np.frombuffer(source, wide).reshape(source.height, -1)[:, : target.width]
    frame.colorspace, frame.color_range = 1, 1
    return frame


def write_interlaced(path, frames=40, *, coding="h264", first="top", content="fields", flag="same", size=SIZE) -> Path:
    """Writes an interlaced film at 25 frames a second.

    Parameters
    ----------
    coding
        One of `CODINGS`.
    first
        The field shown first: top or bottom.
    content
        "fields", or "progressive": pictures whole, which ``flag`` may call interlaced.
    flag
        "same" as the coding says, or "none": coded as if it were progressive.
    """
    codec, form, options = CODINGS[coding]
    name = {"top": "tff", "bottom": "bff"}[first]
    if flag == "none":
        options = {"crf": "12", "g": "12"}
    graph = Graph()
    source = graph.add("buffer", f"video_size={size[0]}x{size[1]}:pix_fmt={form}:time_base=1/25:colorspace=1:range=1")
    setting = graph.add("setfield", "prog" if flag == "none" else name)
    graph.link_nodes(source, setting, graph.add("buffersink")).configure()
    with av.open(str(path), "w") as container:
        options = {key: value.format(first=name) for key, value in options.items()}
        stream = container.add_stream(codec, rate=25, options=options)
        stream.width, stream.height, stream.pix_fmt = *size, form
        stream.codec_context.colorspace, stream.codec_context.color_range = 1, 1
        if flag == "same":
            stream.codec_context.field_order = 2 if first == "top" else 3
        for k in range(frames):
            whole = content == "progressive"
            picture = true_picture(2 * k, size) if whole else woven_picture(k, first, size)
            frame = planes_of(picture, form)
            frame.pts, frame.time_base = k, Fraction(1, 25)
            graph.push(frame)
            container.mux(stream.encode(graph.pull()))
        container.mux(stream.encode(None))
    return Path(path)
