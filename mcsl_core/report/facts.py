"""What the report says, as plain values for the page: no picture is decoded here and no HTML is written."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

import numpy as np
from attrs import frozen

from mcsl_core.analysis.measurements import Measurements
from mcsl_core.edl import Camera, Edl, Override
from mcsl_core.edl.resolve import Decision, resolve
from mcsl_core.movement.protocol import Curve
from mcsl_core.occlusion.score_table import ScoreTable
from mcsl_core.selection.selectors import mean_known, sample_borders
from mcsl_core.timing import FrameRange

from .charts import Bar, Tick, bar, binned, bounds, coordinate, curve_path, short_time, time_ticks, x_of
from .field_words import field_lines, scored, seen_of
from .headline import Tile, headline
from .relief_words import relief_words


@frozen
class Lane:
    """A camera over time.

    Attributes
    ----------
    camera : str
        Its name.
    colour : int
        Its index among the page's colours.
    chosen, gaps : tuple of Bar
        When it is shown, and when it has no picture.
    curve, filled : str
        SVG paths of its visible field: the line, and the area below; empty where it is not known.
    share, visible : str
        How much of the time it is shown, and its mean visible field, in words.
    """

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
    """The curve that movements were judged by.

    Attributes
    ----------
    label : str
        What it is.
    curve, threshold : str
        SVG paths.
    marks : tuple of Tick
        Labels of the y axis, per cent from the bottom.
    cut : bool
        Whether peaks are higher than the chart.
    """

    label: str
    curve: str
    threshold: str
    marks: tuple[Tick, ...]
    cut: bool


@frozen
class CameraFit:
    """A camera in a pose: its residual and support as written, and why it is weak, or nothing."""

    camera: str
    colour: int
    residual: str
    support: str
    weak: str


@frozen
class PoseFacts:
    """A pose: its number from 1 on, when it is, whose perspective it has, how its relief and its cameras were found."""

    number: int
    start: str
    stop: str
    perspective: str
    solved_from: int
    relief: str
    cameras: tuple[CameraFit, ...]


@frozen
class ClockFacts:
    """How a camera's clock stands to the programme's, and its files; all in words, empty where there is nothing to say.

    Attributes
    ----------
    camera : str
        Its name.
    colour : int
        Its index among the page's colours.
    media, size, rate : str
        Its files, picture size and frame rate.
    offset, drift, method, confidence : str
        Of its clock.
    gaps : str
        When it has no picture.
    """

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
    """The whole page without its pictures and its steadiness.

    Attributes
    ----------
    tiles, verdict
        See `Headline`.
    cameras : tuple of (str, int)
        Each with its index among the page's colours.
    ticks : tuple of Tick
        Along the time.
    programme, overrides, movements, perspectives : tuple of Bar
        The cameras shown, the editor's overrides, when the lamp moves, where a new perspective begins.
    override_notes, moves, weak : tuple of str
        The overrides, the movements and new perspectives, and the weak cameras in words.
    gaps : bool
        Whether some camera has gaps.
    lanes : tuple of Lane
        By camera.
    movement : MovementChart or None
        None where the curve is not known.
    poses : tuple of PoseFacts
        In order.
    clocks : tuple of ClockFacts
        By camera.
    seen : str
        What the cameras' shares are shares of.
    fields : tuple of str
        Where the surgical field lies when; empty where the EDL does not tell.
    """

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
    seen: str
    fields: tuple[str, ...]


def gather(edl: Edl, measured: Measurements | None) -> Facts:
    """The facts of an EDL.

    Parameters
    ----------
    edl : Edl
        The programme.
    measured : Measurements or None
        What the analysis measured beside it, where that is known.

    Returns
    -------
    Facts
    """
    scores = None if measured is None else measured.scores
    colours = {camera.name: index for index, camera in enumerate(edl.cameras)}
    decisions = resolve(edl)
    times = _Times(edl)
    first = headline(edl, scores)
    return Facts(
        tiles=first.tiles,
        verdict=first.verdict,
        cameras=tuple(colours.items()),
        ticks=tuple(time_ticks(float(edl.frames / edl.rate))),
        programme=tuple(
            bar(p.start, p.stop, edl.frames, f"c{colours[d.camera] % 7}", f"{d.camera}, {times.span(p)}")
            for p, d in _joined(decisions)
        ),
        overrides=tuple(_bar(edl, o.range, "override", f"override, {times.span(o.range)}") for o in edl.overrides),
        override_notes=tuple(f"{times.span(o.range)}: {_override_words(o)}" for o in edl.overrides),
        movements=tuple(
            _bar(edl, m.range, "movement", f"the lamp moves, {times.span(m.range)}") for m in edl.movements
        ),
        moves=_moves(edl, times),
        perspectives=tuple(
            bar(start, start + max(1, edl.frames // 250), edl.frames, "perspective", "new perspective")
            for start in _perspective_starts(edl)
        ),
        gaps=any(c.gaps for c in edl.cameras),
        lanes=tuple(_lane(edl, c, colours[c.name], decisions, scores, times) for c in edl.cameras),
        movement=None if measured is None else _movement(edl, measured.movement),
        poses=tuple(_pose(edl, index, colours, times) for index in range(len(edl.poses))),
        weak=tuple(f"{w.camera}, {times.span(pose.range)}: {w.reason}" for pose in edl.poses for w in pose.weak),
        clocks=tuple(_clock(edl, camera, colours[camera.name], times) for camera in edl.cameras),
        seen=seen_of(edl),
        fields=field_lines(edl, times.span),
    )


def colour_bar(shares: Mapping[str, float], colours: Mapping[str, int]) -> tuple[tuple[Bar, ...], str]:
    """Which cameras the programme's pixels come from.

    Parameters
    ----------
    shares : mapping of str to float
        By camera: share of the pixels, 0..1.
    colours : mapping of str to int
        By camera: its index among the page's colours.

    Returns
    -------
    bars : tuple of Bar
        Side by side.
    words : str
        The same to read.
    """
    bars, at = [], 0.0
    for name, share in shares.items():
        width = coordinate(x_of(share, 1))
        bars.append(Bar(coordinate(x_of(at, 1)), width, f"c{colours[name] % 7}", f"{name} {share:.0%}"))
        at += share
    words = [f"{name} {share:.0%}" for name, share in shares.items()]
    if at < 0.995:
        words.append(f"no camera {1 - at:.0%}")
    return tuple(bars), ", ".join(words)


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


def _bar(edl: Edl, piece: FrameRange, group: str, title: str) -> Bar:
    return bar(piece.start, piece.stop, edl.frames, group, title)


def _perspective_starts(edl: Edl) -> list[int]:
    """The first frames of the poses in which a new perspective begins."""
    return [b.range.start for a, b in zip(edl.poses, edl.poses[1:], strict=False) if a.perspective != b.perspective]


def _moves(edl: Edl, times: _Times) -> tuple[str, ...]:
    moves = [f"{times.span(m.range, tenths=True)} (confidence {m.confidence:.0%})" for m in edl.movements]
    starts = [f"{times.at(start, tenths=True)}: a new perspective begins" for start in _perspective_starts(edl)]
    return (*moves, *starts)


def _joined(decisions: Sequence[tuple[FrameRange, Decision]]) -> Iterable[tuple[FrameRange, Decision]]:
    """Ranges of one camera, whatever their look."""
    found: list[tuple[FrameRange, Decision]] = []
    for piece, decision in decisions:
        if found and found[-1][1].camera == decision.camera:
            found[-1] = (FrameRange(found[-1][0].start, piece.stop), decision)
        else:
            found.append((piece, decision))
    return found


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
        values = scores.seen[:, scores.cameras.index(camera.name)]
        x, y = binned(scores.frames, values, edl.frames)
        curve = curve_path(x, y, edl.frames, 0, 1)
        filled = curve_path(x, y, edl.frames, 0, 1, closed=True)
        told = scored(edl, scores)[0]
        seen = mean_known(values[told], np.diff(sample_borders(scores, edl.frames))[told]) if len(values) else None
        visible = "" if seen is None else f"{seen:.0%}"
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
        Tick(coordinate(100 * (v - lowest) / (highest - lowest)), _with_unit(v, curve.unit, share))
        for v in (lowest, highest)
    ]
    return MovementChart(
        curve.label,
        curve_path(x, y, edl.frames, lowest, highest),
        curve_path(tx, ty, edl.frames, lowest, highest),
        tuple(marks),
        bool(np.nanmax(curve.values) > highest),
    )


def _with_unit(value: float, unit: str, share: bool) -> str:
    return f"{value:.0%}" if share else f"{value:.3g} {unit}".strip()


def _override_words(override: Override) -> str:
    words = [override.camera] if override.camera else []
    for name in ("centering", "fill", "colour", "surface", "see_through"):
        value = getattr(override, name)
        if value is not None:
            words.append(f"{name.replace('_', ' ')} {'on' if value else 'off'}")
    return ", ".join(words) + (f" ({override.note})" if override.note else "")


def _pose(edl: Edl, index: int, colours: Mapping[str, int], times: _Times) -> PoseFacts:
    pose = edl.poses[index]
    reasons = {w.camera: w.reason for w in pose.weak}
    fits = []
    for name, colour in colours.items():
        residual, support = pose.residual_px.get(name), pose.support.get(name)
        told = "reference" if name == edl.reference else "-" if residual is None else f"{residual:.1f}"
        fits.append(CameraFit(name, colour, told, "-" if support is None else str(support), reasons.get(name, "")))
    before = edl.poses[index - 1] if index else None
    kept = "the first" if before is None else "kept" if before.perspective == pose.perspective else "a new one"
    start, stop, solved_from = times.at(pose.range.start), times.at(pose.range.stop), len(pose.solved_from)
    return PoseFacts(index + 1, start, stop, kept, solved_from, relief_words(edl, pose), tuple(fits))


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
