"""How much a picture differs from the one after it: PSNR, and how far feature points move (the paper's ITF, AvSpeed).

Pictures are grey, (H, W) uint8, full range. Points are (x, y) in the pixels of the picture they were found in,
centres at integers.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import cv2
import numpy as np
from attrs import field, frozen
from numpy.typing import NDArray

from mcsl_core.alignment.features import RootSift
from mcsl_core.imaging.planes import U8, Planes

Points = NDArray[np.float64]
Lay = Callable[[Points], Points]

CEILING_DB = 60.0  # equal pictures: their PSNR is infinite, and one still pair must not decide a mean

# How it was measured, in words for a table's foot.
FOLLOWED = "Shi-Tomasi corners followed by pyramidal Lucas-Kanade, there and back within 0.5 px"
MATCHED = "RootSIFT, mutual nearest neighbours (ratio 0.85), within 5 % of the width of the plane that a third share"

_LEAST_POINTS = 8
_LEAST_PLANAR = 12  # four points fix a homography; three times as many that agree are no chance
_LEAST_SHARE = 1 / 3  # of a head seen by both cameras a fifth of the matches agreed, of the field two fifths and more
_WINDOW = (15, 15)
_LEVELS = 3


def grey(planes: Planes) -> U8:
    """The luma of ``planes`` in full range: 16 becomes 0, 235 becomes 255."""
    return cv2.convertScaleAbs(planes.y.astype(np.float32) - 16, alpha=255 / 219).clip(0, 255)  # pyright: ignore


def fidelity_db(a: U8, b: U8, mask: U8 | None = None) -> float:
    """PSNR of two pictures; its mean over all pairs of neighbouring frames is the paper's ITF.

    Parameters
    ----------
    a, b : (H, W) uint8
        Grey, full range.
    mask : (H, W) uint8, optional
        Only where it is not 0.

    Returns
    -------
    float
        In dB, `CEILING_DB` at most; NaN where the mask is empty.
    """
    count = a.size if mask is None else cv2.countNonZero(mask)
    if not count:
        return math.nan
    error = (cv2.norm(a, b, cv2.NORM_L2SQR) if mask is None else cv2.norm(a, b, cv2.NORM_L2SQR, mask)) / count
    return CEILING_DB if error == 0 else min(CEILING_DB, 10 * math.log10(255**2 / error))


@frozen(eq=False)
class Tracks:
    """The same points in two pictures.

    Attributes
    ----------
    before, after : (N, 2) float64
        (x, y) in pixels of either picture.
    """

    before: Points
    after: Points

    def __len__(self) -> int:
        return len(self.before)


NO_TRACKS = Tracks(np.zeros((0, 2)), np.zeros((0, 2)))


@frozen
class Tracker:
    """Finds the tracks of two pictures.

    Parameters
    ----------
    corners : int
        How many at most.
    spacing_px : float
        Least distance between them.
    off_plane : float
        How far from the plane of most matches one may lie, as a share of the picture's width: hands a decimetre above
        the field still count, chance matches (a hundredth of the picture's area fits) hardly do.
    matcher : RootSift
        For two cameras' pictures.

    References
    ----------
    J. Shi, C. Tomasi: Good features to track. CVPR 1994.
    J.-Y. Bouguet: Pyramidal implementation of the affine Lucas Kanade feature tracker. Intel, 2001.
    D. Barath, J. Noskova, M. Ivashechkin, J. Matas: MAGSAC++. CVPR 2020.
    """

    corners: int = 400
    spacing_px: float = 8
    off_plane: float = 0.05
    matcher: RootSift = field(factory=RootSift)

    def follow(self, a: U8, b: U8) -> Tracks:
        """Corners of one picture followed into another: for one camera's neighbouring pictures.

        Parameters
        ----------
        a, b : (H, W) uint8
            Grey, full range.

        Returns
        -------
        Tracks
            Those that lead there and back within half a pixel; none where there are fewer than eight.
        """
        corners = cv2.goodFeaturesToTrack(a, self.corners, 0.01, self.spacing_px)
        if corners is None or len(corners) < _LEAST_POINTS:
            return NO_TRACKS
        options = {"winSize": _WINDOW, "maxLevel": _LEVELS}
        there, found, _ = cv2.calcOpticalFlowPyrLK(a, b, corners, None, **options)  # pyright: ignore
        back, returned, _ = cv2.calcOpticalFlowPyrLK(b, a, there, None, **options)  # pyright: ignore
        start, end = corners.reshape(-1, 2), there.reshape(-1, 2)
        same = np.linalg.norm(back.reshape(-1, 2) - start, axis=1) < 0.5
        keep = (found.ravel() == 1) & (returned.ravel() == 1) & same
        return _enough(Tracks(start[keep].astype(np.float64), end[keep].astype(np.float64)))

    def match(self, a: U8, b: U8) -> Tracks:
        """Points of one picture found again in another, however far and turned: for two cameras at about one time.

        Parameters
        ----------
        a, b : (H, W) uint8
            Grey, full range.

        Returns
        -------
        Tracks
            Those near the plane that most share; none where fewer than a third share one.
        """
        of_a, of_b = self.matcher.features(a), self.matcher.features(b)
        pairs = self.matcher.match(of_a, of_b)
        before = of_a.points[pairs[:, 0]].astype(np.float64)
        after = of_b.points[pairs[:, 1]].astype(np.float64)
        if len(pairs) < _LEAST_PLANAR:
            return NO_TRACKS
        width = b.shape[1]
        plane, planar = cv2.findHomography(
            before, after, cv2.USAC_MAGSAC, 0.01 * width, maxIters=5000, confidence=0.999
        )
        if plane is None or planar is None:
            return NO_TRACKS
        if np.count_nonzero(planar) < max(_LEAST_PLANAR, _LEAST_SHARE * len(pairs)):
            return NO_TRACKS
        off = np.linalg.norm(carried(plane, before) - after, axis=1)
        keep = off < self.off_plane * width
        return _enough(Tracks(before[keep], after[keep]))


def _enough(tracks: Tracks) -> Tracks:
    return tracks if len(tracks) >= _LEAST_POINTS else NO_TRACKS


def carried(matrix: NDArray, points: Points) -> Points:
    """Points through a homography.

    Parameters
    ----------
    matrix : (3, 3) float64
        The homography.
    points : (N, 2) float64
        (x, y).

    Returns
    -------
    (N, 2) float64
        NaN at or behind its horizon.
    """
    x, y, w = matrix @ np.column_stack([points, np.ones(len(points))]).T
    w = np.where(w * matrix[2, 2] > 1e-9, w, np.nan)
    return np.column_stack([x / w, y / w])


def speed_px(tracks: Tracks, before: NDArray | Lay, after: NDArray | Lay, size: tuple[int, int]) -> float:
    """Mean distance that tracks move in the programme; its mean over all pairs is the paper's AvSpeed.

    Parameters
    ----------
    tracks : Tracks
        In the two cameras' own pictures.
    before, after : (3, 3) float64, or callable
        Pixel of either picture -> programme pixel; a function for (N, 2) points, with NaN for what has no place.
    size : (int, int)
        Width and height of the programme. Points that lie outside it in either frame do not count.

    Returns
    -------
    float
        Programme pixels a frame; NaN with fewer than eight points.
    """
    start, end = (
        lay(points) if callable(lay) else carried(lay, points)
        for lay, points in ((before, tracks.before), (after, tracks.after))
    )
    edge = np.array(size) - 0.5
    with np.errstate(invalid="ignore"):
        inside = ((start >= -0.5) & (start <= edge) & (end >= -0.5) & (end <= edge)).all(axis=1)
    if np.count_nonzero(inside) < _LEAST_POINTS:
        return math.nan
    return float(np.linalg.norm(end[inside] - start[inside], axis=1).mean())
