"""Test films whose every picture carries its number as black and white blocks; written and read without mcsl."""

from fractions import Fraction
from pathlib import Path

import av
import cv2
import numpy as np

BITS = 16
SIZE = (256, 144)
DATA = Path(__file__).parents[2] / "shared" / "data"


def coded_picture(number: int, size=SIZE, texture: int = 40) -> np.ndarray:
    """A moving texture with the number's bits in a row of 16 blocks across the upper quarter; the rest is texture."""
    width, height = size
    rng = np.random.default_rng(1)
    base = cv2.resize(rng.integers(100 - texture, 100 + texture, (9, 16, 3), dtype=np.uint8), size)
    picture = np.roll(base, number * 3, axis=1).copy()
    block = width // BITS
    for bit in range(BITS):
        picture[: height // 4, bit * block : (bit + 1) * block] = 235 if number >> bit & 1 else 20
    return picture


def read_number(picture: np.ndarray) -> int:
    """The number in a BGR or grey picture of any size."""
    grey = picture if picture.ndim == 2 else picture.mean(axis=2)
    height, width = grey.shape
    row = grey[height // 16 : 3 * height // 16].mean(axis=0)
    middles = [row[int((bit + 0.3) * width / BITS) : int((bit + 0.7) * width / BITS)].mean() for bit in range(BITS)]
    return sum(1 << bit for bit, value in enumerate(middles) if value > 128)


def write_coded(
    path,
    numbers,
    *,
    rate=Fraction(30),
    gop=12,
    bframes=2,
    options=None,
    stamps=None,
    time_base=None,
    size=SIZE,
    codec="libx264",
    sound=None,
    sound_rate=48000,
    rotate=None,
    aspect=None,
    container_options=None,
    pix_fmt="yuv420p",
):
    """Writes pictures ``numbers`` with PyAV alone. stamps: timestamps in ``time_base`` where not 0, 1, 2 / rate."""
    with av.open(str(path), "w", container_options=container_options or {}) as container:
        settings = {"preset": "veryfast", "crf": "20", "bf": str(bframes), "sc_threshold": "0"}
        stream = container.add_stream(codec, rate=rate, options=options or settings)
        stream.width, stream.height, stream.pix_fmt = *size, pix_fmt
        stream.codec_context.gop_size = gop
        if aspect is not None:
            stream.codec_context.sample_aspect_ratio = aspect
        base = time_base or 1 / Fraction(rate)
        stream.codec_context.time_base = base
        if rotate is not None:
            stream.set_display_rotation(rotate)
        track = None
        if sound is not None:
            track = container.add_stream("aac" if "mp4" in str(path) else "pcm_s16le", rate=sound_rate, layout="mono")
        for index, number in enumerate(numbers):
            frame = av.VideoFrame.from_ndarray(coded_picture(number, size), format="bgr24")
            frame = frame.reformat(format=pix_fmt, dst_colorspace="ITU709")
            frame.pts, frame.time_base = (index if stamps is None else stamps[index]), base
            container.mux(stream.encode(frame))
        container.mux(stream.encode(None))
        if track is not None:
            for start in range(0, len(sound), 4800):
                data = np.ascontiguousarray(sound[start : start + 4800], dtype=np.float32)[None]
                frame = av.AudioFrame.from_ndarray(data, format="fltp", layout="mono")
                frame.sample_rate, frame.pts, frame.time_base = sound_rate, start, Fraction(1, sound_rate)
                container.mux(track.encode(frame))
            container.mux(track.encode(None))
    return Path(path)
