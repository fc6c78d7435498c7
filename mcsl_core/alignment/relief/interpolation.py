"""Gamma all over a picture from its scattered points."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from mcsl_core.imaging.geometry import Array

_CELL_PX = 3  # points of one cell count as their median
_REACHES = (1.5, 3.0, 6.0, 12.0, 24.0, 48.0)  # cells: the nearest points say what they can, farther ones the rest


def gamma_map(points: Array, size: tuple[int, int], far: float | None = None) -> NDArray[np.float32]:
    """Gamma at every pixel, smoothly from the points about it.

    Parameters
    ----------
    points : (N, 3) array
        x and y in pixels of the map, and gamma; one at least.
    size : (int, int)
        Width and height of the map.
    far : float, optional
        What holds far from all points; their median without.

    Returns
    -------
    (H, W) float32 array
        Near points their own.

    References
    ----------
    Knutsson, Westin, "Normalized and differential convolution", CVPR 1993.
    """
    columns, rows = (max(1, -(-n // _CELL_PX)) for n in size)
    cell = np.floor((points[:, :2] + 0.5) / _CELL_PX).astype(int)
    inside = ((cell >= 0) & (cell < (columns, rows))).all(axis=1)
    cell, gamma = cell[inside], points[inside, 2]
    middle = float(np.median(points[:, 2])) if far is None else far
    order = np.lexsort((gamma, cell[:, 1] * columns + cell[:, 0]))
    at, gamma = (cell[:, 1] * columns + cell[:, 0])[order], gamma[order]
    cells, start, count = np.unique(at, return_index=True, return_counts=True)
    value, weight = np.zeros((2, rows * columns), np.float32)
    if len(cells):
        value[cells], weight[cells] = gamma[start + count // 2] - middle, 1
    value, weight = value.reshape(rows, columns), weight.reshape(rows, columns)
    found, left = np.zeros_like(value), np.ones_like(value)
    for reach in _REACHES:
        near = cv2.GaussianBlur(weight, (0, 0), reach)
        share = np.minimum(near * 2 * np.pi * reach**2, 1) * left
        found += share * cv2.GaussianBlur(value, (0, 0), reach) / np.maximum(near, 1e-9)
        left -= share
    grown = cv2.resize(found, (columns * _CELL_PX, rows * _CELL_PX), interpolation=cv2.INTER_LINEAR)
    return (grown[: size[1], : size[0]] + middle).astype(np.float32)
