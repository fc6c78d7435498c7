"""One pose solved: which samples are clear, which points match, where the field lies, how every camera lies to it.

First by distinctive points, then, with the views laid over each other, by dense matching over the field. Reads samples;
returns values. Full-size pixels unless a name says otherwise.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence, Set
from itertools import combinations

import attrs
import cv2
import numpy as np
from attrs import frozen
from numpy.typing import NDArray

from mcsl_core.edl import Colour, Pose, Weak
from mcsl_core.imaging.geometry import Array, scaling, size_at_columns, to_edl_matrix, transform_points
from mcsl_core.imaging.masks import Mask, central_ellipse, convex_hull, resize_mask
from mcsl_core.progress import Progress
from mcsl_core.timing import FrameRange

from .aligned_views import AlignedPose, Picture
from .clear_frames import degree_of_occlusion, field_area
from .colour_match import match_colours
from .correspondences import Pairs
from .dense_matching import AlignedCamera, match_densely
from .field import field_by_hue, field_by_vote, field_in_camera, field_that_stays, modal_picture
from .observations import (
    Observations,
    Samples,
    SolvedPose,
    match_cameras,
    observe,
    spread,
    weight_by_aim,
    weight_matches,
)
from .photo_consistency import Agreement, LaidView, refuted
from .protocol import Aligner, Alignment, Matcher
from .settings import SolveSettings
from .steady import SteadyView, steady_view

STEADY = 6  # levels of 255 that a pixel may be off its median half of the time: noise and breathing, not hands


@frozen(eq=False)
class PoseSolver:
    """Solves the poses of one recording.

    Attributes
    ----------
    sizes : mapping of str to (int, int)
        Every camera's full width and height.
    reference : str
        The reference camera.
    matcher : Matcher
        What finds and matches distinctive points.
    aligner : Aligner
        What ties the cameras together by matches.
    settings : SolveSettings
        Sizes, weights and thresholds.

    References
    ----------
    The paper's section "View Alignment".
    """

    sizes: Mapping[str, tuple[int, int]]
    reference: str
    matcher: Matcher
    aligner: Aligner
    settings: SolveSettings

    def solve(self, frames: FrameRange, standing: Sequence[int], samples: Samples, progress: Progress) -> SolvedPose:
        """Solves one pose.

        Parameters
        ----------
        frames : FrameRange
            The programme frames of the pose.
        standing : sequence of int
            Positions of the samples in which the lamp stands still; one at least.
        samples : Samples
            What is read.
        progress : Progress
            Told of weak cameras.

        Returns
        -------
        SolvedPose
            Its perspective is its own reference camera's until it is anchored.
        """
        settings = self.settings
        doo = np.array([_degree_of_occlusion(samples, position) for position in standing])
        picked, _ = settings.clear.choose(doo)
        clear = [standing[i] for i in picked]
        for_field = spread(standing, settings.typical_moments)
        for_dense = spread(standing, settings.dense_moments)
        observations = observe(clear, for_field, samples, self.matcher)
        first, by_points = self._by_points(observations)
        coarse = self._aligned(first, settings.typical_width)
        by_hue = field_by_hue(modal_picture(coarse, (samples[i].pictures for i in for_field)))
        pictures = [samples[i].pictures for i in for_dense]
        steady = {name: steady_view([shown.get(name) for shown in pictures]) for name in self.sizes}
        dense = self._densely(first, by_hue, pictures, steady)
        alignment = self._confirmed([self._together(first, by_points, dense), first], steady)
        for weak in alignment.weak:
            progress.note(f"frames {frames}: camera {weak.camera} is weak: {weak.reason}")
        aligned = self._aligned(alignment, settings.scene_width)
        field = field_that_stays(aligned, resize_mask(by_hue, aligned.size), dense)
        aligned = attrs.evolve(aligned, field=field)
        pose = Pose(
            range=frames,
            homographies={name: to_edl_matrix(h) for name, h in alignment.homographies.items()},
            colour=_colours(aligned, pictures),
            solved_from=tuple(samples.frames[i] for i in clear),
            residual_px={n: round(v, 3) for n, v in alignment.residual_px.items()},
            support=dict(alignment.support),
            weak=alignment.weak,
        )
        kept = {name: Observations(own.features[::4], own.field) for name, own in observations.items()}
        return SolvedPose(pose, aligned, tuple(for_dense), kept)

    def _by_points(self, observations: Mapping[str, Observations]) -> tuple[Alignment, Pairs]:
        """The alignment by distinctive points, and the matches it was made from.

        A head may hide the field from one camera in all clear samples. So the cameras are tied twice: first by where
        each sees the field itself, then by where all together have it.
        """
        sizes = self.sizes
        found = {
            (a, b): match_cameras(observations[a], observations[b], sizes[a], sizes[b], self.matcher, self.settings)
            for a, b in combinations(sorted(observations), 2)
        }
        fields = {name: own.field for name, own in observations.items()}
        first, _ = self._by_weight(found, fields)
        aligned = self._aligned(first, self.settings.scene_width)
        aligned = attrs.evolve(aligned, field=field_by_vote(aligned, fields))
        for name in first.homographies.keys() & fields.keys():
            fields[name] = field_in_camera(aligned, name, fields[name].shape)
        return self._by_weight(found, fields)

    def _by_weight(self, found: Pairs, fields: Mapping[str, Mask]) -> tuple[Alignment, Pairs]:
        """The alignment by matches weighed by the fields of their cameras, and those matches."""
        sizes = self.sizes
        pairs = {
            (a, b): weight_matches(matches, sizes[a], sizes[b], fields[a], fields[b], self.settings)
            for (a, b), matches in found.items()
        }
        return self.aligner.align(pairs, sizes, self.reference), pairs

    def _densely(
        self,
        first: Alignment,
        by_hue: Mask,
        pictures: Sequence[Mapping[str, Picture | None]],
        steady: Mapping[str, SteadyView | None],
    ) -> Pairs:
        """Matches all over the field of the cameras that are tied in, where they cover enough of it.

        A camera that hardly ever sees the field shows it in no steady view, but in single samples it does.
        """
        size = size_at_columns(self.sizes[self.reference], self.settings.dense_width)
        to_aligned = scaling(self.sizes[self.reference], size)
        laid = {name: to_aligned @ h for name, h in first.homographies.items() if steady.get(name) is not None}
        field = resize_mask(by_hue, size)
        field = field if field.any() else central_ellipse(size)
        cameras = {
            name: AlignedCamera([view.picture], h, self.sizes[name], [view.steady])
            for name, h in laid.items()
            if (view := steady[name]) is not None
        }
        dense = self._covering(cameras, field)
        left = laid.keys() - {name for pair in dense for name in pair}
        if left:
            shown = {n: AlignedCamera([p.get(n) for p in pictures], h, self.sizes[n]) for n, h in laid.items()}
            dense = _leading_to(self.reference, {**dense, **self._covering(shown, field, left)})
        return dense

    def _covering(self, cameras: Mapping[str, AlignedCamera], field: Mask, wanted: Set[str] | None = None) -> Pairs:
        """The matches in a field of the pairs that cover enough of it.

        Outside of it a quarter as many as inside at most, or drapes would decide which are true. Only pairs that lead
        to the reference: others would outweigh the points that they hang on.
        """
        settings = self.settings
        least = settings.least_covered * field.sum() / settings.dense.grid_px**2
        covering = {}
        for (a, b), matches in match_densely(cameras, convex_hull(field), settings.dense, wanted).items():
            inside = _inside(transform_points(cameras[a].to_aligned, matches.a), field)
            if inside.sum() >= least:
                covering[a, b] = matches.where(inside | _as_many(~inside, int(inside.sum()) // 4))
        return covering if wanted else _leading_to(self.reference, covering)

    def _together(self, first: Alignment, by_points: Pairs, dense: Pairs) -> Alignment:
        """The alignment by dense matches, where there are any; a camera without stays where its points lay it.

        The aligner's own verdict on weak cameras was given on the points: dense matching reaches only where those lead.
        """
        if not dense:
            return first
        tied = {name for pair in dense for name in pair}
        rest = {
            pair: matches
            for pair, matches in by_points.items()
            if not tied.issuperset(pair) and first.homographies.keys() >= set(pair)
        }
        aimed = {
            (a, b): weight_by_aim(matches, self.sizes[a], self.sizes[b], self.settings.aim)
            for (a, b), matches in dense.items()
        }
        sizes = {name: self.sizes[name] for name in first.homographies}
        final = self.aligner.align({**aimed, **rest}, sizes, self.reference)
        if final.weak:
            return first
        return attrs.evolve(final, weak=first.weak)

    def _confirmed(self, choice: Sequence[Alignment], steady: Mapping[str, SteadyView | None]) -> Alignment:
        """The first alignment in which the pictures refute the fewest cameras, without those: they are weak."""
        size = size_at_columns(self.sizes[self.reference], self.settings.dense_width)
        reach = round(self.settings.alignment.relief * float(np.hypot(*size)))
        wrong = []
        for alignment in choice:
            laid = self._laid(self._aligned(alignment, size[0]), steady)
            wrong.append(refuted(laid, self.reference, reach) if self.reference in laid else {})
        best = min(range(len(choice)), key=lambda i: len(wrong[i]))
        return _without(choice[best], wrong[best])

    def _laid(self, aligned: AlignedPose, steady: Mapping[str, SteadyView | None]) -> dict[str, LaidView]:
        """Every camera's steady view in aligned pixels."""
        laid = {}
        for name in aligned.homographies:
            view = steady.get(name)
            if view is None:
                continue
            warp = aligned.warp_of(name, (view.picture.shape[1], view.picture.shape[0]))
            grey = cv2.warpPerspective(cv2.cvtColor(view.picture, cv2.COLOR_BGR2GRAY), warp, aligned.size)
            mask = cv2.warpPerspective(view.steady.astype(np.uint8), warp, aligned.size, flags=cv2.INTER_NEAREST)
            laid[name] = LaidView(np.asarray(grey, np.uint8), mask > 0)
        return laid

    def _aligned(self, alignment: Alignment, columns: int) -> AlignedPose:
        """The aligned pose of so many columns; where its field lies is not known yet."""
        size = size_at_columns(self.sizes[self.reference], columns)
        nowhere = np.zeros((size[1], size[0]), bool)
        return AlignedPose(size, self.reference, alignment.homographies, self.sizes, nowhere)


def _inside(points: Array, mask: Mask) -> NDArray[np.bool_]:
    """Which of some aligned pixels lie in a mask."""
    at = np.clip(np.round(points).astype(int), 0, np.array(mask.shape[::-1]) - 1)
    return mask[at[:, 1], at[:, 0]]


def _as_many(mask: NDArray[np.bool_], most: int) -> NDArray[np.bool_]:
    """``mask`` with so many of its True left at most, evenly."""
    at = np.flatnonzero(mask)
    kept = np.zeros(len(mask), bool)
    kept[at[np.unique(np.linspace(0, len(at) - 1, min(most, len(at))).round().astype(int))]] = True
    return kept


def _leading_to(reference: str, pairs: Pairs) -> Pairs:
    """The pairs by which one comes to the reference."""
    reached = {reference}
    while near := [pair for pair in pairs if len(reached.intersection(pair)) == 1]:
        reached.update(*near)
    return {pair: matches for pair, matches in pairs.items() if reached.issuperset(pair)}


def _without(alignment: Alignment, wrong: Mapping[str, Agreement]) -> Alignment:
    """The alignment without the cameras that the pictures refute, which are weak."""
    weak = [
        Weak(
            name,
            f"where its points lay it, only {found.found} of {found.tried} places look as in the others: "
            "they match by chance, or show something else than the field",
        )
        for name, found in sorted(wrong.items())
    ]
    return Alignment(
        {name: h for name, h in alignment.homographies.items() if name not in wrong},
        {name: v for name, v in alignment.residual_px.items() if name not in wrong},
        {name: v for name, v in alignment.support.items() if name not in wrong},
        (*alignment.weak, *weak),
    )


def _degree_of_occlusion(samples: Samples, position: int) -> float:
    pictures = samples[position].pictures.values()
    return degree_of_occlusion([field_area(picture) for picture in pictures if picture is not None])


def _colours(aligned: AlignedPose, samples: Sequence[Mapping[str, Picture | None]]) -> dict[str, Colour]:
    """Each camera's match to the reference camera, from the medians of what both show steadily.

    Where hands and heads come and go the median is nobody's colour; such pixels are left out by their deviation.
    """
    shown: dict[str, list[Picture]] = {}
    steady: dict[str, Mask] = {}
    for pictures in samples:
        for view in aligned.views(pictures):
            shown.setdefault(view.camera, []).append(view.aligned)
            steady[view.camera] = view.inside
    medians: dict[str, Picture] = {}
    for name, own in shown.items():
        stack = np.stack(own)
        medians[name] = np.median(stack, axis=0).astype(np.uint8)
        off = np.median(cv2.absdiff(stack, np.broadcast_to(medians[name], stack.shape).copy()), axis=0).max(axis=2)
        steady[name] = steady[name] & (off <= STEADY)
    if aligned.reference not in medians:
        return {}
    target = medians.pop(aligned.reference)
    colours = {}
    for name, median in medians.items():
        overlap = steady[name] & steady[aligned.reference]
        if overlap.mean() > 0.02:
            colours[name] = match_colours(median, target, overlap.astype(np.uint8))
    return colours
