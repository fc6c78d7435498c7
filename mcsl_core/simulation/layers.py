"""Pictures in planes, and the transparent layers that are laid on them.

A layer is (h, w, 4) uint8: Y, U, V (BT.709, limited range) and opacity. The first three are multiplied by the opacity,
their offsets of 16 and 128 included, so a layer lies over a picture as picture * (1 - opacity) + layer in each plane.
"""

from __future__ import annotations

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
        warped = _warped(layer, matrix, box)
        x0, y0, x1, y1 = box
        alpha = cv2.extractChannel(warped, 3)
        _over(self.y[y0:y1, x0:x1], cv2.extractChannel(warped, 0), cv2.bitwise_not(alpha))
        self._chroma(cv2.resize(warped, None, fx=0.5, fy=0.5, interpolation=cv2.INTER_AREA), x0 // 2, y0 // 2)
        return box, alpha

    def _chroma(self, layer: NDArray, x: int, y: int) -> None:
        """Lays a half-size layer's U and V at chroma pixel (x, y)."""
        rest = cv2.bitwise_not(cv2.extractChannel(layer, 3))
        for plane, channel in ((self.u, 1), (self.v, 2)):
            window = plane[y : y + rest.shape[0], x : x + rest.shape[1]]
            _over(window, cv2.extractChannel(layer, channel), rest)


class Overlay:
    """A layer ``scale`` (2, 4 or 8) times smaller than the picture: others are drawn on it, and it is laid once."""

    def __init__(self, size: tuple[int, int], scale: int) -> None:
        self.scale = scale
        self.layer = np.zeros((-(-size[1] // scale), -(-size[0] // scale), 4), np.uint8)
        self._used: Box | None = None

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
        old = self._used or box
        self._used = (min(old[0], x0), min(old[1], y0), max(old[2], x1), max(old[3], y1))
        alpha = cv2.extractChannel(layer, 3)
        rest = cv2.bitwise_not(alpha)
        _over(self.layer[y0:y1, x0:x1], layer, cv2.merge([rest, rest, rest, rest]))
        return alpha

    def _take(self) -> tuple[NDArray, int, int] | None:
        """What was drawn, with a margin for its enlargement to fade out in, and where; the overlay is empty then."""
        if self._used is None:
            return None
        rows, columns = self.layer.shape[:2]
        x0, y0, x1, y1 = self._used
        x0, y0, x1, y1 = max(x0 - 1, 0), max(y0 - 1, 0), min(x1 + 1, columns), min(y1 + 1, rows)
        taken = self.layer[y0:y1, x0:x1].copy()
        self.layer[y0:y1, x0:x1] = 0
        self._used = None
        return taken, x0, y0

    def into(self, finer: Overlay) -> None:
        """Lays what was drawn on a finer overlay."""
        taken = self._take()
        if taken is None:
            return
        small, x, y = taken
        s = self.scale // finer.scale
        rows, columns = finer.layer.shape[:2]
        box = (s * x, s * y, min(s * (x + small.shape[1]), columns), min(s * (y + small.shape[0]), rows))
        large = cv2.resize(small, None, fx=s, fy=s, interpolation=cv2.INTER_LINEAR)
        finer._lay(large[: box[3] - box[1], : box[2] - box[0]], box)

    def onto(self, picture: Picture) -> None:
        """Lays what was drawn on the picture: its chroma has half the size anyway."""
        taken = self._take()
        if taken is None:
            return
        small, x, y = taken
        s = self.scale
        window = picture.y[s * y : s * (y + small.shape[0]), s * x : s * (x + small.shape[1])]
        rows, columns = window.shape
        whole = (s * small.shape[1], s * small.shape[0])
        luma, alpha = (
            cv2.resize(cv2.extractChannel(small, channel), whole, interpolation=cv2.INTER_LINEAR)[:rows, :columns]
            for channel in (0, 3)
        )
        _over(window, luma, cv2.bitwise_not(alpha))
        if s > 2:
            small = cv2.resize(small, None, fx=s // 2, fy=s // 2, interpolation=cv2.INTER_LINEAR)
        rows, columns = -(-rows // 2), -(-columns // 2)
        picture._chroma(small[:rows, :columns], s * x // 2, s * y // 2)


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
    corners = matrix @ np.array([[0, columns, columns, 0], [0, 0, rows, rows], [1, 1, 1, 1]])
    if (corners[2] < NEAREST_MM).any():
        return None
    px = corners[:2] / corners[2]
    (x0, y0), (x1, y1) = px.min(1), px.max(1)
    if x1 < 0 or y1 < 0 or x0 > picture[1] or y0 > picture[0]:
        return None
    left, top = max(int(x0) // step * step, 0), max(int(y0) // step * step, 0)
    right, bottom = -(-(int(x1) + 2) // step) * step, -(-(int(y1) + 2) // step) * step
    right, bottom = min(right, picture[1]), min(bottom, picture[0])
    return (left, top, right, bottom) if left < right and top < bottom else None
