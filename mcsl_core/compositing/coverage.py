"""Which programme pixels come from a camera, and from which: the compositor and the filler run on plain pictures.

Each camera's picture is one brightness all over, so what comes out is how much of it the compositor and any filler,
built in or not, put where. Nothing is decoded but the few pictures that tell the cameras' parallax.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import attrs
import numpy as np
from numpy.typing import NDArray

from mcsl_core.edl import Edl, Look
from mcsl_core.filling.protocol import Filler
from mcsl_core.imaging.planes import U8, Planes
from mcsl_core.recording.decoder import Part, part_at
from mcsl_core.recording.footage import Footage
from mcsl_core.timing import FrameRange

from .compositor import Compositor
from .parallax import Parallax

_LIT, _DIM = 235, 126  # both bright: to the `reference` filler a dark pixel is a hole


class _PlainPlayer:
    def __init__(self, footage: _PlainFootage, camera: str) -> None:
        self._footage, self._camera = footage, camera

    def at(self, frame: int) -> Planes | None:
        return self._footage.plain(self._camera) if has_picture(self._footage, self._camera, frame) else None

    def close(self) -> None:
        """Nothing is open."""


class _PlainFootage(Footage):
    """Pictures of one brightness, there where ``source`` has one."""

    def __init__(self, source: Footage) -> None:
        super().__init__(source.cameras, rate=source.rate, frames=source.frames, base=source.base)
        self._source = source
        self.lit = ""

    def parts(self, camera: str) -> tuple[Part, ...]:
        return self._source.parts(camera)

    def plain(self, camera: str) -> Planes:
        width, height = self.camera(camera).size
        chroma = np.full((height // 2, width // 2), 128, np.uint8)
        return Planes(np.full((height, width), _LIT if camera == self.lit else _DIM, np.uint8), chroma, chroma)

    def player(self, camera: str) -> _PlainPlayer:  # pyright: ignore[reportIncompatibleMethodOverride]
        return _PlainPlayer(self, camera)

    def median(self, camera: str, frames: Sequence[int], within: FrameRange) -> Planes | None:
        return self.plain(camera) if any(has_picture(self, camera, frame) for frame in frames) else None


def has_picture(footage: Footage, camera: str, frame: int) -> bool:
    """Whether the camera has a picture at a programme frame, as far as can be told without decoding."""
    if footage.has_gap(camera, frame):
        return False
    time = footage.camera_time(camera, frame)
    part = part_at(footage.parts(camera), time)
    return part is not None and part.file_time(time) is not None


class Coverage:
    """What covers the programme's pixels. filler, look: as the `Compositor` takes them, the filler for this alone."""

    def __init__(self, edl: Edl, footage: Footage, *, filler: Filler | None = None, look: Look | None = None) -> None:
        plain = attrs.evolve(
            edl,
            look=attrs.evolve(edl.look, colour=False),
            overrides=tuple(attrs.evolve(o, colour=None) for o in edl.overrides),
        )
        self._footage = _PlainFootage(footage)
        look = None if look is None else attrs.evolve(look, colour=False)
        parallax = Parallax(edl, footage)
        self._compositor = Compositor(plain, self._footage, filler=filler, look=look, parallax=parallax)

    def covered(self, frame: int) -> U8:
        """(H, W): 255 where programme frame ``frame`` shows a camera's picture by at least half, else 0."""
        self._footage.lit = ""
        return np.where(self._luma(frame) >= (16 + _DIM) // 2, 255, 0).astype(np.uint8)

    def shares(self, frame: int) -> Mapping[str, NDArray[np.float32]]:
        """camera -> (H, W) 0..1, how much of each pixel of programme frame ``frame`` is its."""
        self._footage.lit = ""
        ground = self._luma(frame).astype(np.float32)
        made = {}
        for camera in self._footage.cameras:
            self._footage.lit = camera.name
            made[camera.name] = np.clip((self._luma(frame) - ground) / (_LIT - _DIM), 0, 1)
        return made

    def _luma(self, frame: int) -> U8:
        return next(iter(self._compositor.frames(FrameRange(frame, frame + 1)))).y
