"""The pictures of one camera, one after another, and how much of the field each of them shows.

Pictures are put together as BGRA uint8 whose colours have been mixed so that OpenCV's BT.601 conversion gives BT.709
planes (one fast conversion a frame instead of a slow one). Pixel centres lie at integers.
"""

from __future__ import annotations

from collections.abc import Iterator

import cv2
import numpy as np
from numpy.typing import NDArray

from mcsl_core.images import Planes

from .clocks import Clock
from .ground import Ground
from .rig import View, unit
from .solids import Sprite
from .staging import Placement, Play
from .surface import HALF_MM

COARSE = 4
"""Where rays meet the surface is worked out on every fourth pixel and interpolated between: the surface is smooth."""

BT709 = np.array([[0.0722, 0.7152, 0.2126], [0.5, -0.385428, -0.114572], [-0.045847, -0.454153, 0.5]])
BT601 = np.array([[0.114, 0.587, 0.299], [0.5, -0.331264, -0.168736], [-0.081312, -0.418688, 0.5]])
_PREPARE = np.linalg.solve(BT601, BT709)
NEAREST_MM = 40.0
"""Nothing is drawn nearer to a camera than this."""


class CameraPictures:
    """Draws what one camera sees. ``frame(k)`` must be asked in rising order of k to be quick; any order is right."""

    def __init__(self, play: Play, ground: Ground, camera: int, clock: Clock) -> None:
        self._play, self._ground, self._camera, self._clock = play, ground, camera, clock
        scenario = play.scenario
        self._size = scenario.size
        rng = scenario.stream("sensor", camera)
        gains = rng.uniform(0.93, 1.07, 3) * rng.uniform(0.9, 1.08)
        self._colour = np.eye(4)
        self._colour[:3, :3] = _PREPARE @ np.diag(gains)
        self._base = self._prepared(ground.base)
        self._states: dict[int, NDArray] = {}
        self._sprites: dict[int, tuple[Sprite, NDArray, Sprite]] = {}
        width, height = self._size
        x, y = np.meshgrid(np.linspace(-1, 1, width), np.linspace(-1, 1, height))
        dark = rng.uniform(0.06, 0.16)
        self._vignette = np.clip(255 * (1 - dark * (x * x + y * y * (height / width) ** 2) / 1.3), 0, 255).astype(
            np.uint8
        )
        grain = rng.normal(0, scenario.noise, (height + 64, width + 64))
        grain = grain + 0.5 * cv2.GaussianBlur(grain, (0, 0), 0.8)
        self._brighter = np.clip(np.round(grain), 0, 255).astype(np.uint8)
        self._darker = np.clip(np.round(-grain), 0, 255).astype(np.uint8)
        self._still: tuple[int, int, NDArray, NDArray, NDArray] | None = None
        self._moving: tuple[int, NDArray] | None = None

    def _prepared(self, bgr: NDArray) -> NDArray:
        """BGRA in this camera's colours."""
        bgra = cv2.cvtColor(bgr, cv2.COLOR_BGR2BGRA) if bgr.shape[2] == 3 else bgr
        return cv2.transform(bgra, self._colour)

    def _sprite(self, sprite: Sprite) -> tuple[Sprite, NDArray, Sprite]:
        key = id(sprite)
        if key not in self._sprites:
            own = Sprite(self._prepared(sprite.bgra), sprite.origin_px, sprite.pitch_mm)
            rows, columns = sprite.bgra.shape[:2]
            pad = int(14 / sprite.pitch_mm)
            alpha = cv2.copyMakeBorder(sprite.bgra[..., 3], pad, pad, pad, pad, cv2.BORDER_CONSTANT, value=0)
            soft = cv2.GaussianBlur(alpha, (0, 0), 7 / sprite.pitch_mm)
            small = cv2.resize(soft, None, fx=0.25, fy=0.25, interpolation=cv2.INTER_AREA)
            ox, oy = sprite.origin_px
            origin = ((ox + pad + 0.5) / 4 - 0.5, (oy + pad + 0.5) / 4 - 0.5)
            self._sprites[key] = (own, own.to_plane, Sprite(small, origin, sprite.pitch_mm * 4))
        return self._sprites[key]

    def _state(self, stage: int) -> NDArray:
        if stage not in self._states:
            while len(self._states) > 2:
                self._states.pop(min(self._states))
            self._states[stage] = self._prepared(self._ground.state(stage, self._camera))
        return self._states[stage]

    def _field_at(self, progress: float) -> NDArray:
        stage = int(progress)
        # Steps of a 64th: finer ones change no pixel by a whole level.
        way = round((progress - stage) * 64) / 64
        return cv2.addWeighted(self._state(stage), 1 - way, self._state(stage + 1), way, 0)

    def _maps(self, view: View) -> tuple[NDArray, NDArray]:
        """Where in the ground's map each pixel looks."""
        width, height = self._size
        columns, rows = -(-width // COARSE), -(-height // COARSE)
        # cv2.resize puts coarse sample i at pixel COARSE * i + (COARSE - 1) / 2.
        x = np.arange(columns) * COARSE + (COARSE - 1) / 2
        y = np.arange(rows) * COARSE + (COARSE - 1) / 2
        px = np.stack(np.meshgrid(x, y), -1)
        gx, gy = self._play.surface.meet(view, px)
        scale, shift = 1 / self._ground.pitch_mm, HALF_MM / self._ground.pitch_mm
        full = (columns * COARSE, rows * COARSE)
        return tuple(
            cv2.resize(g * scale + shift, full, interpolation=cv2.INTER_LINEAR)[:height, :width] for g in (gx, gy)
        )  # type: ignore[return-value]

    def _texture(self, progress: float) -> NDArray:
        texture = self._base.copy()
        texture[self._ground.cut] = self._field_at(progress)
        return texture

    def _background(self, t: float) -> tuple[NDArray, View]:
        """The picture of all that lies still. Not to be drawn upon."""
        pose, still = self._play.path.pose(t)
        view = self._play.rig.view(self._camera, pose)
        progress = self._play.progression.at(t)
        if still is None:
            if self._moving is None or self._moving[0] != round(progress * 64):
                self._moving = (round(progress * 64), self._texture(progress))
            mx, my = self._maps(view)
            return cv2.remap(self._moving[1], mx, my, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REFLECT), view
        self._moving = None
        step = round(progress * 64)
        if self._still is None or self._still[0] != still:
            mx, my = self._maps(view)
            whole = cv2.remap(self._texture(step / 64), mx, my, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REFLECT)
            self._still = (still, step, whole, mx, my)
        elif self._still[1] != step:
            self._still = self._refresh(self._still, step)
        return self._still[2], view

    def _refresh(self, still, step: int):
        """The same background with the field as it has become."""
        pose, _, whole, mx, my = still
        cut = self._ground.cut
        first, side = cut[0].start, cut[0].stop - cut[0].start
        inside = (mx > first + 1) & (mx < first + side - 2) & (my > first + 1) & (my < first + side - 2)
        if not inside.any():
            return pose, step, whole, mx, my
        rows, columns = np.flatnonzero(inside.any(1)), np.flatnonzero(inside.any(0))
        window = (slice(rows[0], rows[-1] + 1), slice(columns[0], columns[-1] + 1))
        shift = np.float32(first)
        fresh = cv2.remap(
            self._field_at(step / 64), mx[window] - shift, my[window] - shift, cv2.INTER_LINEAR,
            borderMode=cv2.BORDER_REPLICATE,
        )  # fmt: skip
        whole = whole.copy()
        whole[window][inside[window]] = fresh[inside[window]]
        return pose, step, whole, mx, my

    def frame(self, k: int) -> tuple[Planes, tuple[float, float]]:
        """The camera's own frame ``k`` and the visible fraction of the field, with and without counting hands."""
        t = self._clock.programme(k / float(self._play.scenario.rate))
        background, view = self._background(t)
        picture = background.copy()
        points = view.project(self._play.surface.dense_points_mm)
        columns, rows = np.rint(points).astype(int).T
        width, height = self._size
        inside = (columns >= 0) & (columns < width) & (rows >= 0) & (rows < height)
        columns, rows = columns[inside], rows[inside]
        clear = np.ones(len(columns))
        clear_of_heads = np.ones(len(columns))
        for placement in self._play.placements(t):
            drawn = self._draw(picture, placement, view)
            if drawn is None:
                continue
            (x0, y0, x1, y1), alpha = drawn
            under = (columns >= x0) & (columns < x1) & (rows >= y0) & (rows < y1)
            shows = 1 - alpha[rows[under] - y0, columns[under] - x0] / 255.0
            clear[under] *= shows
            if not placement.is_hand:
                clear_of_heads[under] *= shows
        total = len(inside)
        visible = (float((clear > 0.5).sum() / total), float((clear_of_heads > 0.5).sum() / total))
        return self._develop(picture, k), visible

    def _develop(self, picture: NDArray, k: int) -> Planes:
        """Vignette, grain and planes."""
        width, height = self._size
        yuv = cv2.cvtColor(picture, cv2.COLOR_BGRA2YUV_I420)
        luma = yuv[:height]
        luma = cv2.multiply(luma, self._vignette, scale=1 / 255)
        # One large field of grain, looked at somewhere else in every frame.
        dx, dy = (k * 29) % 64, (k * 47 + k // 64 * 13) % 64
        luma = cv2.add(luma, self._brighter[dy : dy + height, dx : dx + width])
        luma = cv2.subtract(luma, self._darker[dy : dy + height, dx : dx + width])
        quarter = width * height // 4
        chroma = yuv[height:].reshape(-1)
        half = (height // 2, width // 2)
        return Planes(luma, chroma[:quarter].reshape(half), chroma[quarter:].reshape(half))

    def _draw(
        self, picture: NDArray, placement: Placement, view: View
    ) -> tuple[tuple[int, int, int, int], NDArray] | None:
        own, to_plane, shade = self._sprite(placement.sprite)
        ahead, aside = placement.ahead, placement.aside
        if placement.facing:
            sight = unit(placement.origin - view.centre_mm)
            ahead = unit(ahead - (ahead @ sight) * sight)
            aside = np.cross(-sight, ahead)
        if placement.shade_z is not None:
            below = placement.origin * (1, 1, 0) + np.array([0, 0, placement.shade_z])
            flat = ahead * (1, 1, 0)
            self._shade(picture, shade, view, below, flat, aside * (1, 1, 0))
        matrix = plane_to_picture(view, placement.origin, ahead, aside) @ to_plane
        box = _box(matrix, own.bgra.shape, self._size)
        if box is None:
            return None
        x0, y0, x1, y1 = box
        # A sprite enlarged more than twice is blurred anyway: it is warped small and enlarged, which is cheaper.
        centre = matrix @ np.array([own.bgra.shape[1] / 2, own.bgra.shape[0] / 2, 1.0])
        enlarged = np.sqrt(abs(np.linalg.det(matrix)) / abs(centre[2]) ** 3)
        coarse = 4 if enlarged > 4 else 2 if enlarged > 1.9 else 1
        columns, rows = -(-(x1 - x0) // coarse), -(-(y1 - y0) // coarse)
        shift = np.array(
            [[1 / coarse, 0, (0.5 - x0) / coarse - 0.5], [0, 1 / coarse, (0.5 - y0) / coarse - 0.5], [0, 0, 1]]
        )
        warped = cv2.warpPerspective(own.bgra, shift @ matrix, (columns, rows), flags=cv2.INTER_LINEAR)
        if coarse > 1:
            warped = cv2.resize(warped, (columns * coarse, rows * coarse), interpolation=cv2.INTER_LINEAR)
            warped = warped[: y1 - y0, : x1 - x0]
        alpha = cv2.extractChannel(warped, 3)
        rest = cv2.bitwise_not(alpha)
        window = picture[y0:y1, x0:x1]
        cv2.multiply(window, cv2.merge([rest, rest, rest, rest]), window, scale=1 / 255)
        cv2.add(window, warped, window)
        return box, alpha

    def _shade(self, picture, shade: Sprite, view: View, origin, ahead, aside) -> None:
        """Soft darkness below a hand, worked out small."""
        matrix = plane_to_picture(view, origin, ahead, aside) @ shade.to_plane
        box = _box(matrix, shade.bgra.shape, self._size)
        if box is None:
            return
        x0, y0, x1, y1 = box
        coarse = 8
        columns, rows = -(-(x1 - x0) // coarse), -(-(y1 - y0) // coarse)
        shift = np.array(
            [[1 / coarse, 0, (0.5 - x0) / coarse - 0.5], [0, 1 / coarse, (0.5 - y0) / coarse - 0.5], [0, 0, 1]]
        )
        dark = cv2.warpPerspective(shade.bgra, shift @ matrix, (columns, rows), flags=cv2.INTER_LINEAR)
        light = cv2.cvtColor(cv2.convertScaleAbs(dark, alpha=-0.5, beta=255.0), cv2.COLOR_GRAY2BGRA)
        light = cv2.resize(light, (columns * coarse, rows * coarse), interpolation=cv2.INTER_LINEAR)
        window = picture[y0:y1, x0:x1]
        cv2.multiply(window, light[: y1 - y0, : x1 - x0], window, scale=1 / 255)


def plane_to_picture(view: View, origin: NDArray, ahead: NDArray, aside: NDArray) -> NDArray:
    """3x3: plane coordinates (mm) to pixels; the third row gives depth in mm."""
    return view.K @ np.stack([view.R @ ahead, view.R @ aside, view.R @ origin + view.t], 1)


def _box(matrix: NDArray, shape: tuple[int, ...], size: tuple[int, int]) -> tuple[int, int, int, int] | None:
    """The part of the picture that a sprite may touch, or None."""
    rows, columns = shape[:2]
    corners = matrix @ np.array([[0, columns, columns, 0], [0, 0, rows, rows], [1, 1, 1, 1]])
    if (corners[2] < NEAREST_MM).any():
        return None
    px = corners[:2] / corners[2]
    x0, y0 = np.floor(px.min(1)).astype(int)
    x1, y1 = np.ceil(px.max(1)).astype(int) + 1
    x0, y0, x1, y1 = max(int(x0), 0), max(int(y0), 0), min(int(x1), size[0]), min(int(y1), size[1])
    return (x0, y0, x1, y1) if x0 < x1 and y0 < y1 else None


def camera_frames(pictures: CameraPictures, count: int) -> Iterator[tuple[Planes, tuple[float, float]]]:
    for k in range(count):
        yield pictures.frame(k)
