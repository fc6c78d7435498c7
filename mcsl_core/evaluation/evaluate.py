"""How steady a programme is, by the paper's measures, and the programmes that it is held against.

ITF is the mean PSNR between neighbouring frames, AvSpeed the mean distance that a feature point moves from one frame
to the next (the paper's section on evaluation metrics). Every variant shows the same shots at the same size, all made
by the compositor; docs/explanation/evaluation.md says how each figure comes about.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from contextlib import closing
from itertools import groupby
from pathlib import Path

import attrs
from attrs import frozen

from mcsl_core.compositing.proxy import ProxyFootage, proxy_edl, proxy_size
from mcsl_core.edl import IDENTITY, Edl, Look
from mcsl_core.edl.movement import unfollowed
from mcsl_core.edl.resolve import resolve
from mcsl_core.errors import UsageError
from mcsl_core.progress import Progress, Silent
from mcsl_core.recording.changed_media import media_files, tell_of_changed_media
from mcsl_core.recording.contents import read_contents
from mcsl_core.timing import FrameRange

from .manual_alignment import ByHand, aligned_by_hand
from .observer import TrackFollower, VariantObserver
from .results import Conditions, Evaluation, Measured, Pair, Steadiness, Switch
from .seen_through import seen_through

WIDTH = 640  # of the pictures measured: the paper names none
DELIVERED = "delivered"


def without_alignment(edl: Edl) -> Edl:
    """The same shots with every picture as its camera took it: no warp, no look; the paper's No-alignment."""
    names = [c.name for c in edl.cameras]
    poses = tuple(
        attrs.evolve(p, homographies=dict.fromkeys(names, IDENTITY), anchor=IDENTITY, relief=None, weak=())
        for p in edl.poses
    )
    movements = unfollowed(edl.movements)
    return attrs.evolve(edl, poses=poses, movements=movements, corrections=(), look=Look(False, False, False, False))


# -------------------------------------------------------------------------------------------------------- variants


@frozen
class Variant:
    """A programme to be measured.

    Parameters
    ----------
    name : str
        For programs.
    label : str
        For people.
    edl : Edl
        The programme.
    look : Look, optional
        In place of the EDL's.
    """

    name: str
    label: str
    edl: Edl
    look: Look | None = None


def standard_variants(edl: Edl, *, manual: ByHand | None = None, colour: bool = False) -> tuple[Variant, ...]:
    """The paper's comparison, then the programme as it is delivered.

    Parameters
    ----------
    edl : Edl
        The programme.
    manual : mapping of int to mapping of str to Matrix, optional
        Alignments by hand: pose index -> camera -> camera pixel to programme pixel.
    colour : bool
        Whether the cameras' colours are matched, in all alike, since it changes the PSNR whatever the alignment is;
        the delivered programme has the EDL's own look.

    Returns
    -------
    tuple of Variant
        "no", "manual" (where given), "plane", "surface" (where the EDL has a relief), "auto" (the one of these two that
        the EDL's look says), "centered", "filled", "delivered".

    References
    ----------
    The paper's section on evaluation metrics.
    """
    plain = Look(centering=False, fill=False, colour=colour, surface=False)
    found = [Variant("no", "No-alignment", without_alignment(edl), plain)]
    if manual is not None:
        found.append(Variant("manual", "Manual-alignment", aligned_by_hand(edl, manual), plain))
    found.append(Variant("plane", "Auto, by planes", edl, plain))
    own = plain
    if any(pose.relief for pose in edl.poses):
        by_relief = attrs.evolve(plain, surface=True)
        found.append(Variant("surface", "Auto, by the relief", edl, by_relief))
        own = by_relief if edl.look.surface else plain
    found += [
        Variant("auto", "Auto", edl, own),
        Variant("centered", "Auto + centered", edl, attrs.evolve(own, centering=True)),
        Variant("filled", "Auto + centered + filled", edl, attrs.evolve(own, centering=True, fill=True)),
        Variant(DELIVERED, "As delivered", edl),
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
    """Measure variants of one programme; every camera is decoded once for all of them.

    Parameters
    ----------
    edl : Edl
        The programme.
    base : Path
        The folder that media paths are relative to.
    variants : sequence of Variant, optional
        Of the same shots; `standard_variants` without.
    width : int
        Of the pictures measured, 16 or more; the programme's at most.
    every : int
        Of the pairs of neighbouring frames within a shot one in so many is measured and stands for the others; 0 for
        none of them.
    most_switches : int, optional
        At so many switches, spread evenly, instead of at all.
    progress : Progress, optional
        Where it is told how far it has come.

    Returns
    -------
    Evaluation

    Raises
    ------
    UsageError
        Where a variant has other shots, or a number is out of bounds.
    McslError
        Whatever reading the media raises.
    """
    variants = standard_variants(edl) if variants is None else tuple(variants)
    _check(edl, variants, width, every)
    selection = _select(edl, every, most_switches)
    made = {_made_alike(variant): variant for variant in variants}  # what is made alike is measured once
    size, progress = proxy_size(edl.size, width), progress or Silent()
    read_contents(media_files(edl, base), progress)
    tell_of_changed_media(edl, base, progress)
    measured = _measure(edl, base, list(made.values()), size, selection.pairs, progress)
    found = dict(zip(made, measured, strict=True))
    weights_at_switches, weights = selection.weights(edl.frames)
    rows = []
    for variant in variants:
        pairs = found[_made_alike(variant)]
        whole, at_switches = _summary(pairs, weights) if every else None, _summary(pairs, weights_at_switches)
        one_by_one = tuple(pairs[s.frame - 1] for s in selection.switches)
        rows.append(Measured(variant.name, variant.label, whole, at_switches, one_by_one))
    seen = seen_through(edl, base, progress) if any(variant.name == DELIVERED for variant in variants) else ()
    return Evaluation(Conditions(size, every, len(selection.cuts)), selection.switches, tuple(rows), seen)


@frozen
class _Selection:
    """The pairs (j, j + 1) to measure, by their j, and the switches among them; ``cuts`` are the pairs of all."""

    switches: tuple[Switch, ...]
    cuts: frozenset[int]
    within: frozenset[int]

    @property
    def at_switches(self) -> frozenset[int]:
        return frozenset(s.frame - 1 for s in self.switches)

    @property
    def pairs(self) -> frozenset[int]:
        return self.at_switches | self.within

    def weights(self, frames: int) -> tuple[dict[int, float], dict[int, float]]:
        """How many pairs each stands for: at switches, and over the whole programme."""
        chosen = self.at_switches
        at_switches = {j: len(self.cuts) / len(chosen) for j in chosen}
        within = {j: (frames - 1 - len(self.cuts)) / len(self.within) for j in self.within}
        return at_switches, at_switches | within


def _made_alike(variant: Variant) -> tuple[int, Look | None]:
    """Equal for variants whose pictures are the same."""
    return id(variant.edl), variant.look


def _check(edl: Edl, variants: Sequence[Variant], width: int, every: int) -> None:
    if every < 0 or width < 16:
        raise UsageError(f"every must be 0 or more and the width 16 or more, got {every} and {width}")
    for variant in variants:
        if _cuts(variant.edl) != _cuts(edl) or variant.edl.frames != edl.frames or variant.edl.cameras != edl.cameras:
            raise UsageError(f"the variant {variant.name!r} does not show the same shots of the same cameras")


def _select(edl: Edl, every: int, most_switches: int | None) -> _Selection:
    switches = _switches(edl)
    cuts = frozenset(s.frame - 1 for s in switches)
    if most_switches is not None and len(switches) > most_switches:
        switches = tuple(switches[i * len(switches) // most_switches] for i in range(most_switches))
    within = frozenset(j for j in range(0, edl.frames - 1, every) if j not in cuts) if every else frozenset()
    return _Selection(switches, cuts, within)


def _measure(
    edl: Edl,
    base: Path,
    variants: Sequence[Variant],
    size: tuple[int, int],
    pairs: frozenset[int],
    progress: Progress,
) -> list[dict[int, Pair]]:
    """For each variant: first frame of a pair -> what was measured of it."""
    found: list[dict[int, Pair]] = [{} for _ in variants]
    progress.stage("Measuring the programme", len(pairs), "pairs")
    done = 0
    with closing(ProxyFootage(edl, base, size)) as footage:
        follower = TrackFollower(proxy_edl(edl, size), footage)
        observers = [VariantObserver(variant.edl, variant.look, footage, size) for variant in variants]
        for run in _runs(pairs):
            for observer in observers:
                observer.begin(run)
            for frame in run:
                follower.advance(frame)
                for observer, measured in zip(observers, found, strict=True):
                    pair = observer.step(frame, follower)
                    if pair is not None:
                        measured[frame - 1] = pair
                done += frame > run.start
                progress.advance(done)
    return found


def _summary(pairs: Mapping[int, Pair], weights: Mapping[int, float]) -> Steadiness:
    """Means over the pairs, each standing for as many as its weight says."""
    measured = [(pairs[j], weights[j]) for j in sorted(weights)]

    def mean(name: str) -> float | None:
        values = [(getattr(pair, name), weight) for pair, weight in measured]
        known = [(value, weight) for value, weight in values if value is not None]
        return math.fsum(v * w for v, w in known) / math.fsum(w for _, w in known) if known else None

    return Steadiness(
        mean("psnr_db"),
        mean("psnr_valid_db"),
        mean("psnr_field_db"),
        mean("speed_px"),
        mean("speed_field_px"),
        round(math.fsum(weights.values())),
        sum(pair.speed_px is not None for pair, _ in measured),
    )


def _cuts(edl: Edl) -> list[tuple[int, str]]:
    """(first frame, camera) of each range of one camera."""
    runs = [(piece.start, decision.camera) for piece, decision in resolve(edl)]
    return [next(group) for _, group in groupby(runs, key=lambda run: run[1])]


def _switches(edl: Edl) -> tuple[Switch, ...]:
    cuts = _cuts(edl)
    return tuple(Switch(frame, before, camera) for (_, before), (frame, camera) in zip(cuts, cuts[1:], strict=False))


def _runs(pairs: frozenset[int]) -> Iterator[FrameRange]:
    """Ranges of frames that hold all pairs (j, j + 1), so that no frame is made twice within one."""
    start = stop = None
    for j in sorted(pairs):
        if start is None or stop is None or j >= stop:
            if start is not None and stop is not None:
                yield FrameRange(start, stop)
            start = j
        stop = j + 2
    if start is not None and stop is not None:
        yield FrameRange(start, stop)
