"""A classifier trained on a few frames that somebody marked, as mcsl's occlusion detector.

`mcsl-label` exports the frames and trains; `--occlusion learned` detects, with the model that MCSL_LEARNED_MODEL names.
"""

from __future__ import annotations

import hashlib
import os
from collections.abc import Mapping, Sequence
from functools import lru_cache
from pathlib import Path

import cv2
import numpy as np
from attrs import evolve, field, frozen

from mcsl_core.hooks import AlignedPose, AlignedView, Cut, Mask, UsageError, hookimpl, main_region

from .features import REACH, Box, Float, Seen, Usual, backgrounds, features, seen_of, usual_of, whole
from .model import Model

VARIABLE = "MCSL_LEARNED_MODEL"


@frozen(repr=False)
class LearnedOcclusion:
    """The visible field by a classifier trained on frames that you mark with mcsl-label. Named by MCSL_LEARNED_MODEL.

    looks: so many samples of a stretch are classified to find where the field lies, by a model that knows the field
    from what lies elsewhere; else the field is where mcsl takes it to be.
    """

    looks: int = field(default=8)
    name = "learned"

    def prepare(self) -> None:
        """Loads the model, so that one that is missing or wrong is refused before any work is done."""
        chosen_model()

    def scorer(self, aligned: AlignedPose, samples: Sequence[Sequence[AlignedView]]) -> LearnedScorer:
        """A scorer for the stretch of a pose that ``samples`` were taken from."""
        model, cut = chosen_model(), whole(aligned)
        usual = usual_of(backgrounds(aligned, samples)) if len(samples) else {}
        scorer = LearnedScorer(model, cut, usual, cut.mask(aligned.field))
        if "elsewhere" not in model.classes or not len(samples):
            return scorer.trimmed()
        positions = np.unique(np.linspace(0, len(samples) - 1, min(self.looks, len(samples))).astype(int))
        place = scorer.field([samples[position] for position in positions])
        return evolve(scorer, place=place if place.any() else scorer.place).trimmed()

    def __repr__(self) -> str:
        """With the model's fingerprint: results in the cache are those of this model."""
        path = os.environ.get(VARIABLE)
        return f"LearnedOcclusion(looks={self.looks}, model={path and fingerprint(Path(path))})"


@frozen(eq=False)
class LearnedScorer:
    """Scores samples of one stretch of a pose. usual: how each view looks with nothing before it. place: (h, w), the
    field. box: the part of the aligned pose that is looked at, rows and columns; all three are of the same shape."""

    model: Model
    cut: Cut
    usual: Mapping[str, Usual]
    place: Mask
    box: Box = (slice(None), slice(None))

    def trimmed(self) -> LearnedScorer:
        """The same for the surroundings of its place only, in a fraction of the time."""
        if not self.place.any():
            return self
        along = (np.flatnonzero(self.place.any(axis=axis)) for axis in (1, 0))
        rows, columns = (slice(max(0, int(at[0]) - REACH), int(at[-1]) + REACH + 1) for at in along)
        box = rows, columns
        usual = {name: view.part(box) for name, view in self.usual.items()}
        return LearnedScorer(self.model, self.cut, usual, self.place[box], box)

    def score(self, views: Sequence[AlignedView]) -> Mapping[str, float]:
        """camera -> visible share of the field, 0..1."""
        area = max(int(self.place.sum()), 1)
        visible = self.visible(views)
        return {name: float(np.count_nonzero(self.place & mask)) / area for name, mask in visible.items()}

    def visible(self, views: Sequence[AlignedView]) -> dict[str, Mask]:
        """camera -> (h, w) bool in the box: where nothing is in the way."""
        seen = self._seen(views)
        way = self.model.classes.index("in the way")
        return {
            name: seen[name].inside & (cv2.blur(np.ascontiguousarray(shares[..., way]), (5, 5)) < 0.5)
            for name, shares in self._shares(seen).items()
        }

    def field(self, samples: Sequence[Sequence[AlignedView]]) -> Mask:
        """(h, w) bool: where the field lies, by all views of some samples; what is in the way has no vote."""
        shown, elsewhere = (np.zeros(self.place.shape, np.float32) for _ in range(2))
        for views in samples:
            seen = self._seen(views)
            for name, shares in self._shares(seen).items():
                shown += shares[..., self.model.classes.index("field")] * seen[name].inside
                elsewhere += shares[..., self.model.classes.index("elsewhere")] * seen[name].inside
        return main_region(cv2.blur(shown, (5, 5)) > cv2.blur(elsewhere, (5, 5)))

    def _seen(self, views: Sequence[AlignedView]) -> dict[str, Seen]:
        return {
            name: Seen(np.ascontiguousarray(view.picture[self.box]), view.inside[self.box])
            for name, view in seen_of(views, self.cut).items()
        }

    def _shares(self, seen: Mapping[str, Seen]) -> dict[str, Float]:
        """camera -> (h, w, classes) probabilities."""
        found = features(seen, self.usual, list(seen))
        return {name: self.model.probabilities(values) for name, values in found.items()}


def chosen_model() -> Model:
    """The model that MCSL_LEARNED_MODEL names; UsageError where it names none."""
    path = os.environ.get(VARIABLE)
    if not path:
        raise UsageError(
            "no model is named",
            where="--occlusion learned",
            remedy=f"Set the environment variable {VARIABLE} to a model that `mcsl-label train` made",
        )
    return _loaded(Path(path).absolute(), fingerprint(Path(path)))


@lru_cache(maxsize=2)
def _loaded(path: Path, fingerprint: str) -> Model:
    return Model.load(path)


def fingerprint(path: Path) -> str:
    """Of the file's content; empty where there is none."""
    if not path.is_file():
        return ""
    with path.open("rb") as file:  # by pieces: what is named may be no model, and of any size
        return hashlib.file_digest(file, "sha256").hexdigest()[:24]


@hookimpl
def register_occlusion_detectors():
    return [LearnedOcclusion()]
