"""One pose as the detectors see it: every camera's picture laid into the reference camera's perspective.

Scene pixels are reference pixels reduced to ``size``; pixel centres lie at integers.
"""

from __future__ import annotations

from collections.abc import Mapping

import cv2
import numpy as np
from attrs import frozen
from numpy.typing import NDArray

from mcsl_core.imaging.geometry import scaling
from mcsl_core.imaging.masks import Mask

Picture = NDArray[np.uint8]
Array = NDArray[np.float64]


@frozen(eq=False)
class AlignedView:
    """One camera at one moment. picture: (h, w, 3) BGR as the camera sees it, reduced.

    aligned: (H, W, 3) BGR in scene pixels, black outside ``inside``. inside: (H, W) where the camera has picture.
    """

    camera: str
    picture: Picture
    aligned: Picture
    inside: Mask


@frozen(eq=False)
class AlignedPose:
    """A pose in scene pixels.

    size: (W, H). homographies: camera -> 3x3, full-size camera pixel -> full-size reference pixel (no weak cameras).
    camera_sizes: full (width, height). reference: its name. field: (H, W) bool, the surgical field.
    """

    size: tuple[int, int]
    reference: str
    homographies: Mapping[str, Array]
    camera_sizes: Mapping[str, tuple[int, int]]
    field: Mask

    def warp_of(self, camera: str, picture_size: tuple[int, int]) -> Array:
        """3x3: pixel of a reduced picture of ``camera`` -> scene pixel."""
        to_scene = scaling(self.camera_sizes[self.reference], self.size)
        return to_scene @ self.homographies[camera] @ scaling(picture_size, self.camera_sizes[camera])

    def views(self, pictures: Mapping[str, Picture | None]) -> tuple[AlignedView, ...]:
        """The views of one moment, of the cameras that are tied in and have a picture."""
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
