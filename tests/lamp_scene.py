"""The simulator's rig over a textured plane, turned from one pose into another: what trackers are shown."""

from __future__ import annotations

import cv2
import numpy as np
from attrs import frozen

from mcsl_core.alignment.steady import SteadyView
from mcsl_core.alignment.tracking.lamp import AT_REST, Lamp, LampView
from mcsl_core.alignment.tracking.least_squares import Blocks
from mcsl_core.alignment.tracking.protocol import End, Instant
from mcsl_core.alignment.tracking.templates import Ground, templates
from mcsl_core.imaging.geometry import inverse, project
from mcsl_core.simulation import Scenario
from mcsl_core.simulation.rig import LampPose, Rig

SIZE = (480, 270)
NAMES = ("cam1", "cam2", "cam3", "cam4", "cam5")
HEIGHT = 1.5e-3  # of inverse distance that gamma 1 stands above gamma 0


def true_lamp() -> Lamp:
    """The simulator's rig, as a lamp at rest."""
    rig = Rig.of(Scenario(seed=7, size=SIZE, cameras=5))
    pose = LampPose(np.array([0.0, 0.0, 1000.0]), np.array([0.0, 0.0, 5.0]))
    cameras = [rig.pinhole(n, pose) for n in range(5)]
    home = cameras[0]
    distance = float((home.R @ np.zeros(3) + home.t)[2])
    mounts = {
        name: np.column_stack([c.R @ home.R.T, (c.t - c.R @ home.R.T @ home.t) / distance])
        for name, c in zip(NAMES, cameras, strict=True)
    }
    to_metric = np.zeros((4, 4))
    to_metric[:3, :3] = np.linalg.inv(home.K)
    to_metric[3] = [1e-4, -2e-4, 1 - 1e-4 * 240 + 2e-4 * 135, HEIGHT]
    return Lamp(dict.fromkeys(NAMES, SIZE), {n: float(c.K[0, 0]) for n, c in zip(NAMES, cameras, strict=True)},
                mounts, to_metric)  # fmt: skip


def scene(count: int = 60) -> np.ndarray:
    rng = np.random.default_rng(3)
    return np.column_stack([rng.uniform(40, 440, count), rng.uniform(30, 240, count), rng.uniform(-8, 16, count)])


MOVED = LampView(np.array([0.05, -0.11, 0.35]), np.array([0.12, -0.05, 0.03]), 0.04)


def seen(lamp: Lamp, view: LampView) -> dict[str, np.ndarray]:
    return {name: lamp.projection(name, view) for name in NAMES}


def dense_slopes(problem: Blocks, numbers: np.ndarray) -> np.ndarray:
    """(R, P): the whole Jacobian of a problem's blocks."""
    whole = []
    for columns, slopes in problem.slopes(numbers):
        whole.append(np.zeros((len(slopes), len(numbers))))
        whole[-1][:, columns] = slopes
    return np.concatenate(whole)


def drawn(lamp: Lamp, texture: np.ndarray, camera: str, view: LampView) -> np.ndarray:
    """A camera's picture of a texture that lies over the programme's pixels at gamma 0."""
    projection = lamp.projection(camera, view)
    back = inverse(projection[:, :3])
    picture = cv2.warpPerspective(texture, np.linalg.inv(back) @ np.diag([0.5, 0.5, 1.0]), SIZE, flags=cv2.INTER_AREA)
    return np.asarray(picture, np.uint8)


@frozen(eq=False)
class Turned:
    """A movement from `AT_REST` to `MOVED`, and where the lamp stands at its instants."""

    lamp: Lamp
    before: End
    after: End
    instants: tuple[Instant, ...]
    true: tuple[LampView, ...]

    def off(self, index: int, found: LampView) -> float:
        """By how many pixels the worst camera's median scene point lies off at an instant."""
        points, true = scene(), self.true[index]
        apart = [
            project(self.lamp.projection(n, found), points) - project(self.lamp.projection(n, true), points)
            for n in NAMES
        ]
        return float(max(np.median(np.hypot(*each.T)) for each in apart))


def turned(steps: int = 20, *, arm: float = 0.0, dark: bool = False) -> Turned:
    """One camera is late by half a frame. arm: of every picture's width, elsewhere in each. dark: nothing shows."""
    lamp, rng = true_lamp(), np.random.default_rng(5)
    texture = cv2.GaussianBlur(rng.integers(0, 255, (2 * SIZE[1], 2 * SIZE[0])).astype(np.uint8), (0, 0), 3)
    texture = cv2.normalize(texture, None, 0, 255, cv2.NORM_MINMAX)  # pyright: ignore[reportCallIssue, reportArgumentType]
    ground = Ground.of(SIZE, np.zeros((8, 12)))
    ends = []
    for view in (AT_REST, MOVED):
        whole = np.ones(SIZE[::-1], bool)
        views = {
            n: SteadyView(cv2.cvtColor(drawn(lamp, texture, n, view), cv2.COLOR_GRAY2BGR), whole)  # pyright: ignore
            for n in NAMES
        }
        made = templates(ground, views, seen(lamp, view), lamp.sizes)
        ends.append(End(view, ground, made, dict.fromkeys(NAMES, np.eye(3))))
    part = np.linspace(0, 1, steps + 1)
    way = [0.0, 0.0, *(3 * part**2 - 2 * part**3), 1.0, 1.0]
    late = {"cam3": 0.5}

    def at(frame: float) -> LampView:
        return LampView.of(np.interp(frame, range(len(way)), way) * MOVED.numbers)

    instants, hidden = [], int(arm * SIZE[0])
    for frame in range(len(way)):
        pictures = {n: drawn(lamp, texture, n, at(frame - late.get(n, 0.0))) for n in NAMES}
        for picture in pictures.values():
            x = int(rng.integers(0, SIZE[0] - hidden))
            picture[:, x : x + hidden] = 120
            if dark:
                picture[:] = 0
        instants.append(Instant(frame, pictures, late))
    return Turned(lamp, ends[0], ends[1], tuple(instants), tuple(at(i.frame) for i in instants))
