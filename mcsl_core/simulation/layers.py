"""Pictures in planes, and the transparent layers that are laid on them.

A layer is (h, w, 4) uint8: Y, U, V (BT.709, limited range) and opacity. The first three are multiplied by the opacity,
their offsets of 16 and 128 included, so a layer lies over a picture as picture * (1 - opacity) + layer in each plane.
"""

from __future__ import annotations

from collections.abc import Iterator

import cv2
import numpy as np
from numpy.typing import NDArray

from mcsl_core.imaging.planes import BGR_TO_YUV, Planes

NEAREST_MM = 40.0
"""Nothing is drawn nearer to a camera than this."""
Box = tuple[int, int, int, int]
"""x0, y0, x1, y1, half-open."""


def layer_of(picture: NDArray, gains: NDArray) -> NDArray:
    """A layer from a BGR picture or premultiplied BGRA, its colours multiplied by ``gains`` (B, G, R)."""
    bgra = cv2.cvtColor(picture, cv2.COLOR_BGR2BGRA) if picture.shape[2] == 3 else picture
    matrix = np.eye(4)
    matrix[:3, :3] = BGR_TO_YUV[:, :3] * gains
    matrix[:3, 3] = BGR_TO_YUV[:, 3] / 255
    return cv2.transform(bgra, matrix)


class Picture:
    """Y, U and V of a picture that is being drawn."""

    def __init__(self, y: NDArray, u: NDArray, v: NDArray) -> None:
        self.y, self.u, self.v = y, u, v

    @classmethod
    def of(cls, layer: NDArray) -> Picture:
        """From an opaque layer of even size."""
        small = cv2.resize(layer, None, fx=0.5, fy=0.5, interpolation=cv2.INTER_AREA)
        return cls(cv2.extractChannel(layer, 0), cv2.extractChannel(small, 1), cv2.extractChannel(small, 2))

    def copy(self) -> Picture:
        """One to draw upon."""
        return Picture(self.y.copy(), self.u.copy(), self.v.copy())

    def planes(self) -> Planes:
        """As the encoder takes it."""
        return Planes(self.y, self.u, self.v)

    def draw(self, layer: NDArray, matrix: NDArray) -> tuple[Box, NDArray] | None:
        """Draws a layer.

        Parameters
        ----------
        layer
            (h, w, 4).
        matrix
            (3, 3), pixel of the layer -> pixel of this picture.

        Returns
        -------
        tuple or None
            Its box and (h, w) opacity there; None where it lies outside.
        """
        box = _box(matrix, layer.shape, self.y.shape, 2)
        if box is None:
            return None
        x0, y0, x1, y1 = box
        luma, u, v, alpha = cv2.split(_warped(layer, matrix, box))
        _over(self.y[y0:y1, x0:x1], luma, cv2.bitwise_not(alpha))
        half = ((x1 - x0) // 2, (y1 - y0) // 2)
        self._chroma([cv2.resize(p, half, interpolation=cv2.INTER_AREA) for p in (u, v, alpha)], x0 // 2, y0 // 2)
        return box, alpha

    def _chroma(self, layer: list[NDArray], x: int, y: int) -> None:
        """Lays a half-size layer's U and V (its planes: U, V and opacity) at chroma pixel (x, y)."""
        u, v, alpha = layer
        rest = cv2.bitwise_not(alpha)
        for plane, channel in ((self.u, u), (self.v, v)):
            _over(plane[y : y + rest.shape[0], x : x + rest.shape[1]], channel, rest)


class Overlay:
    """A layer ``scale`` (2, 4 or 8) times smaller than the picture: others are drawn on it, and it is laid once."""

    def __init__(self, size: tuple[int, int], scale: int) -> None:
        self.scale = scale
        self.layer = np.zeros((-(-size[1] // scale), -(-size[0] // scale), 4), np.uint8)
        self._boxes: list[Box] = []  # what was drawn on: apart from one another

    def draw(self, layer: NDArray, matrix: NDArray) -> tuple[Box, NDArray] | None:
        """As `Picture.draw`; ``matrix`` leads to full-size pixels, box and opacity are in the overlay's."""
        s = self.scale
        # A small pixel covers s full-size ones: its centre lies at their middle.
        matrix = np.array([[1 / s, 0, 0.5 / s - 0.5], [0, 1 / s, 0.5 / s - 0.5], [0, 0, 1]]) @ matrix
        box = _box(matrix, layer.shape, self.layer.shape, 1)
        if box is None:
            return None
        warped = _warped(layer, matrix, box)
        return box, self._lay(warped, box)

    def _lay(self, layer: NDArray, box: Box) -> NDArray:
        x0, y0, x1, y1 = box
        window = self.layer[y0:y1, x0:x1]
        alpha = cv2.extractChannel(layer, 3)
        apart = [other for other in self._boxes if _is_apart(other, box)]
        if len(apart) == len(self._boxes):
            window[...] = layer
        else:
            rest = cv2.bitwise_not(alpha)
            _over(window, layer, cv2.merge([rest, rest, rest, rest]))
        # One that has grown may reach others that it was apart from.
        while len(apart) < len(self._boxes):
            near = [other for other in self._boxes if other not in apart]
            box = _around([*near, box])
            self._boxes = apart
            apart = [other for other in self._boxes if _is_apart(other, box)]
        self._boxes.append(box)
        return alpha

    def _take(self) -> Iterator[tuple[NDArray, int, int]]:
        """What was drawn, with a margin for its enlargement to fade out in, and where; the overlay is empty then."""
        rows, columns = self.layer.shape[:2]
        for x0, y0, x1, y1 in self._boxes:
            x0, y0, x1, y1 = max(x0 - 1, 0), max(y0 - 1, 0), min(x1 + 1, columns), min(y1 + 1, rows)
            yield self.layer[y0:y1, x0:x1], x0, y0
            self.layer[y0:y1, x0:x1] = 0
        self._boxes = []

    def into(self, finer: Overlay) -> None:
        """Lays what was drawn on a finer overlay."""
        s = self.scale // finer.scale
        rows, columns = finer.layer.shape[:2]
        for small, x, y in self._take():
            box = (s * x, s * y, min(s * (x + small.shape[1]), columns), min(s * (y + small.shape[0]), rows))
            large = cv2.resize(small, None, fx=s, fy=s, interpolation=cv2.INTER_LINEAR)
            finer._lay(large[: box[3] - box[1], : box[2] - box[0]], box)

    def onto(self, picture: Picture) -> None:
        """Lays what was drawn on the picture: its chroma has half the size anyway."""
        s = self.scale
        for small, x, y in self._take():
            window = picture.y[s * y : s * (y + small.shape[0]), s * x : s * (x + small.shape[1])]
            rows, columns = window.shape
            luma, u, v, alpha = cv2.split(small)
            whole = _enlarged(alpha, s)[:rows, :columns]
            _over(window, _enlarged(luma, s)[:rows, :columns], cv2.bitwise_not(whole))
            rows, columns = -(-rows // 2), -(-columns // 2)
            half = [_enlarged(p, s // 2)[:rows, :columns] for p in (u, v, alpha)]
            picture._chroma(half, s * x // 2, s * y // 2)


def _enlarged(plane: NDArray, scale: int) -> NDArray:
    return plane if scale == 1 else cv2.resize(plane, None, fx=scale, fy=scale, interpolation=cv2.INTER_LINEAR)


def _is_apart(a: Box, b: Box) -> bool:
    """Whether two boxes keep clear of one another, margins of a pixel included."""
    return a[2] + 2 <= b[0] or b[2] + 2 <= a[0] or a[3] + 2 <= b[1] or b[3] + 2 <= a[1]


def _around(boxes: list[Box]) -> Box:
    left, top, right, bottom = zip(*boxes, strict=True)
    return min(left), min(top), max(right), max(bottom)


def _over(window: NDArray, premultiplied: NDArray, rest: NDArray) -> None:
    cv2.multiply(window, rest, window, scale=1 / 255)
    cv2.add(window, premultiplied, window)


def _warped(layer: NDArray, matrix: NDArray, box: Box) -> NDArray:
    x0, y0, x1, y1 = box
    shift = np.array([[1.0, 0, -x0], [0, 1, -y0], [0, 0, 1]])
    return cv2.warpPerspective(layer, shift @ matrix, (x1 - x0, y1 - y0), flags=cv2.INTER_LINEAR)


def _box(matrix: NDArray, sprite: tuple[int, ...], picture: tuple[int, ...], step: int) -> Box | None:
    """The part of the picture that a sprite may touch, its edges at multiples of ``step``, or None."""
    rows, columns = sprite[:2]
    x, y, depth = (matrix @ np.array([[0, columns, columns, 0], [0, 0, rows, rows], [1, 1, 1, 1]])).tolist()
    if min(depth) < NEAREST_MM:
        return None
    x, y = [p / d for p, d in zip(x, depth, strict=True)], [p / d for p, d in zip(y, depth, strict=True)]
    x0, y0, x1, y1 = min(x), min(y), max(x), max(y)
    if x1 < 0 or y1 < 0 or x0 > picture[1] or y0 > picture[0]:
        return None
    left, top = max(int(x0) // step * step, 0), max(int(y0) // step * step, 0)
    right, bottom = -(-(int(x1) + 2) // step) * step, -(-(int(y1) + 2) // step) * step
    right, bottom = min(right, picture[1]), min(bottom, picture[0])
    return (left, top, right, bottom) if left < right and top < bottom else None
