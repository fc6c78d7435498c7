"""How every camera sees the relief: plane + parallax, by bundle adjustment over the matches of all pairs.

A scene point is its pixel (x, y) in the reference camera and its parallax gamma. A camera sees it at
``P [x, y, 1, gamma]`` (homogeneous); P is its (3, 4) *projection*, the reference's [I | 0]. All cameras determine one
gamma a point together. Inside this module lengths are half widths of the pictures about their middles.

References
----------
Irani, Anandan, "Parallax geometry of pairs of points for 3D scene analysis", ECCV 1996. Triggs et al., "Bundle
adjustment - a modern synthesis", 1999: points eliminated (Schur), Levenberg's damping, which fixes the gauge as well.
Geman, McClure, "Statistical methods for tomographic image reconstruction", 1987: the loss, annealed.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from attrs import field, frozen
from numpy.typing import NDArray

from mcsl_core.imaging.geometry import Array, half_widths, inverse, project, transform_points

from ..correspondences import Pairs

_SCALES = tuple(np.geomspace(6, 0.5, 9) * 2 / 960)  # of the loss: what is farther off counts less and less
_STEPS = 4  # at each
_AGREES = 1.5 * 2 / 960  # a match lies where the projections say
_MOST = 500  # matches of a pair without the reference: enough to tie it, as they say little of where points lie
_FAR = 0.1  # half widths of parallax from which a match counts for its direction alone in the first guess


@frozen(eq=False)
class Tracks:
    """Scene points and where the cameras see them.

    Attributes
    ----------
    cameras : tuple of str
        The reference first.
    seen : (N, K, 2) array
        Full-size pixels; NaN where a camera does not see the point.
    """

    cameras: tuple[str, ...]
    seen: Array

    def counted(self) -> dict[str, int]:
        """Camera -> how many points it sees."""
        there = (~np.isnan(self.seen[..., 0])).sum(axis=0)
        return dict(zip(self.cameras, map(int, there), strict=True))


@frozen(eq=False)
class ReliefCameras:
    """The cameras' projections, and the points they were found by.

    Attributes
    ----------
    projections : mapping of str to (3, 4) array
        Full-size reference pixel and gamma -> full-size camera pixel; [2, 2] is 1. The reference is first.
    points : (N, 3) array
        x and y, full-size reference pixels, and gamma of the scene points that agree.
    residual_px : mapping of str to float
        Median distance of a camera's matches from where its projection has them, in its full-size pixels.
    matches : mapping of str to int
        How many steady places tie a camera; 0 where it is placed by another pose's rig.
    """

    projections: Mapping[str, Array]
    points: Array
    residual_px: Mapping[str, float]
    matches: Mapping[str, int] = field(factory=dict)


def tracks_of(pairs: Pairs, cameras: Sequence[str]) -> Tracks:
    """Scene points from the matches of pairs.

    Parameters
    ----------
    pairs : mapping of (str, str) to Correspondences
        Those with the reference have it first, on one grid of its pixels.
    cameras : sequence of str
        The reference first. Pairs of others are left out.

    Returns
    -------
    Tracks
        A point of the reference's grid as all cameras see it; what two others match is a point of its own.
    """
    place = {name: k for k, name in enumerate(cameras)}
    own = [(b, m) for (a, b), m in pairs.items() if a == cameras[0] and b in place and len(m)]
    parts = []
    if own:
        grid, row = np.unique(np.concatenate([m.a for _, m in own]).round(1), axis=0, return_inverse=True)
        seen = np.full((len(grid), len(cameras), 2), np.nan)
        row = row.reshape(-1)
        for b, m in own:
            at, row = row[: len(m)], row[len(m) :]
            seen[at, 0], seen[at, place[b]] = m.a, m.b
        parts.append(seen)
    for (a, b), m in pairs.items():
        if cameras[0] in (a, b) or a not in place or b not in place or not len(m):
            continue
        few = np.unique(np.linspace(0, len(m) - 1, min(len(m), _MOST)).round().astype(int))
        seen = np.full((len(few), len(cameras), 2), np.nan)
        seen[:, place[a]], seen[:, place[b]] = m.a[few], m.b[few]
        parts.append(seen)
    return Tracks(tuple(cameras), np.concatenate(parts) if parts else np.zeros((0, len(cameras), 2)))


def solve_cameras(tracks: Tracks, start: Mapping[str, Array], sizes: Mapping[str, tuple[int, int]]) -> dict[str, Array]:
    """Finds the projections.

    Parameters
    ----------
    tracks : Tracks
        Of all cameras, each with some hundred points; wrong ones may be among them.
    start : mapping of str to (3, 3) or (3, 4) array
        Where it starts: camera -> its plane, full-size camera pixel -> reference pixel; or its projection.
    sizes : mapping of str to (int, int)
        Every camera's full width and height.

    Returns
    -------
    dict of str to (3, 4) array
        Camera -> projection; [2, 2] is 1.
    """
    norm = {name: half_widths(sizes[name]) for name in tracks.cameras}
    first = norm[tracks.cameras[0]]
    problem = _Problem.of(tracks, norm)
    if start[tracks.cameras[0]].shape == (3, 4):
        projections = _within(start, tracks.cameras, norm)
        points, _, _ = _located(tracks, start, sizes)
    else:
        planes = [norm[n] @ inverse(first @ start[n]) for n in tracks.cameras]
        flat = np.stack([np.column_stack([plane / plane[2, 2], np.zeros(3)]) for plane in planes])
        projections, points = problem.started(flat)
    damping = 1e-3
    for scale in _SCALES:
        for _ in range(_STEPS):
            projections, points, damping = problem.step(projections, points, scale, damping)
    full = {}
    for name, own in zip(tracks.cameras, projections, strict=True):
        moved = inverse(norm[name]) @ own
        moved = np.column_stack([moved[:, :3] @ first, moved[:, 3]])
        full[name] = moved / moved[2, 2]
    return full


def locate(
    tracks: Tracks, projections: Mapping[str, Array], sizes: Mapping[str, tuple[int, int]], least: int = 2
) -> ReliefCameras:
    """Triangulates the points that cameras of known projections see.

    Parameters
    ----------
    tracks : Tracks
        Of cameras that have projections.
    projections : mapping of str to (3, 4) array
        As `solve_cameras` finds them.
    sizes : mapping of str to (int, int)
        Every camera's full width and height.
    least : int, optional
        How many cameras must agree on a point.

    Returns
    -------
    ReliefCameras
        With the points that so many cameras at least agree on.
    """
    if not len(tracks.seen):
        return ReliefCameras(dict(projections), np.zeros((0, 3)), dict.fromkeys(tracks.cameras, 0.0))
    points, off, norm = _located(tracks, projections, sizes)
    agree = (off < _AGREES).sum(axis=1) >= least
    known = agree[:, None] & np.isfinite(off)
    median = [float(np.median(off[known[:, k], k])) if known[:, k].any() else 0.0 for k in range(off.shape[1])]
    return ReliefCameras(
        dict(projections),
        np.column_stack([transform_points(inverse(norm), points[agree, :2]), points[agree, 2]]),
        {n: m * sizes[n][0] / 2 for n, m in zip(tracks.cameras, median, strict=True)},
    )


def confirmed(
    tracks: Tracks, projections: Mapping[str, Array], sizes: Mapping[str, tuple[int, int]]
) -> dict[str, tuple[int, float]]:
    """How well each camera fits points that are triangulated without it.

    Parameters
    ----------
    tracks, projections, sizes
        As `locate` has them.

    Returns
    -------
    dict of str to (int, float)
        Camera, without the reference -> how many points it sees that two others agree on without it, and the share of
        those that it sees where they say. Two cameras alone always agree: a point may lie anywhere on a ray.
    """
    found = {}
    for k, name in list(enumerate(tracks.cameras))[1:]:
        seen = tracks.seen[(~np.isnan(tracks.seen[..., 0])).sum(axis=1) >= 3]
        seen = seen[~np.isnan(seen[:, k, 0])]
        if not len(seen):
            found[name] = 0, 0.0
            continue
        others = seen.copy()
        others[:, k] = np.nan
        points, off, norm = _located(Tracks(tracks.cameras, others), projections, sizes)
        agree = (off < _AGREES).sum(axis=1) >= 2
        full = np.column_stack([transform_points(inverse(norm), points[agree, :2]), points[agree, 2]])
        apart = np.hypot(*(project(projections[name], full) - seen[agree, k]).T) / sizes[name][0] * 2
        found[name] = int(agree.sum()), float((apart < 2 * _AGREES).mean()) if agree.any() else 0.0
    return found


def disagreement(tracks: Tracks, projections: Mapping[str, Array], sizes: Mapping[str, tuple[int, int]]) -> float:
    """How far matches are from known projections, 0..1, their points triangulated; parameters as `locate`'s.

    The mean of Geman-McClure's loss, which is 0.5 of a match that lies off by 1.5 px of 960.
    """
    if not len(tracks.seen):
        return 1.0
    _, off, _ = _located(tracks, projections, sizes)
    ratio = (off[np.isfinite(off)] / _AGREES) ** 2
    return float((ratio / (1 + ratio)).mean())


def _located(
    tracks: Tracks, projections: Mapping[str, Array], sizes: Mapping[str, tuple[int, int]]
) -> tuple[Array, Array, Array]:
    """((N, 3) points, (N, K) how far off each camera sees them, inf where not, (3, 3) the reference's scale)."""
    norm = {name: half_widths(sizes[name]) for name in tracks.cameras}
    within = _within(projections, tracks.cameras, norm)
    problem = _Problem.of(tracks, norm)
    _, points = problem.started(np.concatenate([within[..., :3], np.zeros((len(within), 3, 1))], axis=2))
    points[:, 2] = 0
    for scale in _SCALES:
        points = problem.point_step(within, points, scale)
    off = np.where(problem.sees, np.linalg.norm(_projected(within, points) - problem.seen, axis=2), np.inf)
    return points, off, norm[tracks.cameras[0]]


def _within(projections: Mapping[str, Array], cameras: Sequence[str], norm: Mapping[str, Array]) -> Array:
    """(K, 3, 4) projections in half widths; [2, 2] is 1."""
    back = inverse(norm[cameras[0]])
    own = [norm[name] @ projections[name] for name in cameras]
    within = np.stack([np.column_stack([p[:, :3] @ back, p[:, 3]]) for p in own])
    return within / within[:, 2:3, 2:3]


def _projected(projections: Array, points: Array) -> Array:
    """(N, K, 2): where every camera sees every point."""
    return np.stack([project(own, points) for own in projections], axis=1)


@frozen(eq=False)
class _Problem:
    """Where the cameras see the points: (N, K, 2), 0 where they do not (``sees``, (N, K))."""

    seen: Array
    sees: NDArray[np.bool_]

    @classmethod
    def of(cls, tracks: Tracks, norm: Mapping[str, Array]) -> _Problem:
        seen = [transform_points(norm[n], tracks.seen[:, k]) for k, n in enumerate(tracks.cameras)]
        return cls(np.nan_to_num(np.stack(seen, axis=1)), ~np.isnan(tracks.seen[..., 0]))

    def started(self, projections: Array) -> tuple[Array, Array]:
        """(projections, points) to start from: what the planes leave, as one number a point times two a camera.

        The reference says where a point lies; where it does not see it, the mean of where the others' planes have it.
        """
        seen, n, k = np.where(self.sees[..., None], self.seen, np.nan), *self.sees.shape
        laid = np.stack([transform_points(inverse(p[:, :3]), seen[:, i]) for i, p in enumerate(projections)], axis=1)
        some = ~np.isnan(laid[..., 0])
        mean = np.nansum(laid, axis=1) / np.maximum(some.sum(axis=1), 1)[:, None]
        points = np.column_stack([np.where(some[:, :1], laid[:, 0], mean), np.zeros(n)])
        off = (seen - _projected(projections, points)).reshape(n, 2 * k)
        weight = (~np.isnan(off)).astype(float)
        weight[:, :2] = 0  # the reference's own
        off = np.nan_to_num(off)
        weight *= np.minimum(1, _FAR / np.maximum(np.abs(off), 1e-9))
        _, _, ways = np.linalg.svd(off * np.sqrt(weight), full_matrices=False)
        way, gamma = ways[0], np.zeros(n)
        for _ in range(30):
            gamma = (weight * off * way).sum(axis=1) / np.maximum((weight * way * way).sum(axis=1), 1e-9)
            way = (weight * off * gamma[:, None]).sum(axis=0) / np.maximum(
                (weight * gamma[:, None] ** 2).sum(axis=0), 1e-12
            )
            length = max(float(np.linalg.norm(way)), 1e-12)
            way, gamma = way / length, gamma * length
        projections = projections.copy()
        projections[1:, :2, 3] = way.reshape(k, 2)[1:]
        points[:, 2] = gamma
        return projections, points

    def loss(self, projections: Array, points: Array, scale: float) -> float:
        """Geman-McClure's, over all matches."""
        r = ((_projected(projections, points) - self.seen) ** 2).sum(axis=2) / scale**2
        return float(np.where(self.sees, r / (1 + r), 0).sum())

    def step(self, projections: Array, points: Array, scale: float, damping: float) -> tuple[Array, Array, float]:
        """One step of Levenberg's: (projections, points, damping)."""
        before = self.loss(projections, points, scale)
        normal = self._normal(projections, points, scale)
        for _ in range(6):
            cameras, moved = normal.solved(damping)
            new = projections.copy()
            new[1:] += cameras.reshape(-1, 3, 4)
            new[1:] /= new[1:, 2:3, 2:3]
            if self.loss(new, points + moved, scale) < before:
                return new, points + moved, max(damping / 4, 1e-9)
            damping *= 8
        return projections, points, min(damping, 1e3)

    def point_step(self, projections: Array, points: Array, scale: float) -> Array:
        """One step of Gauss-Newton's with the cameras as they are: the points."""
        normal = self._normal(projections, points, scale)
        size = np.trace(normal.points, axis1=1, axis2=2)[:, None, None]
        return (
            points
            + np.linalg.solve(normal.points + (1e-6 * size + 1e-9) * np.eye(3), normal.right_points[..., None])[..., 0]
        )

    def _normal(self, projections: Array, points: Array, scale: float) -> _Normal:
        n, k = self.sees.shape
        scene = np.column_stack([points[:, :2], np.ones(n), points[:, 2]])
        depth = scene @ projections[:, 2].T
        uv = _projected(projections, points)
        off = uv - self.seen
        weight = self.sees / (1 + (off**2).sum(axis=2) / scale**2) ** 2
        base = scene[:, None] / depth[..., None]
        by_camera = np.zeros((n, k, 2, 12))
        by_camera[:, :, 0, :4] = by_camera[:, :, 1, 4:8] = base
        by_camera[..., 8:] = -uv[..., None] * base[:, :, None]
        numbers = projections[:, :, [0, 1, 3]]
        by_point = (numbers[None, :, :2] - uv[..., None] * numbers[None, :, 2:]) / depth[..., None, None]
        free = by_camera[:, 1:]  # the reference stays
        weighed = free * weight[:, 1:, None, None]
        weighed_rows = weighed.transpose(1, 0, 2, 3).reshape(k - 1, -1, 12)
        points_weighed = by_point * weight[..., None, None]
        return _Normal(
            np.matmul(weighed_rows.transpose(0, 2, 1), free.transpose(1, 0, 2, 3).reshape(k - 1, -1, 12)),
            np.matmul(points_weighed.reshape(n, -1, 3).transpose(0, 2, 1), by_point.reshape(n, -1, 3)),
            np.matmul(weighed.transpose(0, 1, 3, 2), by_point[:, 1:]).reshape(n, -1, 3),
            -np.matmul(off[:, 1:].transpose(1, 0, 2).reshape(k - 1, 1, -1), weighed_rows).ravel(),
            -np.matmul(off.reshape(n, 1, -1), points_weighed.reshape(n, -1, 3))[:, 0],
        )


@frozen(eq=False)
class _Normal:
    """The normal equations in blocks.

    cameras: (K - 1, 12, 12). points: (N, 3, 3). both: (N, 12 (K - 1), 3). right_cameras, right_points: the right side.
    """

    cameras: Array
    points: Array
    both: Array
    right_cameras: Array
    right_points: Array

    def solved(self, damping: float) -> tuple[Array, Array]:
        """((12 (K - 1),) of the cameras, (N, 3) of the points), the points eliminated."""
        size = np.trace(self.points, axis1=1, axis2=2)[:, None, None] / 3
        inverse = np.linalg.inv(self.points + (damping * size + 1e-9) * np.eye(3))
        reduced = np.zeros((len(self.right_cameras),) * 2)
        for k, block in enumerate(self.cameras):
            own = slice(12 * k, 12 * k + 12)
            least = 1e-9 * np.trace(block) + 1e-12  # a camera that all matches contradict stays where it is
            reduced[own, own] = block + damping * np.diag(np.diag(block)) + least * np.eye(12)
        by_points = np.matmul(self.both, inverse)
        wide = (len(self.both) * 3, -1)
        reduced -= by_points.transpose(0, 2, 1).reshape(wide).T @ self.both.transpose(0, 2, 1).reshape(wide)
        right = self.right_cameras - np.einsum("nma,na->m", by_points, self.right_points)
        cameras = np.linalg.solve(reduced, right)
        moved = np.einsum("nab,nb->na", inverse, self.right_points - np.einsum("nma,m->na", self.both, cameras))
        return cameras, moved
