"""Brushes: noise, cells, smooth steps, shading. Pictures are float32, BGR, 0..1 unless said otherwise."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray


def bgr(*values: float) -> NDArray:
    """(3,): a colour, or a factor of each channel."""
    return np.array(values, np.float32)


def smoothstep(low: float, high: float, x: NDArray) -> NDArray:
    """0 where x is ``low``, 1 where it is ``high``, smooth between; float32 for float32."""
    low, high = float(low), float(high)
    u = np.clip((x - low) * (1 / (high - low)), 0, 1)
    return u * u * (3 - 2 * u)


def mix(a: NDArray, b: NDArray | tuple, way: NDArray | float) -> NDArray:
    """``a`` where ``way`` is 0, ``b`` where it is 1; a two-dimensional ``way`` serves all three colours."""
    weight = way if isinstance(way, np.ndarray) else float(way)
    if isinstance(weight, np.ndarray):
        weight = weight.astype(np.float32, copy=False)
        weight = weight[..., None] if weight.ndim == 2 and np.ndim(a) == 3 else weight
    out = np.asarray(b, np.float32) - a
    out *= weight
    out += a
    return out.astype(np.float32, copy=False)


def waves(rng: np.random.Generator, shape: tuple[int, ...], length_px: float) -> NDArray:
    """Smooth noise of mean 0 and deviation about 1 whose features are ``length_px`` long."""
    height, width = shape[:2]
    if length_px <= 1.5:
        return rng.standard_normal(shape, np.float32)
    coarse = (int(width / length_px) + 4, int(height / length_px) + 4)
    grid = rng.standard_normal((coarse[1], coarse[0]), np.float32)
    scale = np.array([[length_px, 0, -length_px * 1.5], [0, length_px, -length_px * 1.5]])
    return cv2.warpAffine(grid, scale, (width, height), flags=cv2.INTER_CUBIC, borderMode=cv2.BORDER_REFLECT) * 1.35


def streaks(
    rng: np.random.Generator, shape: tuple[int, ...], along_px: float, across_px: float, angle_deg: float
) -> NDArray:
    """Smooth noise like ``waves``, but drawn out in one direction."""
    height, width = shape[:2]
    reach = np.hypot(height, width)
    cells_x, cells_y = int(reach / along_px) + 5, int(reach / across_px) + 5
    grid = rng.standard_normal((cells_y, cells_x), np.float32)
    c, s = np.cos(np.deg2rad(angle_deg)), np.sin(np.deg2rad(angle_deg))
    turn = np.array([[c * along_px, -s * across_px], [s * along_px, c * across_px]])
    shift = np.array([width / 2, height / 2]) - turn @ np.array([cells_x / 2, cells_y / 2])
    scale = np.column_stack([turn, shift])
    return cv2.warpAffine(grid, scale, (width, height), flags=cv2.INTER_CUBIC, borderMode=cv2.BORDER_REFLECT) * 1.35


def clouds(rng: np.random.Generator, shape: tuple[int, ...], length_px: float, octaves: int, fall: float = 0.5):
    """Several sizes of noise on top of each other, each half as long and ``fall`` times as strong as the last."""
    total = np.zeros(shape, np.float32)
    for n in range(octaves):
        if length_px / 2**n < 1.0:
            break
        total += fall**n * waves(rng, shape, length_px / 2**n)
    return total


def warp_by(picture: NDArray, dx: NDArray, dy: NDArray) -> NDArray:
    """``picture`` resampled (dx, dy) pixels away from each pixel."""
    height, width = dx.shape
    x = np.arange(width, dtype=np.float32)[None] + dx
    y = np.arange(height, dtype=np.float32)[:, None] + dy
    return cv2.remap(
        picture, x.astype(np.float32), y.astype(np.float32), cv2.INTER_LINEAR, borderMode=cv2.BORDER_REFLECT
    )


def cells(rng: np.random.Generator, shape: tuple[int, ...], length_px: float) -> tuple[NDArray, NDArray]:
    """Lobules: (0 at the border .. 1 in the middle of each cell, a random 0..1 value of each cell)."""
    height, width = shape[:2]
    step = max(length_px, 3.0)
    gy, gx = np.mgrid[0 : height + step : step, 0 : width + step : step]
    px = (gx + rng.uniform(-0.45, 0.45, gx.shape) * step).ravel()
    py = (gy + rng.uniform(-0.45, 0.45, gy.shape) * step).ravel()
    seeds = np.full(shape, 255, np.uint8)
    inside = (px >= 0) & (px < width) & (py >= 0) & (py < height)
    seeds[py[inside].astype(int), px[inside].astype(int)] = 0
    distance, label = cv2.distanceTransformWithLabels(seeds, cv2.DIST_L2, 5, labelType=cv2.DIST_LABEL_PIXEL)
    value = rng.random(int(label.max()) + 1).astype(np.float32)[np.asarray(label, np.int32)]
    dome = np.clip(1 - (distance / (0.75 * step)) ** 2, 0, 1)
    edge = np.minimum(cv2.absdiff(value, cv2.dilate(value, np.ones((3, 3), np.uint8))) * 50, 1)
    dome = (dome * (1 - 0.5 * edge)).astype(np.float32)
    return cv2.GaussianBlur(dome, (0, 0), max(step * 0.06, 0.6)), value


def gradient(height: NDArray, pitch: float) -> tuple[NDArray, NDArray]:
    """Slopes dh/dx, dh/dy of a height map, by central differences."""
    dx = cv2.Sobel(height, cv2.CV_32F, 1, 0, ksize=3, scale=1 / (8 * pitch))
    dy = cv2.Sobel(height, cv2.CV_32F, 0, 1, ksize=3, scale=1 / (8 * pitch))
    return dx, dy


def normals(height: NDArray, pitch: float) -> NDArray:
    """Unit normals (h, w, 3) of a height map; height and pitch in the same unit."""
    dx, dy = gradient(height, pitch)
    length = 1 / np.sqrt(1 + dx * dx + dy * dy)
    return np.dstack([-dx * length, -dy * length, length])


def lambert(normal: NDArray, direction: tuple[float, float, float]) -> NDArray:
    """(h, w): diffuse reflection of light from ``direction``, 0..1."""
    light = np.asarray(direction, np.float32)
    return np.clip(normal @ (light / np.linalg.norm(light)), 0, 1)


def shine(normal: NDArray, half_direction: NDArray, hardness: float) -> NDArray:
    """(h, w): specular highlight (Blinn-Phong) where the surface faces ``half_direction``, 0..1."""
    towards = normal @ (half_direction / np.linalg.norm(half_direction)).astype(np.float32)
    return np.clip(towards, 0, 1) ** hardness


def polyline(mask: NDArray, points_px: NDArray, width_px: float, value: float = 1.0) -> None:
    """Draws an anti-aliased line of any width into a uint8 mask, ``value`` 0..1."""
    fine = np.round(np.asarray(points_px) * 16).astype(np.int32).reshape(-1, 1, 2)
    cv2.polylines(mask, [fine], False, int(255 * value), max(1, round(width_px)), cv2.LINE_AA, 4)


def to_uint8(picture: NDArray) -> NDArray:
    """0..1 as 0..255."""
    return np.clip(picture * 255 + 0.5, 0, 255).astype(np.uint8)
