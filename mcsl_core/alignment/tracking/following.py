"""The lamp followed through a movement: every picture held against the background of the poses at its ends.

Every frame is laid as the lamp's place of the frame before foretells and compared with what the pose before showed at
the programme's same pixels (pyramidal Lucas-Kanade flow at corners, there and back); the places that agree tell where
the lamp stands. So nothing drifts: a frame is never compared with the one before it. From the other end the same is
done backwards, and at every frame the one counts that more places agree with.

References
----------
J.-Y. Bouguet: Pyramidal implementation of the Lucas Kanade feature tracker. Intel 2000.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import cv2
import numpy as np
from attrs import frozen

from mcsl_core.imaging.geometry import Array, project
from mcsl_core.parallel import by_threads

from .fitting import Fit, Sighting, fit_view
from .lamp import Lamp, LampView
from .protocol import End, Instant
from .templates import Grey, level

_WINDOW = (21, 21)
_LEVELS = (3, 1)  # of pyramids, by round: the second has little left to find
_STEPS = (cv2.TERM_CRITERIA_COUNT | cv2.TERM_CRITERIA_EPS, 10, 0.03)  # 30 and 0.01 find the lamp 0.01 px of 960 off
_BACK = 0.7  # pixels by which the flow back may miss
_REACH = 48.0  # pixels: what is found farther off is something else
_LEAST, _SHARE = 40, 0.12  # places that agree, and their share: with fewer the lamp is lost at a frame
_AGREE = 8.0 / 960  # of the width: from both ends the lamp is found there
_TRUST = 0.5  # in a new speed: trusted alone, turns and shifts that show the same alternated more and more
_DAMPED = 0.8  # of its speed the lamp keeps, foretold, where it is lost


@frozen
class BackgroundTracker:
    """Holds every picture against the background of the poses at the movement's ends, from one end and the other.

    From the one over into the other: each weighs by the places that agree, and by how near it is.
    """

    name = "background"

    def follow(self, lamp: Lamp, before: End, after: End, instants: Sequence[Instant]) -> list[LampView | None]:
        """Where the lamp stands at the instants of a movement, None where it is lost; see `Tracker`."""
        ways = ((before, instants), (after, instants[::-1]))
        there, back = by_threads(lambda way: follow_from(lamp, *way), ways)
        back = back[::-1]
        first, last = instants[0].frame, instants[-1].frame
        found: list[LampView | None] = []
        for instant, a, b in zip(instants, there, back, strict=True):
            way = (instant.frame - first) / max(last - first, 1)
            parts = [(fit, near) for fit, near in ((a, 1 - way), (b, way)) if fit is not None and near > 0]
            if len(parts) == 2 and not _agree(lamp, parts[0][0], parts[1][0]):
                parts = [max(parts, key=lambda part: part[0].inliers)]
            if not parts:
                found.append(None)
                continue
            weights = np.array([fit.inliers * near**2 for fit, near in parts])
            numbers = np.stack([fit.view.numbers for fit, _ in parts])
            found.append(LampView.of(weights @ numbers / weights.sum()))
        return found


def follow_from(lamp: Lamp, end: End, instants: Sequence[Instant]) -> list[Fit | None]:
    """Where the lamp stands at instants, by one pose alone; the parameters are those of `follow`.

    The first is the nearest to the pose, which may come before them or after: they run away from it.
    """
    return _Follower(lamp, end).run(instants)


def _agree(lamp: Lamp, a: Fit, b: Fit) -> bool:
    """Whether two views show about the same."""
    name = next(iter(lamp.mounts))
    width, height = lamp.sizes[name]
    grid = np.array([[x * width, y * height, 0.0] for x in (0.3, 0.7) for y in (0.3, 0.7)])
    off = project(lamp.projection(name, a.view), grid) - project(lamp.projection(name, b.view), grid)
    return bool(np.hypot(*off.T).max() < _AGREE * width)


class _Follower:
    """From one end of a movement on."""

    def __init__(self, lamp: Lamp, end: End) -> None:
        self._lamp, self._end = lamp, end

    def run(self, instants: Sequence[Instant]) -> list[Fit | None]:
        found: list[Fit | None] = []
        now, speed, last = self._end.view.numbers, np.zeros(7), instants[0].frame
        for instant in instants:
            gone = instant.frame - last
            foreseen = LampView.of(now + gone * speed)
            fit = self._fitted(instant, foreseen, speed)
            if fit.inliers >= _LEAST and fit.share >= _SHARE:
                if gone:
                    speed = (1 - _TRUST) * speed + _TRUST * (fit.view.numbers - now) / gone
                now, last = fit.view.numbers, instant.frame
                found.append(fit)
            else:
                now, last, speed = foreseen.numbers, instant.frame, _DAMPED * speed
                found.append(None)
        return found

    def _fitted(self, instant: Instant, foreseen: LampView, speed: Array) -> Fit:
        fit = Fit(foreseen, 0, 0.0)

        def projection(camera: str, view: LampView) -> Array:
            late = instant.late.get(camera, 0.0)
            seen = self._lamp.projection(camera, LampView.of(view.numbers - late * speed))
            return self._end.bends[camera] @ seen

        for levels in _LEVELS:  # laid anew by what the round before told
            sightings = [
                self._sighting(name, instant.pictures[name], projection(name, fit.view), levels)
                for name in sorted(self._end.templates.keys() & instant.pictures.keys())
            ]
            fit = fit_view(sightings, projection, fit.view)
        return fit

    def _sighting(self, camera: str, picture: Grey, projection: Array, levels: int) -> Sighting:
        """Where a camera's picture has the template's places, laid first by ``projection``."""
        template, ground = self._end.templates[camera], self._end.ground
        size = self._lamp.sizes[camera]
        laid = level(ground.laid(picture, size, projection))
        start = template.places.reshape(-1, 1, 2)
        options: dict[str, Any] = {"winSize": _WINDOW, "maxLevel": levels, "criteria": _STEPS}
        to, found, _ = cv2.calcOpticalFlowPyrLK(template.picture, laid, start, start.copy(), **options)
        good = np.flatnonzero((found.ravel() > 0) & (np.linalg.norm((to - start).reshape(-1, 2), axis=1) < _REACH))
        if len(good):
            back, again, _ = cv2.calcOpticalFlowPyrLK(laid, template.picture, to[good], to[good], **options)
            missed = np.linalg.norm((back - start[good]).reshape(-1, 2), axis=1)
            good = good[(again.ravel() > 0) & (missed < _BACK)]
        there = ground.scene(to.reshape(-1, 2)[good].astype(np.float64))
        return Sighting(camera, size[0], template.scene[good], project(projection, there))
