"""What a camera's lens and electronics make of a picture: distortion, blur, exposure and white balance that change.

All of it is a plain function of the frame's time, so that any frame can be asked for.
"""

from __future__ import annotations

from bisect import bisect_right

import attrs
import cv2
import numpy as np
from numpy.typing import NDArray

from mcsl_core.imaging.planes import BGR_TO_YUV

from .layers import Picture
from .rig import PinholeCamera
from .scenario import Scenario
from .schedule import LampPath, Track, ease, make_track

Maps = tuple[NDArray, NDArray]
"""x and y as `cv2.remap` takes them."""
OFFSETS = np.array([16.0, 128, 128])
SETTLING_S = (1.2, 2.6)
"""Within which time a camera's exposure comes two thirds of the way to where it should be."""


@attrs.frozen(eq=False)
class Exposure:
    """Automatic exposure: off when the camera begins and whenever the lamp has moved, hunting now and then.

    Attributes
    ----------
    movements
        (start, stop) of the lamp's, seconds.
    off
        By how much it is off at the beginning and after each movement, natural logarithms.
    settling_s
        Time constant.
    pump
        What it hunts by, natural logarithms.
    """

    movements: tuple[tuple[float, float], ...]
    off: tuple[float, ...]
    settling_s: float
    pump: Track

    @classmethod
    def of(cls, scenario: Scenario, path: LampPath, camera: int) -> Exposure:
        """A camera's exposure."""
        rng, size = scenario.stream("exposure", camera), scenario.traits.exposure
        off = rng.choice((-1, 1), len(path.poses)) * rng.uniform(0.5, 1.0, len(path.poses)) * size
        keys: list[tuple[float, float, NDArray]] = []
        t = rng.uniform(0, 6)
        while t < scenario.duration_s + 5:
            # Something bright or dark comes into the picture; the camera answers, and goes back when it is gone.
            for value in (rng.normal(0, size / 3), 0.0):
                keys.append((t, t + rng.uniform(0.3, 0.9), np.array([value])))
                t += rng.uniform(1.2, 6)
            t += rng.exponential(4)
        return cls(
            path.movements, tuple(float(v) for v in off), rng.uniform(*SETTLING_S), make_track(keys, np.zeros(1))
        )

    def at(self, t: float) -> float:
        """The factor of the light."""
        done = bisect_right([stop for _, stop in self.movements], t)
        since = t - (self.movements[done - 1][1] if done else 0.0)
        off = self.off[done] * np.exp(-max(since, 0.0) / self.settling_s)
        if done < len(self.movements) and t > self.movements[done][0]:
            start, stop = self.movements[done]
            off += (self.off[done + 1] - off) * ease((t - start) / (stop - start))
        return float(np.exp(off + self.pump.at(t)[0]))


@attrs.frozen(eq=False)
class WhiteBalance:
    """White balance that drifts: the logarithms of blue's and red's gains rise and fall over a minute or two."""

    size: float
    period_s: NDArray
    phase: NDArray

    @classmethod
    def of(cls, scenario: Scenario, camera: int) -> WhiteBalance:
        """A camera's white balance."""
        rng = scenario.stream("white balance", camera)
        return cls(scenario.traits.white_balance, rng.uniform(24, 110, 2), rng.uniform(0, 6.28, 2))

    def at(self, t: float) -> NDArray:
        """(3,) gains of B, G, R."""
        blue, red = self.size * np.sin(2 * np.pi * t / self.period_s + self.phase)
        return np.exp([blue, 0.0, red])


class Optics:
    """One camera's lens and electronics.

    Parameters
    ----------
    scenario, path
        Of the recording.
    camera
        Its index.
    """

    def __init__(self, scenario: Scenario, path: LampPath, camera: int) -> None:
        traits = scenario.traits
        self._exposure = Exposure.of(scenario, path, camera) if traits.exposure else None
        self._balance = WhiteBalance.of(scenario, camera) if traits.white_balance else None
        self._blur_px = traits.defocus * scenario.size[0] if camera == defocused(scenario) else 0.0
        self._maps: tuple[float, Maps, Maps] | None = None

    def seen(self, picture: Picture, drawn: PinholeCamera, true: PinholeCamera, t: float) -> Picture:
        """The picture as the camera sees it at programme time ``t``.

        Parameters
        ----------
        picture
            As it was drawn.
        drawn, true
            The camera that it was drawn for, and the same with its lens's distortion.
        t
            Seconds.
        """
        if true.k1:
            picture = self._distorted(picture, drawn, true)
        if self._blur_px:
            y = cv2.GaussianBlur(picture.y, (0, 0), self._blur_px)
            u, v = (cv2.GaussianBlur(plane, (0, 0), self._blur_px / 2) for plane in (picture.u, picture.v))
            picture = Picture(y, u, v)
        gains = np.ones(3)
        if self._exposure:
            gains = gains * self._exposure.at(t)
        if self._balance:
            gains = gains * self._balance.at(t)
        return _brightened(picture, gains) if (gains != 1).any() else picture

    def drawn_at(self, true: PinholeCamera, drawn: PinholeCamera, size: tuple[int, int]) -> Maps:
        """x and y (H, W) float32 where the picture was drawn that each pixel shows."""
        px = np.stack(np.meshgrid(np.arange(size[0], dtype=float), np.arange(size[1], dtype=float)), -1)
        x, y = np.moveaxis(true.undistorted(px) @ drawn.K[:2, :2].T + drawn.K[:2, 2], -1, 0)
        return x.astype(np.float32), y.astype(np.float32)

    def _distorted(self, picture: Picture, drawn: PinholeCamera, true: PinholeCamera) -> Picture:
        """The picture through a lens that distorts: each of its pixels is looked up where the drawing has it."""
        focal = float(true.K[0, 0])
        if self._maps is None or self._maps[0] != focal:
            rows, columns = picture.y.shape
            full = self.drawn_at(true, drawn, (columns, rows))
            # A chroma sample lies amid four luma samples.
            x, y = ((cv2.resize(m, (columns // 2, rows // 2), interpolation=cv2.INTER_AREA) - 0.5) / 2 for m in full)
            self._maps = focal, full, (x, y)
        _, full, half = self._maps
        return Picture(_remapped(picture.y, full), _remapped(picture.u, half), _remapped(picture.v, half))


def _remapped(plane: NDArray, maps: Maps) -> NDArray:
    return cv2.remap(plane, *maps, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)


def defocused(scenario: Scenario) -> int | None:
    """The camera that is out of focus, if one is: by chance, never the reference unless it is alone."""
    if not scenario.traits.defocus:
        return None
    return int(scenario.stream("defocus").integers(1, scenario.cameras)) if scenario.cameras > 1 else 0


def _brightened(picture: Picture, gains: NDArray) -> Picture:
    """The picture with its B, G and R multiplied."""
    rows, columns = picture.y.shape
    linear = BGR_TO_YUV[:, :3]
    matrix = linear @ np.diag(gains) @ np.linalg.inv(linear)
    matrix = np.column_stack([matrix, OFFSETS - matrix @ OFFSETS])
    u, v = (cv2.resize(p, (columns, rows), interpolation=cv2.INTER_LINEAR) for p in (picture.u, picture.v))
    return Picture.of(cv2.transform(cv2.merge([picture.y, u, v]), matrix))
