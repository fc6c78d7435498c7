"""Films of a red field on green cloth by three cameras on one lamp, made without mcsl's simulator.

The lamp's way is any function of time; each camera moves in its own way with it. Heads are dark blue discs that go to
and fro. Some seconds of film take some seconds to make.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from fractions import Fraction
from pathlib import Path

import av
import cv2
import numpy as np
from attrs import frozen

from mcsl_core.edl import Camera, Media
from mcsl_core.recording.footage import Footage
from mcsl_core.timing import FrameRange

CAMERAS = 3


def ground(seed: int, size: int = 1400) -> np.ndarray:
    """(size, size, 3): what lies on the table."""
    rng = np.random.default_rng(seed)
    grey = np.zeros((size, size), np.float32)
    for k in (4, 9, 25, 80):
        grey += cv2.resize(rng.normal(0, 1, (size // k + 2,) * 2).astype(np.float32), (size, size)) * k**0.4
    grey = 40 + 170 * (grey - grey.min()) / np.ptp(grey)
    field = np.zeros((size, size, 1), np.float32)
    cv2.circle(field, (size // 2, size // 2), 130, 1, -1)
    green, red = grey[..., None] * (0.5, 1.0, 0.4), grey[..., None] * (0.3, 0.35, 1.1)
    return (green * (1 - field) + red * field).clip(0, 255).astype(np.uint8)


@frozen(kw_only=True)
class LampFilm:
    """What the three cameras film.

    Attributes
    ----------
    seconds, rate, size
        Of their films.
    heads
        Radius of the heads, in picture heights; 0 for none.
    frozen_cameras
        Cameras that show their first picture for ever.
    blind_cameras
        Cameras that have no picture in the middle third of the film.
    far_px
        How far the pictures move while the lamp goes all its way.
    seed
        Of all that is drawn from chance.
    """

    seconds: float
    rate: Fraction = Fraction(6)
    size: tuple[int, int] = (480, 270)
    heads: float = 0.0
    frozen_cameras: Sequence[int] = ()
    blind_cameras: Sequence[int] = ()
    far_px: float = 60.0
    seed: int = 1

    @property
    def frames(self) -> int:
        return round(self.seconds * self.rate)


def write_lamp(folder: Path, way: Callable[[float], float], **settings) -> Footage:
    """Films in ``folder``, and the footage of them.

    way: seconds -> 0..1, how far the lamp has gone of ``far_px``; ``settings`` are those of `LampFilm`.
    """
    film = LampFilm(**settings)
    rng = np.random.default_rng(film.seed)
    table = ground(film.seed)
    noises = [rng.normal(0, 1.5, (*film.size[::-1], 3)).astype(np.float32) for _ in range(7)]
    cameras = []
    for camera in range(CAMERAS):
        path = folder / f"cam{camera + 1}.mp4"
        phase = rng.uniform(0, 6, 2)
        with av.open(str(path), "w") as container:
            options = {"preset": "veryfast", "crf": "18", "sc_threshold": "0"}
            stream = container.add_stream("libx264", rate=film.rate, options=options)
            stream.width, stream.height, stream.pix_fmt = *film.size, "yuv420p"
            stream.codec_context.gop_size = round(film.rate)
            still = camera in film.frozen_cameras
            for n in range(film.frames):
                t = 0.0 if still else float(n / film.rate)
                picture = seen(table, camera, way(t) * film.far_px, film.size).astype(np.float32)
                _draw_heads(picture, film.heads, t, phase)
                noise = 0 if still else noises[n % len(noises)]
                frame = (picture + noise).round().clip(0, 255).astype(np.uint8)
                container.mux(stream.encode(av.VideoFrame.from_ndarray(frame, format="bgr24")))
            container.mux(stream.encode(None))
        cameras.append(_camera(path, film, blind=camera in film.blind_cameras))
    return Footage(cameras, rate=film.rate, frames=film.frames, base=folder)


def _draw_heads(picture: np.ndarray, radius: float, t: float, phase: np.ndarray) -> None:
    height, width = picture.shape[:2]
    for k in range(2 if radius else 0):
        x = (0.5 + 0.6 * np.sin(0.7 * t + phase[k])) * width
        y = (0.25 + 0.5 * k + 0.05 * np.sin(1.3 * t)) * height
        cv2.circle(picture, (int(x), int(y)), int(radius * height), (90, 50, 20), -1)


def seen(table: np.ndarray, camera: int, gone_px: float, size: tuple[int, int]) -> np.ndarray:
    """What ``camera`` sees of the table once the lamp has moved the pictures by about ``gone_px``."""
    middle = (table.shape[1] / 2, table.shape[0] / 2)
    turn = cv2.getRotationMatrix2D(middle, 120 * camera + 0.08 * gone_px * (camera - 0.7), 0.6 + 0.0005 * gone_px)
    away = np.deg2rad(120 * camera + 40)
    turn[:, 2] += np.array([size[0] / 2, size[1] / 2]) - middle
    turn[:, 2] += gone_px * np.array([np.cos(away), np.sin(away)])
    return cv2.warpAffine(table, turn, size, flags=cv2.INTER_AREA, borderMode=cv2.BORDER_REFLECT)


def _camera(path: Path, film: LampFilm, *, blind: bool) -> Camera:
    gaps = (FrameRange(film.frames // 3, 2 * film.frames // 3),) if blind else ()
    return Camera(path.stem, (Media(path.name, film.frames, "0"),), film.size, film.rate, gaps=gaps)
