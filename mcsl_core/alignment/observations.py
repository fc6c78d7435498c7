"""What a pose is solved from: every camera's points in some samples, and which of them are the same.

Full-size pixels unless a name says otherwise.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Protocol

import numpy as np
from attrs import evolve, frozen
from numpy.typing import NDArray

from mcsl_core.edl import Pose
from mcsl_core.edl.field import HAND, PICTURES
from mcsl_core.imaging.geometry import Array, scaling
from mcsl_core.imaging.masks import Mask, central_ellipse, warp_mask
from mcsl_core.parallel import by_threads
from mcsl_core.recording.sample_store import Sample
from mcsl_core.timing import FrameRange

from .aligned_views import AlignedPose, Picture
from .correspondences import Correspondences, pool
from .field import field_of_camera
from .protocol import Features, Matcher
from .relief.cameras import ReliefCameras
from .relief.matching import Views
from .relief.pose_relief import PoseRelief
from .relief.rig import Rig
from .settings import SolveSettings

NOTHING = Features(np.zeros((0, 2), np.float32), np.zeros((0, 1), np.float32), (1, 1))


class Samples(Protocol):
    """What a pose is solved from: a recording's `SampleStore`, or still pictures as its only sample."""

    @property
    def frames(self) -> Sequence[int]: ...

    @property
    def cameras(self) -> Sequence[str]: ...

    def picture(self, position: int, camera: str) -> Picture | None:
        """The (h, w, 3) BGR picture of a camera in the sample at a position, None where there is none."""
        ...

    def __getitem__(self, position: int, /) -> Sample: ...


@frozen(eq=False)
class Observations:
    """What one camera shows in one pose.

    Attributes
    ----------
    features : tuple of Features
        Its distinctive points in each sample solved from; `NOTHING` where it has no picture.
    field : (h, w) bool array
        Where its own reduced picture has the field's hue most of the time.
    """

    features: tuple[Features, ...]
    field: Mask


@frozen(eq=False)
class SeenScene:
    """How a pose's cameras see its relief, over pixels of its reference camera, and what they show.

    Attributes
    ----------
    cameras : ReliefCameras
    views : Views
    """

    cameras: ReliefCameras
    views: Views


@frozen(eq=False)
class SolvedPose:
    """A pose that is solved.

    Attributes
    ----------
    pose : Pose
        For the EDL.
    aligned : AlignedPose
        For the detectors.
    samples : tuple of int
        Positions of samples spread over the pose, which later poses are anchored by.
    observations : mapping of str to Observations
        Camera -> its points, of some samples only, which later poses are anchored by; none where no later one can be.
    field_by : str
        What ``aligned.field`` rests on: PICTURES, or MIDDLE where they show none.
    drawn : tuple of (FrameRange, (H, W) bool array)
        In order: the field drawn by hand, which over its range holds in place of ``aligned.field``.
    scene : SeenScene, optional
        How its cameras see the relief.
    rig : Rig, optional
        How they lie, which other poses go by where a camera shows them little.
    relief : PoseRelief, optional
        Over programme pixels, once it is anchored.
    """

    pose: Pose
    aligned: AlignedPose
    samples: tuple[int, ...]
    observations: Mapping[str, Observations]
    field_by: str = PICTURES
    drawn: tuple[tuple[FrameRange, Mask], ...] = ()
    scene: SeenScene | None = None
    rig: Rig | None = None
    relief: PoseRelief | None = None

    def seeing(self, cameras: ReliefCameras, views: Views) -> SolvedPose:
        """The pose, with how its cameras see the relief, and what they show."""
        return evolve(self, scene=SeenScene(cameras, views), rig=Rig.of(cameras))

    def field_in_programme(self) -> Mask:
        """(H, W), of the aligned size: the surgical field in the programme's picture, by the pose's anchor."""
        size, full = self.aligned.size, self.aligned.camera_sizes[self.aligned.reference]
        warp = scaling(full, size) @ np.array(self.pose.anchor) @ scaling(size, full)
        return warp_mask(self.aligned.field, warp, size)

    def fields(self) -> list[tuple[FrameRange, Mask, str]]:
        """Where the field lies when: ranges that tile the pose's, with what each rests on."""
        at, stop = self.pose.range.start, self.pose.range.stop
        found: list[tuple[FrameRange, Mask, str]] = []
        for piece, mask in self.drawn:
            if at < piece.start:
                found.append((FrameRange(at, piece.start), self.aligned.field, self.field_by))
            found.append((piece, mask, HAND))
            at = piece.stop
        return found if at == stop else [*found, (FrameRange(at, stop), self.aligned.field, self.field_by)]


def spread(positions: Sequence[int], wanted: int) -> list[int]:
    """Chooses evenly.

    Parameters
    ----------
    positions : sequence of int
        To choose from.
    wanted : int
        How many at most.

    Returns
    -------
    list of int
        In the same order, the first and the last among them.
    """
    chosen = np.linspace(0, len(positions) - 1, min(wanted, len(positions))).round().astype(int)
    return [positions[i] for i in np.unique(chosen)]


def observe(
    for_points: Sequence[int], for_field: Sequence[int], samples: Samples, matcher: Matcher
) -> dict[str, Observations]:
    """Finds every camera's points and its own field.

    Parameters
    ----------
    for_points : sequence of int
        Positions of the samples to find points in.
    for_field : sequence of int
        Positions of the samples to find the field by.
    samples : Samples
        What is read.
    matcher : Matcher
        What finds points.

    Returns
    -------
    dict of str to Observations
        In the order of the cameras, without those that have no picture in ``for_field``.

    Notes
    -----
    The samples' own reduced pictures serve: points in pictures of twice their rows cost three times as much and, once
    the field is matched densely, locate it no better. SIFT lets go of the interpreter: cameras share cores.
    """

    def observed(camera: str) -> Observations | None:
        many = [samples.picture(position, camera) for position in for_field]
        own = [picture for picture in many if picture is not None]
        if not own:
            return None
        pictures = [samples.picture(position, camera) for position in for_points]
        features = tuple(NOTHING if picture is None else matcher.features(picture) for picture in pictures)
        return Observations(features, field_of_camera(own))

    found = by_threads(observed, samples.cameras)
    return {name: own for name, own in zip(samples.cameras, found, strict=True) if own is not None}


def match_cameras(
    a: Observations,
    b: Observations,
    size_a: tuple[int, int],
    size_b: tuple[int, int],
    matcher: Matcher,
    settings: SolveSettings,
    *,
    every: bool = False,
) -> Correspondences:
    """Matches the points of two cameras.

    Parameters
    ----------
    a, b : Observations
        Of two cameras in the same samples, or (``every``) of one camera in two poses.
    size_a, size_b : (int, int)
        Full width and height of each.
    matcher : Matcher
        What matches.
    settings : SolveSettings
        ``alignment.min_support`` says how many matches are enough to be choosy.
    every : bool, optional
        Match each sample of one with each of the other, in place of sample by sample.

    Returns
    -------
    Correspondences
        Pooled, of weight 1. What matches in one sample only is a hand, or chance: it is left out where four samples or
        more are matched and enough is left.
    """
    if every:
        samples = [(own, other) for own in a.features for other in b.features]
    else:
        samples = list(zip(a.features, b.features, strict=True))
    matches = []
    for own, other in samples:
        pairs = matcher.match(own, other)
        points_a = _full_size(own.points[pairs[:, 0]], own.size, size_a)
        points_b = _full_size(other.points[pairs[:, 1]], other.size, size_b)
        matches.append((points_a, points_b, np.ones(len(pairs))))
    pooled = pool(matches)
    if len(samples) >= 4 and len(pooled):
        lasting = pooled.seen >= 2
        if lasting.sum() >= 2 * settings.alignment.min_support:
            pooled = pooled.where(lasting)
    return pooled


def weight_matches(
    pair: Correspondences,
    size_a: tuple[int, int],
    size_b: tuple[int, int],
    field_a: Mask,
    field_b: Mask,
    settings: SolveSettings,
) -> Correspondences:
    """Weighs matches by how much of them lies in the field, and by how long they last.

    Parameters
    ----------
    pair : Correspondences
        Of two cameras.
    size_a, size_b : (int, int)
        Full width and height of each.
    field_a, field_b : (h, w) bool array
        The field in the reduced picture of each; the middle of the picture where it is empty.
    settings : SolveSettings
        ``drape_weight`` is what a match in neither field counts.

    Returns
    -------
    Correspondences
        1 inside in both, times the samples it was found in up to 8 (what lasts is the patient; what matches in few may
        be a hand above the field's plane), divided by the crowd around it.
    """
    inside = _in_field(pair.a, size_a, field_a).astype(float) + _in_field(pair.b, size_b, field_b)
    weight = settings.drape_weight + (1 - settings.drape_weight) * inside / 2
    lasting = np.minimum(pair.seen, 8)
    return _evened(Correspondences(pair.a, pair.b, weight * lasting, pair.seen), size_a)


def _full_size(points: NDArray, reduced: tuple[int, int], size: tuple[int, int]) -> Array:
    grow = scaling(reduced, size)
    return points.astype(np.float64) @ grow[:2, :2].T + grow[:2, 2]


def _in_field(points: Array, size: tuple[int, int], mask: Mask) -> NDArray[np.bool_]:
    """Whether full-size points lie in the field's mask, which is of any reduced size."""
    height, width = mask.shape
    if not mask.any():
        mask = central_ellipse((width, height))
    shrink = scaling(size, (width, height))
    at = np.round(points @ shrink[:2, :2].T + shrink[:2, 2]).astype(int)
    at = np.clip(at, 0, [width - 1, height - 1])
    return mask[at[:, 1], at[:, 0]]


def _evened(pair: Correspondences, size: tuple[int, int]) -> Correspondences:
    """Weights divided by the crowd around each match, so that a knot of texture does not draw the plane to itself."""
    if not len(pair):
        return pair
    cell_px = size[0] / 24
    cells = np.floor(pair.a / cell_px).astype(np.int64)
    _, inverse, count = np.unique(cells, axis=0, return_inverse=True, return_counts=True)
    crowd = count[inverse.reshape(-1)]
    return Correspondences(pair.a, pair.b, pair.weight / crowd, pair.seen)
