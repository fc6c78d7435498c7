"""Test films whose every picture carries its number as black and white blocks; written and read without mcsl."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from pathlib import Path

import av
import cv2
import numpy as np
from attrs import field, frozen

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


@frozen(kw_only=True)
class Film:
    """How a test film is coded.

    Attributes
    ----------
    rate, size, codec, pix_fmt
        Of its video.
    gop, bframes
        Most frames from one keyframe to the next, and B-frames between two others.
    options, container_options
        FFmpeg's, of the encoder (in place of the preset and ``bframes``) and of the container.
    stamps, time_base
        Timestamps of the pictures in ``time_base`` where they are not 0, 1, 2 / rate.
    rotate, aspect
        Degrees of its display rotation, and its sample aspect ratio.
    sound, sound_rate
        (n,) audio samples in -1..1.
    """

    rate: Fraction = field(default=Fraction(30), converter=Fraction)
    size: tuple[int, int] = SIZE
    codec: str = "libx264"
    pix_fmt: str = "yuv420p"
    gop: int = 12
    bframes: int = 2
    options: dict | None = None
    container_options: dict | None = None
    stamps: Sequence[int] | None = None
    time_base: Fraction | None = None
    rotate: int | None = None
    aspect: Fraction | None = None
    sound: np.ndarray | None = None
    sound_rate: int = 48000

    @property
    def tick(self) -> Fraction:
        return self.time_base or 1 / self.rate


def write_coded(path, numbers, **settings) -> Path:
    """Writes pictures ``numbers`` with PyAV alone; ``settings`` are those of `Film`."""
    film = Film(**settings)
    with av.open(str(path), "w", container_options=film.container_options or {}) as container:
        stream = _video_stream(container, film)
        audio = "aac" if "mp4" in str(path) else "pcm_s16le"
        track = container.add_stream(audio, rate=film.sound_rate, layout="mono") if film.sound is not None else None
        for index, number in enumerate(numbers):
            frame = av.VideoFrame.from_ndarray(coded_picture(number, film.size), format="bgr24")
            frame = frame.reformat(format=film.pix_fmt, dst_colorspace="ITU709")
            frame.pts = index if film.stamps is None else film.stamps[index]
            frame.time_base = film.tick
            container.mux(stream.encode(frame))
        container.mux(stream.encode(None))
        if track is not None:
            _write_sound(container, track, film)
    return Path(path)


def _video_stream(container, film: Film):
    settings = {"preset": "veryfast", "crf": "20", "bf": str(film.bframes), "sc_threshold": "0"}
    stream = container.add_stream(film.codec, rate=film.rate, options=film.options or settings)
    stream.width, stream.height, stream.pix_fmt = *film.size, film.pix_fmt
    stream.codec_context.gop_size = film.gop
    if film.aspect is not None:
        stream.codec_context.sample_aspect_ratio = film.aspect
    stream.codec_context.time_base = film.tick
    if film.rotate is not None:
        stream.set_display_rotation(film.rotate)
    return stream


def _write_sound(container, track, film: Film) -> None:
    for start in range(0, len(film.sound), 4800):
        data = np.ascontiguousarray(film.sound[start : start + 4800], dtype=np.float32)[None]
        frame = av.AudioFrame.from_ndarray(data, format="fltp", layout="mono")
        frame.sample_rate, frame.pts, frame.time_base = film.sound_rate, start, Fraction(1, film.sound_rate)
        container.mux(track.encode(frame))
    container.mux(track.encode(None))
