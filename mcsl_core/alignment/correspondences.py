"""The same points seen by two cameras, pooled over frames."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from attrs import frozen
from numpy.typing import NDArray

from mcsl_core.imaging.geometry import Array

CELL_PX = 4.0  # static false matches repeat in every frame: one match per pair of cells of this size counts


@frozen(eq=False)
class Correspondences:
    """The same points seen by two cameras, pooled over frames.

    Attributes
    ----------
    a, b : (N, 2) float array
        Full-size pixels (x, y) of either camera.
    weight : (N,) float array
        How much each counts, above 0 (the surgical field's more than the drapes').
    seen : (N,) int array
        In how many frames the match was found.
    """

    a: Array
    b: Array
    weight: Array
    seen: NDArray[np.int64]

    def __len__(self) -> int:
        return len(self.a)

    def where(self, keep: NDArray[np.bool_]) -> Correspondences:
        """Some of the matches.

        Parameters
        ----------
        keep : (N,) bool array
            Which.

        Returns
        -------
        Correspondences
        """
        return Correspondences(self.a[keep], self.b[keep], self.weight[keep], self.seen[keep])


Pairs = Mapping[tuple[str, str], Correspondences]  # (camera a, camera b) -> their matches


def pool(matches: Sequence[tuple[Array, Array, Array]], cell_px: float = CELL_PX) -> Correspondences:
    """Pools the matches of many frames: one match per pair of cells.

    Parameters
    ----------
    matches : sequence of ((N, 2) array, (N, 2) array, (N,) array)
        Per frame: points of camera a, the same points in camera b (full-size pixels), and weights.
    cell_px : float, optional
        Size of the cells in pixels.

    Returns
    -------
    Correspondences
        Position and weight are means over the frames in which the pair of cells matched.

    References
    ----------
    The paper's section "Multi-Camera Calibration of Consecutive Frames" (after Obayashi et al.): matches are collected
    over a sequence of frames. That a pair of cells counts once is ours.
    """
    if not matches or not sum(len(a) for a, _, _ in matches):
        empty = np.zeros((0, 2))
        return Correspondences(empty, empty, np.zeros(0), np.zeros(0, np.int64))
    a = np.concatenate([a for a, _, _ in matches]).astype(np.float64)
    b = np.concatenate([b for _, b, _ in matches]).astype(np.float64)
    weight = np.concatenate([weight for _, _, weight in matches]).astype(np.float64)
    cells = np.floor(np.hstack([a, b]) / cell_px).astype(np.int64)
    _, inverse, count = np.unique(cells, axis=0, return_inverse=True, return_counts=True)
    inverse = inverse.reshape(-1)

    def mean(values: Array) -> Array:
        return np.bincount(inverse, values, len(count)) / count

    return Correspondences(
        np.stack([mean(a[:, 0]), mean(a[:, 1])], axis=1),
        np.stack([mean(b[:, 0]), mean(b[:, 1])], axis=1),
        mean(weight),
        count.astype(np.int64),
    )


def off_epipolar(fundamental: Array, pair: Correspondences) -> Array:
    """(N,): how many pixels matches are off their epipolar lines (Sampson), by a's points to b's lines."""
    a, b = (np.insert(points, 2, 1.0, axis=1) for points in (pair.a, pair.b))
    in_b, in_a = a @ fundamental.T, b @ fundamental
    slope = np.square(in_b[:, :2]).sum(axis=1) + np.square(in_a[:, :2]).sum(axis=1)
    return np.abs((in_b * b).sum(axis=1)) / np.sqrt(np.maximum(slope, 1e-30))
