"""One pose solved: which moments are clear, which points match, where the field lies, how every camera lies to it.

First by distinctive points, then, with the views laid over each other, by every spot of the field (`dense`). Reads
samples; returns values. Full-size pixels unless a name says otherwise.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import combinations

import attrs
import cv2
import numpy as np
from numpy.typing import NDArray

from mcsl_core.alignment import colour_match as colour
from mcsl_core.edl import Colour, Pose
from mcsl_core.imaging.geometry import scaling, size_at_columns, to_edl_matrix, transform_points
from mcsl_core.imaging.masks import Mask, central_ellipse, close_gaps, convex_hull, main_region, resize_mask
from mcsl_core.progress import Progress
from mcsl_core.timing import FrameRange

from .aligned_views import AlignedPose
from .clear_frames import degree_of_occlusion, field_area
from .correspondences import Correspondences
from .dense_matching import PlacedCamera, match_densely
from .field import field_by_hue, typical_picture
from .observations import (
    Observations,
    Samples,
    SolvedPose,
    field_in_camera,
    match_cameras,
    observe,
    spread,
    weight_matches,
)
from .protocol import Aligner, Alignment, Matcher
from .settings import SolveSettings

Array = NDArray[np.float64]
Pairs = dict[tuple[str, str], Correspondences]
STEADY = 6  # levels of 255 that a pixel may be off its median half of the time: noise and breathing, not hands


def solve_pose(
    piece: FrameRange,
    standing: Sequence[int],
    samples: Samples,
    sizes: Mapping[str, tuple[int, int]],
    *,
    reference: str,
    matcher: Matcher,
    aligner: Aligner,
    settings: SolveSettings,
    progress: Progress,
) -> SolvedPose:
    """Solves the pose over ``piece``; its perspective is its own reference camera's until it is anchored.

    standing: positions of the samples in which the lamp stands still. sizes: every camera's full (width, height).
    """
    picked, _ = settings.clear.choose(np.array([_doo(samples, i) for i in standing]))
    moments = [standing[i] for i in picked]
    many = spread(standing, settings.typical_moments)
    evidence = observe(moments, many, samples, matcher)
    first, pairs = _by_points(evidence, sizes, reference, matcher, aligner, settings)
    typical = _scene(first, sizes, reference, settings.typical_width)
    place = field_by_hue(typical_picture(typical, (samples[i].pictures for i in many)))
    views = spread(standing, settings.dense_moments)
    dense = _by_spots(first, place, views, samples, sizes, reference, settings)
    alignment = _together(first, pairs, dense, sizes, reference, aligner)
    for weak in alignment.weak:
        progress.note(f"frames {piece}: camera {weak.camera} is weak: {weak.reason}")
    scene = _scene(alignment, sizes, reference, settings.scene_width)
    scene = attrs.evolve(scene, field=_field(place, dense, scene))
    pose = Pose(
        range=piece,
        homographies={name: to_edl_matrix(h) for name, h in alignment.homographies.items()},
        colour=_colours(scene, [samples[i].pictures for i in views]),
        solved_from=tuple(samples.frames[i] for i in moments),
        residual_px={n: round(v, 3) for n, v in alignment.residual_px.items()},
        support=dict(alignment.support),
        weak=alignment.weak,
    )
    kept = {name: Observations(seen.features[::4], seen.field) for name, seen in evidence.items()}
    return SolvedPose(pose, scene, tuple(views), kept)


def _doo(samples: Samples, position: int) -> float:
    return degree_of_occlusion([field_area(p) for p in samples[position].pictures.values() if p is not None])


def _by_points(
    evidence: Mapping[str, Observations],
    sizes: Mapping[str, tuple[int, int]],
    reference: str,
    matcher: Matcher,
    aligner: Aligner,
    settings: SolveSettings,
) -> tuple[Alignment, Pairs]:
    """The alignment by distinctive points, and the matches it was made from."""
    found = {
        (a, b): match_cameras(evidence[a], evidence[b], sizes[a], sizes[b], matcher, settings)
        for a, b in combinations(sorted(evidence), 2)
    }
    # A head may hide the field from one camera at all clear moments. So the cameras are tied twice: first by where
    # each sees the field itself, then by where all together place it.
    fields = {name: seen.field for name, seen in evidence.items()}
    for again in (True, False):
        pairs = {(a, b): weight_matches(p, sizes, a, b, fields, settings) for (a, b), p in found.items()}
        alignment = aligner.align(pairs, sizes, reference)
        if again:
            scene = _scene(alignment, sizes, reference, settings.scene_width)
            scene = attrs.evolve(scene, field=_voted(scene, evidence))
            fields |= {
                name: field_in_camera(scene, name, fields[name].shape)
                for name in alignment.homographies
                if name in fields
            }
    return alignment, pairs  # pyright: ignore[reportPossiblyUnboundVariable]


def _by_spots(
    first: Alignment,
    place: Mask,
    moments: Sequence[int],
    samples: Samples,
    sizes: Mapping[str, tuple[int, int]],
    reference: str,
    settings: SolveSettings,
) -> Pairs:
    """Matches spot by spot over the hull of ``place``, of the cameras that are tied in."""
    scene = _scene(first, sizes, reference, settings.dense_width)
    to_scene = scaling(sizes[reference], scene.size)
    pictures = [samples[i].pictures for i in moments]
    views = {
        name: PlacedCamera([p.get(name) for p in pictures], to_scene @ h, sizes[name])
        for name, h in first.homographies.items()
    }
    area = convex_hull(resize_mask(place, scene.size))
    return match_densely(views, area if area.any() else central_ellipse(scene.size), settings.dense)


def _together(
    first: Alignment,
    by_points: Pairs,
    dense: Pairs,
    sizes: Mapping[str, tuple[int, int]],
    reference: str,
    aligner: Aligner,
) -> Alignment:
    """The alignment by the spots, where there are any; a camera without stays where its points place it.

    The aligner's own verdict on weak cameras was given on the points: spots are compared only where those lead.
    """
    if not dense:
        return first
    tied = {name for pair in dense for name in pair}
    rest = {
        pair: matches
        for pair, matches in by_points.items()
        if not tied.issuperset(pair) and first.homographies.keys() >= set(pair)
    }
    final = aligner.align({**dense, **rest}, {n: sizes[n] for n in first.homographies}, reference)
    if final.weak:
        return first
    return attrs.evolve(final, weak=first.weak)


def _field(place: Mask, dense: Pairs, scene: AlignedPose) -> Mask:
    """The field in the scene: where its hue is typical and two pairs of cameras at least see something that stays.

    Hands in gloves of the field's hue lie in the typical picture where they work, but nothing there stays.
    """
    typical = resize_mask(place, scene.size)
    stays = np.zeros((scene.size[1], scene.size[0]), np.uint8)
    to_scene = scaling(scene.camera_sizes[scene.reference], scene.size)
    for (a, _), matches in dense.items():
        at = np.round(transform_points(to_scene @ scene.homographies[a], matches.a)).astype(int)
        inside = ((at >= 0) & (at < scene.size)).all(axis=1) & (matches.weight > 0.6)
        seen = np.zeros_like(stays)
        seen[at[inside, 1], at[inside, 0]] = 1
        stays += cv2.dilate(seen, np.ones((7, 7), np.uint8))  # pyright: ignore[reportOperatorIssue]
    field = close_gaps(main_region((stays >= min(2, len(dense))) & typical), gap=0.04)
    if field.sum() >= 0.3 * typical.sum() > 0:
        return field
    return typical if typical.any() else central_ellipse(scene.size)


def _scene(alignment: Alignment, sizes: Mapping[str, tuple[int, int]], reference: str, columns: int) -> AlignedPose:
    """The scene of so many columns; where its field lies is not known yet."""
    size = size_at_columns(sizes[reference], columns)
    return AlignedPose(size, reference, alignment.homographies, sizes, np.zeros((size[1], size[0]), bool))


def _voted(scene: AlignedPose, evidence: Mapping[str, Observations]) -> Mask:
    """(H, W) bool: where most of the cameras that show the place have the field there by their own pictures."""
    shape = (scene.size[1], scene.size[0])
    votes, voters = np.zeros(shape), np.zeros(shape)
    for name in scene.homographies:
        mask = evidence[name].field if name in evidence else None
        if mask is None or not mask.any():
            continue
        warp = scene.warp_of(name, (mask.shape[1], mask.shape[0]))
        votes += cv2.warpPerspective(mask.astype(np.float32), warp, scene.size)
        voters += cv2.warpPerspective(np.ones(mask.shape, np.float32), warp, scene.size)
    place = main_region((votes > 0.5 * voters) & (voters > 0.5))
    return place if place.any() else central_ellipse(scene.size)


def _colours(scene: AlignedPose, moments: Sequence[Mapping[str, NDArray[np.uint8] | None]]) -> dict[str, Colour]:
    """Each camera's match to the reference camera, from the medians of what both show steadily.

    Where hands and heads come and go the median is nobody's colour; such pixels are left out by their deviation.
    """
    shown: dict[str, list[NDArray[np.uint8]]] = {}
    inside: dict[str, Mask] = {}
    for pictures in moments:
        for view in scene.views(pictures):
            shown.setdefault(view.camera, []).append(view.aligned)
            inside[view.camera] = view.inside
    medians: dict[str, NDArray[np.uint8]] = {}
    for name, pictures in shown.items():
        stack = np.stack(pictures)
        medians[name] = np.median(stack, axis=0).astype(np.uint8)
        off = np.median(cv2.absdiff(stack, np.broadcast_to(medians[name], stack.shape).copy()), axis=0).max(axis=2)
        inside[name] = inside[name] & (off <= STEADY)
    if scene.reference not in medians:
        return {}
    target = medians.pop(scene.reference)
    colours = {}
    for name, median in medians.items():
        overlap = inside[name] & inside[scene.reference]
        if overlap.mean() > 0.02:
            colours[name] = colour.match_colours(median, target, overlap.astype(np.uint8))
    return colours
