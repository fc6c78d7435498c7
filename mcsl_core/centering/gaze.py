"""Where viewers looked: recorded by eye trackers, told as stretches in which the eyes rest on one place.

A file is CSV with a header line. Columns: ``frame`` (programme frames) or ``time`` (programme seconds); ``x`` and ``y``
in pixels of the programme without centering, or of the camera named in a column ``camera``; ``observer``, where there
are several (else a file is one). Lines with an empty x or y are blinks.
"""

from __future__ import annotations

import csv
from collections import defaultdict
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path

import numpy as np
from attrs import frozen
from numpy.typing import NDArray

from mcsl_core.errors import DocumentError, InputError
from mcsl_core.timing import FrameRange

Placed = Callable[[int, str], NDArray[np.float64] | None]  # frame, camera -> camera pixel to programme pixel, or None

WINDOW_S = 2.0  # over which one observer's eyes are taken together: a few fixations
REST_S = 6.0  # eyes that are back sooner have not moved on
APART = 0.06  # share of the picture's width from which on it is another place


@frozen
class Gaze:
    """One look: programme frame, observer, and pixel of the programme, or of ``camera`` where one is named."""

    frame: float
    observer: str
    x: float
    y: float
    camera: str | None = None


def read_gaze(paths: Sequence[Path], *, rate: float, cameras: Sequence[str]) -> tuple[Gaze, ...]:
    """All looks of all files. InputError for a file that is missing, DocumentError with the line that is wrong."""
    looks: list[Gaze] = []
    for path in paths:
        try:
            with path.open(newline="", encoding="utf-8-sig") as stream:
                looks += _read(csv.DictReader(stream), path, rate, set(cameras))
        except (OSError, UnicodeDecodeError) as error:
            raise InputError(f"cannot be read as a file of gaze ({error})", where=str(path)) from error
    return tuple(looks)


def _read(lines: csv.DictReader[str], path: Path, rate: float, cameras: set[str]) -> Iterable[Gaze]:
    columns = set(lines.fieldnames or ())
    if not {"x", "y"} <= columns or not columns & {"frame", "time"}:
        raise DocumentError(
            f"has the columns {', '.join(sorted(columns)) or 'none'}, expected frame or time, x and y",
            where=str(path),
            remedy="Write them in the first line, separated by commas; docs/look.md shows an example",
        )
    for line in lines:
        try:
            if not (line["x"] or "").strip() or not (line["y"] or "").strip():
                continue
            frame = float(line["frame"]) if "frame" in columns else float(line["time"]) * rate
            x, y = float(line["x"]), float(line["y"])
            camera = (line.get("camera") or "").strip() or None
            if not np.isfinite([frame, x, y]).all():
                raise ValueError("a number is not finite")
            if camera is not None and camera not in cameras:
                raise ValueError(f"{camera!r} is not a camera, expected one of {', '.join(sorted(cameras))}")
        except (TypeError, ValueError) as error:
            raise DocumentError(
                f"line {lines.line_num} cannot be read ({error})", where=str(path), remedy="Correct or delete the line"
            ) from None
        yield Gaze(frame, line.get("observer") or path.name, x, y, camera)


def fixations(
    looks: Sequence[Gaze], placed: Placed, *, frames: int, size: tuple[int, int], rate: float
) -> list[tuple[FrameRange, tuple[float, float]]]:
    """Stretches that tile [0, frames) and the programme pixel (x, y) looked at in each; none without any look.

    Of each two seconds, each observer's median, and of those the mean over the observers, as in the paper; where
    nobody's eyes were recorded, what was last looked at. A new place is one that lies ``APART`` of the width from
    the one before for ``REST_S``: eyes that wander to an instrument and back do not move the picture.
    """
    step = WINDOW_S * rate
    windows: dict[int, dict[str, list[tuple[float, float]]]] = defaultdict(lambda: defaultdict(list))
    for look in looks:
        point = _in_programme(look, placed) if 0 <= look.frame < frames else None
        if point is not None:
            windows[int(look.frame // step)][look.observer].append(point)
    means = {
        number: np.mean([np.median(points, axis=0) for points in observers.values()], axis=0)
        for number, observers in windows.items()
    }
    places: list[tuple[int, list[NDArray[np.float64]]]] = []
    astray: list[tuple[int, NDArray[np.float64]]] = []
    for number in sorted(means):
        if not places:
            places.append((0, [means[number]]))
            continue
        resting = np.median(places[-1][1], axis=0)
        if np.linalg.norm(means[number] - resting) <= APART * size[0]:
            places[-1][1].append(means[number])
            astray = []
            continue
        astray.append((number, means[number]))
        if (number + 1 - astray[0][0]) * WINDOW_S >= REST_S:
            places.append((astray[0][0], [mean for _, mean in astray]))
            astray = []
    starts = [round(start * step) for start, _ in places] + [frames]
    return [
        (FrameRange(a, b), (float(x), float(y)))
        for (a, b), (x, y) in zip(
            zip(starts, starts[1:], strict=False), (np.median(means, axis=0) for _, means in places), strict=True
        )
    ]


def _in_programme(look: Gaze, placed: Placed) -> tuple[float, float] | None:
    """The programme pixel looked at; None where the camera's place is not known then."""
    if look.camera is None:
        return look.x, look.y
    matrix = placed(int(look.frame), look.camera)
    if matrix is None:
        return None
    x, y, w = matrix @ (look.x, look.y, 1.0)
    return float(x / w), float(y / w)
