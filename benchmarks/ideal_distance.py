"""How far a picture is from the ideal programme's: by its codes, and by its structure whatever its gain."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import cv2
import numpy as np
from attrs import frozen
from numpy.typing import NDArray

from mcsl_core.simulation import Truth

U8 = NDArray[np.uint8]
CEILING_DB = 60.0  # equal pictures
LEAST = 400  # pixels
HEADS = 0.9  # under heads: of the chosen camera's field no more than this is seen past heads, shoulders and arms
_SIGMA = 1.5  # of SSIM's window
_C1, _C2 = (0.01 * 255) ** 2, (0.03 * 255) ** 2


@frozen
class Distance:
    """Of two pictures.

    Attributes
    ----------
    psnr_db : float
        Over the field.
    ssim : float
        The same after gain and offset were fitted: -1..1.
    """

    psnr_db: float
    ssim: float


def distance(made: U8, ideal: U8, mask: NDArray[np.bool_]) -> Distance | None:
    """The distance of a picture's luma to the ideal one's, where ``mask`` is; None where that is too little to tell.

    References
    ----------
    Z. Wang, A. Bovik, H. Sheikh, E. Simoncelli: Image quality assessment, IEEE Transactions on Image Processing 2004.
    """
    if mask.sum() < LEAST:
        return None
    a, b = made.astype(np.float64), ideal.astype(np.float64)
    error = float(((a - b)[mask] ** 2).mean())
    psnr = CEILING_DB if error == 0 else min(CEILING_DB, 10 * np.log10(255**2 / error))
    return Distance(float(psnr), float(_ssim(_levelled(a, b, mask), b)[mask].mean()))


def _levelled(a: NDArray, b: NDArray, mask: NDArray[np.bool_]) -> NDArray:
    """``a`` with the gain and offset that bring it nearest to ``b``."""
    x, y = a[mask], b[mask]
    gain = ((x - x.mean()) * (y - y.mean())).mean() / max(float(x.var()), 1e-6)
    gain = float(np.clip(gain, 0.25, 4))
    return gain * (a - x.mean()) + y.mean()


def _ssim(a: NDArray, b: NDArray) -> NDArray:
    def mean(v: NDArray) -> NDArray:
        return np.asarray(cv2.GaussianBlur(v, (0, 0), _SIGMA))

    ma, mb = mean(a), mean(b)
    va, vb, both = mean(a * a) - ma * ma, mean(b * b) - mb * mb, mean(a * b) - ma * mb
    return (2 * ma * mb + _C1) * (2 * both + _C2) / ((ma * ma + mb * mb + _C1) * (va + vb + _C2))


def occasions(truth: Truth, shown: Sequence[str]) -> Mapping[str, NDArray[np.bool_]]:
    """Which frames are which: all, standing, moving, and with heads over the chosen camera's field.

    Parameters
    ----------
    truth
        Of the recording.
    shown
        The chosen camera by frame.
    """
    frames = len(shown)
    moving = np.zeros(frames, bool)
    for start, stop in truth.movements:
        moving[start:stop] = True
    cameras = [truth.camera_index(camera) for camera in shown]
    heads = truth.visible_field_without_hands[np.arange(frames), cameras] < HEADS
    return {"all": np.ones(frames, bool), "standing": ~moving, "moving": moving, "heads": heads & ~moving}


def means(distances: Sequence[Distance | None], which: NDArray[np.bool_]) -> tuple[float, float] | None:
    """Means of PSNR and structure over the frames ``which`` that have them; None where there are none."""
    known = [(d.psnr_db, d.ssim) for d, chosen in zip(distances, which, strict=True) if chosen and d is not None]
    if not known:
        return None
    psnr, ssim = np.mean(known, axis=0)
    return round(float(psnr), 3), round(float(ssim), 4)
