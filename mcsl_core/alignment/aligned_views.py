"""One pose as the detectors see it: every camera's picture laid into the reference camera's perspective.

Aligned pixels are reference pixels reduced to the ``size`` of an `AlignedPose`; pixel centres lie at integers.
"""

from __future__ import annotations

from collections.abc import Mapping

import attrs
import cv2
import numpy as np
from attrs import frozen
from numpy.typing import NDArray

from mcsl_core.imaging.geometry import Array, scaling
from mcsl_core.imaging.masks import Mask

Picture = NDArray[np.uint8]


@frozen(eq=False)
class AlignedView:
    """What one camera shows in one frame, laid into the reference perspective.

    Attributes
    ----------
    camera : str
        Its name.
    picture : (h, w, 3) uint8 array
        BGR, as the camera sees it, reduced.
    aligned : (H, W, 3) uint8 array
        The same in aligned pixels, black outside ``inside``.
    inside : (H, W) bool array
        The aligned pixels that the camera covers.
    """

    camera: str
    picture: Picture
    aligned: Picture
    inside: Mask


@frozen(eq=False)
class AlignedPose:
    """A pose in aligned pixels: how every camera's picture is laid, and where the surgical field lies.

    Attributes
    ----------
    size : (int, int)
        Width and height of aligned pictures.
    reference : str
        Name of the reference camera.
    homographies : mapping of str to (3, 3) array
        Camera -> full-size camera pixel to full-size reference pixel; without the weak cameras.
    camera_sizes : mapping of str to (int, int)
        Camera -> full width and height.
    field : (H, W) bool array
        The surgical field.
    hands : mapping of str to (H, W) bool array
        Camera -> where a hand lies in its view that rests all through the pose; none is known without.
    """

    size: tuple[int, int]
    reference: str
    homographies: Mapping[str, Array]
    camera_sizes: Mapping[str, tuple[int, int]]
    field: Mask
    hands: Mapping[str, Mask] = attrs.field(factory=dict)

    def warp_of(self, camera: str, picture_size: tuple[int, int]) -> Array:
        """The homography of a camera's reduced pictures.

        Parameters
        ----------
        camera : str
            One of ``homographies``.
        picture_size : (int, int)
            Width and height of the reduced picture.

        Returns
        -------
        (3, 3) array
            Pixel of the reduced picture -> aligned pixel.
        """
        to_aligned = scaling(self.camera_sizes[self.reference], self.size)
        return to_aligned @ self.homographies[camera] @ scaling(picture_size, self.camera_sizes[camera])

    def views(self, pictures: Mapping[str, Picture | None]) -> tuple[AlignedView, ...]:
        """Lays the pictures of one frame over each other.

        Parameters
        ----------
        pictures : mapping of str to (h, w, 3) uint8 array or None
            Camera -> its picture, BGR, of any size; None where it has none.

        Returns
        -------
        tuple of AlignedView
            In the order of ``pictures``, of the cameras that are tied in and have a picture.
        """
        made = []
        for camera, picture in pictures.items():
            if picture is None or camera not in self.homographies:
                continue
            warp = self.warp_of(camera, (picture.shape[1], picture.shape[0]))
            aligned = cv2.warpPerspective(picture, warp, self.size, flags=cv2.INTER_LINEAR)
            full = np.full(picture.shape[:2], 255, np.uint8)
            inside = cv2.warpPerspective(full, warp, self.size, flags=cv2.INTER_NEAREST) > 0
            made.append(AlignedView(camera, picture, aligned, inside))  # pyright: ignore[reportArgumentType]
        return tuple(made)
