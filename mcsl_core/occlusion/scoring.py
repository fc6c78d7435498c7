"""How much of the field every camera shows: the poses in scoring segments, each with a scorer made from its samples."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cached_property

import attrs
import numpy as np
from attrs import frozen
from numpy.typing import NDArray

from mcsl_core.alignment.aligned_views import AlignedPose, AlignedView, Picture
from mcsl_core.alignment.observations import SolvedPose
from mcsl_core.alignment.tracking.followed_views import aligned_at
from mcsl_core.edl import Movement
from mcsl_core.imaging.geometry import Array
from mcsl_core.progress import Progress
from mcsl_core.recording.sample_store import SampleStore
from mcsl_core.timing import FrameRange

from .protocol import OcclusionDetector, OcclusionScorer
from .score_table import ScoreTable

# Samples that one scorer is made from. The field changes in a long pose: it bleeds, it is opened further; in three
# minutes hands and heads have moved on often enough.
SEGMENT_SAMPLES = 180


@frozen(eq=False)
class SegmentSamples(Sequence[tuple[AlignedView, ...]]):
    """The views of some samples, read when they are asked for.

    Attributes
    ----------
    store : SampleStore
        What they are read from.
    aligned : AlignedPose
        The pose they are laid into.
    positions : (N,) int array
        Their positions in ``store``.
    """

    store: SampleStore
    aligned: AlignedPose
    positions: NDArray[np.int64]

    def __len__(self) -> int:
        return len(self.positions)

    def __getitem__(self, at):  # pyright: ignore[reportIncompatibleMethodOverride]
        return self.aligned.views(self.store[int(self.positions[at])].pictures)


@frozen(eq=False)
class ScoringSegment:
    """Part of a pose in which the lamp stands still, and what scores its frames: those of samples and any other.

    Attributes
    ----------
    range : FrameRange
        Its programme frames.
    samples : SegmentSamples
        The views that its scorer is made from.
    detector : OcclusionDetector
        What makes the scorer.
    anchor : (3, 3) array
        The pose's reference camera's pixel -> programme pixel.
    movements : sequence of Movement
        Those that are followed have views.
    """

    range: FrameRange
    samples: SegmentSamples
    detector: OcclusionDetector
    anchor: Array = attrs.field(factory=lambda: np.eye(3))
    movements: Sequence[Movement] = ()

    @cached_property
    def scorer(self) -> OcclusionScorer:
        """The segment's scorer, made at first use: where all scores are in the cache, only around switches."""
        return self.detector.scorer(self.samples.aligned, self.samples)

    def views(self, pictures: Mapping[str, Picture | None], shown: Mapping[str, float]) -> tuple[AlignedView, ...]:
        """The views of one frame; ``shown``: camera -> when its picture was taken, in programme frames."""
        return aligned_at(self.samples.aligned, self.anchor, self.movements, shown).views(pictures)

    def score(self, views: Sequence[AlignedView]) -> Mapping[str, float]:
        """Scores the views of one frame; see `OcclusionScorer.score`."""
        return self.scorer.score(views)


def scoring_segments(
    samples: SampleStore, solved: Sequence[SolvedPose], movements: Sequence[Movement], detector: OcclusionDetector
) -> tuple[ScoringSegment, ...]:
    """Cuts every pose where its field changes, and into segments of about `SEGMENT_SAMPLES` samples.

    Parameters
    ----------
    samples : SampleStore
        The recording's samples.
    solved : sequence of SolvedPose
        In order of time.
    movements : sequence of Movement
        Samples in them belong to no segment.
    detector : OcclusionDetector
        What scores.

    Returns
    -------
    tuple of ScoringSegment
        In order of time; those of a pose tile its range. A pose that never stands still has none.
    """
    segments = []
    for pose in solved:
        still = samples.standing(pose.pose.range, movements)
        parts = [
            (part, attrs.evolve(pose.aligned, field=mask))
            for piece, mask, _ in pose.fields()
            if (own := [position for position in still if samples.frames[position] in piece])
            for part in np.array_split(np.array(own), max(1, round(len(own) / SEGMENT_SAMPLES)))
        ]
        edges = [pose.pose.range.start, *(samples.frames[int(part[0])] for part, _ in parts[1:]), pose.pose.range.stop]
        for (part, aligned), start, stop in zip(parts, edges, edges[1:], strict=False):
            views = SegmentSamples(samples, aligned, part)
            anchor = np.array(pose.pose.anchor)
            segments.append(ScoringSegment(FrameRange(start, stop), views, detector, anchor, movements))
    return tuple(segments)


def score_views(
    samples: SampleStore,
    solved: Sequence[SolvedPose],
    segments: Sequence[ScoringSegment],
    movements: Sequence[Movement],
    progress: Progress,
) -> ScoreTable:
    """Scores every camera at every sample.

    Parameters
    ----------
    samples : SampleStore
        The recording's samples.
    solved : sequence of SolvedPose
        Tiling the programme.
    segments : sequence of ScoringSegment
        Those of ``solved``.
    movements : sequence of Movement
        In them there is no data, unless they are followed.
    progress : Progress
        Told of every sample.

    Returns
    -------
    ScoreTable
        Each score stands at the frame that its picture really belongs to; a picture of a moving lamp has none.
    """
    progress.stage("Scoring the views", len(samples), "samples")
    visible = np.full((len(samples), len(samples.cameras)), np.nan)
    usable = np.zeros(visible.shape, bool)
    shown = np.repeat(np.array(samples.frames, np.int64)[:, None], len(samples.cameras), axis=1)
    held = [movement for movement in movements if not movement.views]
    for pose in solved:
        still = set(samples.standing(pose.pose.range, held))
        for position in samples.within(pose.pose.range):
            sample = samples[position]
            taken = {name: float(sample.shown_frames.get(name, sample.frame)) for name in sample.pictures}
            views = aligned_at(pose.aligned, np.array(pose.pose.anchor), movements, taken).views(sample.pictures)
            segment = next((s for s in segments if sample.frame in s.range), None) if position in still else None
            scores = {} if segment is None else segment.score(views)
            for view in views:
                column = samples.cameras.index(view.camera)
                frame = shown[position, column] = sample.shown_frames.get(view.camera, sample.frame)
                usable[position, column] = True
                # A camera may run before the programme begins and after it ends.
                within = min(max(frame, solved[0].pose.range.start), solved[-1].pose.range.stop - 1)
                if within in pose.pose.range and not any(within in m.range for m in held):
                    visible[position, column] = scores.get(view.camera, np.nan)
            progress.advance(position + 1)
    return ScoreTable(np.array(samples.frames), samples.cameras, visible, usable, shown=shown)
