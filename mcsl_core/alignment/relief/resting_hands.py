"""Hands that rest all through a pose: they are not the scene's surface, which is carried on under them.

What rests is as steady as the patient, has one height in all cameras, and passes for relief. But it stands above what
lies around it, and a part of it at least, the wrist or the sleeve, has the colours of what comes and goes. A wound's
rim, a limb or a fold stand above their surroundings as well, and have the scene's own colours.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import cv2
import numpy as np
from attrs import evolve, frozen
from numpy.typing import NDArray
from scipy import sparse
from scipy.sparse.linalg import splu

from mcsl_core.imaging.geometry import project, scaling, transform_points
from mcsl_core.imaging.masks import Mask, mask_at
from mcsl_core.imaging.relief import node_pixels

from .foreign import ForeignColours
from .protocol import ReliefCamera, ReliefSurface
from .thin_plate import Nodes, Plate, second_differences

# The ground: plates less and less stiff, each over so many nodes of 48 and by what stands no higher above the one
# before, in pixels of 960. So they climb what rises gently, but no step.
_GROUND = ((12, 24.0), (8, 18.0), (4.5, 15.0), (3, 12.0), (2, 12.0))
_BELOW = 2.5  # so much farther may lie what is lower: hands stand above the ground, nothing under it
_PULL = 3e-4  # towards the plane
_STANDS = 4.0  # pixels of 960 above the ground
_WIDE, _EDGE = 5, 2  # nodes of 96 that a hand is wide at least; a wound's rim is not, and is cut off where they meet
_FEWEST = 12  # nodes either way, with fewer nothing is told
_SEEN = 0.05  # confidence from which a node's height counts
_COLOURED = 0.3  # share of cameras that see sure foreign colours from which a node is no ground
# A piece's share of sure foreign colours times its height in pixels of 960: hands had 2.1 (bloody ones, sleeves out of
# the picture) to 20, limbs, rims and folds 0 to 1.3.
_HAND = 1.7
_MOST = 0.5  # of the field; hands alone covered 0.28 at most
# Tan gloves on a tan limb: half of the cameras see likely colours, and it stands higher than a rim or a fold, in pixels
# of 960.
_HALF, _HIGH = 0.5, 10.0
_UNDER = Plate(pull=1e-5)  # by the usual pull it sags to the plane within a hand's width
# Under a hand the surface is half sure where the mean confidence about a node, over such a sigma in nodes, is so high.
_REACH, _FULL = 4.0, 0.15


@frozen(eq=False)
class ForeignShare:
    """At the nodes of a surface the share of the cameras that see foreign colours there, 0..1.

    Attributes
    ----------
    sure, likely : (rows, columns) array
        See `ForeignColours`.
    """

    sure: Nodes
    likely: Nodes


def without_resting_hands(
    surface: ReliefSurface, foreign: ForeignShare, height: float, field: Mask | None = None
) -> tuple[ReliefSurface, Mask]:
    """The surface as it goes on under hands that rest on it.

    Parameters
    ----------
    surface : ReliefSurface
        As an estimator finds it.
    foreign : ForeignShare
        Where it has foreign colours; see `foreign_share`.
    height : float
        Pixels of 960 that gamma 1 stands above gamma 0, negative where gamma falls towards the cameras.
    field : (rows, columns) bool array, optional
        The nodes of the surgical field: no hand hides most of it.

    Returns
    -------
    (ReliefSurface, (rows, columns) bool array)
        The surface, smooth under the hands and half sure near what is seen; and the nodes where they are.

    Notes
    -----
    Where a hand rested over the field its points were off by 4.1 to 13.3 px rms of 960, and are by 1.6 to 5.6. Lengths
    are in nodes of 96 columns, which the estimators of this package have; on finer grids less is found.
    """
    if min(surface.gamma.shape) < _FEWEST:
        return surface, np.zeros(surface.gamma.shape, bool)
    sure = np.clip(2 * surface.confidence, 0, 1)
    heights, known = surface.gamma * height, surface.confidence > _SEEN
    above = heights - _ground(heights, sure * (foreign.sure < _COLOURED))
    hands = np.zeros(heights.shape, bool)
    for piece in _wide_pieces(known & (above > _STANDS), field):
        if foreign.sure[piece].mean() * np.median(above[piece]) > _HAND:
            hands |= piece
    likely = foreign.likely > _HALF
    above = heights - _ground(heights, sure * ~likely)
    for piece in _wide_pieces(known & (above > _STANDS) & (cv2.blur(foreign.likely, (3, 3)) > _HALF), field):
        if np.median(above[piece]) > _HIGH:
            hands |= piece
    if not hands.any():
        return surface, hands
    rim = with_rim(hands)
    beside = np.where(rim, 0.0, sure)
    under = _UNDER.through(surface.gamma, beside, np.inf)
    near = np.clip(cv2.GaussianBlur(beside, (0, 0), _REACH) / _FULL, 0, 1)
    return evolve(
        surface,
        gamma=np.where(rim, under, surface.gamma),
        confidence=np.where(rim, near / 2, surface.confidence),
    ), hands


def with_rim(hands: Mask) -> Mask:
    """The nodes of hands and those beside them, whose heights are of both."""
    return cv2.dilate(hands.astype(np.uint8), np.ones((3, 3), np.uint8)) > 0


def foreign_share(
    surface: ReliefSurface,
    size: tuple[int, int],
    cameras: Mapping[str, ReliefCamera],
    foreign: Mapping[str, ForeignColours],
) -> ForeignShare:
    """How many cameras see foreign colours at the nodes of a surface.

    Parameters
    ----------
    surface : ReliefSurface
        Over a perspective.
    size : (int, int)
        The perspective's full width and height.
    cameras : mapping of str to ReliefCamera
        How they see it; of each the first view says where it is steady.
    foreign : mapping of str to ForeignColours
        Camera -> where its steady picture has foreign colours.

    Returns
    -------
    ForeignShare
        Of the cameras that see the node steadily; 0 where none does.
    """
    scene = np.column_stack([node_pixels(surface.gamma.shape, size), surface.gamma.ravel()])
    sure, likely, seen = (np.zeros(len(scene)) for _ in range(3))
    for name, camera in cameras.items():
        own = foreign.get(name)
        if own is None or not camera.views:
            continue
        to_picture = scaling(camera.size, (own.sure.shape[1], own.sure.shape[0]))
        at = transform_points(to_picture, project(camera.projection, scene))
        shown = mask_at(camera.views[0].steady | own.sure, at)
        sure += shown & mask_at(own.sure, at)
        likely += shown & mask_at(own.likely, at)
        seen += shown
    seen, shape = np.maximum(seen, 1), surface.gamma.shape
    return ForeignShare((sure / seen).reshape(shape), (likely / seen).reshape(shape))


def _wide_pieces(standing: Mask, field: Mask | None) -> Iterator[Mask]:
    """The connected pieces of what stands above the ground, without what is narrow and what hangs on by little.

    None that covers most of the field: it is the field, as a limb is.
    """
    given = standing.astype(np.uint8)
    wide = cv2.morphologyEx(given, cv2.MORPH_OPEN, cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (_WIDE, _WIDE)))
    count, pieces = cv2.connectedComponents(wide, connectivity=4)
    for piece in range(1, count):
        own = (pieces == piece).astype(np.uint8)
        found = (cv2.dilate(own, np.ones((3, 3), np.uint8), iterations=_EDGE) > 0) & standing
        if field is None or (found & field).sum() <= _MOST * field.sum() or not field.any():
            yield found


def _ground(heights: Nodes, worth: Nodes) -> Nodes:
    """The lower of what is there, as far as it goes on gently; heights in pixels of 960."""
    full = heights.shape[::-1]
    half = ((full[0] + 1) // 2, (full[1] + 1) // 2)
    total, count = (cv2.resize(a, half, interpolation=cv2.INTER_AREA).ravel() for a in (heights * worth, worth))
    measured, given = np.asarray(total / np.maximum(count, 1e-6), np.float64), np.asarray(count, np.float64)
    bending = second_differences(half[1], half[0])
    bending = bending.T @ bending
    held = _PULL * sparse.identity(measured.size)
    trust, ground = given, measured

    def plate(nodes: float, trust: NDArray[np.float64]) -> NDArray[np.float64]:
        return splu((nodes**4 * bending + held + sparse.diags(trust)).tocsc()).solve(trust * measured)

    for _ in range(3):  # the lower quantile
        ground = plate(_GROUND[0][0], trust)
        left = measured - ground
        trust = given * np.where(left > 0, 0.3, 0.7) * 4 / np.maximum(np.abs(left), 4)
    for nodes, high in _GROUND:
        for _ in range(3):  # Geman and McClure's loss
            ground = plate(nodes, trust)
            left = (measured - ground) / np.where(measured > ground, high, _BELOW * high)
            trust = given / (1 + left**2) ** 2
    return cv2.resize(ground.reshape(half[::-1]), full, interpolation=cv2.INTER_LINEAR)  # pyright: ignore[reportReturnType]
