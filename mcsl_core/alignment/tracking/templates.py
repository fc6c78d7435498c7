"""What a pose's cameras show of the background, laid over the programme's pixels: what pictures are held against."""

from __future__ import annotations

from collections.abc import Mapping

import cv2
import numpy as np
from attrs import frozen
from numpy.typing import NDArray

from mcsl_core.imaging.geometry import Array, project, scaling, size_at_columns, transform_points
from mcsl_core.imaging.masks import Mask
from mcsl_core.imaging.relief import between_nodes

from ..steady import SteadyView

Grey = NDArray[np.uint8]

WIDTH = 480  # of the programme as compared
_NODE = 6  # of its pixels, between places that are projected
_SURROUNDINGS = 10.0  # sigma of what brightness and contrast are levelled over, its pixels
_CONTRAST = 40.0
_POINTS, _APART, _QUALITY = 220, 8, 0.01  # a camera's distinctive places: how many, how far apart, of the best corner


@frozen(eq=False)
class Ground:
    """The scene under the programme's picture, reduced: where its pixels lie, and how high.

    Attributes
    ----------
    size : (int, int)
        Width and height of the reduced picture.
    full : (int, int)
        The programme's.
    gamma : (rows, columns) array
        Of its relief, at nodes over the programme's picture.
    """

    size: tuple[int, int]
    full: tuple[int, int]
    gamma: Array

    @classmethod
    def of(cls, full: tuple[int, int], gamma: Array) -> Ground:
        """Under a programme of that width and height."""
        return cls(size_at_columns(full, WIDTH), full, gamma)

    def scene(self, places: Array) -> Array:
        """(N, 3): full-size programme pixel and gamma at (N, 2) pixels of the reduced picture."""
        at = transform_points(scaling(self.size, self.full), places)
        return np.column_stack([at, between_nodes(self.gamma[..., None], self.full, at)])

    def laid(self, picture: Grey, camera_size: tuple[int, int], projection: Array, mask: Mask | None = None) -> Grey:
        """(h, w): a camera's picture of any size as the programme shows it; ``mask``: what of it is known, 0 or 255."""
        width, height = self.size
        columns, rows = width // _NODE + 2, height // _NODE + 2
        x, y = np.meshgrid(np.arange(columns) * _NODE, np.arange(rows) * _NODE)
        nodes = self.scene(np.stack([x, y], axis=-1).reshape(-1, 2).astype(np.float64))
        there = project(scaling(camera_size, (picture.shape[1], picture.shape[0])) @ projection, nodes)
        there = there.reshape(rows, columns, 2).astype(np.float32)
        px, py = np.meshgrid(*(np.arange(n, dtype=np.float32) / _NODE for n in self.size))
        at = cv2.remap(there, px, py, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
        source, how = (picture, cv2.INTER_LINEAR) if mask is None else (mask.view(np.uint8) * 255, cv2.INTER_NEAREST)
        return np.asarray(cv2.remap(source, at, None, how), np.uint8)  # pyright: ignore


@frozen(eq=False)
class Template:
    """One camera's background in one pose.

    Attributes
    ----------
    picture : (h, w) uint8
        As the programme shows it, brightness and contrast levelled.
    places : (N, 2) float32
        Distinctive places in it.
    scene : (N, 3) array
        The same as scene points.
    """

    picture: Grey
    places: NDArray[np.float32]
    scene: Array


def templates(
    ground: Ground,
    views: Mapping[str, SteadyView],
    projections: Mapping[str, Array],
    sizes: Mapping[str, tuple[int, int]],
) -> dict[str, Template]:
    """Of every camera that is known and shows enough."""
    made = {}
    for name in sorted(views.keys() & projections.keys()):
        view = views[name]
        grey = np.asarray(cv2.cvtColor(view.picture, cv2.COLOR_BGR2GRAY), np.uint8)
        known = ground.laid(grey, sizes[name], projections[name], view.steady)
        inside = np.asarray(cv2.erode(known, np.ones((9, 9), np.uint8), borderType=cv2.BORDER_CONSTANT), np.uint8)
        picture = level(ground.laid(grey, sizes[name], projections[name]))
        corners = cv2.goodFeaturesToTrack(picture, _POINTS, _QUALITY, _APART, mask=inside)
        if corners is not None:
            places = np.asarray(corners.reshape(-1, 2), np.float32)
            made[name] = Template(picture, places, ground.scene(places.astype(np.float64)))
    return made


def level(grey: Grey) -> Grey:
    """Brightness and contrast of the surroundings taken out: exposure and shading tell nothing."""
    values = grey.astype(np.float32)
    above: NDArray[np.float32] = np.subtract(values, _about(values), dtype=np.float32)
    spread = cv2.sqrt(_about(np.square(above)) + 16)
    return np.asarray(cv2.addWeighted(cv2.divide(above, spread), _CONTRAST, above, 0, 128, dtype=cv2.CV_8U), np.uint8)


def _about(values: NDArray[np.float32]) -> NDArray[np.float32]:
    """The mean of the surroundings, from half the size: an eighth of the time, half a code off."""
    height, width = values.shape
    small = cv2.resize(values, (max(1, width // 2), max(1, height // 2)), interpolation=cv2.INTER_AREA)
    small = cv2.GaussianBlur(small, (0, 0), _SURROUNDINGS / 2)
    return np.asarray(cv2.resize(small, (width, height), interpolation=cv2.INTER_LINEAR), np.float32)
