"""Which programme pixels come from a camera, and from which: the compositor and the filler run on plain pictures.

Each camera's picture is one brightness all over, so what comes out is how much of it the compositor and any filler,
built in or not, put where. Nothing is decoded but the few pictures that tell the cameras' parallax.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import attrs
import numpy as np
from attrs import frozen
from numpy.typing import NDArray

from mcsl_core.edl import Edl, Look
from mcsl_core.filling.protocol import Filler
from mcsl_core.imaging.planes import U8, Planes
from mcsl_core.recording.decoder import part_at
from mcsl_core.recording.footage import Footage
from mcsl_core.timing import FrameRange

from .compositor import Compositor
from .parallax import Parallax

_LIT, _DIM = 235, 126  # both bright: to the `reference` filler a dark pixel is a hole


def has_picture(footage: Footage, camera: str, frame: int) -> bool:
    """Whether a camera has a picture at a programme frame, as far as can be told without decoding.

    Parameters
    ----------
    footage : Footage
        The cameras' media.
    camera : str
        The camera's name.
    frame : int
        The programme frame.

    Returns
    -------
    bool
        False in a gap, before the media begin and after they end.
    """
    if footage.has_gap(camera, frame):
        return False
    time = footage.camera_time(camera, frame)
    part = part_at(footage.parts(camera), time)
    return part is not None and part.file_time(time) is not None


class Coverage:
    """Which cameras cover the programme's pixels; a pixel is covered where a camera's picture shows.

    Parameters
    ----------
    edl : Edl
        The programme.
    footage : Footage
        Its media.
    filler : Filler, optional
        As the `Compositor` takes it; for this alone, since a filler may keep what it worked out.
    look : Look, optional
        As the `Compositor` takes it.
    """

    def __init__(self, edl: Edl, footage: Footage, *, filler: Filler | None = None, look: Look | None = None) -> None:
        uncoloured = attrs.evolve(
            edl,
            look=attrs.evolve(edl.look, colour=False),
            overrides=tuple(attrs.evolve(o, colour=None) for o in edl.overrides),
        )
        look = None if look is None else attrs.evolve(look, colour=False)
        self._pictures = _PlainPictures(footage)
        parallax = Parallax(edl, footage)
        self._compositor = Compositor(uncoloured, self._pictures, filler=filler, look=look, parallax=parallax)

    def covered(self, frame: int) -> U8:
        """The covered pixels of a programme frame.

        Parameters
        ----------
        frame : int
            The programme frame.

        Returns
        -------
        (H, W) uint8
            255 where a camera's picture shows by at least half, else 0.
        """
        self._pictures.lit = ""
        return np.where(self._luma(frame) >= (16 + _DIM) // 2, 255, 0).astype(np.uint8)

    def shares(self, frame: int) -> Mapping[str, NDArray[np.float32]]:
        """How much of each pixel of a programme frame comes from each camera.

        Parameters
        ----------
        frame : int
            The programme frame.

        Returns
        -------
        mapping of str to (H, W) float32
            By camera, 0..1.
        """
        self._pictures.lit = ""
        ground = self._luma(frame).astype(np.float32)
        shares = {}
        for camera in self._pictures.footage.cameras:
            self._pictures.lit = camera.name
            shares[camera.name] = np.clip((self._luma(frame) - ground) / (_LIT - _DIM), 0, 1)
        return shares

    def _luma(self, frame: int) -> U8:
        return next(iter(self._compositor.frames(FrameRange(frame, frame + 1)))).y


class _PlainPictures:
    """A `PictureSource` of one brightness a camera, where ``footage`` has a picture; ``lit`` is the brighter camera."""

    def __init__(self, footage: Footage) -> None:
        self.footage = footage
        self.lit = ""

    def player(self, camera: str) -> _PlainPlayer:
        return _PlainPlayer(self, camera)

    def median(self, camera: str, frames: Sequence[int], within: FrameRange) -> Planes | None:
        return self.picture(camera) if any(has_picture(self.footage, camera, frame) for frame in frames) else None

    def picture(self, camera: str) -> Planes:
        width, height = self.footage.camera(camera).size
        chroma = np.full((height // 2, width // 2), 128, np.uint8)
        return Planes(np.full((height, width), _LIT if camera == self.lit else _DIM, np.uint8), chroma, chroma)


@frozen
class _PlainPlayer:
    pictures: _PlainPictures
    camera: str

    def at(self, frame: int) -> Planes | None:
        return self.pictures.picture(self.camera) if has_picture(self.pictures.footage, self.camera, frame) else None

    def close(self) -> None:
        """Nothing is open."""
