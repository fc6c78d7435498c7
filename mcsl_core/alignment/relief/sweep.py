"""The relief by a plane sweep: coarsely over all gammas that may be, then finely about what was found."""

from __future__ import annotations

from collections.abc import Mapping

import cv2
import numpy as np
from attrs import evolve, field, frozen
from numpy.typing import NDArray

from mcsl_core.imaging.geometry import size_at_columns
from mcsl_core.imaging.relief import between_nodes

from ..dense_matching import pixels_of
from .cost_volume import Field, SweptCamera, Volume, swept
from .protocol import ReliefScene, ReliefSurface
from .semi_global import aggregated
from .service import unserved
from .thin_plate import Nodes, Plate

_COLUMNS = 96
_STEP_COST, _JUMP_COST = 0.03, 2.0  # of costs of 0..0.5, for a step of half a working pixel and for any larger
# What a measurement is worth, 0..1, is a product: of its cost, ...
_ALIKE = 0.25
_SHARP = 0.02  # ... of how sharply that rises to both sides (the curvature that counts in full), ...
_PAIRS = 5.0  # ... of the weight of the pairs compared (half at so much), ...
_STANDS_OUT = (0.05, 0.15)  # ... and of how much better the best level is than the mean of all: from nothing to full.
_LITTLE = 0.03  # a node's mean worth that counts half: chance reaches 0.01
# Weight of the perspective's first surface where that is so confident. Of six simulated second poses one whose cameras
# heads hid came from 3.7 to 0.8 px of 960 (median); at 0.3 one whose first was poor lost by it, at 0.03 the hidden one.
_PRIOR, _PRIOR_SURE = 0.1, 0.5
_SCALE = 1.0  # of the plate's loss, working pixels
_SURE = 0.08  # mean worth about a node at which its share is a half; see `_share_of_worth`
_ABOUT = 2.5  # sigma of that mean, nodes
_DOUBT = 0.2  # share below which gamma goes over to the plane
# Share below which the plane is as near. From half way to 1 on the look goes by the relief wholly: there it is off by
# 1.5 to 2 px rms of 960 where the plane is by 6.5; at 0.6 by 3 to 6, and the plane by 2 to 6.
_NOT_SURE = 0.5


@frozen
class Sweep:
    """One pass.

    Attributes
    ----------
    columns : int
        Of the working picture.
    step : float
        From one level to the next, working pixels of the camera moved most.
    reach : float
        How far levels reach to either side, share of the perspective's diagonal.
    """

    columns: int
    step: float
    reach: float


@frozen
class PlaneSweep:
    """A plane sweep over all views together: census, semi-global matching, a robust thin plate.

    Attributes
    ----------
    sweeps : tuple of Sweep
        Coarse, then fine.
    plate : Plate
        What is laid through each.
    prior : float
        What a gamma costs that lies 3 % of the diagonal or more off what the matches say, or off the plane: next to
        nothing where the pictures speak.

    References
    ----------
    Collins 1996 (the sweep); Zabih & Woodfill 1994 (census); Hirschmueller 2008 (semi-global matching).
    """

    name = "plane-sweep"
    sweeps: tuple[Sweep, ...] = (Sweep(240, 0.5, 0.045), Sweep(640, 0.5, 0.004))
    plate: Plate = field(factory=Plate)
    prior: float = 0.05

    def estimate(self, scene: ReliefScene) -> ReliefSurface | None:
        """Finds the relief; None where fewer than two cameras would be served."""
        cameras = {name: SweptCamera.of(camera) for name, camera in scene.cameras.items() if camera.views}
        start = self._start(scene)
        coarse, *fine = self.sweeps
        while True:  # a camera that is wrong disturbs the others
            if len(cameras) < 2:
                return None
            found = self._pass(coarse, cameras, scene, _Found(start, np.ones_like(start), None))
            wrong = self._worst(cameras, scene.size, found.gamma)
            if wrong is None:
                break
            del cameras[wrong]
        for sweep in fine:
            found = self._pass(sweep, cameras, scene, found)
        served = set(cameras)
        while (wrong := self._worst({n: cameras[n] for n in served}, scene.size, found.gamma)) is not None:
            served.remove(wrong)
        if len(served) < 2:
            return None
        share = _share_of_worth(found.worth)
        confidence = np.maximum(share - _NOT_SURE, 0) / (1 - _NOT_SURE)
        return ReliefSurface(found.gamma * np.minimum(1, share / _DOUBT), confidence, frozenset(served))

    def _start(self, scene: ReliefScene) -> Nodes:
        """What the matches say, and 0 far from any."""
        rows = size_at_columns(scene.size, _COLUMNS)[1]
        total, count = np.zeros((rows, _COLUMNS)), np.zeros((rows, _COLUMNS))
        last = np.array([_COLUMNS - 1, rows - 1]) / (np.array(scene.size) - 1)
        inside = ((scene.points[:, :2] >= 0) & (scene.points[:, :2] <= np.array(scene.size) - 1)).all(axis=1)
        points = scene.points[inside]
        column, row = np.round(points[:, :2] * last).astype(int).T
        np.add.at(total, (row, column), points[:, 2])
        np.add.at(count, (row, column), 1)
        plate = evolve(self.plate, stiffness=10 * self.plate.stiffness)
        return plate.through(total / np.maximum(count, 1), np.minimum(count, 1), scene.size[0] / 480)

    def _pass(self, sweep: Sweep, cameras: Mapping[str, SweptCamera], scene: ReliefScene, before: _Found) -> _Found:
        perspective = scene.size
        size = size_at_columns(perspective, sweep.columns)
        pixel = perspective[0] / sweep.columns
        diagonal = float(np.hypot(*perspective))
        count = int(np.ceil(sweep.reach * diagonal / (sweep.step * pixel)))
        levels = np.arange(-count, count + 1, dtype=np.float64) * (sweep.step * pixel)
        base = _spread(before.gamma, size)
        ready = [camera.reduced(perspective, size) for camera in cameras.values()]
        volume = swept(ready, base, levels)
        cost = volume.cost
        if before.stands_out is None:
            far = np.minimum(1, (levels / (0.03 * diagonal)) ** 2).astype(np.float32)
            cost = (cost + np.float32(self.prior) * far[:, None, None]).astype(np.float32)
        paths = aggregated(cost, step=_STEP_COST * sweep.step / 0.5, jump=_JUMP_COST)
        chosen, worth, stands_out = _measured(volume, paths, levels, sweep.step)
        # Only a sweep over all levels tells how far one stands out.
        clear = stands_out if before.stands_out is None else np.asarray(cv2.resize(before.stands_out, size), np.float32)
        values, weights = _at_nodes(base + chosen, worth * clear, before.gamma.shape)
        scale = _SCALE * pixel * (2 if before.stands_out is None else 1)
        values, weights = _with_prior(values, weights, scale, scene.before)
        return _Found(self.plate.through(values, weights, scale), weights, clear)

    def _worst(self, cameras: Mapping[str, SweptCamera], perspective: tuple[int, int], gamma: Nodes) -> str | None:
        size = size_at_columns(perspective, self.sweeps[0].columns)
        ready = {name: camera.reduced(perspective, size) for name, camera in cameras.items()}
        return unserved(ready, _spread(gamma, size))


@frozen(eq=False)
class _Found:
    """Gamma and worth at the nodes, and 0..1 at every working pixel whether one level stands out there."""

    gamma: Nodes
    worth: Nodes
    stands_out: Field | None


def _measured(
    volume: Volume, paths: NDArray[np.float32], levels: NDArray[np.float64], step: float
) -> tuple[Field, Field, Field]:
    """Per pixel: the level chosen (by a parabola), what that is worth, and how far it stands out from the others."""
    best = paths.argmin(axis=0)
    inner = np.clip(best, 1, len(levels) - 2)
    below, at, above = (np.take_along_axis(paths, inner[None] + n, axis=0)[0] for n in (-1, 0, 1))
    bend = below + above - 2 * at
    part = np.where(bend > 1e-6, np.clip((below - above) / np.maximum(2 * bend, 1e-6), -0.5, 0.5), 0)
    inside = best == inner
    chosen = levels[0] + (levels[1] - levels[0]) * (best + part * inside)
    below, at, above = (np.take_along_axis(volume.cost, inner[None] + n, axis=0)[0] for n in (-1, 0, 1))
    pairs = np.take_along_axis(volume.pairs, inner[None], axis=0)[0]
    sharp = np.clip((below + above - 2 * at) / (_SHARP * (step / 0.5) ** 2), 0, 1)
    worth = inside * np.exp(-((at / _ALIKE) ** 2)) * sharp * pairs / (pairs + _PAIRS)
    low, high = _STANDS_OUT
    stands_out = np.clip((volume.cost.mean(axis=0) - at - low) / (high - low), 0, 1)
    return chosen.astype(np.float32), worth.astype(np.float32), stands_out


def _at_nodes(gamma: Field, worth: Field, shape: tuple[int, ...]) -> tuple[Nodes, Nodes]:
    """Weighted means about the nodes, and the mean weight there."""
    height, width = gamma.shape
    box = tuple(max(3, round(pixels / nodes) | 1) for pixels, nodes in ((width, shape[1]), (height, shape[0])))
    total, count = (cv2.blur(a, box, borderType=cv2.BORDER_CONSTANT) for a in (gamma * worth, worth))
    rows, columns = (np.round(np.linspace(0, n - 1, m)).astype(int) for n, m in zip(gamma.shape, shape, strict=True))
    total, count = (a[np.ix_(rows, columns)].astype(np.float64) for a in (total, count))
    return total / np.maximum(count, 1e-6), count**2 / (count + _LITTLE)


def _with_prior(values: Nodes, weights: Nodes, scale: float, prior: ReliefSurface | None) -> tuple[Nodes, Nodes]:
    """Means at the nodes and their weights, with what was known before counted in, less where they contradict it."""
    if prior is None or prior.gamma.shape != values.shape:
        return values, weights
    known = _PRIOR * np.minimum(1, prior.confidence / _PRIOR_SURE)
    known /= 1 + weights / _PRIOR * ((values - prior.gamma) / scale) ** 2
    total = weights + known
    return (weights * values + known * prior.gamma) / np.maximum(total, 1e-6), total


def _spread(nodes: Nodes, size: tuple[int, int]) -> Field:
    """Nodes from the first to the last pixel centre, at every pixel of a picture of that size."""
    return between_nodes(nodes[..., None], size, pixels_of(size)).reshape(size[::-1]).astype(np.float32)


def _share_of_worth(worth: Nodes) -> Nodes:
    """How well a node is supported by the measurements about it, 0..1."""
    around = cv2.GaussianBlur(worth, (0, 0), _ABOUT, borderType=cv2.BORDER_REPLICATE)
    return np.asarray(around / (around + _SURE))
