"""Contact sheets: the cameras' own pictures above, the programme below, standing and while the lamp moves."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import attrs
import cv2
import numpy as np
from numpy.typing import NDArray

from mcsl_core.compositing.compositor import Compositor
from mcsl_core.documents import write_atomic
from mcsl_core.edl import Edl, Movement, Override
from mcsl_core.edl.movement import unfollowed
from mcsl_core.edl.resolve import resolve
from mcsl_core.imaging.lettering import write_text
from mcsl_core.imaging.planes import planes_to_bgr
from mcsl_core.recording.footage import Footage
from mcsl_core.timing import FrameRange, format_time

Picture = NDArray[np.uint8]
GAP = 6
PAPER = (32, 32, 32)


def contact_sheet(edl: Edl, base: Path, frames: Sequence[int], *, width: int = 1600) -> Picture:
    """One column per programme frame: the cameras' pictures small, the chosen one framed, the programme below.

    Parameters
    ----------
    edl : Edl
        The programme.
    base : Path
        The folder that media paths are relative to.
    frames : sequence of int
        Programme frames.
    width : int
        Of the sheet, in pixels.

    Returns
    -------
    (H, width, 3) uint8
        BGR.
    """
    footage = Footage(edl.cameras, rate=edl.rate, frames=edl.frames, base=base)
    compositor = Compositor(edl, footage)
    column = (width - GAP * (len(frames) + 1)) // len(frames)
    blocks = []
    for frame in frames:
        chosen = _chosen(edl, frame)
        small = (column - GAP * (len(edl.cameras) - 1)) // len(edl.cameras)
        thumbnails = [_thumbnail(footage, c.name, frame, small, chosen=c.name == chosen) for c in edl.cameras]
        height = max(t.shape[0] for t in thumbnails)
        strip = np.full((height, column, 3), PAPER, np.uint8)
        for i, thumbnail in enumerate(thumbnails):
            left = i * (small + GAP)
            strip[: thumbnail.shape[0], left : left + thumbnail.shape[1]] = thumbnail
        programme = _programme(compositor, frame, column)
        _label(programme, f"{format_time(frame / edl.rate)}  {chosen}", 0.5)
        gap = np.full((GAP, column, 3), PAPER, np.uint8)
        blocks.append(np.vstack([strip, gap, programme]))
    return _sheet([blocks], width)


def movement_sheet(edl: Edl, base: Path, movement: Movement, *, columns: int = 5, width: int = 1600) -> Picture:
    """A movement of the lamp: what the chosen camera sees, the programme that holds it, the programme that follows.

    Parameters
    ----------
    edl : Edl
        The programme.
    base : Path
        The folder that media paths are relative to.
    movement : Movement
        One of the programme's.
    columns : int
        How many instants of it, the first before it, the last after it.
    width : int
        Of the sheet, in pixels.

    Returns
    -------
    (H, width, 3) uint8
        BGR; a row each, with a cross over the middle of the programme's picture.
    """
    footage = Footage(edl.cameras, rate=edl.rate, frames=edl.frames, base=base)
    held = attrs.evolve(edl, movements=unfollowed(edl.movements))
    laid = [("held", Compositor(held, footage)), ("followed", Compositor(edl, footage))]
    column = (width - GAP * (columns + 1)) // columns
    ends = max(0, movement.range.start - 1), min(edl.frames - 1, movement.range.stop)
    rows: list[list[Picture]] = [[], [], []]
    for frame in np.linspace(*ends, columns).round().astype(int).tolist():
        rows[0].append(_thumbnail(footage, _chosen(edl, frame), frame, column, chosen=False))
        for row, (name, compositor) in zip(rows[1:], laid, strict=True):
            picture = _programme(compositor, frame, column)
            _cross(picture)
            _label(picture, f"{format_time(frame / edl.rate)}  {name}", 0.4)
            row.append(picture)
    return _sheet(rows, width)


def head_sheet(edl: Edl, base: Path, moments: Sequence[tuple[int, str]], *, width: int = 1600) -> Picture:
    """Cameras with a head before them: what each shows, the programme that shows it, the programme that sees through.

    Parameters
    ----------
    edl : Edl
        The programme.
    base : Path
        The folder that media paths are relative to.
    moments : sequence of (int, str)
        Programme frames, and the camera that is shown in each, whichever is chosen there.
    width : int
        Of the sheet, in pixels.

    Returns
    -------
    (H, width, 3) uint8
        BGR; a row each.
    """
    footage = Footage(edl.cameras, rate=edl.rate, frames=edl.frames, base=base)
    column = (width - 4 * GAP) // 3
    rows = []
    for frame, camera in moments:
        shown = attrs.evolve(edl, overrides=(Override(FrameRange(0, edl.frames), camera=camera),))
        row = [_thumbnail(footage, camera, frame, column, chosen=False)]
        for name, through in (("as it is", False), ("seen through", True)):
            look = attrs.evolve(edl.look, centering=False, surface=True, see_through=through)
            picture = _programme(Compositor(shown, footage, look=look), frame, column)
            _label(picture, f"{format_time(frame / edl.rate)}  {name}", 0.4)
            row.append(picture)
        rows.append(row)
    return _sheet(rows, width)


def save_picture(picture: Picture, path: Path) -> None:
    """Writes a BGR picture in the format of the path's suffix; any path, since OpenCV's own writer fails silently."""
    write_atomic(path, cv2.imencode(path.suffix, picture)[1].tobytes())


def _sheet(rows: Sequence[Sequence[Picture]], width: int) -> Picture:
    """Rows of pictures of one width, on paper."""
    heights = [max(picture.shape[0] for picture in row) for row in rows]
    sheet = np.full((sum(heights) + GAP * (len(rows) + 1), width, 3), PAPER, np.uint8)
    top = GAP
    for row, height in zip(rows, heights, strict=True):
        for i, picture in enumerate(row):
            left = GAP + i * (picture.shape[1] + GAP)
            sheet[top : top + picture.shape[0], left : left + picture.shape[1]] = picture
        top += height + GAP
    return sheet


def _chosen(edl: Edl, frame: int) -> str:
    return next(decision.camera for piece, decision in resolve(edl) if frame in piece)


def _programme(compositor: Compositor, frame: int, width: int) -> Picture:
    planes = next(iter(compositor.frames(FrameRange(frame, frame + 1))))
    return _fitted(planes_to_bgr(planes), width)


def _thumbnail(footage: Footage, camera: str, frame: int, width: int, *, chosen: bool) -> Picture:
    found = next(iter(footage.pictures(camera, [frame])))[1]
    size = footage.camera(camera).size
    picture = np.zeros((size[1], size[0], 3), np.uint8) if found is None else found
    small = _fitted(picture, width)
    _label(small, camera, 0.36)
    if chosen:
        cv2.rectangle(small, (1, 1), (small.shape[1] - 2, small.shape[0] - 2), (80, 220, 255), 3)
    return small


def _fitted(picture: Picture, width: int) -> Picture:
    height = round(picture.shape[0] * width / picture.shape[1])
    return cv2.resize(picture, (width, height), interpolation=cv2.INTER_AREA)  # pyright: ignore[reportReturnType]


def _cross(picture: Picture) -> None:
    height, width = picture.shape[:2]
    cv2.drawMarker(picture, (width // 2, height // 2), (80, 220, 255), cv2.MARKER_CROSS, width // 12, 1)


def _label(picture: Picture, text: str, scale: float) -> None:
    """Text in the lower left corner; OpenCV's font has ASCII only."""
    shown = text.encode("ascii", "replace").decode()
    write_text(picture, shown, (8, picture.shape[0] - 8), scale)
