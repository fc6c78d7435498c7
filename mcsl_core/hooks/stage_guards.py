"""What each stage's protocol promises, held at every call: a guard for each stage, by its name in `GUARDS`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fractions import Fraction
from typing import Any

import attrs
import numpy as np
from attrs import frozen
from numpy.typing import NDArray

from mcsl_core.alignment.aligned_views import AlignedPose, AlignedView
from mcsl_core.alignment.correspondences import Correspondences
from mcsl_core.alignment.protocol import Alignment, Features
from mcsl_core.alignment.relief.protocol import ReliefScene, ReliefSurface
from mcsl_core.alignment.tracking.lamp import Lamp, LampView
from mcsl_core.alignment.tracking.protocol import End, Instant
from mcsl_core.centering.protocol import FieldPosition
from mcsl_core.edl import CenteringKey, Movement, Shot, Weak
from mcsl_core.filling.protocol import FillContext
from mcsl_core.imaging.planes import Planes
from mcsl_core.movement.protocol import Curve, Detection
from mcsl_core.occlusion.score_table import ScoreTable
from mcsl_core.progress import Progress
from mcsl_core.recording.footage import Footage
from mcsl_core.recording.sample_store import SampleStore
from mcsl_core.selection.protocol import MIN_SHOT_S
from mcsl_core.timing import check_tiles

from .guards import Guard, described, is_number, read_only

_FARTHEST = 10.0  # of a view's numbers: whole turns and distances, no movement of a lamp


class MovementGuard(Guard):
    """Of a `MovementDetector`: movements in order and within the programme, and a curve whose frames rise."""

    def detect(self, samples: SampleStore, footage: Footage, progress: Progress) -> Detection:
        own = attrs.evolve(samples, frames=tuple(samples.frames))  # pyright: ignore[reportArgumentType]
        found = self.call("detect", own, footage, progress)
        self.need_kind("detect", found, Detection)
        end = 0
        for movement in found.movements:
            self.need_kind("detect", movement, Movement)
            self.need(movement.range.start >= end, f"detect gave movement {movement.range}, which begins before {end}")
            end = movement.range.stop
        self.need(end <= footage.frames, f"detect gave a movement up to {end}, beyond the {footage.frames} frames")
        self.need_kind("detect", found.curve, Curve)
        self.need(bool((np.diff(found.curve.frames) > 0).all()), "detect gave a curve whose frames do not rise")
        return attrs.evolve(found, movements=tuple(found.movements))


class MatcherGuard(Guard):
    """Of a `Matcher`: points inside the picture, descriptors of unit length, no point matched twice."""

    def features(self, picture: NDArray[np.uint8], mask: NDArray[np.uint8] | None = None) -> Features:
        found = self.call("features", read_only(picture), None if mask is None else read_only(mask))
        self.need_kind("features", found, Features)
        size = (picture.shape[1], picture.shape[0])
        self.need(found.size == size, f"features gave the size {described(found.size)} for a picture of {size}")
        inside = (found.points > -1) & (found.points < size)  # false for NaN too
        self.need(bool(inside.all()), f"features gave points that are not inside the picture of {size}")
        self.need(
            found.descriptors.ndim == 2, f"features gave {described(found.descriptors)} as descriptors, expected 2-D"
        )
        length = np.linalg.norm(found.descriptors, axis=1)
        self.need(bool((np.abs(length - 1) < 0.01).all()), "features gave descriptors that are not of unit length")
        return read_only(found)

    def match(self, a: Features, b: Features) -> NDArray[np.intp]:
        pairs = np.asarray(self.call("match", a, b))
        self.need(pairs.ndim == 2 and pairs.shape[1] == 2, f"match gave {described(pairs)}, expected (M, 2) indices")
        if not len(pairs):
            return np.zeros((0, 2), np.intp)
        self.need(pairs.dtype.kind in "iu", f"match gave {described(pairs)}, expected integers")
        for column, features in enumerate((a, b)):
            own, count = pairs[:, column], len(features.points)
            self.need(own.min() >= 0 and own.max() < count, f"match gave an index outside of {count} points")
            self.need(len(np.unique(own)) == len(own), "match gave a point twice")
        return pairs.astype(np.intp)


class AlignerGuard(Guard):
    """Of an `Aligner`: every camera tied in or named weak with a reason, proper homographies."""

    def align(
        self,
        pairs: Mapping[tuple[str, str], Correspondences],
        sizes: Mapping[str, tuple[int, int]],
        reference: str,
    ) -> Alignment:
        found = self.call("align", read_only(pairs), read_only(sizes), reference)
        self.need_kind("align", found, Alignment)
        for weak in found.weak:
            self.need_kind("align", weak, Weak)
        tied, weak = set(found.homographies), [w.camera for w in found.weak]
        missing = sorted(set(sizes) - tied - set(weak))
        self.need(not missing, f"align gave neither a homography nor a reason for {', '.join(missing)}")
        unknown = sorted((tied | set(weak)) - set(sizes))
        self.need(not unknown, f"align gave {', '.join(unknown)}, which no camera is named")
        twice = sorted(tied & set(weak))
        self.need(not twice, f"align gave both a homography and a reason for {', '.join(twice)}")
        self.need(reference in tied, f"align gave no homography for the reference {reference}")
        for camera, matrix in found.homographies.items():
            good = np.shape(matrix) == (3, 3) and np.isfinite(matrix).all() and abs(np.linalg.det(matrix)) > 1e-12
            self.need(bool(good) and abs(matrix[2][2] - 1) < 1e-6, f"align gave {described(matrix)} for {camera}")
        for what, of in (("residual_px", found.residual_px), ("support", found.support)):
            self.need(set(of) == tied - {reference}, f"align gave {what} of {sorted(of)}, expected all tied but one")
            for camera, value in of.items():
                self.need(is_number(value) and value >= 0, f"align gave {described(value)} as {what} of {camera}")
        return attrs.evolve(found, weak=tuple(found.weak))


class ReliefGuard(Guard):
    """Of a `ReliefEstimator`: nothing, or finite nodes with their confidence, and cameras that there are."""

    def estimate(self, scene: ReliefScene) -> ReliefSurface | None:
        if (found := self.call("estimate", read_only(scene))) is None:
            return None
        self.need_kind("estimate", found, ReliefSurface)
        gamma, confidence = np.asarray(found.gamma), np.asarray(found.confidence)
        for what, nodes in (("gamma", gamma), ("confidence", confidence)):
            good = nodes.ndim == 2 and min(nodes.shape) > 1 and nodes.dtype.kind == "f" and np.isfinite(nodes).all()
            self.need(bool(good), f"estimate gave {described(nodes)} as {what}, expected finite nodes")
        self.need(gamma.shape == confidence.shape, f"estimate gave gamma {gamma.shape}, confidence {confidence.shape}")
        self.need(bool((np.abs(confidence - 0.5) <= 0.5).all()), "estimate gave a confidence outside of 0..1")
        unknown = ", ".join(sorted(set(found.cameras) - set(scene.cameras)))
        self.need(not unknown, f"estimate gave {unknown}, which no camera is named")
        return ReliefSurface(gamma, confidence, frozenset(found.cameras))


class TrackerGuard(Guard):
    """Of a `Tracker`: for every instant where the lamp stands, in finite numbers, or nothing."""

    def follow(self, lamp: Lamp, before: End, after: End, instants: Sequence[Instant]) -> list[LampView | None]:
        found = self.call("follow", *read_only((lamp, before, after, tuple(instants))))
        self.need_kind("follow", found, Sequence)
        self.need(len(found) == len(instants), f"follow gave {len(found)} views of {len(instants)} instants")
        return [self._view(view, instant.frame) for view, instant in zip(found, instants, strict=True)]

    def _view(self, view: LampView | None, frame: int) -> LampView | None:
        if view is None:
            return None
        self.need_kind("follow", view, LampView)
        for what, vector in (("turn", view.turn), ("shift", view.shift)):
            good = isinstance(vector, np.ndarray) and vector.shape == (3,) and vector.dtype.kind in "fiu"
            told = f"follow gave {described(vector)} as {what} at frame {frame}, expected 3 finite numbers"
            self.need(good and bool(np.isfinite(vector).all()), told)
        self.need(
            is_number(view.zoom), f"follow gave {described(view.zoom)} as zoom at frame {frame}, expected a number"
        )
        told = f"follow gave a view at frame {frame} with numbers of {_FARTHEST} and more, in radians and distances"
        self.need(bool((np.abs(view.numbers) < _FARTHEST).all()), told)
        return LampView.of(view.numbers)


@frozen(eq=False)
class _Samples(Sequence[Sequence[AlignedView]]):
    """Samples whose views cannot be written to; each is read only when it is asked for, as a slice's are."""

    samples: Sequence[Sequence[AlignedView]]
    positions: range

    def __len__(self) -> int:
        return len(self.positions)

    def __getitem__(self, at):  # pyright: ignore[reportIncompatibleMethodOverride]
        found = self.positions[at]
        if isinstance(found, range):
            return _Samples(self.samples, found)
        return read_only(tuple(self.samples[found]))


@frozen(eq=False)
class ScorerGuard:
    """An occlusion detector's scorer behind the same checks.

    Attributes
    ----------
    guard : Guard
        The detector's.
    scorer : object
        What it returned.
    """

    guard: Guard
    scorer: Any

    def score(self, views: Sequence[AlignedView]) -> Mapping[str, float]:
        scores = self.guard.call("score", read_only(tuple(views)), on=self.scorer)
        self.guard.need_kind("score", scores, Mapping)
        for view in views:
            value = scores.get(view.camera)
            good = is_number(value) and 0 <= value <= 1
            self.guard.need(good, f"score gave {described(value)} for camera {view.camera}, expected a number in 0..1")
        return {view.camera: float(scores[view.camera]) for view in views}


class OcclusionGuard(Guard):
    """Of an `OcclusionDetector`: something that has a `score`."""

    def scorer(self, aligned: AlignedPose, samples: Sequence[Sequence[AlignedView]]) -> ScorerGuard:
        scorer = self.call("scorer", read_only(aligned), _Samples(samples, range(len(samples))))
        self.need(callable(getattr(scorer, "score", None)), f"scorer gave {described(scorer)}, which has no score")
        return ScorerGuard(self, scorer)


class SelectorGuard(Guard):
    """Of a `Selector`: shots of known cameras that tile the programme, none shorter than it promises."""

    @property
    def min_shot_s(self) -> float:
        """The minimum shot length that the selector promises, in seconds; `MIN_SHOT_S` where it promises none."""
        promised = getattr(self.implementation, "min_shot_s", MIN_SHOT_S)
        good = is_number(promised) and promised >= 0
        self.need(good, f"min_shot_s is {described(promised)}, expected seconds of 0 or more")
        return float(promised)

    def select(self, table: ScoreTable, *, frames: int, rate: Fraction) -> tuple[Shot, ...]:
        shots = self.call("select", read_only(table), frames=frames, rate=rate)
        self.need_kind("select", shots, Sequence)
        for shot in shots:
            self.need_kind("select", shot, Shot)
        unknown = sorted({s.camera for s in shots} - set(table.cameras))
        self.need(not unknown, f"select chose camera {unknown[:1]}, expected one of {', '.join(table.cameras)}")
        try:
            check_tiles((s.range for s in shots), frames, "shots")
        except ValueError as error:
            raise self.fault(f"select gave shots with a gap or an overlap: {error}") from error
        return tuple(shots)


class CentererGuard(Guard):
    """Of a `Centerer`: keys in order, within the programme, no shift larger than it."""

    def centre(
        self, positions: Sequence[FieldPosition], *, size: tuple[int, int], rate: float
    ) -> tuple[CenteringKey, ...]:
        keys = self.call("centre", tuple(positions), size=size, rate=rate)
        self.need_kind("centre", keys, Sequence)
        frames = max((p.range.stop for p in positions), default=0)
        made: list[CenteringKey] = []
        for key in keys:
            good = isinstance(key, Sequence) and len(key) == 3 and all(is_number(value) for value in key)
            self.need(good, f"centre gave {described(key)}, expected (frame, dx, dy)")
            frame, dx, dy = int(key[0]), float(key[1]), float(key[2])
            self.need(frame == key[0] and 0 <= frame < frames, f"centre gave a key at {key[0]} of {frames} frames")
            self.need(not made or frame > made[-1][0], f"centre gave the keys' frames out of order at {frame}")
            near = abs(dx) <= size[0] and abs(dy) <= size[1]
            self.need(near, f"centre gave a shift of ({dx:g}, {dy:g}), larger than the programme")
            made.append((frame, dx, dy))
        return tuple(made)


class _FrozenContext:
    """A programme frame before filling, whose pictures cannot be written to: they may be the decoder's own memory."""

    def __init__(self, context: FillContext) -> None:
        self._context = context
        self.front = read_only(context.front)
        self.previous = read_only(context.previous)

    def __getattr__(self, name: str) -> Any:
        return getattr(self._context, name)

    def footprint(self, *given: Any, **named: Any) -> Any:
        return read_only(self._context.footprint(*given, **named))

    def picture(self, *given: Any, **named: Any) -> Any:
        return read_only(self._context.picture(*given, **named))


class FillerGuard(Guard):
    """Of a `Filler`: a picture of the programme's size."""

    @property
    def version(self) -> int:
        return self.implementation.version

    @property
    def remembers(self) -> bool:
        return self.implementation.remembers

    def fill(self, context: FillContext) -> Planes:
        shown = _FrozenContext(context)
        filled = self.call("fill", shown)
        if filled is shown.front:
            return context.front
        self.need_kind("fill", filled, Planes)
        self.need(filled.size == context.size, f"fill gave a picture of {filled.size}, expected {context.size}")
        return filled


GUARDS: Mapping[str, type[Guard]] = {
    "movement": MovementGuard,
    "matcher": MatcherGuard,
    "aligner": AlignerGuard,
    "relief": ReliefGuard,
    "tracker": TrackerGuard,
    "occlusion": OcclusionGuard,
    "selector": SelectorGuard,
    "centerer": CentererGuard,
    "filler": FillerGuard,
}
