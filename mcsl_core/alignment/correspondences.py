"""The same places seen by two cameras, pooled over frames."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from attrs import frozen
from numpy.typing import NDArray

from mcsl_core.imaging.geometry import Array

CELL_PX = 4.0  # static false matches repeat in every frame: one match per pair of cells of this size counts


@frozen(eq=False)
class Correspondences:
    """The same places seen by two cameras, pooled over frames.

    a, b: (N, 2) full-size pixels of either camera. weight: (N,) above 0, how much each counts (the surgical
    field's more than the drapes'). seen: (N,) in how many frames the match was found.
    """

    a: Array
    b: Array
    weight: Array
    seen: NDArray[np.int64]

    def __len__(self) -> int:
        return len(self.a)

    def where(self, keep: NDArray[np.bool_]) -> Correspondences:
        return Correspondences(self.a[keep], self.b[keep], self.weight[keep], self.seen[keep])


def pool(matches: Sequence[tuple[Array, Array, Array]], cell_px: float = CELL_PX) -> Correspondences:
    """Matches (points a (N, 2), points b (N, 2), weight (N,)) of many frames, one per pair of cells.

    The place kept is the mean over the frames in which the pair of cells matched.
    """
    if not matches or not sum(len(m[0]) for m in matches):
        empty = np.zeros((0, 2))
        return Correspondences(empty, empty, np.zeros(0), np.zeros(0, np.int64))
    a = np.concatenate([m[0] for m in matches]).astype(np.float64)
    b = np.concatenate([m[1] for m in matches]).astype(np.float64)
    weight = np.concatenate([m[2] for m in matches]).astype(np.float64)
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
