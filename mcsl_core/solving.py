"""One pose solved: which moments are clear, which points match, how every camera lies to the reference and to the past.

Reads samples and footage; returns values. Full-size pixels unless a name says otherwise.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from itertools import combinations

import cv2
import numpy as np
from attrs import field, frozen
from numpy.typing import NDArray

from . import colour
from .alignment import Alignment, AlignmentSettings, Correspondences, apply, fit_pair, pool
from .edl import IDENTITY, Colour, Matrix, Pose
from .features import Features
from .footage import Footage
from .hookspecs import Aligner, Matcher
from .occlusion import ClearFrames, degree_of_occlusion, field_area, field_from_hue, main_region
from .progress import Progress
from .samples import Samples
from .scene import Mask, Scene, scaling
from .timing import FrameRange

Array = NDArray[np.float64]


@frozen
class SolveSettings:
    """solve_height: rows of the pictures that points are found in. scene_width: columns of a scene.

    drape_weight: how much a match outside the field counts against one inside: the drapes' area is ten times the
    field's and lies centimetres below it. With 0.1 the error over the field was 1.10 to 1.43 times the best plane's on
    a tuning recording, with 0.01 it was 1.05 to 1.29; with none a field without texture would not be tied at all.
    """

    solve_height: int = field(default=720)
    scene_width: int = field(default=480)
    drape_weight: float = field(default=0.01)
    clear: ClearFrames = field(factory=ClearFrames)
    alignment: AlignmentSettings = field(factory=AlignmentSettings)


_NOTHING = Features(np.zeros((0, 2), np.float32), np.zeros((0, 1), np.float32), (1, 1))


@frozen(eq=False)
class Evidence:
    """The clear pictures of one camera in one pose: their points, and where the field lies in the picture."""

    features: tuple[Features, ...]
    field: Mask


@frozen(eq=False)
class SolvedPose:
    """A pose for the EDL, the scene it makes, and the evidence that the next pose is anchored by."""

    pose: Pose
    scene: Scene
    evidence: Mapping[str, Evidence]


def to_matrix(homography: Array) -> Matrix:
    """A 3x3 array as the EDL writes it, scaled so that the last element is 1."""
    h = np.asarray(homography, float) / homography[2, 2]
    rows = [tuple(float(v) for v in row) for row in h]
    return rows[0], rows[1], rows[2]  # pyright: ignore[reportReturnType]


def solve_pose(
    piece: FrameRange,
    standing: Sequence[int],
    samples: Samples,
    footage: Footage,
    *,
    reference: str,
    matcher: Matcher,
    aligner: Aligner,
    previous: SolvedPose | None,
    settings: SolveSettings,
    progress: Progress,
) -> SolvedPose:
    """Solves the pose over ``piece``.

    standing: positions of the samples in which the lamp stands still. previous: the pose before, whose perspective
    is kept where the two can be tied together; else a new perspective begins.
    """
    sizes = {c.name: c.size for c in footage.cameras}
    doo = np.array([_doo(samples, i) for i in standing])
    picked, clear = settings.clear.choose(doo)
    moments = [standing[i] for i in picked]
    frames = [samples.frames[i] for i in moments]
    if not clear:
        progress.note(
            f"frames {piece}: no {settings.clear.run} clear samples in a row (DOO below {settings.clear.threshold}); "
            "the clearest moments were taken instead"
        )
    evidence = _gather(moments, frames, samples, footage, matcher, settings, progress)
    found = {
        (a, b): _correspondences(evidence[a], evidence[b], sizes[a], sizes[b], matcher, settings)
        for a, b in combinations(sorted(evidence), 2)
    }
    # A head may hide the field from one camera at all clear moments. So the cameras are tied twice: first by where
    # each sees the field itself, then by where all together place it.
    fields = {name: seen.field for name, seen in evidence.items()}
    for _ in range(2):
        pairs = {(a, b): _weighted(p, sizes, a, b, fields, settings) for (a, b), p in found.items()}
        alignment = aligner.align(pairs, sizes, reference)
        scene = _scene(alignment, sizes, reference, evidence, settings)
        fields |= {
            name: _field_in(scene, name, fields[name].shape) for name in alignment.homographies if name in fields
        }
    for weak in alignment.weak:
        progress.note(f"frames {piece}: camera {weak.camera} is weak: {weak.reason}")
    anchor, perspective = IDENTITY, 0
    if previous is not None:
        anchor, perspective = _anchored(previous, evidence, fields, alignment, reference, matcher, settings)
        if perspective != previous.pose.perspective:
            progress.note(f"frames {piece}: too little in common with the view before; a new perspective begins")
    pose = Pose(
        range=piece,
        homographies={name: to_matrix(h) for name, h in alignment.homographies.items()},
        anchor=anchor,
        perspective=perspective,
        colour=_colours(scene, [samples[i].pictures for i in moments]),
        solved_from=tuple(frames),
        residual_px={n: round(v, 3) for n, v in alignment.residual_px.items()},
        support=dict(alignment.support),
        weak=alignment.weak,
    )
    return SolvedPose(pose, scene, evidence)


def _doo(samples: Samples, position: int) -> float:
    return degree_of_occlusion([field_area(p) for p in samples[position].pictures.values() if p is not None])


def _gather(
    moments: Sequence[int],
    frames: Sequence[int],
    samples: Samples,
    footage: Footage,
    matcher: Matcher,
    settings: SolveSettings,
    progress: Progress,
) -> dict[str, Evidence]:
    """Every camera's points at the clear frames; SIFT lets go of the interpreter, so cameras share the cores."""
    progress.stage("Finding points", len(footage.cameras), "cameras")

    def gathered(camera: str) -> Evidence | None:
        small = [p for i in moments if (p := samples[i].pictures[camera]) is not None]
        if not small:
            return None
        pictures = footage.pictures(camera, frames, height=settings.solve_height)
        return Evidence(
            tuple(_NOTHING if picture is None else matcher.features(picture) for _, picture in pictures),
            field_from_hue(small),
        )

    evidence: dict[str, Evidence] = {}
    with ThreadPoolExecutor(max_workers=2) as workers:
        names = [c.name for c in footage.cameras]
        for done, (name, made) in enumerate(zip(names, workers.map(gathered, names), strict=True)):
            if made is not None:
                evidence[name] = made
            progress.advance(done + 1)
    return evidence


def _near_middle(points: Array, size: tuple[int, int]) -> NDArray[np.bool_]:
    """Whether points lie in the middle of the picture, where the lamp is aimed: for a field that no colour shows."""
    centred = (points - np.array(size) / 2) / (0.3 * np.array(size))
    return (centred**2).sum(axis=1) < 1


def _in_field(points: Array, size: tuple[int, int], mask: Mask) -> NDArray[np.bool_]:
    """Whether full-size points lie in the field's mask, which is of any reduced size."""
    if not mask.any():
        return _near_middle(points, size)
    shrink = scaling(size, (mask.shape[1], mask.shape[0]))
    at = np.round(points @ shrink[:2, :2].T + shrink[:2, 2]).astype(int)
    at = np.clip(at, 0, [mask.shape[1] - 1, mask.shape[0] - 1])
    return mask[at[:, 1], at[:, 0]]


def _full(points: NDArray, reduced: tuple[int, int], size: tuple[int, int]) -> Array:
    grow = scaling(reduced, size)
    return points.astype(np.float64) @ grow[:2, :2].T + grow[:2, 2]


def _correspondences(
    a: Evidence,
    b: Evidence,
    size_a: tuple[int, int],
    size_b: tuple[int, int],
    matcher: Matcher,
    settings: SolveSettings,
    *,
    every: bool = False,
) -> Correspondences:
    """Matches of two cameras, frame by frame (or, with ``every``, some frames of one with some of the other)."""
    if every:
        moments = [(fa, fb) for fa in a.features[::4] for fb in b.features[::4]]
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


def _weighted(
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


def _field_in(scene: Scene, camera: str, shape: tuple[int, int]) -> Mask:
    """The hull of the scene's field in a reduced picture (rows, columns) of ``camera``: hands and instruments cut
    holes into the field's colour, but what lies between is the field too."""
    outline = cv2.convexHull(np.argwhere(scene.field)[:, ::-1].astype(np.float32)).reshape(-1, 2)
    back: Array = np.asarray(np.linalg.inv(scene.warp_of(camera, (shape[1], shape[0]))), np.float64)
    mask = np.zeros(shape, np.uint8)
    cv2.fillConvexPoly(mask, np.round(apply(back, outline.astype(np.float64))).astype(np.int32), 1)
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


def _scene(
    alignment: Alignment,
    sizes: Mapping[str, tuple[int, int]],
    reference: str,
    evidence: Mapping[str, Evidence],
    settings: SolveSettings,
) -> Scene:
    """The scene, its field being where most cameras place theirs."""
    width, height = sizes[reference]
    size = (settings.scene_width, max(1, round(height * settings.scene_width / width)))
    empty = Scene(size, reference, alignment.homographies, sizes, np.zeros((size[1], size[0]), bool))
    votes, voters = np.zeros((size[1], size[0])), np.zeros((size[1], size[0]))
    for name in alignment.homographies:
        mask = evidence[name].field if name in evidence else None
        if mask is None or not mask.any():
            continue
        warp = empty.warp_of(name, (mask.shape[1], mask.shape[0]))
        votes += cv2.warpPerspective(mask.astype(np.float32), warp, size)
        voters += cv2.warpPerspective(np.ones(mask.shape, np.float32), warp, size)
    place = main_region((votes > 0.5 * voters) & (voters > 0.5))
    if not place.any():
        grid = np.stack(np.meshgrid(np.arange(size[0]), np.arange(size[1])), axis=-1).reshape(-1, 2)
        place = _near_middle(grid.astype(np.float64), size).reshape(size[1], size[0])
    return Scene(size, reference, alignment.homographies, sizes, place)


def _anchored(
    previous: SolvedPose,
    evidence: Mapping[str, Evidence],
    fields: Mapping[str, Mask],
    alignment: Alignment,
    reference: str,
    matcher: Matcher,
    settings: SolveSettings,
) -> tuple[Matrix, int]:
    """The anchor that keeps the programme's perspective over a movement, and the number of the perspective.

    Each camera's own view is matched with its view before; the reference's own is taken when it has at least half
    the support of the best, since the others go through one homography more on either side.
    """
    best: tuple[float, Array] | None = None
    for name in sorted(alignment.homographies):
        before = previous.scene.homographies.get(name)
        if before is None or name not in evidence or name not in previous.evidence:
            continue
        size = previous.scene.camera_sizes[name]
        pair = _correspondences(evidence[name], previous.evidence[name], size, size, matcher, settings, every=True)
        both = {"now": fields[name], "before": _field_in(previous.scene, name, fields[name].shape)}
        pair = _weighted(pair, {"now": size, "before": size}, "now", "before", both, settings)
        fit = fit_pair(pair, size, size, settings.alignment)
        if fit is None:
            continue
        worth = fit.support * (2.0 if name == reference else 1.0)
        to_before = before @ fit.homography @ np.linalg.inv(alignment.homographies[name])
        if best is None or worth > best[0]:
            best = (worth, to_before)
    if best is None:
        return IDENTITY, previous.pose.perspective + 1
    return to_matrix(np.array(previous.pose.anchor) @ best[1]), previous.pose.perspective


def _colours(scene: Scene, moments: Sequence[Mapping[str, NDArray[np.uint8] | None]]) -> dict[str, Colour]:
    """Each camera's match to the reference camera, from the medians of what both show."""
    shown: dict[str, list[NDArray[np.uint8]]] = {}
    inside: dict[str, Mask] = {}
    for pictures in moments[:: max(1, len(moments) // 5)]:
        for view in scene.views(pictures):
            shown.setdefault(view.camera, []).append(view.aligned)
            inside[view.camera] = view.inside
    medians = {name: np.median(pictures, axis=0).astype(np.uint8) for name, pictures in shown.items()}
    if scene.reference not in medians:
        return {}
    target = medians.pop(scene.reference)
    colours = {}
    for name, median in medians.items():
        overlap = inside[name] & inside[scene.reference]
        if overlap.mean() > 0.02:
            colours[name] = colour.match(median, target, overlap.astype(np.uint8))
    return colours
