"""How much of the field every camera shows: the poses in stretches, each with a scorer made from its own moments."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cached_property

import numpy as np
from attrs import frozen
from numpy.typing import NDArray

from mcsl_core.alignment.aligned_views import AlignedPose, AlignedView
from mcsl_core.alignment.observations import SolvedPose
from mcsl_core.edl import Movement
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
    """The views of some samples, read when they are asked for."""

    samples: SampleStore
    scene: AlignedPose
    positions: NDArray[np.int64]

    def __len__(self) -> int:
        return len(self.positions)

    def __getitem__(self, at):  # pyright: ignore[reportIncompatibleMethodOverride]
        return self.scene.views(self.samples[int(self.positions[at])].pictures)


@frozen(eq=False)
class ScoringSegment:
    """Part of a pose in which the lamp stands still, and what scores its moments: those of samples and any other."""

    range: FrameRange
    moments: SegmentSamples
    detector: OcclusionDetector

    @cached_property
    def scorer(self) -> OcclusionScorer:
        """Made at first use: where all scores are in the cache, only around switches."""
        return self.detector.scorer(self.moments.scene, self.moments)

    def score(self, views: Sequence[AlignedView]) -> Mapping[str, float]:
        """camera -> visible share of the field for every view."""
        return self.scorer.score(views)


def scoring_segments(
    samples: SampleStore, solved: Sequence[SolvedPose], movements: Sequence[Movement], detector: OcclusionDetector
) -> tuple[ScoringSegment, ...]:
    """Every pose in stretches of about `STRETCH` samples, in order of time."""
    made = []
    for pose in solved:
        still = samples.standing(pose.pose.range, movements)
        if not still:
            continue
        parts = np.array_split(np.array(still), max(1, round(len(still) / SEGMENT_SAMPLES)))
        edges = [pose.pose.range.start, *(samples.frames[int(p[0])] for p in parts[1:]), pose.pose.range.stop]
        for part, start, stop in zip(parts, edges, edges[1:], strict=False):
            made.append(ScoringSegment(FrameRange(start, stop), SegmentSamples(samples, pose.scene, part), detector))
    return tuple(made)


def score_views(
    samples: SampleStore,
    solved: Sequence[SolvedPose],
    pieces: Sequence[ScoringSegment],
    movements: Sequence[Movement],
    progress: Progress,
) -> ScoreTable:
    """The visible field of every camera at every sample; no data while the lamp moves."""
    progress.stage("Scoring the views", len(samples), "samples")
    visible = np.full((len(samples), len(samples.cameras)), np.nan)
    usable = np.zeros(visible.shape, bool)
    for pose in solved:
        still = set(samples.standing(pose.pose.range, movements))
        for i in samples.within(pose.pose.range):
            moment = samples[i]
            views = pose.scene.views(moment.pictures)
            piece = None if i not in still else next((p for p in pieces if moment.frame in p.range), None)
            scores = {} if piece is None else piece.score(views)
            for view in views:
                column = samples.cameras.index(view.camera)
                usable[i, column] = True
                visible[i, column] = scores.get(view.camera, np.nan)
            progress.advance(i + 1)
    return ScoreTable(np.array(samples.frames), samples.cameras, visible, usable)
