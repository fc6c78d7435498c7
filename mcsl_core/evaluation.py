"""How steady a programme is, by the paper's measure, and the programme that it is held against."""

from __future__ import annotations

import math
from collections.abc import Iterable

import attrs
import numpy as np
from numpy.typing import NDArray

from .edl import IDENTITY, Edl, Look
from .images import psnr


def without_alignment(edl: Edl) -> Edl:
    """The same shots with every view as its camera saw it (the paper's No-alignment): no warp, no look."""
    names = [c.name for c in edl.cameras]
    poses = tuple(
        attrs.evolve(p, homographies=dict.fromkeys(names, IDENTITY), anchor=IDENTITY, weak=()) for p in edl.poses
    )
    return attrs.evolve(edl, poses=poses, look=Look(centering=False, fill=False, colour=False))


def interframe_fidelity(pictures: Iterable[NDArray[np.uint8]], *, ceiling_db: float = 60.0) -> float:
    """ITF in dB: the mean PSNR between neighbouring pictures (the paper's equation for ITF). Higher is steadier.

    pictures: (H, W) or (H, W, 3) uint8, at least two. Equal neighbours count as ``ceiling_db``, since their PSNR is
    infinite.
    """
    values: list[float] = []
    before: NDArray[np.uint8] | None = None
    for picture in pictures:
        if before is not None:
            values.append(min(psnr(before, picture), ceiling_db))
        before = picture
    if not values:
        raise ValueError("ITF needs at least two pictures")
    return math.fsum(values) / len(values)
