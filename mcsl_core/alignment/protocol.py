"""What a matcher and an aligner are given and give."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Protocol

import numpy as np
from attrs import frozen
from numpy.typing import NDArray

from mcsl_core.edl import Weak
from mcsl_core.imaging.geometry import Array

from .correspondences import Correspondences


@frozen(eq=False)
class Features:
    """The distinctive points of one picture.

    Attributes
    ----------
    points : (N, 2) float32 array
        Pixels (x, y) of the picture.
    descriptors : (N, D) float32 array
        One for each point, of unit length.
    size : (int, int)
        Width and height of the picture.

    Raises
    ------
    ValueError
        Where a shape does not fit.
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
    """Finds the same points in two pictures."""

    @property
    def name(self) -> str: ...

    def features(self, picture: NDArray[np.uint8], mask: NDArray[np.uint8] | None = None) -> Features:
        """Finds the distinctive points of a picture.

        Parameters
        ----------
        picture : (H, W, 3) uint8 array
            BGR.
        mask : (H, W) uint8 array, optional
            Points are wanted only where it is not 0.

        Returns
        -------
        Features
        """
        ...

    def match(self, a: Features, b: Features) -> NDArray[np.intp]:
        """Matches the points of two pictures.

        Parameters
        ----------
        a, b : Features
            Of the two pictures.

        Returns
        -------
        (M, 2) int array
            Point [i, 0] of ``a`` is point [i, 1] of ``b``; each point at most once.
        """
        ...


@frozen(eq=False)
class Alignment:
    """One homography per camera that could be tied in, and how sure each is.

    Attributes
    ----------
    homographies : mapping of str to (3, 3) array
        Camera -> full-size camera pixel to full-size reference pixel, [2, 2] being 1; the reference's is the identity.
    residual_px : mapping of str to float
        Camera, without the reference -> weighted rms over the matches kept, in reference pixels.
    support : mapping of str to int
        Camera, without the reference -> in how many distinct cells its matches lie.
    weak : tuple of Weak
        The other cameras, with the reason.
    """

    homographies: Mapping[str, Array]
    residual_px: Mapping[str, float]
    support: Mapping[str, int]
    weak: tuple[Weak, ...]

    def without(self, weak: Iterable[Weak]) -> Alignment:
        """The alignment without more cameras, which are weak."""
        out = {one.camera: one for one in weak}
        return Alignment(
            {name: h for name, h in self.homographies.items() if name not in out},
            {name: v for name, v in self.residual_px.items() if name not in out},
            {name: v for name, v in self.support.items() if name not in out},
            (*self.weak, *out.values()),
        )


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
        """Ties the cameras together by the matches of their pairs.

        Parameters
        ----------
        pairs : mapping of (str, str) to Correspondences
            Cameras (a, b) -> their matches, pooled over clear frames. The aligner is asked twice: first with
            distinctive points, of which those in the surgical field weigh 1, those outside about 0.01; then with where
            each camera sees a grid of points all over the field, which weigh 1, those outside next to nothing. Where a
            relief is found that knows nine tenths of the field, its surface lays the planes anew.
        sizes : mapping of str to (int, int)
            Every camera's full width and height.
        reference : str
            The camera whose perspective is kept, one of ``sizes``.

        Returns
        -------
        Alignment
            One homography per camera that can be tied in, the others as weak with a reason.
        """
        ...
