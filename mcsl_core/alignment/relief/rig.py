"""The rig is rigid: how its cameras lie to each other in one pose says how they lie in another.

Projections are known but for the plane that gamma counts from and its scale; and a lamp's cameras zoom by one knob,
about the middles of their pictures (1 % of zoom that is not allowed for leaves 2 px of 960). So the projections of
two poses differ by five numbers, ``P' = S_k(z) P S_ref(z)^-1 [[I, 0], [m, s]]`` up to a factor each: the zoom z, the
plane m (three) and the scale s. Only z changes which pixels of two cameras can show one point: `zoomed_rig` fits it
to matches alone, before any camera is known. m and s are a choice of coordinates: `moved_rig` fits them to cameras
that both poses know well, and so has a camera that a head hid through one pose in that pose's coordinates.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence

import numpy as np
import scipy
from attrs import frozen

from mcsl_core.imaging.geometry import Array, project

from .cameras import ReliefCameras, Tracks, disagreement

_FITS = 1.0 / 960  # of the width: how far off the cameras that both know may lie, medians
_SURE = 600  # steady places from which a camera's projection is relied on
_LEAST = 2  # cameras that both know, beside the reference
_ZOOMS = np.geomspace(0.7, 1.4, 15)  # a lamp's from pose to pose; the loss has one valley, some 10 % wide
_TRACKS = 600  # points that the zoom is fitted to; more fitted it no better
_AGREED = 0.7  # the best zoom's loss over the median of all: 0.1 to 0.65 of one rig, 0.95 and more where it was bent


@frozen(eq=False)
class Rig:
    """How a pose's cameras lie.

    Attributes
    ----------
    projections : mapping of str to (3, 4) array
        As `ReliefCameras` has them.
    matches : mapping of str to int
        How many steady places tie a camera; 0 where it is placed by another pose's rig.
    """

    projections: Mapping[str, Array]
    matches: Mapping[str, int]

    @classmethod
    def of(cls, cameras: ReliefCameras | None) -> Rig:
        """Of a pose's cameras; empty without."""
        return cls({}, {}) if cameras is None else cls(cameras.projections, cameras.matches)

    def sure(self) -> set[str]:
        """The cameras that many places tie, whose projections are relied on."""
        return {name for name, count in self.matches.items() if count >= _SURE}

    def transferred(self) -> set[str]:
        """The cameras that are placed by another pose's rig."""
        return {name for name, count in self.matches.items() if count == 0}


def helpful(rigs: Sequence[Rig], unsure: Collection[str]) -> Rig | None:
    """Of the rigs that are sure of any of these cameras the one that is sure of most, then by most places; or None."""
    able = [rig for rig in rigs if rig.sure() & set(unsure)]
    return max(able, key=lambda rig: (len(rig.sure() & set(unsure)), sum(rig.matches.values())), default=None)


def zoomed(
    projections: Mapping[str, Array], zoom: float, reference: str, sizes: Mapping[str, tuple[int, int]]
) -> dict[str, Array]:
    """The projections of a rig whose cameras all have so many times their focal length; parameters as `moved_rig`'s."""
    back = np.eye(4)
    back[:3, :3] = _about_middle(sizes[reference], 1 / zoom)
    made = {name: _about_middle(sizes[name], zoom) @ p @ back for name, p in projections.items()}
    return {name: p / p[2, 2] for name, p in made.items()}


def zoomed_rig(
    known: Mapping[str, Array], tracks: Tracks, sizes: Mapping[str, tuple[int, int]]
) -> dict[str, Array] | None:
    """The projections of another pose's rig, zoomed as this pose's matches have it.

    Parameters
    ----------
    known : mapping of str to (3, 4) array
        Camera -> its projection in the other pose.
    tracks : Tracks
        This pose's, of cameras among them; wrong ones may be among the matches.
    sizes : mapping of str to (int, int)
        Every camera's full width and height.

    Returns
    -------
    dict of str to (3, 4) array or None
        ``known`` over the other pose's plane and scale of gamma; None where the matches do not agree with it.
    """
    reference = tracks.cameras[0]
    few = np.unique(np.linspace(0, len(tracks.seen) - 1, _TRACKS).round().astype(int)) if len(tracks.seen) else []
    some = Tracks(tracks.cameras, tracks.seen[few])

    def loss(way: float) -> float:
        return disagreement(some, zoomed(known, float(np.exp(way)), reference, sizes), sizes)

    ways = np.log(_ZOOMS)
    losses = [loss(way) for way in ways]
    at = int(np.argmin(losses))
    bounds = ways[max(at - 1, 0)], ways[min(at + 1, len(ways) - 1)]
    best = scipy.optimize.minimize_scalar(loss, bounds=bounds, method="bounded", options={"xatol": 1e-4, "maxiter": 15})
    return zoomed(known, float(np.exp(best.x)), reference, sizes) if best.fun < _AGREED * np.median(losses) else None


def _about_middle(size: tuple[int, int], zoom: float) -> Array:
    x, y = (size[0] - 1) / 2, (size[1] - 1) / 2
    return np.array([[zoom, 0, (1 - zoom) * x], [0, zoom, (1 - zoom) * y], [0, 0, 1]])


def moved_rig(
    known: Mapping[str, Array],
    sure: Mapping[str, Array],
    points: Array,
    reference: str,
    sizes: Mapping[str, tuple[int, int]],
) -> dict[str, Array] | None:
    """The projections of one pose in terms of another's.

    Parameters
    ----------
    known : mapping of str to (3, 4) array
        Camera -> its projection in a pose that knows them all.
    sure : mapping of str to (3, 4) array
        Camera -> its projection in this pose, of those that can be relied on.
    points : (N, 3) array
        This pose's scene points: full-size reference pixels and gamma.
    reference : str
        The reference camera.
    sizes : mapping of str to (int, int)
        Every camera's full width and height.

    Returns
    -------
    dict of str to (3, 4) array or None
        ``known``, each camera of it, over this pose's plane and scale. None where fewer than two cameras are common, or
        the rig does not fit them.
    """
    common = sorted((known.keys() & sure.keys()) - {reference})
    if len(common) < _LEAST or len(points) < 10:
        return None
    scene = np.column_stack([points[:, :2], np.ones(len(points)), points[:, 2]])
    scale = np.abs(scene).mean(axis=0) + 1e-12
    moved, off = dict(known), np.zeros((len(common), len(points)))
    for _ in range(8):
        weight = 1 / (1 + (off / _FITS) ** 2) ** 2
        rows, right = [], []
        for own, name in zip(weight, common, strict=True):
            a, b = _linear(known[name], project(sure[name], points), scene / scale, scene[:, :3])
            size = np.sqrt(own)[:, None] / sizes[name][0]
            rows.append((a * size[..., None]).reshape(-1, 4))
            right.append((b * size).ravel())
        numbers = np.linalg.lstsq(np.concatenate(rows), np.concatenate(right), rcond=None)[0] / scale
        moved = {name: _moved(projection, numbers) for name, projection in known.items()}
        apart = [(project(moved[n], points) - project(sure[n], points)) / sizes[n][0] for n in common]
        off = np.linalg.norm(np.stack(apart), axis=2)
    return None if np.median(off, axis=1).max() > _FITS else moved


def _linear(projection: Array, seen: Array, scene: Array, pixels: Array) -> tuple[Array, Array]:
    """What the four numbers must fulfil, ((N, 2, 4), (N, 2)): A x + t (numbers . scene) lies where it is seen."""
    base = pixels @ projection[:, :3].T
    t = projection[:, 3]
    depth = base[:, 2]
    along = (t[:2] - seen * t[2]) / depth[:, None]
    return along[..., None] * scene[:, None], seen - base[:, :2] / depth[:, None]


def _moved(projection: Array, numbers: Array) -> Array:
    own = np.column_stack([projection[:, :3] + np.outer(projection[:, 3], numbers[:3]), projection[:, 3] * numbers[3]])
    return own / own[2, 2]
