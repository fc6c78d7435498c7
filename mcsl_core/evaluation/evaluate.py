"""How steady a programme is, by the paper's measures, and the programmes that it is held against.

ITF is the mean PSNR between neighbouring frames, AvSpeed the mean distance that a feature point moves from one frame
to the next (the paper's section on evaluation metrics). Every variant shows the same shots at the same size, all made
by the compositor; docs/evaluation.md says how each figure comes about.
"""

from __future__ import annotations

import math
from collections.abc import Hashable, Iterator, Mapping, Sequence
from contextlib import closing
from itertools import groupby
from pathlib import Path

import attrs
import cv2
import numpy as np
from attrs import frozen
from numpy.typing import NDArray

from mcsl_core.compositing.compositor import Compositor
from mcsl_core.compositing.coverage import Coverage, has_picture
from mcsl_core.compositing.placement import programme_matrix
from mcsl_core.compositing.proxy import SharedFootage, reduced, reduced_filler, reduced_size
from mcsl_core.edl import IDENTITY, Edl, Look
from mcsl_core.edl.placement import placement_matrix
from mcsl_core.edl.resolve import Decision, offset_at, resolve, shift_at
from mcsl_core.errors import UsageError
from mcsl_core.imaging.planes import U8, Planes
from mcsl_core.progress import Progress, Silent
from mcsl_core.timing import FrameRange

from .manual_alignment import ByHand, aligned_by_hand
from .metrics import NO_TRACKS, Tracker, Tracks, carried, fidelity_db, grey, speed_px
from .results import FIELD, Conditions, Evaluation, Measured, Pair, Steadiness, Switch

WIDTH = 640  # of the pictures measured: the paper names none


def without_alignment(edl: Edl) -> Edl:
    """The same shots with every view as its camera saw it (the paper's No-alignment): no warp, no look."""
    names = [c.name for c in edl.cameras]
    poses = tuple(
        attrs.evolve(p, homographies=dict.fromkeys(names, IDENTITY), anchor=IDENTITY, weak=()) for p in edl.poses
    )
    return attrs.evolve(edl, poses=poses, corrections=(), look=Look(centering=False, fill=False, colour=False))


# -------------------------------------------------------------------------------------------------------- variants


@frozen
class Variant:
    """A programme to be measured. name: for programs; label: for people. look: in place of the EDL's; None keeps it."""

    name: str
    label: str
    edl: Edl
    look: Look | None = None


def standard_variants(edl: Edl, *, manual: ByHand | None = None, colour: bool = False) -> tuple[Variant, ...]:
    """The paper's comparison: no, manual (where given), auto, centered, filled; then the programme as it is delivered.

    manual: pose index -> camera -> camera pixel to programme pixel. colour: whether the cameras' colours are matched,
    in all alike, since it changes the PSNR whatever the alignment is; the delivered programme has the EDL's own look.
    """
    plain = Look(centering=False, fill=False, colour=colour)
    found = [Variant("no", "No-alignment", without_alignment(edl), plain)]
    if manual is not None:
        found.append(Variant("manual", "Manual-alignment", aligned_by_hand(edl, manual), plain))
    found += [
        Variant("auto", "Auto", edl, plain),
        Variant("centered", "Auto + centered", edl, attrs.evolve(plain, centering=True)),
        Variant("filled", "Auto + centered + filled", edl, attrs.evolve(plain, centering=True, fill=True)),
        Variant("delivered", "As delivered", edl),
    ]
    return tuple(found)


# ------------------------------------------------------------------------------------------------------- measuring


def evaluate(
    edl: Edl,
    base: Path,
    variants: Sequence[Variant] | None = None,
    *,
    width: int = WIDTH,
    every: int = 1,
    most_switches: int | None = None,
    progress: Progress | None = None,
) -> Evaluation:
    """Measures ``variants`` (`standard_variants` without) of one programme.

    base: the folder that media paths are relative to. width: of the pictures measured, the programme's at most. every:
    of the pairs of neighbouring frames within a shot one in so many is measured and stands for the others, 0 for none
    of them; the pairs at switches are measured all, or with ``most_switches`` so many, spread evenly. Every camera
    is decoded once for all variants. UsageError where a variant has other shots; else raises what reading raises.
    """
    if every < 0 or width < 16:
        raise UsageError(f"every must be 0 or more and the width 16 or more, got {every} and {width}")
    progress = progress or Silent()
    variants = standard_variants(edl) if variants is None else tuple(variants)
    for variant in variants:
        if _cuts(variant.edl) != _cuts(edl) or variant.edl.frames != edl.frames or variant.edl.cameras != edl.cameras:
            raise UsageError(f"the variant {variant.name!r} does not show the same shots of the same cameras")
    switches = every_switch = _switches(edl)
    if most_switches is not None and len(switches) > most_switches:
        switches = tuple(switches[i * len(switches) // most_switches] for i in range(most_switches))
    at_switches, cuts = ({s.frame - 1 for s in group} for group in (switches, every_switch))
    within = {j for j in range(0, edl.frames - 1, every) if j not in cuts} if every else set()
    size = reduced_size(edl.size, width)
    results: list[dict[int, Pair]] = [{} for _ in variants]
    progress.stage("Measuring the programme", len(at_switches | within), "pairs")
    done = 0
    with closing(SharedFootage(edl, base, size)) as footage:
        followed = _Followed(reduced(edl, size), footage)
        eyes = [_Eye(variant, footage, size) for variant in variants]
        for run in _runs(at_switches | within):
            for eye in eyes:
                eye.begin(run)
            for frame in run:
                followed.advance(frame)
                for eye, result in zip(eyes, results, strict=True):
                    pair = eye.step(frame, followed)
                    if pair is not None:
                        result[frame - 1] = pair
                done += frame > run.start
                progress.advance(done)
    weights = {j: len(cuts) / len(at_switches) for j in at_switches}
    others = {j: (edl.frames - 1 - len(cuts)) / len(within) for j in within}
    rows = tuple(
        Measured(
            variant.name,
            variant.label,
            _summary(result, weights | others) if every else None,
            _summary(result, weights),
            tuple(result[s.frame - 1] for s in switches),
        )
        for variant, result in zip(variants, results, strict=True)
    )
    return Evaluation(Conditions(size, every, len(cuts)), switches, rows)


def _summary(pairs: Mapping[int, Pair], weights: Mapping[int, float]) -> Steadiness:
    """Means over the pairs, each standing for as many as its weight says."""
    looked = [(pairs[j], weights[j]) for j in sorted(weights)]

    def mean(name: str) -> float | None:
        known = [(value, weight) for pair, weight in looked if (value := getattr(pair, name)) is not None]
        return math.fsum(v * w for v, w in known) / math.fsum(w for _, w in known) if known else None

    return Steadiness(
        mean("psnr_db"),
        mean("psnr_valid_db"),
        mean("psnr_field_db"),
        mean("speed_px"),
        mean("speed_field_px"),
        round(math.fsum(weights.values())),
        sum(pair.speed_px is not None for pair, _ in looked),
    )


def _by_frame(edl: Edl) -> list[Decision]:
    return [decision for piece, decision in resolve(edl) for _ in piece]


def _cuts(edl: Edl) -> list[tuple[int, str]]:
    """(first frame, camera) of each stretch of one camera."""
    runs = [(piece.start, decision.camera) for piece, decision in resolve(edl)]
    return [next(group) for _, group in groupby(runs, key=lambda run: run[1])]


def _switches(edl: Edl) -> tuple[Switch, ...]:
    cuts = _cuts(edl)
    return tuple(Switch(frame, before, camera) for (_, before), (frame, camera) in zip(cuts, cuts[1:], strict=False))


def _runs(pairs: set[int]) -> Iterator[FrameRange]:
    """Stretches of frames that hold all pairs (j, j + 1), so that no frame is made twice within one."""
    start = stop = None
    for j in sorted(pairs):
        if start is None or stop is None or j >= stop:
            if start is not None and stop is not None:
                yield FrameRange(start, stop)
            start = j
        stop = j + 2
    if start is not None and stop is not None:
        yield FrameRange(start, stop)


# ------------------------------------------------------------------------------------------------------ one by one


@frozen(eq=False)
class _Shown:
    """What a frame shows: the camera (the reference where the chosen one has no picture) and its grey picture."""

    frame: int
    camera: str
    picture: U8 | None


class _Followed:
    """The places that the cameras shown at two neighbouring frames have in common, the same for all variants.

    They are found in the cameras' own pictures, so every variant is judged by the same points, whatever its pictures
    have become; a variant's matrices carry them into its programme, as they carry the pictures.
    """

    def __init__(self, edl: Edl, footage: SharedFootage) -> None:
        self._edl, self._footage, self._tracker = edl, footage, Tracker()
        self._decisions = _by_frame(edl)
        self.before = self.now = _Shown(-2, edl.reference, None)
        self.tracks = self.in_field = NO_TRACKS

    def advance(self, frame: int) -> None:
        self.before, self.now, self.tracks, self.in_field = self.now, self._shown(frame), NO_TRACKS, NO_TRACKS
        a, b = self.before, self.now
        if a.frame == frame - 1 and a.picture is not None and b.picture is not None:
            self.tracks = (self._tracker.follow if a.camera == b.camera else self._tracker.match)(a.picture, b.picture)
            self.in_field = self._in_field()

    def field_at(self, frame: int) -> tuple[float, float] | None:
        """Where the EDL has the field's middle in the programme before centering: centering moves it to the middle."""
        if not self._edl.centering:
            return None
        (width, height), (dx, dy) = self._edl.size, offset_at(self._edl.centering, frame)
        return (width - 1) / 2 - dx, (height - 1) / 2 - dy

    def _in_field(self) -> Tracks:
        """The tracks that begin about the field, as the EDL's own alignment places them: again the same for all."""
        frame, camera = self.before.frame, self.before.camera
        pose, middle = self._edl.pose_at(frame), self.field_at(frame)
        if middle is None or placement_matrix(self._edl, pose, camera) is None:
            return NO_TRACKS
        start = carried(programme_matrix(self._edl, pose, camera), self.tracks.before)
        near = np.linalg.norm(start - middle, axis=1) < FIELD * self._edl.size[0]
        return Tracks(self.tracks.before[near], self.tracks.after[near])

    def _shown(self, frame: int) -> _Shown:
        for camera in (self._decisions[frame].camera, self._edl.reference):
            planes = self._footage.player(camera).at(frame)
            if planes is not None:
                return _Shown(frame, camera, grey(planes))
        return _Shown(frame, self._edl.reference, None)


class _Eye:
    """Watches one variant, frame by frame."""

    def __init__(self, variant: Variant, footage: SharedFootage, size: tuple[int, int]) -> None:
        self._edl, self._look = reduced(variant.edl, size), variant.look
        self._decisions = _by_frame(self._edl)
        self._footage = footage
        self._compositor = Compositor(self._edl, footage, filler=reduced_filler(variant.edl, size), look=variant.look)
        self._coverage = Coverage(self._edl, footage, filler=reduced_filler(variant.edl, size), look=variant.look)
        self._covered: tuple[Hashable, U8] | None = None
        self._frames: Iterator[Planes] = iter(())
        self._before: tuple[U8, U8, NDArray] | None = None

    def begin(self, run: FrameRange) -> None:
        """The next frames asked for are those of ``run``, in order."""
        self._frames, self._before = self._compositor.frames(run), None

    def step(self, frame: int, followed: _Followed) -> Pair | None:
        """The figures of the frame before and this one; None at a run's first."""
        shown = followed.now.camera
        decision = self._decisions[frame]
        if self._look is not None:
            decision = attrs.evolve(decision, **attrs.asdict(self._look))
        pose = self._edl.pose_at(frame)
        offset = shift_at(self._edl, decision, frame)
        now = (
            grey(next(self._frames)),
            self._cover(frame, (pose.range, shown, offset, decision.fill)),
            programme_matrix(self._edl, pose, shown, offset),
        )
        before, self._before = self._before, now
        if before is None:
            return None
        both: U8 = np.asarray(cv2.bitwise_and(before[1], now[1]), np.uint8)
        return Pair(
            fidelity_db(before[0], now[0]),
            _known(fidelity_db(before[0], now[0], both)),
            _known(fidelity_db(before[0], now[0], self._about_field(both, followed.field_at(frame), offset))),
            _known(speed_px(followed.tracks, before[2], now[2], self._edl.size)),
            _known(speed_px(followed.in_field, before[2], now[2], self._edl.size)),
        )

    def _about_field(self, mask: U8, field: tuple[float, float] | None, offset: tuple[float, float]) -> U8:
        """``mask`` within a circle about the field's middle, which this variant's centering shifts by ``offset``."""
        circle = np.zeros_like(mask)
        if field is not None:
            at = (round(field[0] + offset[0]), round(field[1] + offset[1]))
            cv2.circle(circle, at, round(FIELD * self._edl.size[0]), 255, cv2.FILLED)
        return np.asarray(cv2.bitwise_and(circle, mask), np.uint8)

    def _cover(self, frame: int, geometry: tuple[Hashable, ...]) -> U8:
        """The covered pixels, worked out again only where they may have changed."""
        present = tuple(has_picture(self._footage, c.name, frame) for c in self._edl.cameras)
        if self._covered is None or self._covered[0] != (geometry, present):
            self._covered = (geometry, present), self._coverage.covered(frame)
        return self._covered[1]


def _known(value: float) -> float | None:
    return None if math.isnan(value) else value
