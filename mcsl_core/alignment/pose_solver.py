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
from attrs import field, frozen

from mcsl_core.edl import Colour, Pose, Weak
from mcsl_core.edl.field import MIDDLE, PICTURES
from mcsl_core.imaging.geometry import size_at_columns, to_edl_matrix
from mcsl_core.imaging.masks import Mask, central_ellipse, resize_mask
from mcsl_core.parallel import by_threads
from mcsl_core.progress import Progress
from mcsl_core.timing import FrameRange

from .agreed_colours import agreed_colours
from .aligned_views import AlignedPose, Picture
from .clear_frames import degree_of_occlusion, field_area
from .correspondences import Correspondences, Pairs
from .field import field_by_vote, field_in_camera, shared_aim
from .field_voices import find_field
from .observations import Observations, Samples, SolvedPose, match_cameras, observe, spread, weight_matches
from .photo_consistency import Agreement, LaidView, refuted
from .plausibility import plausible
from .protocol import Aligner, Alignment, Matcher
from .relief.cameras import ReliefCameras
from .relief.matching import Views, field_pairs, relief_cameras
from .relief.protocol import PlaneRelief, ReliefEstimator
from .relief.rig import Rig
from .settings import SolveSettings
from .steady import SteadyView, steady_view

ONE_AIM = 0.94  # cameras that aim at one place; see `shared_aim`


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
    estimator : ReliefEstimator
        What finds the surface that all cameras see, once the pose is anchored; none is looked for without.

    References
    ----------
    The paper's section "View Alignment".
    """

    sizes: Mapping[str, tuple[int, int]]
    reference: str
    matcher: Matcher
    aligner: Aligner
    settings: SolveSettings
    estimator: ReliefEstimator = field(factory=PlaneRelief)

    def solve(
        self,
        frames: FrameRange,
        standing: Sequence[int],
        samples: Samples,
        progress: Progress,
        *,
        known: Mask | None = None,
        rigs: Sequence[Rig] = (),
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
        rigs : sequence of Rig, optional
            Of other poses, for cameras that show little in this one.

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
        pictures = [samples[i].pictures for i in for_dense]
        steady = self._steady(pictures)
        views = Views(self.reference, self.sizes, steady, pictures)
        cameras = relief_cameras(views, first.homographies, rigs)
        if known is None:  # what is found in views laid by their points lays them well enough to find it again
            coarse = self._field(first, for_field, samples)
            laid = self._together(first, by_points, cameras, coarse, views)
            field = self._field(laid, for_field, samples, coarse)
        else:
            field = known
        tied = self._together(first, by_points, cameras, field, views)
        unseen = Rig.of(cameras).transferred()
        alignment = self._confirmed(tied, {name: view for name, view in steady.items() if name not in unseen})
        _tell_of_weak(alignment, frames, progress)
        aligned = self._aligned(alignment, settings.scene_width)
        sure = known is not None or bool(field.any() and shared_aim(self._aligned(tied, aligned.size[0])) >= ONE_AIM)
        field = resize_mask(field, aligned.size) if sure else central_ellipse(aligned.size)
        aligned = attrs.evolve(aligned, field=field)
        pose = _pose(frames, alignment, [samples.frames[i] for i in clear], agreed_colours(aligned, pictures))
        kept = {name: Observations(own.features[::4], own.field) for name, own in observations.items()}
        solved = SolvedPose(pose, aligned, tuple(for_dense), kept, PICTURES if sure else MIDDLE)
        return solved if cameras is None else solved.seeing(cameras, views)

    def _steady(self, pictures: Sequence[Mapping[str, Picture | None]]) -> dict[str, SteadyView | None]:
        """What every camera shows steadily."""
        found = by_threads(lambda name: steady_view([shown.get(name) for shown in pictures]), self.sizes)
        return dict(zip(self.sizes, found, strict=True))

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

        def matched(pair: tuple[str, str]) -> Correspondences:
            (a, b), (size_a, size_b) = (observations[n] for n in pair), (sizes[n] for n in pair)
            return match_cameras(a, b, size_a, size_b, self.matcher, self.settings)

        pairs = list(combinations(sorted(observations), 2))
        found = dict(zip(pairs, by_threads(matched, pairs), strict=True))
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
        return plausible(self.aligner.align(pairs, sizes, self.reference), sizes, self.reference), pairs

    def _field(
        self, alignment: Alignment, positions: Sequence[int], samples: Samples, before: Mask | None = None
    ) -> Mask:
        """Where the field lies, empty where nothing shows one, by how the views lie now; ``before``: as they did."""
        coarse = self._aligned(alignment, self.settings.typical_width)
        return find_field(coarse, [samples[i].pictures for i in positions], before)

    def _together(
        self, first: Alignment, by_points: Pairs, relief: ReliefCameras | None, field: Mask, views: Views
    ) -> Alignment:
        """The alignment by the relief over the field; a camera without stays where its points lay it.

        The aligner's own verdict on weak cameras was given on the points: the relief reaches only where those lead.
        """
        if relief is None:
            return first
        known = relief.projections.keys()
        dense = field_pairs(relief, field if field.any() else central_ellipse(views.size), views)
        rest = {
            pair: matches
            for pair, matches in by_points.items()
            if not known >= set(pair) and first.homographies.keys() >= set(pair)
        }
        sizes = {name: self.sizes[name] for name in self.sizes if name in first.homographies or name in known}
        final = plausible(self.aligner.align({**dense, **rest}, sizes, self.reference), sizes, self.reference)
        if final.weak:
            return first
        return attrs.evolve(final, weak=tuple(w for w in first.weak if w.camera not in known))

    def _confirmed(self, alignment: Alignment, steady: Mapping[str, SteadyView | None]) -> Alignment:
        """The alignment without the cameras that the pictures refute: they are weak."""
        size = size_at_columns(self.sizes[self.reference], self.settings.dense_width)
        reach = round(self.settings.alignment.relief * float(np.hypot(*size)))
        laid = self._laid(self._aligned(alignment, size[0]), steady)
        return _without(alignment, refuted(laid, self.reference, reach)) if self.reference in laid else alignment

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


def _pose(frames: FrameRange, alignment: Alignment, solved_from: Sequence[int], colour: Mapping[str, Colour]) -> Pose:
    """What the EDL says of an alignment."""
    return Pose(
        range=frames,
        homographies={name: to_edl_matrix(h) for name, h in alignment.homographies.items()},
        colour=colour,
        solved_from=tuple(solved_from),
        residual_px={n: round(v, 3) for n, v in alignment.residual_px.items()},
        support=dict(alignment.support),
        weak=alignment.weak,
    )


def _tell_of_weak(alignment: Alignment, frames: FrameRange, progress: Progress) -> None:
    for weak in alignment.weak:
        progress.note(f"frames {frames}: camera {weak.camera} is weak: {weak.reason}")


def _without(alignment: Alignment, wrong: Mapping[str, Agreement]) -> Alignment:
    """The alignment without the cameras that the pictures refute, which are weak."""
    return alignment.without(
        Weak(
            name,
            f"where its matches lay it, only {found.found} of {found.tried} places look as in the other cameras, "
            "no more than by chance: they show different things, or hardly overlap",
        )
        for name, found in sorted(wrong.items())
    )


def _degree_of_occlusion(samples: Samples, position: int) -> float:
    pictures = samples[position].pictures.values()
    return degree_of_occlusion([field_area(picture) for picture in pictures if picture is not None])
