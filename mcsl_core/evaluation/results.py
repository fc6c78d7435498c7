"""The results of an evaluation, and how they are written down."""

from __future__ import annotations

import csv
import io
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from attrs import frozen

from mcsl_core.documents import canonical_json, make_converter, read_json, structure_document
from mcsl_core.errors import DocumentError, UsageError
from mcsl_core.timing import FrameRange

from .metrics import FOLLOWED, MATCHED

SCHEMA = "mcsl.evaluation/1"
MEASURES = ("itf_db", "itf_valid_db", "itf_field_db", "av_speed_px", "av_speed_field_px")
FIELD = 0.2  # radius of "about the field" as a share of the programme's width: wounds of a hand's size fit in


@frozen
class Steadiness:
    """Means over pairs of neighbouring frames; None where none could be measured.

    Attributes
    ----------
    itf_db, itf_valid_db, itf_field_db : float or None
        Mean PSNR over the whole pictures, over the pixels that are covered in both, and over those of them about the
        surgical field.
    av_speed_px, av_speed_field_px : float or None
        Mean distance that a point moves, in pixels a frame at the measured size: of all, and of those about the field.
    pairs : int
        How many there are.
    tracked : int
        In how many of the measured ones points were found.

    References
    ----------
    The paper's equations for ITF and AvSpeed.
    """

    itf_db: float | None
    itf_valid_db: float | None
    itf_field_db: float | None
    av_speed_px: float | None
    av_speed_field_px: float | None
    pairs: int
    tracked: int


@frozen
class Pair:
    """What was measured of two neighbouring frames; None without data.

    Attributes
    ----------
    psnr_db, psnr_valid_db, psnr_field_db : float or None
        Over all pixels, those covered in both, and those of them about the field.
    speed_px, speed_field_px : float or None
        Mean distance that a point moves: of all, and of those about the field.
    """

    psnr_db: float
    psnr_valid_db: float | None
    psnr_field_db: float | None
    speed_px: float | None
    speed_field_px: float | None


@frozen
class Measured:
    """A variant's results.

    Attributes
    ----------
    name, label : str
        For programs and for people.
    whole : Steadiness or None
        Over the programme; None if only switches were measured.
    switches : Steadiness
        Over the two frames around each switch.
    at_switches : tuple of Pair
        One by one, as in `Evaluation.switches`.
    """

    name: str
    label: str
    whole: Steadiness | None
    switches: Steadiness
    at_switches: tuple[Pair, ...]


@frozen
class Switch:
    """Where one camera follows another.

    Attributes
    ----------
    frame : int
        The first programme frame of ``camera``.
    before, camera : str
        The camera before, and the one from ``frame`` on.
    """

    frame: int
    before: str
    camera: str


@frozen
class Conditions:
    """How it was measured.

    Attributes
    ----------
    size : (int, int)
        Width and height of the pictures.
    every : int
        Of the pairs without a switch one in so many was measured, 0 for none.
    switches : int
        How many there are, of which all or some were measured.
    within_camera, at_switches, picture : str
        In words: how points were tracked within a shot and at a switch, and in which pictures.
    field : float
        Radius of "about the field", as a share of the programme's width.
    """

    size: tuple[int, int]
    every: int
    switches: int
    within_camera: str = FOLLOWED
    at_switches: str = MATCHED
    picture: str = "luma, full range"
    field: float = FIELD


@frozen
class SeenThrough:
    """A stretch in which the delivered programme shows, under heads, what other cameras see.

    Attributes
    ----------
    range : FrameRange
        When, to half a second.
    camera : str
        The chosen camera.
    share, most : float
        0..1 of the surgical field or of the middle that stands for it, in the mean and at most.
    by : mapping of str to float
        Of ``share``, what each other camera shows.
    """

    range: FrameRange
    camera: str
    share: float
    most: float
    by: Mapping[str, float]


@frozen
class Evaluation:
    """The results of all variants.

    Attributes
    ----------
    conditions : Conditions
        How they were measured.
    switches : tuple of Switch
        Those that were measured.
    measured : tuple of Measured
        By variant.
    seen_through : tuple of SeenThrough
        Of the delivered programme.
    """

    conditions: Conditions
    switches: tuple[Switch, ...]
    measured: tuple[Measured, ...]
    seen_through: tuple[SeenThrough, ...] = ()

    def row(self, name: str) -> Measured:
        """The variant of that name; UsageError where it was not measured."""
        for measured in self.measured:
            if measured.name == name:
                return measured
        there = ", ".join(measured.name for measured in self.measured)
        raise UsageError(f"there is no variant {name!r}", remedy=f"Measured are {there or 'none'}")

    def gains(self, over: str = "manual", of: str = "auto") -> dict[str, float]:
        """By how much one variant is steadier than another, as the paper tells it.

        Parameters
        ----------
        over, of : str
            Names of the variants: the gains of ``of`` over ``over``.

        Returns
        -------
        dict of str to float
            Per cent more ITF and per cent less AvSpeed: "itf", "itf_valid", "itf_field",
            "av_speed", "av_speed_field", and at switches "switches_itf" and so on; what was not measured is left out.
        """
        better, worse = self.row(of), self.row(over)
        found = {}
        for prefix, a, b in (("", better.whole, worse.whole), ("switches_", better.switches, worse.switches)):
            if a is None or b is None:
                continue
            for name in MEASURES:
                x, y = getattr(a, name), getattr(b, name)
                if x is not None and y:
                    sign = -1 if name.startswith("av_speed") else 1
                    found[prefix + name.rpartition("_")[0]] = sign * 100 * (x / y - 1)
        return found


_converter = make_converter()


def to_json(evaluation: Evaluation) -> str:
    """Canonical text: the same results give the same bytes. Results at three decimals, gains at one."""
    value: dict[str, Any] = {"schema": SCHEMA, **_converter.unstructure(evaluation, Evaluation)}
    if {"manual", "auto"} <= {m.name for m in evaluation.measured}:
        value["gains_of_auto_over_manual_percent"] = {k: round(v, 1) for k, v in evaluation.gains().items()}
    return canonical_json(_rounded(value))


def _rounded(value: Any) -> Any:
    if isinstance(value, float):
        return round(value, 3)
    if isinstance(value, dict):
        return {k: _rounded(v) for k, v in value.items()}
    return [_rounded(v) for v in value] if isinstance(value, list | tuple) else value


def load_evaluation(path: Path) -> Evaluation:
    """Read what `to_json` wrote.

    Parameters
    ----------
    path : Path
        The file.

    Returns
    -------
    Evaluation

    Raises
    ------
    DocumentError
        Where it is something else.
    """
    value = read_json(path)
    if not isinstance(value, dict) or value.get("schema") != SCHEMA:
        raise DocumentError(
            f"is not the results of an evaluation ({SCHEMA})", where=str(path),
            remedy="Make them with `mcsl evaluate EDL --json FILE`",
        )  # fmt: skip
    kept = {k: v for k, v in value.items() if k not in ("schema", "gains_of_auto_over_manual_percent")}
    return structure_document(kept, Evaluation, _converter, where=str(path), name="the results (evaluation.md)")


COLUMNS = (*MEASURES, "pairs", "tracked")


def to_csv(evaluation: Evaluation) -> str:
    """One row per variant and scope (whole, switches); what was not measured is empty."""
    stream = io.StringIO()
    writer = csv.writer(stream, lineterminator="\n")
    writer.writerow(["variant", "scope", *COLUMNS, "width", "height", "every"])
    conditions = evaluation.conditions
    for row in evaluation.measured:
        for scope, means in (("whole", row.whole), ("switches", row.switches)):
            if means is not None:
                values = [getattr(means, name) for name in COLUMNS]
                shown = ["" if v is None else f"{v:.3f}" if isinstance(v, float) else v for v in values]
                writer.writerow([row.name, scope, *shown, *conditions.size, conditions.every])
    return stream.getvalue()
