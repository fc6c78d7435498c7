"""Masks of the surgical field and of footprints: by hue, by connected region, closed, feathered.

Masks are (H, W), bool or uint8 (0 and 255) as each function says; sizes are (width, height).
"""

from __future__ import annotations

from collections.abc import Iterable

import cv2
import numpy as np
from numpy.typing import NDArray

from .planes import U8

Mask = NDArray[np.bool_]


def hue_mask(picture: U8, *, saturation: int = 60, value: int = 40) -> U8:
    """The pixels that have the surgical field's reds: hue 0-30 or 150-179 on OpenCV's scale of 180.

    Parameters
    ----------
    picture
        (H, W, 3), BGR.
    saturation, value
        The least ones that count, 0..255: nearly grey and nearly black pixels have no meaningful hue.

    Returns
    -------
    U8
        (H, W), 255 in the field and 0 elsewhere.

    References
    ----------
    The paper, section "View Alignment", for the hues.
    """
    hsv = cv2.cvtColor(picture, cv2.COLOR_BGR2HSV)
    low = cv2.inRange(hsv, (0, saturation, value), (30, 255, 255))  # pyright: ignore
    high = cv2.inRange(hsv, (150, saturation, value), (179, 255, 255))  # pyright: ignore
    return cv2.bitwise_or(low, high)  # pyright: ignore[reportReturnType]


def feathered(mask: U8, width_px: float) -> U8:
    """A soft mask: 0 outside ``mask``, rising smoothly to 255 at ``width_px`` pixels inside its edge.

    Parameters
    ----------
    mask
        (H, W), non-zero inside.
    width_px
        Width of the ramp; 0 gives a hard mask.

    Returns
    -------
    U8
        (H, W), 0..255.

    Notes
    -----
    The picture's own edge is no edge of the mask.
    """
    if width_px <= 0:
        return np.where(mask != 0, 255, 0).astype(np.uint8)
    distance = cv2.distanceTransform(np.where(mask != 0, 255, 0).astype(np.uint8), cv2.DIST_L2, 5)
    ramp = np.clip((distance - 1) / width_px, 0, 1)  # the outermost pixel is half outside: none of it
    return np.round(255 * ramp * ramp * (3 - 2 * ramp)).astype(np.uint8)


def main_region(mask: Mask, *, least: float = 0.004) -> Mask:
    """The largest connected region and those at least a fifth as large, opened and closed.

    Parameters
    ----------
    mask
        (H, W).
    least
        Share of the picture, 0..1, below which a region does not count; empty where the largest is smaller.
    """
    size = max(3, round(0.012 * mask.shape[1]) | 1)
    kernel = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (size, size))
    closed = cv2.morphologyEx(mask.astype(np.uint8), cv2.MORPH_OPEN, kernel)
    closed = cv2.morphologyEx(closed, cv2.MORPH_CLOSE, kernel)
    count, labels, stats, _ = cv2.connectedComponentsWithStats(closed)
    if count < 2:
        return np.zeros(mask.shape, bool)
    areas = stats[1:, cv2.CC_STAT_AREA]
    if areas.max() < least * mask.size:
        return np.zeros(mask.shape, bool)
    keep = np.flatnonzero(areas >= max(areas.max() / 5, least * mask.size)) + 1
    return np.isin(labels, keep)


def resize_mask(mask: Mask, size: tuple[int, int]) -> Mask:
    """``mask`` at another ``size`` (width, height), by nearest neighbour."""
    return cv2.resize(mask.astype(np.uint8), size, interpolation=cv2.INTER_NEAREST) > 0


def mask_at(mask: Mask, points: NDArray[np.float64]) -> Mask:
    """(N,): a mask at the pixels nearest to (N, 2) points; False outside."""
    at = np.round(points).astype(int)
    inside = ((at >= 0) & (at < (mask.shape[1], mask.shape[0]))).all(axis=1)
    at[~inside] = 0
    return inside & mask[at[:, 1], at[:, 0]]


def warp_mask(mask: Mask, matrix: NDArray[np.float64], size: tuple[int, int]) -> Mask:
    """A mask in other pixels, ``matrix`` (3, 3) leading there from its own, by nearest neighbour; nothing outside."""
    return cv2.warpPerspective(mask.astype(np.uint8), matrix, size, flags=cv2.INTER_NEAREST) > 0


def close_gaps(mask: Mask, *, gap: float = 0.05) -> Mask:
    """``mask`` with gaps up to ``gap`` of its width closed (instruments, a dark wound) and its holes filled."""
    size = max(3, round(gap * mask.shape[1]) | 1)
    kernel = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (size, size))
    padded = np.pad(mask.astype(np.uint8), size)
    closed = cv2.morphologyEx(padded, cv2.MORPH_CLOSE, kernel)[size:-size, size:-size]
    outlines, _ = cv2.findContours(closed, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    filled = np.zeros(mask.shape, np.uint8)
    cv2.drawContours(filled, outlines, -1, 1, cv2.FILLED)
    return filled > 0


def polygon_mask(polygons: Iterable[NDArray[np.float64]], size: tuple[int, int]) -> Mask:
    """What lies in any of some polygons, each (N, 2) pixels (x, y), of a picture of ``size`` (width, height)."""
    filled = np.zeros((size[1], size[0]), np.uint8)
    for polygon in polygons:
        shift = 4  # sixteenths of a pixel
        corners = np.round(np.clip(polygon, -1e5, 1e5) * (1 << shift)).astype(np.int32)
        cv2.fillPoly(filled, [corners], 1, shift=shift)
    return filled > 0


def outlines(mask: Mask, *, near: float = 0.75) -> list[NDArray[np.float64]]:
    """The outlines of the regions of ``mask`` without holes, each (N, 2), to ``near`` pixels; the largest first."""
    found, _ = cv2.findContours(mask.astype(np.uint8), cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    simple = [cv2.approxPolyDP(outline, near, True).reshape(-1, 2).astype(np.float64) for outline in found]
    whole = [outline for outline in simple if len(outline) >= 3 and cv2.contourArea(outline.astype(np.float32)) > 1]
    return sorted(whole, key=lambda outline: -cv2.contourArea(outline.astype(np.float32)))


def convex_hull(mask: Mask) -> Mask:
    """The convex hull of ``mask``; empty when it is."""
    filled = np.zeros(mask.shape, np.uint8)
    if mask.any():
        cv2.fillConvexPoly(filled, cv2.convexHull(np.argwhere(mask)[:, ::-1].astype(np.int32)), 1)
    return filled > 0


def central_ellipse(size: tuple[int, int]) -> Mask:
    """The middle of a picture of ``size`` (width, height), where the lamp is aimed: for a field no colour shows."""
    x, y = np.meshgrid(np.arange(size[0]), np.arange(size[1]))
    return ((x - size[0] / 2) / (0.3 * size[0])) ** 2 + ((y - size[1] / 2) / (0.3 * size[1])) ** 2 < 1
