"""Files of gaze: mcsl's own columns, or the exports of Tobii and Pupil Labs; every look is used or counted as lost.

Own columns: ``frame`` (programme frames) or ``time`` (programme seconds; also ``time_ms``, ``time_us``, ``time_ns``),
``x`` and ``y`` in pixels of the programme without centering, or of the camera named in a column ``camera``,
``observer``, where there are several (else a file is one). Places that all lie within 0..1 are shares of the picture.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from itertools import islice, pairwise
from pathlib import Path
from statistics import median

import numpy as np
from attrs import evolve, frozen

from mcsl_core.errors import DocumentError
from mcsl_core.tables import Grouping, Row, Table, number, read_table
from mcsl_core.timing import parse_time

from .gaze import WINDOW_S, Gaze

_SECONDS = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9}
_TIMES = {  # column, without its unit -> the unit it has where it names none
    "frame": "frames",
    "time": "s",
    "timestamp": "s",
    "recording timestamp": "",  # Tobii: milliseconds or microseconds, as the export was set
    "recordingtimestamp": "ms",
    "gaze timestamp": "s",
    "world timestamp": "s",
}
_PLACES = (  # x, y, whether y points up
    ("x", "y", False),
    ("gaze point x", "gaze point y", False),
    ("gazepointx", "gazepointy", False),
    ("gaze x", "gaze y", False),
    ("norm pos x", "norm pos y", True),
    ("x norm", "y norm", True),
)
_IN_PICTURE = ("", "px", "mcs px", "mcspx", "norm", "mcs norm", "mcsnorm")
_OBSERVERS = ("observer", "participant name", "participantname", "participant", "recording id")
_LOST = frozenset({"", "nan", "na", "n/a", "null", "none", "-", "."})
_SURE = 0.6  # Pupil's own bound on ``confidence``
_SHARES = 1.5  # places beyond it are pixels; eyes wander off a picture, but not far
_STEP = (0.4, 60.0)  # between two samples of a tracker, in its unit of time: 2500 to 17 a second
_REMEDY = "docs/how-to/look.md lists what is read"


@frozen
class Shown:
    """What the viewers looked at.

    Attributes
    ----------
    rate : float
        Programme frames per second.
    frames : int
        Length of the programme.
    size : (int, int)
        Its width and height.
    cameras : mapping of str to (int, int)
        Each camera's width and height.
    """

    rate: float
    frames: int
    size: tuple[int, int]
    cameras: Mapping[str, tuple[int, int]]


@frozen
class GazeFile:
    """What one file holds.

    Attributes
    ----------
    path : Path
        The file.
    looks : tuple of Gaze
        Those that lie in the programme and in a picture.
    blind, outside, early : int
        Samples without eyes, those that look past the picture, and those before or after the programme.
    read_as : str
        What was understood beyond mcsl's own form, for people.
    """

    path: Path
    looks: tuple[Gaze, ...]
    blind: int
    outside: int
    early: int
    read_as: str = ""

    @property
    def samples(self) -> int:
        """All lines of the file."""
        return len(self.looks) + self.blind + self.outside + self.early

    def __str__(self) -> str:
        """How many looks of how many are used, and why not the others."""
        lost = {
            "without eyes": self.blind,
            "past the picture": self.outside,
            "before or after the programme": self.early,
        }
        why = ", ".join(f"{count} {where}" for where, count in lost.items() if count)
        told = f"{len(self.looks)} of {self.samples} looks are used"
        return told + (f" ({why})" if why else "") + (f"; {self.read_as}" if self.read_as else "")


@frozen
class _Columns:
    """The columns that are read. unit: of the time, "" where the values have to tell."""

    time: str
    unit: str
    x: str
    y: str
    upward: bool
    observer: str | None
    camera: str | None
    confidence: str | None


@frozen
class _Look:
    line: int
    time: float
    x: float
    y: float
    observer: str
    camera: str | None


def read_gaze(path: Path, shown: Shown) -> GazeFile:
    """Reads a file of gaze.

    Parameters
    ----------
    path : Path
        CSV or TSV; see the module's description.
    shown : Shown
        The programme.

    Raises
    ------
    InputError
        Where the file is missing or is no text.
    DocumentError
        Where a line is wrong (it names the line), or most looks lie outside of the programme or the picture.
    """
    table = read_table(path, wanted="a file of gaze", remedy=f"Its first line names time, x and y. {_REMEDY}")
    columns = _columns(table)
    looks, blind = _looks(table, columns, shown, path)
    looks, as_time = _in_frames(looks, columns, shown, path)
    during = [look for look in looks if 0 <= look.time < shown.frames]
    _check_time(looks, during, shown, path)
    inside, as_place = _in_pixels(during, columns, shown, path)
    used = tuple(Gaze(look.time, look.observer, look.x, look.y, look.camera) for look in inside)
    read_as = "; ".join(text for text in (as_time, as_place) if text)
    return GazeFile(path, used, blind, len(during) - len(used), len(looks) - len(during), read_as)


# ---------------------------------------------------------------------------------------------------------- columns


def _plain(header: str) -> tuple[str, str]:
    """A column's name without its unit, and the unit: "Gaze point X [MCS px]" -> "gaze point x", "mcs px"."""
    text = header.strip().lower().replace("µ", "u").replace("μ", "u")
    split = re.fullmatch(r"(.*?)\s*[\[(]\s*(.*?)\s*[\])]", text) or re.fullmatch(r"(.*)_(s|ms|us|ns)", text)
    name, unit = split.groups() if split else (text, "")
    return re.sub(r"[\s_]+", " ", name).strip(), unit


def _columns(table: Table) -> _Columns:
    plain = {header: _plain(header) for header in table.columns}
    time = next((h for wanted in _TIMES for h, (name, _) in plain.items() if name == wanted), None)
    places = [
        (x, y, upward)
        for x_name, y_name, upward in _PLACES
        for x, (name, unit) in plain.items()
        for y, other in plain.items()
        if name == x_name and other == (y_name, unit)
    ]
    place = next((p for p in places if plain[p[0]][1] in _IN_PICTURE), None)
    if time is None or (place is None and not places):
        named = ", ".join(map(repr, table.columns[:12])) or "none"
        what = f"has the columns {named}, expected frame or time, x and y, or Tobii's or Pupil's"
        raise DocumentError(what, where=f"{table.path}, line 1", remedy=f"Name them in the first line; {_REMEDY}")
    if place is None:
        what = f"{places[0][0]!r} is no place in the picture that was shown"
        raise DocumentError(what, where=f"{table.path}, line 1", remedy="Export Gaze point X [MCS px]")
    name, unit = plain[time]
    unit = unit or _TIMES[name]
    if unit not in ("", "frames", *_SECONDS) or (name == "frame") != (unit == "frames"):
        what = f"{time!r} has a unit of time that is not known"
        raise DocumentError(what, where=f"{table.path}, line 1", remedy=f"Units are {', '.join(_SECONDS)}")
    found = {name: header for header, (name, _) in reversed(plain.items())}
    observer = next((found[name] for name in _OBSERVERS if name in found), None)
    return _Columns(time, unit, *place, observer, found.get("camera"), found.get("confidence"))


# ------------------------------------------------------------------------------------------------------------ lines


def _looks(table: Table, columns: _Columns, shown: Shown, path: Path) -> tuple[list[_Look], int]:
    """The lines with eyes, and how many have none."""
    looks, blind = [], 0
    sides = [side for size in (shown.size, *shown.cameras.values()) for side in size]
    places, times = Grouping(most=max(sides)), Grouping()
    for row in table:
        look = _look(row, columns, shown, path)
        if look is None:
            blind += 1
            continue
        looks.append(look)
        for column in (columns.x, columns.y):
            places.see(row.cells[column], row.line)
        if columns.unit != "s":
            times.see(row.cells[columns.time], row.line)
    if not looks:
        what = f"none of its {blind} lines has eyes" if blind else "holds no looks, its first line alone"
        raise DocumentError(what, where=str(path), remedy=_REMEDY)
    places.check(path)
    times.check(path)
    return looks, blind


def _look(row: Row, columns: _Columns, shown: Shown, path: Path) -> _Look | None:
    """What a line says; None where there were no eyes."""
    cells = row.cells
    try:
        if cells[columns.x].lower() in _LOST or cells[columns.y].lower() in _LOST:
            return None
        x, y = number(cells[columns.x]), number(cells[columns.y])
        if x == y <= 0:  # trackers write 0, 0 or -1, -1 or -9999, -9999 for eyes that they have lost
            return None
        if columns.confidence is not None and number(cells[columns.confidence]) < _SURE:
            return None
        time = _time(cells[columns.time], columns.unit)
        camera = (cells[columns.camera] if columns.camera else "") or None
        if camera is not None and camera not in shown.cameras:
            raise ValueError(f"{camera!r} is not a camera, expected one of {', '.join(sorted(shown.cameras))}")
    except ValueError as error:
        raise DocumentError(str(error), where=f"{path}, line {row.line}", remedy="Correct or delete the line") from None
    observer = (cells[columns.observer] if columns.observer else "") or path.name
    return _Look(row.line, time, x, y, observer, camera)


def _time(text: str, unit: str) -> float:
    """The time in a cell, in the column's unit; seconds also as 0:01:02.5."""
    if ":" not in text:
        return number(text)
    try:
        if unit == "s":
            return float(parse_time(text))
    except ValueError:
        pass
    what = "is no number, and no time of hours, minutes and seconds such as 0:01:02.5"
    raise ValueError(f"{text[:40]!r} {what}" if unit == "s" else f"{text[:40]!r} is no number")


def _in_frames(looks: Sequence[_Look], columns: _Columns, shown: Shown, path: Path) -> tuple[list[_Look], str]:
    """The looks with programme frames in place of their times, and how the times were read."""
    unit = columns.unit or _unit_of(looks, columns, shown, path)
    scale = 1.0 if unit == "frames" else _SECONDS[unit] * shown.rate
    told = [] if unit in ("frames", "s") else [f"{columns.time!r} in {unit}"]
    every_s = _step(looks) * scale / shown.rate
    if every_s > WINDOW_S:  # milliseconds taken for seconds lie in a long programme too
        told.append(f"a look every {every_s:.3g} s")
    return [evolve(look, time=look.time * scale) for look in looks], ", ".join(told)


def _step(looks: Sequence[_Look]) -> float:
    """From one look to the next, in the unit of their times."""
    return median([abs(b.time - a.time) for a, b in islice(pairwise(looks), 10_000)] or [0.0])


def _unit_of(looks: Sequence[_Look], columns: _Columns, shown: Shown, path: Path) -> str:
    """ms or us, by the step between samples and by the programme's length; DocumentError where neither is sure."""
    step = _step(looks)
    low, high = _STEP
    for unit, within in (("ms", low <= step <= high), ("us", low <= step / 1000 <= high)):
        last = shown.frames / (_SECONDS[unit] * shown.rate)
        if within and 2 * sum(0 <= look.time < last for look in looks) >= len(looks):
            return unit
    raise DocumentError(
        f"{columns.time!r} names no unit, and a step of {step:g} does not tell",
        where=f"{path}, line 1",
        remedy="Write [ms] or [us] behind the column's name",
    )


def _check_time(looks: Sequence[_Look], during: Sequence[_Look], shown: Shown, path: Path) -> None:
    """DocumentError where most looks lie outside of the programme: in another unit, or from another moment on."""
    if 2 * len(during) >= len(looks):
        return
    first = next(look for look in looks if not 0 <= look.time < shown.frames)
    seconds = sorted(look.time / shown.rate for look in looks)
    raise DocumentError(
        f"{len(looks) - len(during)} of {len(looks)} looks lie outside of the programme, this line's first: it lasts "
        f"{shown.frames / shown.rate:.6g} s, they go from {seconds[0]:.6g} to {seconds[-1]:.6g} s",
        where=f"{path}, line {first.line}",
        remedy="Times are seconds (milliseconds in a column time_ms) from the programme's first frame: subtract the "
        "moment at which it began from a clock's or an epoch's times",
    )


def _in_pixels(looks: Sequence[_Look], columns: _Columns, shown: Shown, path: Path) -> tuple[list[_Look], str]:
    """The looks that lie in the picture, in its pixels, and how the places were read."""
    largest = np.array([max(abs(look.x), abs(look.y)) for look in looks])
    shares = bool(len(largest)) and float(np.quantile(largest, 0.95)) <= _SHARES
    if columns.upward and not shares:
        what = f"{columns.x!r} should be a share of the picture, 0 to 1"
        raise DocumentError(what, where=f"{path}, line {looks[int(largest.argmax())].line}", remedy="Correct the lines")
    inside, first = [], None
    for look in looks:
        width, height = shown.size if look.camera is None else shown.cameras[look.camera]
        x, y = look.x, look.y
        if shares:
            y = 1 - y if columns.upward else y
            x, y = x * width - 0.5, y * height - 0.5  # pixel centres lie at integers
        if -0.5 <= x <= width - 0.5 and -0.5 <= y <= height - 0.5:
            inside.append(evolve(look, x=x, y=y))
        elif first is None:
            first = look
    if first is not None and 2 * len(inside) < len(looks):
        width, height = shown.size if first.camera is None else shown.cameras[first.camera]
        raise DocumentError(
            f"{len(looks) - len(inside)} of {len(looks)} looks lie past the picture of {width}x{height} pixels, "
            f"this line's {first.x:g}, {first.y:g} first",
            where=f"{path}, line {first.line}",
            remedy="Places are pixels of the programme or of the camera named, not of a screen: scale them",
        )
    told = "places are shares of the picture" + (", y upward" if columns.upward else "")
    return inside, told if shares else ""
