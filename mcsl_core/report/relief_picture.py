"""A pose's relief as a shaded picture over the programme's pixels.

Light falls from the upper left, as on maps; heights are tinted from dark blue to sand. Where the relief is not
confident the plane holds, and the picture goes over to a hatched ground.
"""

from __future__ import annotations

import cv2
import numpy as np
from attrs import frozen
from numpy.typing import NDArray

from mcsl_core.compositing.placement import programme_matrix
from mcsl_core.compositing.proxy import proxy_size
from mcsl_core.edl import Edl, Pose, Relief
from mcsl_core.imaging.geometry import Array, inverse, project, transform_points
from mcsl_core.imaging.relief import ReliefMap

from .pictures import WIDTH, Picture, data_url
from .relief_words import SURE

_STEEP = 3.0  # pixels of height a pixel of gamma: some twice the true steepness of a lamp's cameras
_LIGHT = np.array([-0.45, -0.55, 0.7]) / np.linalg.norm([-0.45, -0.55, 0.7])
_TINTS = 9  # of the scale beside the picture
_GREYED = 0.35  # of the tints' colour taken away: shading must stay legible
_HATCH = 10  # pixels from one line to the next


@frozen
class ReliefPicture:
    """A relief shown.

    Attributes
    ----------
    url : str
        The picture.
    size : (int, int)
        Its width and height.
    tints : tuple of str
        The scale of heights, low to high, as CSS colours.
    moves : str
        How far its heights move what the cameras see, in words.
    """

    url: str
    size: tuple[int, int]
    tints: tuple[str, ...]
    moves: str


def relief_picture(edl: Edl, pose: Pose) -> ReliefPicture | None:
    """The relief of a pose as a picture; None where it has none."""
    if pose.relief is None:
        return None
    size = proxy_size(edl.size, WIDTH)
    relief = ReliefMap.of(pose.relief, edl.size)
    heights = relief.gamma * np.float32(upwards(edl, pose, pose.relief))
    low, high = _span(heights, relief.confidence)
    tints = [f"#{r:02x}{g:02x}{b:02x}" for b, g, r in _tinted(np.linspace(0, 1, _TINTS)).round().astype(int)]
    picture = shaded(heights, relief.confidence, size, edl.size[0], (low, high))
    moves = f"{high - low:.0f} pixel{'' if round(high - low) == 1 else 's'}"
    return ReliefPicture(data_url(picture), size, tuple(tints), moves)


def shaded(
    heights: NDArray[np.float32],
    confidence: NDArray[np.float32],
    size: tuple[int, int],
    width: int,
    span: tuple[float, float],
) -> Picture:
    """A hillshade.

    Parameters
    ----------
    heights, confidence : (rows, columns) float32
        At nodes spread evenly over the programme's picture.
    size : (int, int)
        Width and height of the picture to make.
    width : int
        Of the programme, in pixels, of which heights are.
    span : (float, float)
        Heights with the first and the last tint.

    Returns
    -------
    (H, W, 3) uint8
        BGR.
    """
    fine = _smooth(_resized(heights, size), size[0] / heights.shape[1])
    down, across = np.gradient(fine * np.float32(_STEEP * size[0] / width))
    lit = (_LIGHT[2] - across * _LIGHT[0] - down * _LIGHT[1]) / np.sqrt(1 + across**2 + down**2)
    light = 0.35 + 0.75 * np.clip(lit, 0, 1)
    colour = _tinted((fine - span[0]) / (span[1] - span[0])) * light[..., None]
    sure = _smooth(_resized(confidence, size), size[0] / heights.shape[1])[..., None]
    x, y = np.meshgrid(np.arange(size[0]), np.arange(size[1]))
    ground = np.where((x + y) % _HATCH < 2, 120, 190)[..., None]
    return np.asarray((sure * colour + (1 - sure) * ground).round().clip(0, 255), np.uint8)


def upwards(edl: Edl, pose: Pose, relief: Relief) -> int:
    """1 where gamma grows towards the cameras, -1 where it grows away from them.

    The projections fit either. But of two cameras each shows larger what is nearer to its side, and what stands above
    the plane is laid, by their planes, away from the side that a camera looks from.
    """
    width, height = edl.size
    middle, raised = np.array([[width / 2, height / 2]]), np.array([[width / 2, height / 2, 0.1]])
    larger, laid = [], []
    for name, matrix in relief.projections.items():
        projection = np.array(matrix, np.float64)
        plane = inverse(programme_matrix(edl, pose, name))
        about = 0.02 * width * np.eye(2)
        larger.append([_magnification(plane, middle + way) - _magnification(plane, middle - way) for way in about])
        with np.errstate(divide="ignore", invalid="ignore"):  # of a matrix out of somebody's hand
            laid.append(transform_points(inverse(projection[:, :3]), project(projection, raised))[0])
    return 1 if np.sum((larger - np.mean(larger, axis=0)) * (laid - np.mean(laid, axis=0))) <= 0 else -1


def _span(heights: NDArray[np.float32], confidence: NDArray[np.float32]) -> tuple[float, float]:
    """The heights that tints begin and end at: of nearly all that is sure, a pixel apart at least: noise is none."""
    sure = heights[confidence >= SURE]
    low, high = np.percentile(sure if len(sure) else heights, [2, 98])
    missing = max(0.0, 1 - float(high - low)) / 2
    return float(low) - missing, float(high) + missing


def _tinted(heights: Array | NDArray[np.float32]) -> NDArray[np.float32]:
    """BGR of heights 0..1: a scale of even lightness steps that colour-blind people read as well, greyed."""
    codes = np.atleast_2d(np.clip(heights, 0, 1) * 255).round().astype(np.uint8)
    colours = cv2.applyColorMap(codes, cv2.COLORMAP_CIVIDIS).astype(np.float32)
    grey = colours @ np.array([0.114, 0.587, 0.299], np.float32)
    made = colours + _GREYED * (grey[..., None] - colours)
    return np.asarray(80 + made * (175 / 255), np.float32).reshape(*np.shape(heights), 3)


def _resized(nodes: NDArray[np.float32], size: tuple[int, int]) -> NDArray[np.float32]:
    """Values at nodes, the corners' pixel centres among them, at every pixel: OpenCV's steps of 1/32 node show."""
    rows, columns = nodes.shape
    x, y = np.linspace(0, columns - 1, size[0]), np.linspace(0, rows - 1, size[1])
    across = np.stack([np.interp(x, np.arange(columns), row) for row in nodes])
    return np.stack([np.interp(y, np.arange(rows), column) for column in across.T], axis=1).astype(np.float32)


def _smooth(values: NDArray[np.float32], node: float) -> NDArray[np.float32]:
    """Without the creases of linear interpolation between nodes so many pixels apart."""
    return np.asarray(
        cv2.GaussianBlur(values, (0, 0), max(0.6 * node, 0.3), borderType=cv2.BORDER_REPLICATE), np.float32
    )


def _magnification(matrix: Array, at: Array) -> float:
    """The logarithm of how much larger ``matrix`` makes what lies at (1, 2) ``at``."""
    a, b, c = transform_points(matrix, at + np.array([[0, 0], [1, 0], [0, 1]]))
    return float(np.log(abs(np.linalg.det(np.stack([b - a, c - a]))) + 1e-12))
