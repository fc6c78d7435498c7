"""The surgical field shown: its outline on what the cameras see, with rulers to draw another one by.

Pictures are (H, W, 3) uint8, BGR, in programme pixels before centering.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from mcsl_core.analysis.measurements import load_measurements
from mcsl_core.compositing.placement import camera_placement, laid
from mcsl_core.edl import Edl, FieldStretch
from mcsl_core.edl.field import MIDDLE, field_at, fields_now
from mcsl_core.edl.resolve import resolve
from mcsl_core.errors import McslError, MediaError
from mcsl_core.imaging.lettering import write_text
from mcsl_core.imaging.planes import planes_to_bgr
from mcsl_core.outputs.claim import claim
from mcsl_core.outputs.inputs import inputs_of
from mcsl_core.outputs.manifest import Manifest
from mcsl_core.recording.footage import Footage, footage_of
from mcsl_core.timing import FrameRange

Picture = NDArray[np.uint8]
_LINE, _EDGE, _UNSURE = (80, 255, 255), (0, 0, 0), (200, 200, 200)
_STEPS = (10, 20, 50, 100, 200, 500, 1000, 2000, 5000)


def write_field_picture(edl: Edl, edl_path: Path, out: Path, *, piece: FrameRange | None, force: bool = False) -> int:
    """Writes the field's outline on what the reference camera sees, as a PNG, and returns which frame it is of.

    Parameters
    ----------
    edl, edl_path
        The programme, and its file.
    out
        The picture.
    piece
        Its middle is shown; without, the frame of the longest stretch in which the reference camera sees most of it.
    force
        Replace a file that mcsl did not write, or that was changed since.

    Raises
    ------
    InputError, MediaError
        Where ``out`` may not be written over, or no camera has a picture then.
    """
    output = claim(out, inputs=inputs_of(edl, edl_path), manifest=Manifest.beside(edl_path), force=force)
    frame = (piece.start + piece.stop - 1) // 2 if piece else _clear_frame(edl, edl_path.parent)
    picture = outlined(laid_picture(edl, footage_of(edl, edl_path.parent), frame), field_at(edl, frame))
    output.write(cv2.imencode(".png", with_rulers(picture))[1].tobytes())
    return frame


def _clear_frame(edl: Edl, base: Path) -> int:
    """The frame, of those that poses were solved from, in which the reference camera sees most of the field."""
    longest = max([stretch.range for stretch in fields_now(edl)] or [pose.range for pose in edl.poses], key=len)
    frames = [frame for pose in edl.poses for frame in pose.solved_from if frame in longest]
    try:
        scores = None if edl.scores is None else load_measurements(base / edl.scores).scores
    except McslError:
        scores = None
    if not frames or scores is None or edl.reference not in scores.cameras or not len(scores.frames):
        return frames[len(frames) // 2] if frames else (longest.start + longest.stop - 1) // 2
    seen = np.nan_to_num(scores.visible[:, scores.cameras.index(edl.reference)], nan=-1)
    return max(frames, key=lambda frame: seen[np.abs(scores.frames - frame).argmin()])


def laid_picture(edl: Edl, footage: Footage, frame: int) -> Picture:
    """What the reference camera sees, laid as the look has it; where it has no picture, the shown camera or another."""
    pose = edl.pose_at(frame)
    decision = next(decision for piece, decision in resolve(edl) if frame in piece)
    for name in dict.fromkeys((edl.reference, decision.camera, *(camera.name for camera in edl.cameras))):
        planes = next(footage.planes(name, FrameRange(frame, frame + 1)))
        placement = camera_placement(edl, pose, name, surface=decision.surface)
        if planes is not None and placement is not None:
            return planes_to_bgr(laid(planes, placement, edl.size))
    raise MediaError("no camera has a picture then", where=f"frame {frame}", remedy="Choose another --range")


def outlined(picture: Picture, stretch: FieldStretch | None) -> Picture:
    """The picture with the field's outline; grey where it is only the middle of the picture."""
    made = picture.copy()
    if stretch is None:
        return made
    corners = [np.round(np.array(polygon) * 8).astype(np.int32) for polygon in stretch.polygons]
    width = max(1, round(picture.shape[1] / 480))
    colour = _UNSURE if stretch.by == MIDDLE else _LINE
    for line, thickness in ((_EDGE, 3 * width), (colour, width)):
        cv2.polylines(made, corners, True, line, thickness, cv2.LINE_AA, shift=3)
    return made


def with_rulers(picture: Picture) -> Picture:
    """The picture with pixels counted along its upper and left edge; its own pixels stay where they are."""
    height, width = picture.shape[:2]
    step = next((step for step in _STEPS if width / step <= 12), _STEPS[-1])
    made = picture.copy()
    size = max(0.35, width / 2400)
    for at in range(0, width, step):
        _tick(made, (at, 0), (at, round(0.02 * width)), (at + 3, round(0.02 * width)), size)
    for at in range(step, height, step):
        _tick(made, (0, at), (round(0.02 * width), at), (4, at - 4), size)
    return made


def _tick(picture: Picture, start: Sequence[int], stop: Sequence[int], text: Sequence[int], size: float) -> None:
    number = str(max(start))
    for colour, thickness in (((0, 0, 0), 3), ((255, 255, 255), 1)):
        cv2.line(picture, tuple(start), tuple(stop), colour, thickness)
    write_text(picture, number, (text[0], text[1]), size)
