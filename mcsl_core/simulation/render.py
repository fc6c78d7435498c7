"""The pictures of one camera, one after another, and how much of the field each of them shows.

Pictures are put together as BGRA uint8 whose colours have been mixed so that OpenCV's BT.601 conversion gives BT.709
planes (one fast conversion a frame instead of a slow one). Sprites' colours are premultiplied. Pixel centres lie at
integers.
"""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from mcsl_core.images import Planes

from .backdrop import Backdrop
from .clocks import Clock
from .ground import Ground
from .rig import View, cross, unit
from .solids import Sprite
from .staging import Placement, Play

BT709 = np.array([[0.0722, 0.7152, 0.2126], [0.5, -0.385428, -0.114572], [-0.045847, -0.454153, 0.5]])
BT601 = np.array([[0.114, 0.587, 0.299], [0.5, -0.331264, -0.168736], [-0.081312, -0.418688, 0.5]])
NEAREST_MM = 40.0
"""Nothing is drawn nearer to a camera than this."""
Box = tuple[int, int, int, int]
"""x0, y0, x1, y1, half-open."""


class CameraPictures:
    """Draws what one camera sees. Asking for frames in rising order is quick; any order is right."""

    def __init__(self, play: Play, ground: Ground, camera: int, clock: Clock) -> None:
        self._play, self._clock = play, clock
        scenario = play.scenario
        self._size = width, height = scenario.size
        rng = scenario.stream("sensor", camera)
        gains = rng.uniform(0.93, 1.07, 3) * rng.uniform(0.9, 1.08)
        self._colour = np.eye(4)
        self._colour[:3, :3] = np.linalg.solve(BT601, BT709) @ np.diag(gains)
        self._backdrop = Backdrop(play, ground, camera, self._prepared)
        self._sprites: dict[int, tuple[Sprite, Sprite]] = {}
        # Arms and heads are near the camera and out of focus: they are put together small and enlarged once.
        self._arms = Overlay(self._size, 2)
        self._shades = Overlay(self._size, 8)
        self._heads = Overlay(self._size, 4 if width >= 1400 else 2)
        x, y = np.meshgrid(np.linspace(-1, 1, width), np.linspace(-1, 1, height))
        corner = rng.uniform(0.06, 0.16) * (x * x + y * y * (height / width) ** 2) / 1.3
        self._vignette = np.clip(255 * (1 - corner), 0, 255).astype(np.uint8)
        grain = rng.normal(0, scenario.noise, (height + 64, width + 64))
        self._brighter = np.clip(np.round(grain), 0, 255).astype(np.uint8)
        self._darker = np.clip(np.round(-grain), 0, 255).astype(np.uint8)

    def frame(self, k: int) -> tuple[Planes, tuple[float, float]]:
        """The camera's own frame ``k`` and the visible fraction of the field, with and without counting hands."""
        t = self._clock.programme(k / float(self._play.scenario.rate))
        background, view = self._backdrop.at(t)
        picture = background.copy()
        seen = FieldCount(view.project(self._play.surface.dense_points_mm), self._size)
        placements = list(self._play.placements(t))
        for placement in placements:
            if placement.kind != "head":
                self._shade(placement, view)
        self._shades.onto(self._arms)
        for placement in placements:
            if placement.kind == "sleeve":
                seen.hide(self._draw(self._arms, placement, view), self._arms.scale, True)
        self._arms.onto(picture)
        for placement in placements:
            if placement.kind == "hand":
                seen.hide(self._draw(picture, placement, view), 1, True)
        for placement in placements:
            if placement.kind == "head":
                seen.hide(self._draw(self._heads, placement, view), self._heads.scale, False)
        self._heads.onto(picture)
        return self._develop(picture, k), seen.fractions()

    def _prepared(self, picture: NDArray) -> NDArray:
        """BGRA in this camera's colours."""
        bgra = cv2.cvtColor(picture, cv2.COLOR_BGR2BGRA) if picture.shape[2] == 3 else picture
        return cv2.transform(bgra, self._colour)

    def _sprite(self, sprite: Sprite) -> tuple[Sprite, Sprite]:
        """The sprite in this camera's colours, and the soft shade it throws, small."""
        key = id(sprite)
        if key not in self._sprites:
            own = Sprite(self._prepared(sprite.bgra), sprite.origin_px, sprite.pitch_mm)
            pad = int(14 / sprite.pitch_mm)
            alpha = cv2.copyMakeBorder(sprite.bgra[..., 3], pad, pad, pad, pad, cv2.BORDER_CONSTANT, value=0)
            soft = cv2.GaussianBlur(alpha, (0, 0), 7 / sprite.pitch_mm)
            small = cv2.resize(soft, None, fx=0.25, fy=0.25, interpolation=cv2.INTER_AREA)
            black = np.zeros((*small.shape, 4), np.uint8)
            black[..., 3] = small * 0.5
            ox, oy = sprite.origin_px
            origin = ((ox + pad + 0.5) / 4 - 0.5, (oy + pad + 0.5) / 4 - 0.5)
            self._sprites[key] = own, Sprite(black, origin, sprite.pitch_mm * 4)
        return self._sprites[key]

    def _draw(self, target: NDArray | Overlay, placement: Placement, view: View) -> tuple[Box, NDArray] | None:
        """Where the sprite was drawn and its opacity there, in the target's pixels."""
        own, _ = self._sprite(placement.sprite)
        ahead, aside = placement.ahead, placement.aside
        if placement.facing:
            sight = unit(placement.origin - view.centre_mm)
            ahead = unit(ahead - (ahead @ sight) * sight)
            aside = cross(-sight, ahead)
        return lay(target, own.bgra, plane_to_picture(view, placement.origin, ahead, aside) @ own.to_plane)

    def _shade(self, placement: Placement, view: View) -> None:
        """Soft darkness on the surface right below."""
        _, shade = self._sprite(placement.sprite)
        flat = np.array([1.0, 1.0, 0.0])
        below = placement.origin * flat + (0, 0, placement.ground_z)
        matrix = plane_to_picture(view, below, placement.ahead * flat, placement.aside * flat)
        lay(self._shades, shade.bgra, matrix @ shade.to_plane)

    def _develop(self, picture: NDArray, k: int) -> Planes:
        """Vignette, grain and planes."""
        width, height = self._size
        yuv = cv2.cvtColor(picture, cv2.COLOR_BGRA2YUV_I420)
        luma = cv2.multiply(yuv[:height], self._vignette, scale=1 / 255)
        # One large field of grain, looked at somewhere else in every frame.
        dx, dy = (k * 29) % 64, (k * 47 + k // 64 * 13) % 64
        luma = cv2.add(luma, self._brighter[dy : dy + height, dx : dx + width])
        luma = cv2.subtract(luma, self._darker[dy : dy + height, dx : dx + width])
        quarter = width * height // 4
        chroma = yuv[height:].reshape(-1)
        half = (height // 2, width // 2)
        return Planes(luma, chroma[:quarter].reshape(half), chroma[quarter:].reshape(half))


class Overlay:
    """A transparent picture, ``scale`` times smaller than the camera's, that gathers sprites and is laid on once."""

    def __init__(self, size: tuple[int, int], scale: int) -> None:
        self.scale = scale
        self.bgra = np.zeros((-(-size[1] // scale), -(-size[0] // scale), 4), np.uint8)
        self._used: Box | None = None

    def touch(self, box: Box) -> None:
        old = self._used or box
        self._used = (min(old[0], box[0]), min(old[1], box[1]), max(old[2], box[2]), max(old[3], box[3]))

    def onto(self, target: NDArray | Overlay) -> None:
        """Lays what was gathered on a picture or a finer overlay, and is empty again."""
        if self._used is None:
            return
        # One more all around, for the enlargement to fade out in.
        rows, columns = self.bgra.shape[:2]
        x0, y0, x1, y1 = self._used
        x0, y0, x1, y1 = max(x0 - 1, 0), max(y0 - 1, 0), min(x1 + 1, columns), min(y1 + 1, rows)
        small = self.bgra[y0:y1, x0:x1]
        picture, s = target, self.scale
        if isinstance(target, Overlay):
            picture, s = target.bgra, self.scale // target.scale
            target.touch((s * x0, s * y0, min(s * x1, picture.shape[1]), min(s * y1, picture.shape[0])))
        large = cv2.resize(small, None, fx=s, fy=s, interpolation=cv2.INTER_LINEAR)
        window = picture[s * y0 : s * y1, s * x0 : s * x1]
        _over(window, large[: window.shape[0], : window.shape[1]])
        small[:] = 0
        self._used = None


class FieldCount:
    """Counts which of the field's points are still to be seen as things are drawn over them."""

    def __init__(self, px: NDArray, size: tuple[int, int]) -> None:
        whole = np.rint(px).astype(np.intp)
        inside = ((whole >= 0) & (whole < size)).all(1)
        self._total = len(px)
        self._x, self._y = whole[inside].T
        self._clear = np.ones((2, int(inside.sum())), np.float32)

    def hide(self, drawn: tuple[Box, NDArray] | None, scale: int, is_hand: bool) -> None:
        if drawn is None:
            return
        (x0, y0, x1, y1), alpha = drawn
        x, y = self._x // scale, self._y // scale
        under = (x >= x0) & (x < x1) & (y >= y0) & (y < y1)
        shows = 1 - alpha[y[under] - y0, x[under] - x0] / np.float32(255)
        self._clear[0, under] *= shows
        if not is_hand:
            self._clear[1, under] *= shows

    def fractions(self) -> tuple[float, float]:
        """Visible fractions: everything counted, and without hands."""
        clear, clear_of_heads = (self._clear > 0.5).sum(1) / self._total
        return float(clear), float(clear_of_heads)


def plane_to_picture(view: View, origin: NDArray, ahead: NDArray, aside: NDArray) -> NDArray:
    """3x3: plane coordinates (mm) to pixels; the third row gives depth in mm."""
    return view.K @ np.stack([view.R @ ahead, view.R @ aside, view.R @ origin + view.t], 1)


def lay(target: NDArray | Overlay, bgra: NDArray, matrix: NDArray) -> tuple[Box, NDArray] | None:
    """Draws a premultiplied sprite through ``matrix`` (sprite pixel -> full-size pixel); its box and opacity there."""
    if isinstance(target, Overlay):
        s = target.scale
        # A pixel of the small picture covers s full-size ones: its centre lies at their middle.
        matrix = np.array([[1 / s, 0, 0.5 / s - 0.5], [0, 1 / s, 0.5 / s - 0.5], [0, 0, 1]]) @ matrix
        picture = target.bgra
    else:
        picture = target
    box = _box(matrix, bgra.shape, picture.shape)
    if box is None:
        return None
    x0, y0, x1, y1 = box
    shift = np.array([[1.0, 0, -x0], [0, 1, -y0], [0, 0, 1]])
    warped = cv2.warpPerspective(bgra, shift @ matrix, (x1 - x0, y1 - y0), flags=cv2.INTER_LINEAR)
    if isinstance(target, Overlay):
        target.touch(box)
    return box, _over(picture[y0:y1, x0:x1], warped)


def _over(window: NDArray, premultiplied: NDArray) -> NDArray:
    """Puts a premultiplied picture over ``window`` in place; returns its opacity."""
    alpha = cv2.extractChannel(premultiplied, 3)
    rest = cv2.bitwise_not(alpha)
    cv2.multiply(window, cv2.merge([rest, rest, rest, rest]), window, scale=1 / 255)
    cv2.add(window, premultiplied, window)
    return alpha


def _box(matrix: NDArray, sprite: tuple[int, ...], picture: tuple[int, ...]) -> Box | None:
    """The part of the picture that a sprite may touch, or None."""
    rows, columns = sprite[:2]
    corners = matrix @ np.array([[0, columns, columns, 0], [0, 0, rows, rows], [1, 1, 1, 1]])
    if (corners[2] < NEAREST_MM).any():
        return None
    px = corners[:2] / corners[2]
    x0, y0 = np.floor(px.min(1)).astype(int)
    x1, y1 = np.ceil(px.max(1)).astype(int) + 1
    x0, y0, x1, y1 = max(int(x0), 0), max(int(y0), 0), min(int(x1), picture[1]), min(int(y1), picture[0])
    return (x0, y0, x1, y1) if x0 < x1 and y0 < y1 else None
