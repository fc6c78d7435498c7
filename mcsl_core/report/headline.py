"""The page's headline: a few numbers and the verdict in a sentence or two."""

from __future__ import annotations

import numpy as np
from attrs import frozen

from mcsl_core.edl import Edl
from mcsl_core.edl.field import MIDDLE
from mcsl_core.edl.removal import delivered_frames
from mcsl_core.edl.resolve import resolve
from mcsl_core.occlusion.score_table import ScoreTable
from mcsl_core.selection.selectors import mean_known, sample_borders

from .charts import short_time
from .field_words import FIELD, scored


@frozen
class Tile:
    """A headline number.

    Attributes
    ----------
    value : str
        The number.
    label : str
        What it counts.
    remark : str
        What else is to be said of it.
    """

    value: str
    label: str
    remark: str = ""


@frozen
class Headline:
    """The tiles, and the whole page in a sentence or two."""

    tiles: tuple[Tile, ...]
    verdict: str


def headline(edl: Edl, scores: ScoreTable | None) -> Headline:
    """What a reader is told first.

    Parameters
    ----------
    edl : Edl
        The programme.
    scores : ScoreTable or None
        The visible field of each camera over time, if it is known.

    Returns
    -------
    Headline
    """
    shown, best = visible_field(edl, scores)
    seen = FIELD if scores is None else scored(edl, scores)[1]
    weak = list(dict.fromkeys(weak.camera for pose in edl.poses for weak in pose.weak))
    tiles = [
        Tile(short_time(_seconds(edl)), "long", f"{edl.size[0]}x{edl.size[1]}, {float(edl.rate):.5g} frames/s"),
        Tile(str(len(edl.cameras)), _plural(len(edl.cameras), "camera"), f"{edl.reference} is the reference"),
        _movements(edl),
        _switches(edl),
        _visible(shown, best, seen),
        Tile(str(len(weak)), _plural(len(weak), "weak camera"), ", ".join(weak) or "every view tied in"),
    ]
    if edl.overrides:
        tiles.append(_overrides(edl))
    if edl.removed:
        left = short_time(float(delivered_frames(edl) / edl.rate))
        tiles.append(
            Tile(left, "delivered", f"{len(edl.removed)} {_plural(len(edl.removed), 'stretch', 'stretches')} removed")
        )
    return Headline(tuple(tiles), _verdict(edl, shown, best, (seen, weak)))


def visible_field(edl: Edl, scores: ScoreTable | None) -> tuple[float | None, float | None]:
    """Mean visible field of the shown cameras and of the best ones.

    Parameters
    ----------
    edl : Edl
        The programme.
    scores : ScoreTable or None
        The visible field of each camera over time.

    Returns
    -------
    shown, best : float or None
        0..1, over the time in which both are known; None without any. Of the field where it is known at some time,
        else of the middle of the picture; see `scored`.
    """
    if scores is None or not len(scores.frames):
        return None, None
    seen = scores.seen
    shown = seen[np.arange(len(scores.frames)), _columns(edl, scores)]
    known, lengths = ~np.isnan(shown) & scored(edl, scores)[0], np.diff(sample_borders(scores, edl.frames))
    if not known.any():
        return None, None
    best = np.nanmax(seen[known], axis=1)
    return mean_known(shown[known], lengths[known]), mean_known(best, lengths[known])


def _columns(edl: Edl, scores: ScoreTable) -> np.ndarray:
    """(S,) the column of the camera that is shown at each sample."""
    pieces = resolve(edl)
    starts = np.array([piece.start for piece, _ in pieces])
    which = np.searchsorted(starts, scores.frames, side="right") - 1
    return np.array([scores.cameras.index(pieces[i][1].camera) for i in which])


def _movements(edl: Edl) -> Tile:
    count, perspectives = len(edl.movements), len({p.perspective for p in edl.poses})
    remark = "one perspective throughout" if perspectives == 1 else f"{perspectives} perspectives"
    return Tile(str(count), _plural(count, "lamp movement"), remark)


def _switches(edl: Edl) -> Tile:
    decisions = [decision for _, decision in resolve(edl)]
    count = sum(a.camera != b.camera for a, b in zip(decisions, decisions[1:], strict=False))
    pace = f"one every {_seconds(edl) / count:.0f} s" if count else "one camera throughout"
    return Tile(str(count), _plural(count, "switch", "switches"), pace)


def _visible(shown: float | None, best: float | None, seen: str) -> Tile:
    label = "of the field visible" if seen == FIELD else f"of the {seen} visible"
    if shown is None:
        return Tile("?", label)
    return Tile(f"{shown:.0%}", label, f"{min(1.0, shown / best):.0%} of what the best camera shows" if best else "")


def _overrides(edl: Edl) -> Tile:
    frames = sum(len(piece) for piece, decision in resolve(edl) if decision.overridden)
    count = len(edl.overrides)
    return Tile(str(count), _plural(count, "override"), f"{short_time(float(frames / edl.rate))} by the editor")


def _delivered(edl: Edl) -> Tile:
    count, left_s = len(edl.removed), float(delivered_frames(edl) / edl.rate)
    return Tile(short_time(left_s), "delivered", f"{count} {_plural(count, 'stretch', 'stretches')} removed")


def _verdict(edl: Edl, shown: float | None, best: float | None, told: tuple[str, list[str]]) -> str:
    seen, weak = told
    cameras = f"{len(edl.cameras)} {_plural(len(edl.cameras), 'camera')}"
    text = f"{short_time(_seconds(edl))} from {cameras}, in the perspective of {edl.reference}."
    if shown is not None and best is not None:
        text += f" The views shown leave {shown:.0%} of the {seen} free;"
        text += f" the best one at every moment would leave {best:.0%}."
    if any(stretch.by == MIDDLE for stretch in edl.fields):
        when = "" if seen != FIELD else " at times"
        text += f" Nothing shows{when} where the surgical field lies: draw it with mcsl field."
    if weak:
        text += f" Check {', '.join(weak)}: not tied to the other views everywhere."
    changes = sum(a.perspective != b.perspective for a, b in zip(edl.poses, edl.poses[1:], strict=False))
    if changes:
        text += f" The perspective changes {'once' if changes == 1 else f'{changes} times'}."
    return text


def _plural(count: int, one: str, more: str = "") -> str:
    return one if count == 1 else more or f"{one}s"


def _seconds(edl: Edl) -> float:
    return float(edl.frames / edl.rate)
