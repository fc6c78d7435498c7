"""What a pose is solved from: every camera's points at some moments, and which of them are the same places.

Full-size pixels unless a name says otherwise.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import Protocol

import cv2
import numpy as np
from attrs import frozen
from numpy.typing import NDArray

from mcsl_core.edl import Pose
from mcsl_core.imaging.geometry import scaling, transform_points
from mcsl_core.imaging.masks import Mask, central_ellipse
from mcsl_core.recording.sample_store import Sample

from .aligned_views import AlignedPose
from .correspondences import Correspondences, pool
from .field import field_from_hue
from .protocol import Features, Matcher
from .settings import SolveSettings

Array = NDArray[np.float64]


NOTHING = Features(np.zeros((0, 2), np.float32), np.zeros((0, 1), np.float32), (1, 1))


class Samples(Protocol):
    """What a pose is solved from: a recording's `SampleStore`, or still pictures as its only moment."""

    @property
    def frames(self) -> Sequence[int]: ...

    @property
    def cameras(self) -> Sequence[str]: ...

    def picture(self, position: int, camera: str) -> NDArray[np.uint8] | None: ...

    def __getitem__(self, position: int, /) -> Sample: ...


@frozen(eq=False)
class Observations:
    """One camera in one pose: its points at the moments solved from, and where its own picture has the field's hue."""

    features: tuple[Features, ...]
    field: Mask


@frozen(eq=False)
class SolvedPose:
    """A pose for the EDL, the scene it makes, and what later poses are anchored by.

    moments: positions of samples spread over the pose. evidence: camera -> its points, of some moments only.
    """

    pose: Pose
    scene: AlignedPose
    moments: tuple[int, ...]
    evidence: Mapping[str, Observations]


def spread(positions: Sequence[int], wanted: int) -> list[int]:
    """At most ``wanted`` of ``positions``, evenly."""
    at = np.linspace(0, len(positions) - 1, min(wanted, len(positions))).round().astype(int)
    return [positions[i] for i in np.unique(at)]


def observe(
    moments: Sequence[int], views: Sequence[int], samples: Samples, matcher: Matcher
) -> dict[str, Observations]:
    """Every camera's points at ``moments``, and its field by ``views``, both positions of samples.

    The samples' own pictures serve: points in pictures of twice their rows cost three times as much and, once
    every spot of the field is compared, place it no better. SIFT lets go of the interpreter: cameras share cores.
    """

    def gathered(camera: str) -> Observations | None:
        small = [p for i in views if (p := samples.picture(i, camera)) is not None]
        if not small:
            return None
        pictures = [samples.picture(i, camera) for i in moments]
        return Observations(
            tuple(NOTHING if p is None else matcher.features(p) for p in pictures), field_from_hue(small)
        )

    evidence: dict[str, Observations] = {}
    with ThreadPoolExecutor(max_workers=2) as workers:
        for name, made in zip(samples.cameras, workers.map(gathered, samples.cameras), strict=True):
            if made is not None:
                evidence[name] = made
    return evidence


def _in_field(points: Array, size: tuple[int, int], mask: Mask) -> NDArray[np.bool_]:
    """Whether full-size points lie in the field's mask, which is of any reduced size."""
    if not mask.any():
        mask = central_ellipse((mask.shape[1], mask.shape[0]))
    shrink = scaling(size, (mask.shape[1], mask.shape[0]))
    at = np.round(points @ shrink[:2, :2].T + shrink[:2, 2]).astype(int)
    at = np.clip(at, 0, [mask.shape[1] - 1, mask.shape[0] - 1])
    return mask[at[:, 1], at[:, 0]]


def _full(points: NDArray, reduced: tuple[int, int], size: tuple[int, int]) -> Array:
    grow = scaling(reduced, size)
    return points.astype(np.float64) @ grow[:2, :2].T + grow[:2, 2]


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
    """Matches of two cameras, moment by moment (or, with ``every``, each moment of one with each of the other)."""
    if every:
        moments = [(fa, fb) for fa in a.features for fb in b.features]
    else:
        moments = list(zip(a.features, b.features, strict=True))
    matches = []
    for fa, fb in moments:
        pairs = matcher.match(fa, fb)
        points_a, points_b = (
            _full(f.points[pairs[:, i]], f.size, size) for i, (f, size) in enumerate(((fa, size_a), (fb, size_b)))
        )
        matches.append((points_a, points_b, np.ones(len(pairs))))
    pooled = pool(matches)
    if len(moments) >= 4 and len(pooled):
        lasting = pooled.seen >= 2  # what matches in one frame only is a hand, or chance
        if lasting.sum() >= 2 * settings.alignment.min_support:
            pooled = pooled.where(lasting)
    return pooled


def weight_matches(
    pair: Correspondences,
    sizes: Mapping[str, tuple[int, int]],
    a: str,
    b: str,
    fields: Mapping[str, Mask],
    settings: SolveSettings,
) -> Correspondences:
    """Weighs matches by how much of them lies in the field: 1 inside in both views, ``drape_weight`` in neither."""
    inside = _in_field(pair.a, sizes[a], fields[a]).astype(float) + _in_field(pair.b, sizes[b], fields[b])
    weight = settings.drape_weight + (1 - settings.drape_weight) * inside / 2
    # What lasts is the patient; what matches in few moments may be a hand above the field's plane.
    lasting = np.minimum(pair.seen, 8)
    return _evened(Correspondences(pair.a, pair.b, weight * lasting, pair.seen), sizes[a])


def field_in_camera(scene: AlignedPose, camera: str, shape: tuple[int, int]) -> Mask:
    """The hull of the scene's field in a reduced picture (rows, columns) of ``camera``: hands and instruments cut
    holes into the field's colour, but what lies between is the field too."""
    outline = cv2.convexHull(np.argwhere(scene.field)[:, ::-1].astype(np.float32)).reshape(-1, 2)
    back: Array = np.asarray(np.linalg.inv(scene.warp_of(camera, (shape[1], shape[0]))), np.float64)
    mask = np.zeros(shape, np.uint8)
    cv2.fillConvexPoly(mask, np.round(transform_points(back, outline.astype(np.float64))).astype(np.int32), 1)
    return mask > 0


def _evened(pair: Correspondences, size: tuple[int, int]) -> Correspondences:
    """Weights divided by the crowd around each match, so that a knot of texture does not draw the plane to itself."""
    if not len(pair):
        return pair
    cell = size[0] / 24
    cells = np.floor(pair.a / cell).astype(np.int64)
    _, inverse, count = np.unique(cells, axis=0, return_inverse=True, return_counts=True)
    crowd = count[inverse.reshape(-1)]
    return Correspondences(pair.a, pair.b, pair.weight / crowd, pair.seen)
