"""Still pictures laid over each other: what the analysis does for a pose, from one picture a camera."""

from __future__ import annotations

from collections.abc import Mapping

import cv2
import numpy as np
from attrs import frozen
from numpy.typing import NDArray

from mcsl_core.alignment.pose_solver import PoseSolver
from mcsl_core.alignment.protocol import Alignment
from mcsl_core.alignment.settings import SolveSettings
from mcsl_core.errors import UsageError
from mcsl_core.hooks.registry import discover
from mcsl_core.imaging.planes import U8, downscaled_size
from mcsl_core.progress import Silent
from mcsl_core.recording.sample_store import Sample
from mcsl_core.timing import FrameRange

_HEIGHT = 720  # rows that points are looked for in; there is one picture a camera, not the dozens of a pose


def align(
    pictures: Mapping[str, NDArray[np.uint8]],
    *,
    reference: str | None = None,
    matcher: str | None = None,
    aligner: str | None = None,
) -> Alignment:
    """Lays still pictures, taken at the same instant, over one of them.

    Parameters
    ----------
    pictures : mapping of str to (H, W, 3) uint8 array
        Camera name -> its picture, RGB; sizes may differ.
    reference : str, optional
        The camera over whose picture the others are laid; the first without.
    matcher, aligner : str, optional
        Names of the plugins to use (`mcsl plugins` lists them); the defaults without.

    Returns
    -------
    Alignment
        ``homographies``: camera -> 3x3 array, its pixel -> pixel of the reference. ``residual_px``, ``support``: how
        well and by how many distinct points each is tied. ``weak``: the cameras that could not be tied in, and why.

    Raises
    ------
    UsageError
        Where fewer than two pictures are given, one is no such array, or the reference is none of them.

    Notes
    -----
    The plane of the surgical field is what is aligned, found by its reds (the middle where there are none): what lies
    above or below it is off by its parallax. Over a recording the analysis has frames to choose from, and does better.

    Examples
    --------
    >>> found = mcsl.align({"cam1": a, "cam2": b}, reference="cam1")
    >>> height, width = a.shape[:2]
    >>> laid = cv2.warpPerspective(b, found.homographies["cam2"], (width, height))
    """
    bgr = {name: _bgr(name, picture) for name, picture in pictures.items()}
    if len(bgr) < 2:
        raise UsageError(f"two pictures or more are aligned, got {len(bgr)}", remedy='Give {"cam1": a, "cam2": b}')
    reference = next(iter(bgr)) if reference is None else reference
    if reference not in bgr:
        raise UsageError(f"there is no picture of {reference!r}", remedy=f"Take one of {', '.join(bgr)} as reference")
    plugins = discover()
    solver = PoseSolver(
        sizes={name: (picture.shape[1], picture.shape[0]) for name, picture in bgr.items()},
        reference=reference,
        matcher=plugins.choose("matcher", matcher).checked,
        aligner=plugins.choose("aligner", aligner).checked,
        settings=SolveSettings(),
    )
    only = _OneSample({name: _reduced(picture) for name, picture in bgr.items()})
    solved = solver.solve(FrameRange(0, 1), [0], only, Silent())
    pose = solved.pose
    return Alignment(solved.aligned.homographies, pose.residual_px, pose.support, pose.weak)


@frozen(eq=False)
class _OneSample:
    """Still pictures as the only sample of a recording."""

    pictures: Mapping[str, U8]

    @property
    def frames(self) -> tuple[int, ...]:
        return (0,)

    @property
    def cameras(self) -> tuple[str, ...]:
        return tuple(self.pictures)

    def picture(self, position: int, camera: str) -> U8 | None:
        return self.pictures[camera]

    def __getitem__(self, position: int) -> Sample:
        return Sample(0, self.pictures)


def _bgr(name: str, picture: NDArray[np.uint8]) -> U8:
    if not isinstance(picture, np.ndarray) or picture.dtype != np.uint8 or picture.ndim != 3 or picture.shape[2] != 3:
        given = (
            f"{picture.dtype} of shape {picture.shape}" if isinstance(picture, np.ndarray) else type(picture).__name__
        )
        raise UsageError(f"a picture is an (H, W, 3) uint8 array, RGB; got {given}", where=name)
    return np.ascontiguousarray(picture[..., ::-1])


def _reduced(picture: U8) -> U8:
    size = downscaled_size((picture.shape[1], picture.shape[0]), _HEIGHT)
    return np.asarray(cv2.resize(picture, size, interpolation=cv2.INTER_AREA), np.uint8)
