"""What a matcher and an aligner are given and give."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Protocol

import numpy as np
from attrs import frozen
from numpy.typing import NDArray

from mcsl_core.edl import Weak
from mcsl_core.imaging.geometry import Array

from .correspondences import Correspondences


@frozen(eq=False)
class Alignment:
    """One homography per camera that could be tied in, and how sure each is.

    homographies: camera -> 3x3, camera pixel -> reference pixel. residual_px: weighted rms over the matches kept,
    in reference pixels. support: distinct places. weak: the others, with the reason.
    """

    homographies: Mapping[str, Array]
    residual_px: Mapping[str, float]
    support: Mapping[str, int]
    weak: tuple[Weak, ...]


@frozen(eq=False)
class Features:
    """The distinctive points of one picture.

    points: (N, 2) float32 pixels. descriptors: (N, D) float32, each of unit length.
    size: (width, height) of the picture.
    """

    points: NDArray[np.float32]
    descriptors: NDArray[np.float32]
    size: tuple[int, int]

    def __attrs_post_init__(self) -> None:
        if self.points.ndim != 2 or self.points.shape[1] != 2 or len(self.points) != len(self.descriptors):
            raise ValueError(
                f"points must be (N, 2) with one descriptor each, got {self.points.shape} and {self.descriptors.shape}"
            )


class Matcher(Protocol):
    """Finds the same places in two pictures."""

    @property
    def name(self) -> str: ...

    def features(self, picture: NDArray[np.uint8], mask: NDArray[np.uint8] | None = None) -> Features:
        """Distinctive points of a (H, W, 3) BGR picture, only where ``mask`` (H, W) is not 0."""
        ...

    def match(self, a: Features, b: Features) -> NDArray[np.intp]:
        """(M, 2) indices: point [i, 0] of ``a`` is point [i, 1] of ``b``; each point at most once."""
        ...


class Aligner(Protocol):
    """Ties every camera of a pose to the reference camera."""

    @property
    def name(self) -> str: ...

    def align(
        self,
        pairs: Mapping[tuple[str, str], Correspondences],
        sizes: Mapping[str, tuple[int, int]],
        reference: str,
    ) -> Alignment:
        """One homography per camera that can be tied in, the others as weak with a reason.

        pairs: matches of cameras (a, b), pooled over clear moments: first of distinctive points, of which those in the
        surgical field weigh 1, those outside about 0.01; then of every spot of the field, which weigh 0.3 to 1. sizes:
        every camera's (width, height).
        """
        ...
