"""Root-SIFT, the default matcher."""

from __future__ import annotations

import cv2
import numpy as np
from attrs import field, frozen
from numpy.typing import NDArray

from .protocol import Features


@frozen
class RootSift:
    """SIFT with the Hellinger kernel (Arandjelovic and Zisserman, CVPR 2012), mutual nearest neighbours with ratio.

    Finds views turned by any angle. max_features: strongest points kept a picture. ratio: the nearest
    descriptor must be this much nearer than the second (Lowe 2004, section 7.1); 0.85 with the mutual test
    gave more true matches than 0.75 without it on drapes.
    """

    max_features: int = field(default=1500)
    ratio: float = field(default=0.85)
    name = "rootsift"

    def features(self, picture: NDArray[np.uint8], mask: NDArray[np.uint8] | None = None) -> Features:
        """The points of a BGR or grey (H, W[, 3]) uint8 picture, only where ``mask`` (H, W) is not 0."""
        grey = cv2.cvtColor(picture, cv2.COLOR_BGR2GRAY) if picture.ndim == 3 else picture
        # Drapes have contrast of a few grey levels: a lower threshold than Lowe's 0.04 finds their weave and seams.
        sift = cv2.SIFT_create(nfeatures=self.max_features, contrastThreshold=0.01)  # pyright: ignore[reportAttributeAccessIssue]
        keypoints, descriptors = sift.detectAndCompute(grey, mask)
        size = (grey.shape[1], grey.shape[0])
        if descriptors is None or not len(keypoints):
            return Features(np.zeros((0, 2), np.float32), np.zeros((0, 128), np.float32), size)
        points = np.array([k.pt for k in keypoints], np.float32)
        root = np.sqrt(descriptors / np.maximum(descriptors.sum(axis=1, keepdims=True), 1e-9))
        return Features(points, root.astype(np.float32), size)

    def match(self, a: Features, b: Features) -> NDArray[np.intp]:
        """(M, 2) indices: row i says that point [i, 0] of ``a`` is point [i, 1] of ``b``."""
        return mutual_nearest(a.descriptors, b.descriptors, self.ratio)


def mutual_nearest(a: NDArray[np.float32], b: NDArray[np.float32], ratio: float) -> NDArray[np.intp]:
    """Pairs of unit descriptors that are each other's nearest and pass the ratio test from ``a``: (M, 2) indices."""
    if len(a) < 2 or len(b) < 2:
        return np.zeros((0, 2), np.intp)
    similarity = a @ b.T
    best = similarity.argmax(axis=1)
    rows = np.arange(len(a))
    nearest = similarity[rows, best]
    mutual = similarity.argmax(axis=0)[best] == rows
    similarity[rows, best] = -np.inf
    second = similarity.max(axis=1)
    # |a - b|^2 = 2 - 2 a.b for unit vectors: the ratio of distances, squared.
    distinct = (1 - nearest) < ratio**2 * np.maximum(1 - second, 1e-9)
    keep = mutual & distinct
    return np.stack([rows[keep], best[keep]], axis=1)
