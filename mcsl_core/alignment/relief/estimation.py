"""A pose's relief: its scene laid over programme pixels, the surface that its cameras see, hands taken off that.

Poses of one perspective share its relief: a later pose is tied to the scene that the one before it found, and its own
views are estimated together with that one's. So the perspective survives a movement as exactly as a camera is aligned
within a pose, and a hand that rests in one pose is outvoted by the other.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from attrs import evolve

from mcsl_core.imaging.geometry import Array, inverse, project, scaling, transform_points
from mcsl_core.imaging.masks import Mask, central_ellipse, mask_at, warp_mask
from mcsl_core.imaging.relief import node_pixels
from mcsl_core.parallel import by_threads

from ..steady import steady_view
from .cameras import ReliefCameras
from .field_surface import height_of_gamma, knows_up
from .foreign import ForeignColours, foreign_colours
from .matching import Views
from .pose_relief import PoseRelief
from .protocol import ReliefCamera, ReliefEstimator, ReliefScene, ReliefView
from .resting_hands import foreign_share, without_resting_hands
from .tying import tie_scene

_GROUPS = 3  # of moments: a hand that rests in one of them is outvoted
_ABOUT = 0.15  # widths about the picture's middle, where the cameras aim: there gamma 0 is laid through the scene
_BEFORE = " before"  # appended to the names of the cameras of the pose before


def estimate_relief(
    estimator: ReliefEstimator,
    cameras: ReliefCameras,
    views: Views,
    to_programme: Mapping[str, Array],
    before: PoseRelief | None,
    field: Mask | None = None,
) -> PoseRelief | None:
    """Has an estimator find the surface of a pose, and takes hands that rest off it.

    Parameters
    ----------
    estimator : ReliefEstimator
        What finds it.
    cameras : ReliefCameras
        How the cameras see the pose's scene, over pixels of its reference camera.
    views : Views
        What they show; all samples together and in groups of successive ones.
    to_programme : mapping of str to (3, 3) array
        Camera -> its plane, full-size camera pixel -> programme pixel, whose size is the reference camera's.
    before : PoseRelief, optional
        Of the pose that began the perspective.
    field : (h, w) bool array, optional
        Where the surgical field lies in the reference camera's picture, of any size: its colours are no hand's. The
        middle without.

    Returns
    -------
    PoseRelief or None
        None where the plane is to stay.
    """
    size = views.sizes[views.reference]
    field = central_ellipse(views.size) if field is None else field
    foreign = _foreign(views, to_programme, field)
    own = _scene(cameras, views, to_programme, foreign)
    if len(own.cameras) < 2:
        return None
    lifted = np.eye(4)  # programme pixel and gamma -> the pose's own, by the plane alone
    lifted[:3, :3] = to_programme[views.reference]
    known = None if before is None else tie_scene(before.scene, before.seen, own, inverse(lifted))
    if before is None or known is None:
        placed = together = _based(_moved(own, inverse(lifted)))
        coloured = foreign
    else:
        placed = _moved(own, known)
        earlier = {name + _BEFORE: camera for name, camera in before.scene.cameras.items()}
        points = np.concatenate([before.scene.points, placed.points])
        together = ReliefScene(size, {**placed.cameras, **earlier}, points, before.seen)
        coloured = {**foreign, **{name + _BEFORE: own for name, own in before.foreign.items()}}
    surface = estimator.estimate(together)
    if surface is None or not placed.cameras.keys() & surface.cameras:
        return None
    height, sure = _height(placed if before is None or known is None else before.scene)
    lifted_off, hands = surface, np.zeros(surface.gamma.shape, bool)
    if sure:
        share = foreign_share(surface, size, together.cameras, coloured)
        nodes = _at_nodes(field, surface.gamma.shape, to_programme[views.reference], size)
        lifted_off, hands = without_resting_hands(surface, share, height, nodes)
    served = evolve(lifted_off, cameras=surface.cameras & placed.cameras.keys())
    return PoseRelief(placed, served, foreign, hands, surface.gamma, height)


def _height(scene: ReliefScene) -> tuple[float, bool]:
    """See `height_of_gamma`, in the middle of a scene; and whether the cameras know which way is up."""
    projections = {name: camera.projection for name, camera in scene.cameras.items()}
    sizes = {name: camera.size for name, camera in scene.cameras.items()}
    return height_of_gamma(projections, sizes, np.array(scene.size) / 2), knows_up(projections, sizes)


def _at_nodes(field: Mask, shape: tuple[int, ...], to_programme: Array, size: tuple[int, int]) -> Mask:
    """(rows, columns): the field in the reference camera's picture at the nodes of a surface over the programme's."""
    from_programme = scaling(size, field.shape[::-1]) @ inverse(to_programme)
    return mask_at(field, transform_points(from_programme, node_pixels(shape, size))).reshape(shape)


def _scene(
    cameras: ReliefCameras, views: Views, to_programme: Mapping[str, Array], foreign: Mapping[str, ForeignColours]
) -> ReliefScene:
    """The pose's scene over pixels of its reference camera, its planes over programme pixels."""
    count = len(views.samples)
    groups = [slice(g * count // _GROUPS, (g + 1) * count // _GROUPS) for g in range(_GROUPS)]

    def seen_by(name: str) -> ReliefCamera:
        shown = [sample.get(name) for sample in views.samples]
        found = [views.steady.get(name), *(steady_view(shown[group]) for group in groups)]
        own = ~foreign[name].sure if name in foreign else True
        pictures = tuple(ReliefView(view.picture, view.steady & own) for view in found if view is not None)
        return ReliefCamera(views.sizes[name], cameras.projections[name], inverse(to_programme[name]), pictures)

    names = [name for name in cameras.projections if name in to_programme]
    made = dict(zip(names, by_threads(seen_by, names), strict=True))
    return ReliefScene(views.sizes[views.reference], made, cameras.points)


def _foreign(views: Views, to_programme: Mapping[str, Array], field: Mask) -> dict[str, ForeignColours]:
    """Camera -> where hands and sleeves rest in its steady picture; see `foreign_colours`."""
    steady = {name: view for name, view in views.steady.items() if view is not None and name in to_programme}
    from_field = to_programme[views.reference] @ scaling(field.shape[::-1], views.sizes[views.reference])
    fields = {}
    for name, view in steady.items():
        size = (view.picture.shape[1], view.picture.shape[0])
        warp = scaling(views.sizes[name], size) @ inverse(to_programme[name]) @ from_field
        fields[name] = warp_mask(field, warp, size)
    return foreign_colours(views.samples, steady, fields)


def _moved(scene: ReliefScene, to_own: Array) -> ReliefScene:
    """A scene over other pixels, ``to_own`` (4, 4) leading from those and gamma to its own; planes as they are."""
    cameras = {}
    for name, camera in scene.cameras.items():
        projection = camera.projection @ to_own
        cameras[name] = evolve(camera, projection=projection / projection[2, 2])
    points = np.insert(scene.points, 2, 1.0, axis=1) @ inverse(to_own).T
    return ReliefScene(scene.size, cameras, points[:, [0, 1, 3]] / points[:, 2:3])


def _based(scene: ReliefScene) -> ReliefScene:
    """The same with gamma 0 on the plane through the scene's middle, and 1 where it moves some camera by a pixel.

    Projections are known but for a plane and a scale: P [x, 1, gamma] = P' [x, 1, (gamma - m [x, 1]) s].
    """
    middle = np.array([scene.size[0] / 2, scene.size[1] / 2])
    near = np.exp(-((np.hypot(*(scene.points[:, :2] - middle).T) / (_ABOUT * scene.size[0])) ** 2)) + 1e-6
    pixels = np.column_stack([scene.points[:, :2], np.ones(len(scene.points))])
    weight, plane = near, np.zeros(3)
    for _ in range(10):
        root = np.sqrt(weight)
        plane = np.linalg.lstsq(pixels * root[:, None], scene.points[:, 2] * root, rcond=None)[0]
        left = scene.points[:, 2] - pixels @ plane
        weight = near / (1 + (left / (3 * np.median(np.abs(left)) + 1e-12)) ** 2)
    to_own = np.eye(4)
    to_own[3, :3] = plane
    based = _moved(scene, to_own)
    low, high = np.append(middle, 0.0)[None], np.append(middle, 1e-3)[None]
    moves = [np.hypot(*(project(c.projection, high) - project(c.projection, low))[0]) for c in based.cameras.values()]
    return _moved(based, np.diag([1, 1, 1, 1e-3 / float(max(moves))]))
