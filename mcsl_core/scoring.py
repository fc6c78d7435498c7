"""How much of the field every camera shows at every sample: each pose's detector, asked in order of time."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from .edl import Movement
from .errors import PluginError
from .evidence import SolvedPose
from .plugins import Offer
from .progress import Progress
from .samples import Samples
from .scores import ScoreTable


def score_views(
    samples: Samples,
    solved: Sequence[SolvedPose],
    movements: Sequence[Movement],
    detector: Offer,
    progress: Progress,
) -> ScoreTable:
    """The visible field of every camera at every sample; no data while the lamp moves."""
    progress.stage("Scoring the views", len(samples), "samples")
    visible = np.full((len(samples), len(samples.cameras)), np.nan)
    usable = np.zeros(visible.shape, bool)
    for pose in solved:
        scorer = detector.implementation.scorer(pose.scene)
        for i in samples.within(pose.pose.range):
            moment = samples[i]
            moving = any(moment.frame in m.range for m in movements)
            views = pose.scene.views(moment.pictures)
            scores = {} if moving else _checked(scorer.score(views), [v.camera for v in views], detector)
            for view in views:
                column = samples.cameras.index(view.camera)
                usable[i, column] = True
                visible[i, column] = scores.get(view.camera, np.nan)
            progress.advance(i + 1)
    return ScoreTable(np.array(samples.frames), samples.cameras, visible, usable)


def _checked(scores: Mapping[str, float], cameras: Sequence[str], detector: Offer) -> Mapping[str, float]:
    """What a detector returned, refused by name when it is not one number in 0..1 for every view."""
    for camera in cameras:
        value = scores.get(camera)
        if value is None or not 0 <= value <= 1:
            raise PluginError(
                f"gave {value!r} for camera {camera}, expected a number in 0..1",
                where=f"occlusion detector {detector}",
                remedy="Report it to its author, or choose another with --occlusion",
            )
    return scores
