"""One pose solved: which samples are clear, which points match, where the field lies, how every camera lies to it.

First by distinctive points, then, with the views laid over each other, by dense matching over the field. Reads samples;
returns values. Full-size pixels unless a name says otherwise.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import combinations

import attrs
import cv2
import numpy as np
from attrs import frozen

from mcsl_core.edl import Colour, Pose
from mcsl_core.edl.field import MIDDLE, PICTURES
from mcsl_core.imaging.geometry import scaling, size_at_columns, to_edl_matrix
from mcsl_core.imaging.masks import Mask, central_ellipse, convex_hull, resize_mask
from mcsl_core.progress import Progress
from mcsl_core.timing import FrameRange

from .aligned_views import AlignedPose, Picture
from .clear_frames import degree_of_occlusion, field_area
from .colour_match import match_colours
from .correspondences import Pairs
from .dense_matching import AlignedCamera, DenseSettings, match_densely
from .field import field_by_hue, field_by_vote, field_in_camera, modal_picture, shared_aim
from .field_voices import Evidence, aim_of, busy_places, field_by_voices
from .observations import Observations, Samples, SolvedPose, match_cameras, observe, spread, weight_matches
from .protocol import Aligner, Alignment, Matcher
from .settings import SolveSettings

ONE_AIM = 0.94  # cameras that aim at one place; see `shared_aim`
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

    def solve(
        self,
        frames: FrameRange,
        standing: Sequence[int],
        samples: Samples,
        progress: Progress,
        *,
        known: Mask | None = None,
    ) -> SolvedPose:
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
        known : (H, W) bool array, optional
            Where the field lies in the reference camera's picture, of any size; it is looked for without.

        Returns
        -------
        SolvedPose
            Its perspective is its own reference camera's until it is anchored.
        """
        settings = self.settings
        clear = self._clear(standing, samples)
        for_field = spread(standing, settings.typical_moments)
        for_dense = spread(standing, settings.dense_moments)
        observations = observe(clear, for_field, samples, self.matcher)
        first, by_points = self._by_points(observations, known)
        field, area = self._field(first, for_field, samples) if known is None else (known, known)
        pictures = [samples[i].pictures for i in for_dense]
        # In a field that is known its hue says nothing more.
        how = settings.dense if known is None else attrs.evolve(settings.dense, other_hue=1.0)
        dense = self._densely(first, area, pictures, how)
        alignment = self._together(first, by_points, dense)
        for weak in alignment.weak:
            progress.note(f"frames {frames}: camera {weak.camera} is weak: {weak.reason}")
        aligned = self._aligned(alignment, settings.scene_width)
        shown = resize_mask(field, aligned.size)
        sure = known is not None or (bool(shown.any()) and shared_aim(aligned) >= ONE_AIM)
        aligned = attrs.evolve(aligned, field=shown if sure else central_ellipse(aligned.size))
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
        return SolvedPose(pose, aligned, tuple(for_dense), kept, PICTURES if sure else MIDDLE)

    def _clear(self, standing: Sequence[int], samples: Samples) -> list[int]:
        """The samples to find points in."""
        picked, _ = self.settings.clear.choose(np.array([_degree_of_occlusion(samples, at) for at in standing]))
        return [standing[i] for i in picked]

    def _by_points(self, observations: Mapping[str, Observations], known: Mask | None) -> tuple[Alignment, Pairs]:
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
        if known is not None and self.reference in fields:
            fields[self.reference] = resize_mask(known, fields[self.reference].shape[::-1])
        first, _ = self._by_weight(found, fields)
        aligned = self._aligned(first, self.settings.scene_width)
        field = field_by_vote(aligned, fields) if known is None else resize_mask(known, aligned.size)
        aligned = attrs.evolve(aligned, field=field)
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

    def _field(self, first: Alignment, positions: Sequence[int], samples: Samples) -> tuple[Mask, Mask]:
        """The field, empty where nothing shows it, and what to match densely: that, or what has its hue."""
        coarse = self._aligned(first, self.settings.typical_width)
        picture = modal_picture(coarse, (samples[i].pictures for i in positions))
        views = [coarse.views(samples[i].pictures) for i in spread(positions, self.settings.dense_moments)]
        evidence = Evidence(picture, aim_of(coarse), busy_places(views, coarse.size))
        found = field_by_voices(evidence).mask
        return found, found if found.any() else field_by_hue(picture)

    def _densely(
        self, first: Alignment, by_hue: Mask, pictures: Sequence[Mapping[str, Picture | None]], dense: DenseSettings
    ) -> Pairs:
        """Matches all over the hull of the field, of the cameras that are tied in."""
        size = size_at_columns(self.sizes[self.reference], self.settings.dense_width)
        to_aligned = scaling(self.sizes[self.reference], size)
        cameras = {
            name: AlignedCamera([shown.get(name) for shown in pictures], to_aligned @ h, self.sizes[name])
            for name, h in first.homographies.items()
        }
        area = convex_hull(resize_mask(by_hue, size))
        return match_densely(cameras, area if area.any() else central_ellipse(size), dense)

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
        sizes = {name: self.sizes[name] for name in first.homographies}
        final = self.aligner.align({**dense, **rest}, sizes, self.reference)
        if final.weak:
            return first
        return attrs.evolve(final, weak=first.weak)

    def _aligned(self, alignment: Alignment, columns: int) -> AlignedPose:
        """The aligned pose of so many columns; where its field lies is not known yet."""
        size = size_at_columns(self.sizes[self.reference], columns)
        nowhere = np.zeros((size[1], size[0]), bool)
        return AlignedPose(size, self.reference, alignment.homographies, self.sizes, nowhere)


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
