"""How much of the field every camera shows: the poses in stretches, each with a scorer made from its own moments."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cached_property

import numpy as np
from attrs import frozen
from numpy.typing import NDArray

from .edl import Movement
from .evidence import SolvedPose
from .hookspecs import OcclusionScorer
from .plugins import Offer
from .progress import Progress
from .samples import Samples
from .scene import Scene, View
from .scores import ScoreTable
from .timing import FrameRange

# Samples that one scorer is made from. The field changes in a long pose: it bleeds, it is opened further; in three
# minutes hands and heads have moved on often enough.
STRETCH = 180


@frozen(eq=False)
class Moments(Sequence[tuple[View, ...]]):
    """The views of some samples, read when they are asked for."""

    samples: Samples
    scene: Scene
    positions: NDArray[np.int64]

    def __len__(self) -> int:
        return len(self.positions)

    def __getitem__(self, at):  # pyright: ignore[reportIncompatibleMethodOverride]
        return self.scene.views(self.samples[int(self.positions[at])].pictures)


@frozen(eq=False)
class Stretch:
    """Part of a pose in which the lamp stands still, and what scores its moments: those of samples and any other."""

    range: FrameRange
    moments: Moments
    detector: Offer

    @cached_property
    def scorer(self) -> OcclusionScorer:
        """Made at first use: where all scores are in the cache, only around switches."""
        return self.detector.checked.scorer(self.moments.scene, self.moments)

    def score(self, views: Sequence[View]) -> Mapping[str, float]:
        """camera -> visible share of the field for every view."""
        return self.scorer.score(views)


def stretches(
    samples: Samples, solved: Sequence[SolvedPose], movements: Sequence[Movement], detector: Offer
) -> tuple[Stretch, ...]:
    """Every pose in stretches of about `STRETCH` samples, in order of time."""
    made = []
    for pose in solved:
        still = samples.standing(pose.pose.range, movements)
        if not still:
            continue
        parts = np.array_split(np.array(still), max(1, round(len(still) / STRETCH)))
        edges = [pose.pose.range.start, *(samples.frames[int(p[0])] for p in parts[1:]), pose.pose.range.stop]
        for part, start, stop in zip(parts, edges, edges[1:], strict=False):
            made.append(Stretch(FrameRange(start, stop), Moments(samples, pose.scene, part), detector))
    return tuple(made)


def score_views(
    samples: Samples,
    solved: Sequence[SolvedPose],
    pieces: Sequence[Stretch],
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
