"""Pictures of a programme, and how alike two are: for tests to judge by."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mcsl_core.compositing.compositor import Compositor
from mcsl_core.edl import Edl
from mcsl_core.filling.protocol import Filler
from mcsl_core.imaging.planes import Planes
from mcsl_core.recording.footage import footage_of
from mcsl_core.timing import FrameRange


def programme_frames(
    edl: Edl, base: Path, piece: FrameRange | None = None, *, filler: Filler | None = None
) -> Iterator[Planes]:
    """The pictures of ``edl`` over ``piece`` (all of it without), one after another."""
    with Compositor(edl, footage_of(edl, base, threads=1), filler=filler) as compositor:
        yield from compositor.frames(piece or FrameRange(0, edl.frames))


def psnr(a: NDArray, b: NDArray, mask: NDArray | None = None) -> float:
    """Peak signal-to-noise ratio in dB of two 8-bit pictures of one shape; infinite when they are equal.

    mask: (H, W), only pixels where it is non-zero count.
    """
    assert a.shape == b.shape, f"pictures of different shape: {a.shape} and {b.shape}"
    difference = a.astype(np.float64) - b
    if mask is not None:
        difference = difference[mask != 0]
    error = float(np.mean(difference**2)) if difference.size else math.nan
    return math.inf if error == 0 else 10 * math.log10(255**2 / error)
