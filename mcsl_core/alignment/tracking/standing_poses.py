"""The poses of a perspective in arrays, the rig calibrated from them, and what their cameras show about a movement."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import closing

import attrs
import cv2
import numpy as np
from attrs import frozen

from mcsl_core.edl import Movement
from mcsl_core.imaging.geometry import Array, Homography, inverse, project
from mcsl_core.imaging.relief import between_nodes
from mcsl_core.recording.decoder import Decoder, exact_programme_time
from mcsl_core.recording.footage import Footage
from mcsl_core.recording.sample_store import SampleStore

from ..observations import SolvedPose
from ..relief.field_surface import height_of_gamma
from ..relief.surface_planes import field_points, sure_nodes
from ..steady import steady_view
from .calibration import Rig, calibrate
from .lamp import AT_REST, Lamp, LampView
from .protocol import End, Instant
from .templates import WIDTH, Grey, Ground, templates

_RATE = 12.0  # instants a second: the lamp's speed changes by 500 px/s^2 of 960 at most, a third of a pixel between two
_MOST = 400  # instants of a movement
_SAMPLES = 12  # of a pose, the nearest to the movement, that its background is made from
_KNOWN = 0.1  # confidence of nodes that cameras are calibrated by
_LEAST_POINTS = 8
_COLUMNS, _ROWS = 12, 8  # of points over the programme's picture


@frozen(eq=False)
class StandingPose:
    """A pose with a relief, in arrays.

    Attributes
    ----------
    pose : SolvedPose
        The pose itself.
    gamma, confidence : (rows, columns) array
        Of its relief at nodes over the programme's picture; confidence 0..1.
    projections : mapping of str to (3, 4) array
        Camera -> programme pixel and gamma to its pixel.
    planes : mapping of str to (3, 3) array
        Camera -> programme pixel to its pixel, by the pose's plane.
    points : (N, 3) array
        Scene points that are known, spread over the programme's picture.
    view : LampView
        Where the lamp stands.
    refused : tuple of str
        Cameras that the pose's own relief has elsewhere than the rig that explains all others; ``projections`` has
        them as the lamp holds them.
    """

    pose: SolvedPose
    gamma: Array
    confidence: Array
    projections: Mapping[str, Array]
    planes: Mapping[str, Homography]
    points: Array
    view: LampView
    refused: tuple[str, ...] = ()

    @classmethod
    def of(cls, pose: SolvedPose) -> StandingPose | None:
        """None where the pose has no relief, or one that says too little, or nothing of the reference camera."""
        relief = pose.pose.relief
        if relief is None:
            return None
        size = pose.aligned.camera_sizes[pose.aligned.reference]
        gamma, confidence = np.array(relief.gamma), np.array(relief.confidence) / 100
        x, y = np.meshgrid(np.linspace(0, size[0] - 1, _COLUMNS), np.linspace(0, size[1] - 1, _ROWS))
        at = np.column_stack([x.ravel(), y.ravel()])
        heights, sure = between_nodes(np.stack([gamma, confidence], axis=-1), size, at).T
        points = np.column_stack([at, heights])[sure > _KNOWN]
        anchor = np.array(pose.pose.anchor)
        planes = {name: inverse(anchor @ np.array(h)) for name, h in pose.pose.homographies.items()}
        projections = {name: np.array(p) for name, p in relief.projections.items() if name in planes}
        if len(points) < _LEAST_POINTS or len(projections) < 2 or pose.aligned.reference not in projections:
            return None
        return cls(pose, gamma, confidence, projections, planes, points, AT_REST)

    def field_points(self) -> Array:
        """(N, 3): scene points of the surface all over the pose's field; see `field_points`."""
        aligned = self.pose.aligned
        reference, size = aligned.reference, aligned.camera_sizes[aligned.reference]
        names = [reference, *(name for name in self.projections if name != reference)]
        ordered = {name: self.projections[name] for name in names}
        height = height_of_gamma(ordered, aligned.camera_sizes, np.array(size) / 2)
        nodes = sure_nodes(self.gamma, self.confidence, size)
        return field_points(nodes, self.pose.field_in_programme(), size, height)

    def end(self, lamp: Lamp, samples: SampleStore, movements: Sequence[Movement], movement: Movement) -> End:
        """The pose as an end of a movement, with its background about then."""
        near = samples.standing(self.pose.pose.range, movements) or list(self.pose.samples)
        near = sorted(near, key=lambda i: abs(samples.frames[i] - movement.range.start))[:_SAMPLES]
        ground = Ground.of(self.pose.aligned.camera_sizes[self.pose.aligned.reference], self.gamma)
        shown = {name: steady_view([samples.picture(i, name) for i in sorted(near)]) for name in self.projections}
        views = {name: view for name, view in shown.items() if view is not None}
        bends = {
            name: _homography(project(lamp.projection(name, self.view), self.points), project(p, self.points))
            for name, p in self.projections.items()
        }
        return End(self.view, ground, templates(ground, views, self.projections, lamp.sizes), bends)


def _homography(a: Array, b: Array) -> Homography:
    found, _ = cv2.findHomography(a, b, 0)
    return np.eye(3) if found is None else np.asarray(found, np.float64)  # pyright: ignore[reportUnnecessaryComparison]


def calibrated(
    solved: Sequence[SolvedPose], perspective: int, reference: str, footage: Footage
) -> tuple[Lamp, dict[int, StandingPose]] | None:
    """The rig, and where it stands in a perspective's poses.

    Parameters
    ----------
    solved : sequence of SolvedPose
        Every pose of the recording.
    perspective : int
        Which poses count.
    reference : str
        The reference camera.
    footage : Footage
        Whose cameras they are.

    Returns
    -------
    (Lamp, dict of int to StandingPose) or None
        By the poses' positions in ``solved``, of those that have a relief; without those that see least where no rigid
        rig explains all of them. None where it explains none.
    """
    of_perspective = {i: pose for i, pose in enumerate(solved) if pose.pose.perspective == perspective}
    found = {i: own for i, pose in of_perspective.items() if (own := StandingPose.of(pose)) is not None}
    sizes = {camera.name: camera.size for camera in footage.cameras}
    while found:
        poses = list(found.values())
        rig = calibrate([pose.projections for pose in poses], poses[0].points, reference, sizes)
        if rig is not None:
            return rig.lamp, {i: _standing(pose, rig, n) for n, (i, pose) in enumerate(found.items())}
        del found[min(found, key=lambda i: (len(found[i].projections), found[i].confidence.mean()))]
    return None


def _standing(pose: StandingPose, rig: Rig, at: int) -> StandingPose:
    """The pose, ``at`` the rig's, where the lamp stands in it, with what is refused of it."""
    view, refused = rig.views[at], tuple(name for i, name in rig.refused if i == at)
    held = {name: rig.lamp.projection(name, view) for name in refused}
    return attrs.evolve(pose, view=view, refused=refused, projections={**pose.projections, **held})


def instants_between(footage: Footage, first: int, last: int) -> list[Instant]:
    """What the cameras show from one programme frame to another, both among them, some twelve times a second."""
    step = max(1, round(float(footage.rate) / _RATE), -(-(last - first) // _MOST))
    frames = [*range(first, last, step), last]
    pictures: list[dict[str, Grey]] = [{} for _ in frames]
    late: list[dict[str, float]] = [{} for _ in frames]
    for camera in footage.cameras:
        height = max(1, round(WIDTH * camera.size[1] / camera.size[0]))
        with closing(Decoder(footage.parts(camera.name), threads=0)) as decoder:
            for i, frame in enumerate(frames):
                shown = footage.shown(camera.name, decoder, frame)
                if shown is None:
                    continue
                picture = footage.picture(camera.name, shown, height)
                pictures[i][camera.name] = np.asarray(cv2.cvtColor(picture, cv2.COLOR_BGR2GRAY), np.uint8)
                late[i][camera.name] = frame - float(exact_programme_time(camera, shown.camera_s) * footage.rate)
    return [Instant(f, p, t) for f, p, t in zip(frames, pictures, late, strict=True)]
