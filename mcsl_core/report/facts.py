"""What the report says, as plain values for the page: no picture is decoded here and no HTML is written."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

import numpy as np
from attrs import frozen

from mcsl_core.analysis.measurements import Measurements
from mcsl_core.edl import Camera, Edl, Pose
from mcsl_core.edl.resolve import Decision, resolve
from mcsl_core.movement.protocol import Curve
from mcsl_core.occlusion.score_table import ScoreTable
from mcsl_core.timing import FrameRange

from .charts import Bar, Tick, bar, binned, bounds, line, number, place, short_time, time_ticks


@frozen
class Tile:
    """A headline figure: the number, what it counts, and a remark."""

    value: str
    label: str
    remark: str = ""


@frozen
class Lane:
    """A camera over time: its curve of visible field, the same where it is chosen, when it is, and its gaps."""

    camera: str
    colour: int
    chosen: tuple[Bar, ...]
    gaps: tuple[Bar, ...]
    curve: str
    filled: str
    share: str
    visible: str


@frozen
class MovementChart:
    """The curve movements were judged by. marks: labels of the y axis, per cent from the bottom."""

    label: str
    curve: str
    threshold: str
    marks: tuple[Tick, ...]
    cut: bool


@frozen
class CameraFit:
    """A camera in a pose. residual, support: as written; weak: why it is, or empty."""

    camera: str
    colour: int
    residual: str
    support: str
    weak: str


@frozen
class PoseFacts:
    """A pose: when, whose perspective, and how every camera was tied in."""

    number: int
    start: str
    stop: str
    perspective: str
    solved_from: int
    cameras: tuple[CameraFit, ...]


@frozen
class ClockFacts:
    """How a camera's clock stands to the programme's, and its files."""

    camera: str
    colour: int
    media: str
    size: str
    rate: str
    offset: str
    drift: str
    method: str
    confidence: str
    gaps: str


@frozen
class Facts:
    """The whole page without its pictures and figures."""

    tiles: tuple[Tile, ...]
    verdict: str
    cameras: tuple[tuple[str, int], ...]
    ticks: tuple[Tick, ...]
    programme: tuple[Bar, ...]
    overrides: tuple[Bar, ...]
    override_notes: tuple[str, ...]
    movements: tuple[Bar, ...]
    moves: tuple[str, ...]
    perspectives: tuple[Bar, ...]
    gaps: bool
    lanes: tuple[Lane, ...]
    movement: MovementChart | None
    poses: tuple[PoseFacts, ...]
    weak: tuple[str, ...]
    clocks: tuple[ClockFacts, ...]


def gather(edl: Edl, measured: Measurements | None) -> Facts:
    """The facts of an EDL and, where there are any, of what was measured beside it."""
    scores = None if measured is None else measured.scores
    colours = {camera.name: index for index, camera in enumerate(edl.cameras)}
    decisions = resolve(edl)
    cuts = [(a, b) for (_, a), (_, b) in zip(decisions, decisions[1:], strict=False) if a.camera != b.camera]
    seconds = float(edl.frames / edl.rate)
    times = _Times(edl)
    shown, best = _visible(edl, scores)
    weak = [(index, pose, w) for index, pose in enumerate(edl.poses) for w in pose.weak]
    overridden = sum(len(piece) for piece, d in decisions if d.overridden)
    moves = len(edl.movements)
    perspectives = len({p.perspective for p in edl.poses})
    changes = [b.range.start for a, b in zip(edl.poses, edl.poses[1:], strict=False) if a.perspective != b.perspective]
    tiles = [
        Tile(short_time(seconds), "long", f"{edl.size[0]}x{edl.size[1]}, {float(edl.rate):.5g} frames/s"),
        Tile(str(len(edl.cameras)), _plural(len(edl.cameras), "camera"), f"{edl.reference} is the reference"),
        Tile(
            str(moves),
            _plural(moves, "lamp movement"),
            "one perspective throughout" if perspectives == 1 else f"{perspectives} perspectives",
        ),
        Tile(str(len(cuts)), _plural(len(cuts), "switch", "switches"), _pace(seconds, len(cuts))),
        Tile(
            "?" if shown is None else f"{shown:.0%}",
            "of the field visible",
            "" if shown is None or not best else f"{min(1.0, shown / best):.0%} of what the best camera shows",
        ),
        Tile(
            str(len({w.camera for _, _, w in weak})),
            _plural(len({w.camera for _, _, w in weak}), "weak camera"),
            "every view tied in" if not weak else ", ".join(dict.fromkeys(w.camera for _, _, w in weak)),
        ),
    ]
    if edl.overrides:
        count = len(edl.overrides)
        tiles.append(
            Tile(str(count), _plural(count, "override"), f"{short_time(float(overridden / edl.rate))} by the editor")
        )
    return Facts(
        tiles=tuple(tiles),
        verdict=_verdict(edl, shown, best, weak, seconds),
        cameras=tuple(colours.items()),
        ticks=tuple(time_ticks(seconds)),
        programme=tuple(
            bar(p.start, p.stop, edl.frames, f"c{colours[d.camera] % 7}", f"{d.camera}, {times.span(p)}")
            for p, d in _joined(decisions)
        ),
        overrides=tuple(
            bar(o.range.start, o.range.stop, edl.frames, "override", f"override, {times.span(o.range)}")
            for o in edl.overrides
        ),
        override_notes=tuple(f"{times.span(o.range)}: {_asked(o)}" for o in edl.overrides),
        movements=tuple(
            bar(m.range.start, m.range.stop, edl.frames, "movement", f"the lamp moves, {times.span(m.range)}")
            for m in edl.movements
        ),
        moves=tuple(f"{times.span(m.range, tenths=True)} (confidence {m.confidence:.0%})" for m in edl.movements)
        + tuple(f"{times.at(start, tenths=True)}: a new perspective begins" for start in changes),
        perspectives=tuple(
            bar(start, start + max(1, edl.frames // 250), edl.frames, "perspective", "new perspective")
            for start in changes
        ),
        gaps=any(c.gaps for c in edl.cameras),
        lanes=tuple(_lane(edl, c, colours[c.name], decisions, scores, times) for c in edl.cameras),
        movement=None if measured is None else _movement(edl, measured.movement),
        poses=tuple(_pose(edl, i, pose, colours, times) for i, pose in enumerate(edl.poses)),
        weak=tuple(f"{w.camera}, {times.span(pose.range)}: {w.reason}" for _, pose, w in weak),
        clocks=tuple(_clock(edl, camera, colours[camera.name], times) for camera in edl.cameras),
    )


class _Times:
    """Frames of a programme as times for people."""

    def __init__(self, edl: Edl) -> None:
        self._rate = edl.rate
        self._hours = edl.frames / edl.rate >= 3600

    def at(self, frame: int, *, tenths: bool = False) -> str:
        seconds = float(frame / self._rate)
        if not tenths:
            return short_time(seconds, hours=self._hours)
        in_tenths = round(seconds * 10)
        return f"{short_time(in_tenths // 10, hours=self._hours)}.{in_tenths % 10}"

    def span(self, piece: FrameRange, *, tenths: bool = False) -> str:
        return f"{self.at(piece.start, tenths=tenths)} to {self.at(piece.stop, tenths=tenths)}"


def _plural(count: int, one: str, more: str = "") -> str:
    return one if count == 1 else more or f"{one}s"


def _pace(seconds: float, switches: int) -> str:
    return f"one every {seconds / switches:.0f} s" if switches else "one camera throughout"


def _verdict(edl: Edl, shown: float | None, best: float | None, weak: list, seconds: float) -> str:
    """The page in a sentence or two."""
    text = f"{short_time(seconds)} from {len(edl.cameras)} cameras, in the perspective of {edl.reference}."
    if shown is not None and best is not None:
        text += (
            f" The views shown leave {shown:.0%} of the surgical field free; the best at every moment would {best:.0%}."
        )
    if weak:
        names = ", ".join(dict.fromkeys(w.camera for _, _, w in weak))
        text += f" Look at {names}: not tied to the other views everywhere."
    changes = sum(a.perspective != b.perspective for a, b in zip(edl.poses, edl.poses[1:], strict=False))
    if changes:
        text += f" The perspective changes {'once' if changes == 1 else f'{changes} times'}."
    return text


def _joined(decisions: Sequence[tuple[FrameRange, Decision]]) -> Iterable[tuple[FrameRange, Decision]]:
    """Stretches of one camera, whatever their look."""
    found: list[tuple[FrameRange, Decision]] = []
    for piece, decision in decisions:
        if found and found[-1][1].camera == decision.camera:
            found[-1] = (FrameRange(found[-1][0].start, piece.stop), decision)
        else:
            found.append((piece, decision))
    return found


def _visible(edl: Edl, scores: ScoreTable | None) -> tuple[float | None, float | None]:
    """Mean visible field of the shown cameras and of the best ones, over the samples in which both are known."""
    if scores is None or not len(scores.frames):
        return None, None
    shown = scores.visible[np.arange(len(scores.frames)), _columns(edl, scores)]
    known = ~np.isnan(shown)
    if not known.any():
        return None, None
    return float(shown[known].mean()), float(np.nanmax(scores.visible[known], axis=1).mean())


def _columns(edl: Edl, scores: ScoreTable) -> np.ndarray:
    """(S,) the column of the camera that is shown at each sample."""
    pieces = resolve(edl)
    starts = np.array([piece.start for piece, _ in pieces])
    which = np.searchsorted(starts, scores.frames, side="right") - 1
    return np.array([scores.cameras.index(pieces[i][1].camera) for i in which])


def _lane(
    edl: Edl,
    camera: Camera,
    colour: int,
    decisions: Sequence[tuple[FrameRange, Decision]],
    scores: ScoreTable | None,
    times: _Times,
) -> Lane:
    mine = [p for p, d in _joined(decisions) if d.camera == camera.name]
    chosen = tuple(bar(p.start, p.stop, edl.frames, "chosen", f"{camera.name} is shown, {times.span(p)}") for p in mine)
    gaps = tuple(bar(g.start, g.stop, edl.frames, "gap", f"no picture, {times.span(g)}") for g in camera.gaps)
    curve, filled, visible = "", "", ""
    if scores is not None and camera.name in scores.cameras:
        values = scores.visible[:, scores.cameras.index(camera.name)]
        x, y = binned(scores.frames, values, edl.frames)
        curve = line(x, y, edl.frames, 0, 1)
        filled = line(x, y, edl.frames, 0, 1, closed=True)
        visible = "" if np.isnan(values).all() else f"{float(np.nanmean(values)):.0%}"
    share = sum(len(p) for p in mine) / edl.frames
    return Lane(camera.name, colour, chosen, gaps, curve, filled, f"{share:.0%}", visible)


def _movement(edl: Edl, curve: Curve) -> MovementChart | None:
    if not len(curve.frames) or np.isnan(curve.values).all():
        return None
    share = curve.unit == "" and float(np.nanmax(curve.values)) <= 1
    limits = [float(v) for v in np.unique(curve.threshold[~np.isnan(curve.threshold)])]
    lowest, highest = bounds(curve.values, limits, share=share)
    # The side of the threshold on which little happens is where the lamp stands; peaks to the other side must stay.
    low = bool(limits) and float(np.nanmedian(curve.values)) > max(limits)
    x, y = binned(curve.frames, curve.values, edl.frames, keep="min" if low else "max")
    tx, ty = binned(curve.frames, curve.threshold, edl.frames)
    marks = [
        Tick(number(100 * (v - lowest) / (highest - lowest)), _unit(v, curve.unit, share)) for v in (lowest, highest)
    ]
    return MovementChart(
        curve.label,
        line(x, y, edl.frames, lowest, highest),
        line(tx, ty, edl.frames, lowest, highest),
        tuple(marks),
        bool(np.nanmax(curve.values) > highest),
    )


def _unit(value: float, unit: str, share: bool) -> str:
    return f"{value:.0%}" if share else f"{value:.3g} {unit}".strip()


def _asked(override) -> str:
    words = [override.camera] if override.camera else []
    words += [
        f"{n} {'on' if v else 'off'}"
        for n in ("centering", "fill", "colour")
        if (v := getattr(override, n)) is not None
    ]
    return ", ".join(words) + (f" ({override.note})" if override.note else "")


def _pose(edl: Edl, index: int, pose: Pose, colours: Mapping[str, int], times: _Times) -> PoseFacts:
    reasons = {w.camera: w.reason for w in pose.weak}
    fits = []
    for name, colour in colours.items():
        residual, support = pose.residual_px.get(name), pose.support.get(name)
        told = "reference" if name == edl.reference else "-" if residual is None else f"{residual:.1f}"
        fits.append(CameraFit(name, colour, told, "-" if support is None else str(support), reasons.get(name, "")))
    before = edl.poses[index - 1] if index else None
    kept = "the first" if before is None else "kept" if before.perspective == pose.perspective else "a new one"
    return PoseFacts(
        index + 1, times.at(pose.range.start), times.at(pose.range.stop), kept, len(pose.solved_from), tuple(fits)
    )


def _clock(edl: Edl, camera: Camera, colour: int, times: _Times) -> ClockFacts:
    clock, reference = camera.clock, camera.name == edl.reference
    files = len(camera.media)
    return ClockFacts(
        camera.name,
        colour,
        camera.media[0].path.rpartition("/")[2] + (f" and {files - 1} more" if files > 1 else ""),
        f"{camera.size[0]}x{camera.size[1]}",
        f"{float(camera.rate):.5g}",
        "0 (reference)" if reference else f"{clock.offset_s:+.3f} s",
        "" if reference else f"{clock.drift_ppm:+.1f} ppm",
        "" if reference else clock.method,
        "" if reference else f"{clock.confidence:.0%}",
        ", ".join(times.span(g) for g in camera.gaps),
    )


def colour_bar(shares: Mapping[str, float], colours: Mapping[str, int]) -> tuple[tuple[Bar, ...], str]:
    """Shares of the programme's pixels side by side, and in words."""
    bars, at = [], 0.0
    for name, share in shares.items():
        width = number(place(share, 1))
        bars.append(Bar(number(place(at, 1)), width, f"c{colours[name] % 7}", f"{name} {share:.0%}"))
        at += share
    words = [f"{name} {share:.0%}" for name, share in shares.items()]
    if at < 0.995:
        words.append(f"no camera {1 - at:.0%}")
    return tuple(bars), ", ".join(words)
