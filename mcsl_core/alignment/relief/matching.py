"""Dense matches of all pairs of cameras over the whole picture, and the cameras' projections by them.

Views are laid over each other by their planes, then by the relief found so. Where a pose's own matches tie a camera by
little, the rig of another pose starts it, or places it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import attrs
import cv2
import numpy as np
from attrs import frozen
from numpy.typing import NDArray

from mcsl_core.imaging.geometry import Array, inverse, project, scaling, size_at_columns, transform_points
from mcsl_core.imaging.masks import Mask, resize_mask

from ..aligned_views import Picture
from ..correspondences import Correspondences, Pairs
from ..dense_matching import AlignedCamera, DenseSettings, match_densely, pixels_of
from ..steady import SteadyView
from .cameras import ReliefCameras, Tracks, confirmed, locate, solve_cameras, tracks_of
from .field_surface import field_gamma, height_of_gamma
from .interpolation import gamma_map
from .rig import Rig, helpful, moved_rig, zoomed_rig

WIDTH = 480  # columns of the views that are matched: more found no more, and took its time
BY_PLANE = DenseSettings(grid_px=6, other_hue=0.0, reach=0.05)  # views laid by planes: a relief shifts them so far
BY_RELIEF = DenseSettings(grid_px=6, other_hue=0.0, reach=0.02)  # laid by the relief: what that leaves
_CLOSELY = attrs.evolve(BY_RELIEF, grid_px=4)  # over the field alone
_LEAST = 150  # matches that a camera needs: with fewer its projection is wrong, and bends the others'
# A camera is judged by points that two others agree on without it (`confirmed`): so many there must be, and it must
# see such a share of them where the others say. Right cameras saw 0.83 and more (0.97 as a rule); of those that were
# tied by chance, where a head hid the field from the reference, there were no such points, or they saw 0.57 to 0.67.
_JUDGED, _RIGHT = 20, 0.75
# The share in the first pass, laid by planes: where these were 20 px off, right cameras saw 0.70 of a limb. The second
# pass, laid by the relief, judges them once more.
_RIGHT_AT_FIRST = 0.6
_PLENTY = 1200  # matches of a camera's steady view; with fewer single samples are matched as well
_SAMPLES = 12  # of those, spread over the pose
# The share of the picture's middle that steady matches cover, below which single samples are matched as well. Where
# hands work all over the field all the while it is 0: planes were 2 to 11 times the best one's error, with single
# samples 1.3. Other poses had 0.48 and more, where single samples brought in hands: 1.03 became 1.2.
_LEAST_COVERED = 0.25
_AIM = 0.15  # of the width: the middle's radius, where it counts 1/e
# The share of the field's grid that is matched with the reference, below which other cameras are matched with each
# other: 0.3 to 0.9 where no head hid the field from the reference all the while.
_FEW_SEEN = 0.15
FIELD_POINTS = 1500  # of a grid over the field, for its planes
_AROUND_PX, _AROUND_WEIGHT = 16, 1e-4  # of the grid outside the field, whose area is fifty times the field's


@frozen(eq=False)
class Views:
    """What the cameras show in a pose.

    Attributes
    ----------
    reference : str
        One of ``sizes``.
    sizes : mapping of str to (int, int)
        Every camera's full width and height.
    steady : mapping of str to SteadyView or None
        Camera -> what it shows steadily.
    samples : sequence of mapping of str to (h, w, 3) uint8 array or None
        Some samples: camera -> its picture.
    """

    reference: str
    sizes: Mapping[str, tuple[int, int]]
    steady: Mapping[str, SteadyView | None]
    samples: Sequence[Mapping[str, Picture | None]]

    @property
    def size(self) -> tuple[int, int]:
        """Width and height of the reduced reference picture, over which the views are laid."""
        return size_at_columns(self.sizes[self.reference], WIDTH)


def relief_cameras(views: Views, homographies: Mapping[str, Array], rigs: Sequence[Rig] = ()) -> ReliefCameras | None:
    """The projections of the cameras that show enough of the same, and the points they were found by.

    Parameters
    ----------
    views : Views
        What the cameras show.
    homographies : mapping of str to (3, 3) array
        Camera -> its plane, full-size camera pixel -> reference pixel, to some 5 % of a diagonal.
    rigs : sequence of Rig
        Of other poses, which tell of cameras that show little in this one.

    Returns
    -------
    ReliefCameras or None
        None where fewer than two cameras share enough.

    Notes
    -----
    Twice: laid by its plane, what stands high above it is matched with a bias towards its surroundings (flow is
    smooth); laid by the relief found so there is nothing left to lead astray. On plain scenes this takes the
    projections from 0.16 to 0.09 px of 960, on a photographed limb from 0.9 to 0.45.
    """
    names = [views.reference, *(n for n in homographies if n != views.reference and views.steady.get(n) is not None)]
    to_views = scaling(views.sizes[views.reference], views.size)
    planes = pixels_of(views.size)
    laid = {n: transform_points(inverse(to_views @ homographies[n]), planes) for n in names}
    by_plane = _matched(views, laid, BY_PLANE)
    found = _by_planes(by_plane, names, views, homographies)
    shown = {name for name, view in views.steady.items() if view is not None}
    rig = helpful(rigs, shown - Rig.of(found).sure())
    return found if rig is None else _by_rig(found, by_plane, rig, views)


def _by_planes(
    by_plane: _Matches, names: Sequence[str], views: Views, homographies: Mapping[str, Array]
) -> ReliefCameras | None:
    """Found from planes: matched as these lay the views, then as the relief found so does."""
    found = _solved(by_plane, names, views, homographies, _RIGHT_AT_FIRST)
    if found is None:
        return None
    kept = list(found.projections)
    matches, best = _matched(views, _laid_by(found, views), BY_RELIEF), None
    for start in (homographies, _planes_of(found)):
        again = _solved(matches, kept, views, start)
        if again is not None and (best is None or len(again.projections) > len(best.projections)):
            best = again
        if best is not None and len(best.projections) == len(kept):
            break
    return best or _solved(by_plane, names, views, homographies)


def _planes_of(cameras: ReliefCameras) -> dict[str, Array]:
    """The scene's plane at the median gamma: camera -> full-size camera pixel -> reference pixel.

    A second start for the second pass: where a head hid the field from the reference, planes by distinctive points were
    20 px off, and from them the many matches of that pass ended in a worse minimum than the few of the first.
    """
    level = float(np.median(cameras.points[:, 2]))
    lifted = np.array([[1, 0, 0], [0, 1, 0], [0, 0, 1], [0, 0, level]])
    return {name: inverse(p @ lifted) for name, p in cameras.projections.items()}


def _by_rig(found: ReliefCameras | None, by_plane: _Matches, rig: Rig, views: Views) -> ReliefCameras | None:
    """Found from another pose's rig; cameras that match too little are placed by it alone.

    Where a head hides the field from the reference all the while only drapes tie it: planes lay views too far off to be
    matched, and cameras were 3.5 px of 960 off or left out. Started by the rig of another pose they are 0.1 off.

    Cameras that the rig itself ties by few places are not placed by it: 269 places on drapes beside the field left one
    6 px off over the field, and 49 px in the pose that was placed by that.
    """
    names = [n for n in rig.projections if n == views.reference or views.steady.get(n) is not None]
    zoomed, matches = zoomed_rig(rig.projections, tracks_of(by_plane.all, names), views.sizes), by_plane
    if zoomed is None:  # planes may be tied by nothing but heads: match anew, laid by the rig
        laid = _laid_on(np.zeros(views.size[::-1], np.float32), rig.projections, views)
        matches = _matched(views, {name: laid[name] for name in names}, BY_PLANE)
        zoomed = zoomed_rig(rig.projections, tracks_of(matches.all, names), views.sizes)
    if zoomed is None:
        return found
    told = {name: zoomed[name] for name in rig.sure() | {views.reference}}
    own = ReliefCameras({n: zoomed[n] for n in names}, np.zeros((0, 3)), {})
    for _ in range(2):
        laid = locate(tracks_of(matches.all, list(own.projections)), own.projections, views.sizes)
        if len(laid.points) < _LEAST:
            return found
        matches = _matched(views, _laid_by(laid, views), BY_RELIEF)
        again = _solved(matches, list(own.projections), views, own.projections)
        if again is None:
            return found
        own = _with_rigs(again, told, views)
    if found is None or len(own.projections) >= len(found.projections):
        return own
    return _with_rigs(found, told, views)


def _with_rigs(cameras: ReliefCameras, rig: Mapping[str, Array], views: Views) -> ReliefCameras:
    """The same with the cameras that it lacks, as the rig has them: moved by those of both that many places tie."""
    names = Rig.of(cameras).sure() | {views.reference}
    sure = {name: p for name, p in cameras.projections.items() if name in names}
    moved = moved_rig(rig, sure, cameras.points, views.reference, views.sizes)
    more = {} if moved is None else {name: p for name, p in moved.items() if name not in cameras.projections}
    matches = {**cameras.matches, **dict.fromkeys(more, 0)}
    return attrs.evolve(cameras, projections={**cameras.projections, **more}, matches=matches)


def _laid_by(cameras: ReliefCameras, views: Views) -> dict[str, Array]:
    """Camera -> (H * W, 2): where it sees what the relief has at every pixel of the reduced reference picture."""
    return _laid_on(gamma_map(_in_views(cameras.points, views), views.size), cameras.projections, views)


def _laid_on(gamma: NDArray[np.float32], projections: Mapping[str, Array], views: Views) -> dict[str, Array]:
    """The same of any surface over the reduced reference picture."""
    to_views = scaling(views.sizes[views.reference], views.size)
    scene = np.column_stack(
        [transform_points(inverse(to_views), pixels_of(views.size)), gamma.ravel().astype(np.float64)]
    )
    return {name: project(p, scene) for name, p in projections.items()}


@frozen(eq=False)
class _Matches:
    """steady: of steady views, if they cover enough. all: with those of single samples, hands and heads among them."""

    steady: Pairs
    all: Pairs


def _matched(views: Views, laid: Mapping[str, Array], settings: DenseSettings) -> _Matches:
    """Matches of steady views, and of single samples where steady ones are few of a camera or in the middle."""
    width, height = views.size
    maps: dict[str, NDArray[np.float32]] = {
        n: at.reshape(height, width, 2).astype(np.float32) for n, at in laid.items()
    }
    everywhere = np.ones((height, width), bool)
    steady = {
        name: AlignedCamera([view.picture], to_camera, views.sizes[name], [view.steady])
        for name, to_camera in maps.items()
        if (view := views.steady[name]) is not None
    }
    pairs = match_densely(steady, everywhere, settings)
    counted = tracks_of(pairs, list(laid)).counted()
    enough = _aim_covered(pairs, views) >= _LEAST_COVERED
    few = {name for name, count in counted.items() if count < _PLENTY or not enough} - {views.reference}
    if not few:
        return _Matches(pairs, pairs)
    at = np.unique(np.linspace(0, len(views.samples) - 1, _SAMPLES).round().astype(int))
    single = {
        name: AlignedCamera([views.samples[i].get(name) for i in at], to_camera, views.sizes[name])
        for name, to_camera in maps.items()
    }
    more = match_densely(single, everywhere, settings, few)
    joined = {pair: _joined(pairs[pair], own) if pair in pairs else own for pair, own in more.items()}
    found = {**pairs, **joined}
    return _Matches(pairs if enough else found, found)


def _aim_covered(pairs: Pairs, views: Views) -> float:
    """The share of the picture's middle that matches with the reference lie in, 0..1."""
    width, height = views.size
    x, y = np.meshgrid(np.arange(width) - width / 2, np.arange(height) - height / 2)
    aim = np.exp(-((np.hypot(x, y) / (_AIM * width)) ** 2))
    there = np.zeros((height, width), np.uint8)
    to_views = scaling(views.sizes[views.reference], views.size)
    for (a, _), matches in pairs.items():
        if a == views.reference:
            column, row = np.round(transform_points(to_views, matches.a)).astype(int).T
            there[row, column] = 1
    reach = 2 * BY_PLANE.grid_px + 1
    covered = cv2.dilate(there, np.ones((reach, reach), np.uint8))  # pyright: ignore[reportArgumentType]
    return float((covered * aim).sum() / aim.sum())


def _joined(first: Correspondences, second: Correspondences) -> Correspondences:
    """All of the first, and of the second what lies where the first has nothing."""
    taken = {tuple(p) for p in first.a.round(1)}
    new = second.where(np.array([tuple(p) not in taken for p in second.a.round(1)], bool))
    parts = [np.concatenate([getattr(m, f.name) for m in (first, new)]) for f in attrs.fields(Correspondences)]
    return Correspondences(*parts)


def _solved(
    found: _Matches, names: Sequence[str], views: Views, start: Mapping[str, Array], least: float = _RIGHT
) -> ReliefCameras | None:
    """Solves the cameras; those with too few matches, or that the others do not confirm, are dropped one by one."""
    names = list(names)
    while True:
        tracks: Tracks = tracks_of(found.all, names)
        counted = tracks.counted()
        poorest = min(names, key=counted.__getitem__)
        if counted[poorest] >= _LEAST:
            projections = solve_cameras(tracks, start, views.sizes)
            right = confirmed(tracks, projections, views.sizes) if len(names) > 2 else {}
            wrong = [n for n, (judged, share) in right.items() if judged < _JUDGED or share < least]
            if not wrong:
                break
            if len(names) == 3:  # of two cameras that are left nobody could say which is right
                return None
            poorest = min(wrong, key=lambda name: right[name][1])
        if poorest == views.reference or len(names) <= 2:
            return None
        names.remove(poorest)
    steady = {pair: matches for pair, matches in found.steady.items() if set(names).issuperset(pair)}
    # Points that the reference does not see are seen by two cameras, as a rule: no third confirms where they lie.
    own = {pair: matches for pair, matches in steady.items() if pair[0] == names[0]}
    located = locate(tracks_of(own, names), projections, views.sizes)
    if len(located.points) < _LEAST:
        return None
    # 1 at least: 0 marks a camera that another pose's rig has placed.
    return attrs.evolve(located, matches={n: max(1, k) for n, k in tracks_of(steady, names).counted().items()})


def field_pairs(cameras: ReliefCameras, field: Mask, views: Views) -> Pairs:
    """Where every camera sees a grid of points all over the field, for the plane that serves it best.

    Parameters
    ----------
    cameras : ReliefCameras
        With their points.
    field : (h, w) bool array
        Where the field lies in the reference camera's picture, of any size.
    views : Views
        What they were found by.

    Returns
    -------
    mapping of (str, str) to Correspondences
        Each camera's with the reference. Outside of the field there are few points, and they weigh next to nothing:
        they say that the pair is tied, not how.

    Notes
    -----
    The relief knows where a camera sees what a hand hides from it, and evens out what single matches lack. With the
    true field given, planes were 1.00 to 1.06 times the best one's error, by the matches themselves 1.05 to 1.2.
    """
    to_views = scaling(views.sizes[views.reference], views.size)
    mask = resize_mask(field, views.size)
    gamma = _field_surface(cameras, mask, views)
    every = max(1, int(np.sqrt(mask.sum() / FIELD_POINTS)))
    inside, around = np.zeros_like(mask), np.zeros_like(mask)
    inside[::every, ::every], around[::_AROUND_PX, ::_AROUND_PX] = True, True
    at = np.argwhere((inside & mask) | (around & ~mask))
    points = transform_points(inverse(to_views), at[:, ::-1].astype(np.float64))
    scene = np.column_stack([points, gamma[at[:, 0], at[:, 1]].astype(np.float64)])
    weight = np.where(mask[at[:, 0], at[:, 1]], 1.0, _AROUND_WEIGHT)
    seen = np.ones(len(points), np.int64)
    pairs = {}
    for name, projection in cameras.projections.items():
        if name != views.reference:
            pairs[views.reference, name] = Correspondences(points, project(projection, scene), weight, seen)
    return pairs


def _field_surface(cameras: ReliefCameras, mask: Mask, views: Views) -> NDArray[np.float32]:
    """Gamma at every pixel of the reduced reference picture, for the field; matched anew as a first surface lays it."""
    to_views = scaling(views.sizes[views.reference], views.size)
    rows, columns = np.nonzero(mask)
    middle = transform_points(inverse(to_views), np.array([[columns.mean(), rows.mean()]]))[0]
    height = height_of_gamma(cameras.projections, views.sizes, middle)
    gamma = field_gamma(_in_views(cameras.points, views), mask, height)
    again = _in_views(_seen_again(cameras, gamma, mask, views), views)
    return field_gamma(again, mask, height) if len(again) >= _LEAST else gamma


def _seen_again(cameras: ReliefCameras, gamma: NDArray[np.float32], mask: Mask, views: Views) -> Array:
    """(N, 3) points of the field that cameras agree on, matched as a surface lays their views.

    In the shadow of arms a place is not steady, yet what it shows most of the time is the field: that counts where
    three cameras agree.
    """
    width, height = views.size
    area = cv2.dilate(mask.astype(np.uint8), np.ones((9, 9), np.uint8)) > 0
    laid = {
        n: at.reshape(height, width, 2).astype(np.float32)
        for n, at in _laid_on(gamma, cameras.projections, views).items()
    }
    found = [_agreed(laid, cameras, area, views, views.reference, steady) for steady in (True, False)]
    asked = area[:: _CLOSELY.grid_px, :: _CLOSELY.grid_px].sum()
    others = [name for name in laid if name != views.reference]
    if sum(map(len, found)) < _FEW_SEEN * asked:  # a head before the reference: what three others see
        found += [_agreed(laid, cameras, area, views, name, False) for name in others]
    if sum(map(len, found)) < _FEW_SEEN * asked:  # and before more: what two have in common that stays
        found += [_agreed(laid, cameras, area, views, name, True) for name in others]
    return np.concatenate(found)


def _agreed(
    laid: Mapping[str, NDArray[np.float32]],
    cameras: ReliefCameras,
    area: Mask,
    views: Views,
    anchor: str,
    steady: bool,
) -> Array:
    """(N, 3) points of an area that a camera has in common with another in what is steady, else with two others."""
    names = [anchor, *(name for name in laid if name != anchor)]
    shown = {
        name: AlignedCamera([view.picture], laid[name], views.sizes[name], [view.steady] if steady else None)
        for name in names
        if (view := views.steady[name]) is not None
    }
    pairs = match_densely(shown, area, _CLOSELY, {anchor})
    return locate(tracks_of(pairs, names), cameras.projections, views.sizes, 2 if steady else 3).points


def _in_views(points: Array, views: Views) -> Array:
    """Points of the full-size reference picture in pixels of the reduced one, gamma as it is."""
    to_views = scaling(views.sizes[views.reference], views.size)
    return np.column_stack([transform_points(to_views, points[:, :2]), points[:, 2]])
