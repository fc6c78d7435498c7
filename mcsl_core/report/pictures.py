"""The report's pictures: each pose's cameras laid over each other before and after alignment, and the programme.

Pictures are BGR, (H, W, 3) uint8, and go into the page as data: it fetches nothing.
"""

from __future__ import annotations

import base64
from collections.abc import Mapping, Sequence
from contextlib import closing
from pathlib import Path

import cv2
import numpy as np
from attrs import frozen
from numpy.typing import NDArray

from mcsl_core.compositing.compositor import Compositor
from mcsl_core.compositing.coverage import Coverage
from mcsl_core.compositing.placement import camera_placement, laid
from mcsl_core.compositing.proxy import proxy_edl, proxy_filler, proxy_size
from mcsl_core.edl import Edl, Pose
from mcsl_core.edl.field import field_at
from mcsl_core.edl.resolve import resolve
from mcsl_core.imaging.geometry import scaling
from mcsl_core.imaging.planes import Planes, planes_to_bgr
from mcsl_core.imaging.relief import Placement
from mcsl_core.occlusion.score_table import ScoreTable
from mcsl_core.progress import Progress
from mcsl_core.recording.footage import Footage
from mcsl_core.timing import FrameRange

from .field_picture import outlined

WIDTH = 480  # of the pictures: sharp enough to see a ghost of two pixels in 640, 20 to 40 kB each
_QUALITY = 80

Picture = NDArray[np.uint8]


@frozen
class PosePictures:
    """One pose at one frame.

    Attributes
    ----------
    frame : int
        The programme frame.
    camera : str
        The chosen camera.
    before, after, programme, field : str
        The pictures as data URLs; the last one, of the field's outline, empty where the EDL does not tell it.
    views : int
        How many cameras lie in ``after``.
    size : (int, int)
        Width and height of the pictures.
    shares : mapping of str to float
        By camera: share of the programme's pixels that come from it, the chosen one's first; pixels that no camera
        covers are missing to 1.
    """

    frame: int
    camera: str
    before: str
    after: str
    programme: str
    field: str
    views: int
    size: tuple[int, int]
    shares: Mapping[str, float]


def pose_pictures(edl: Edl, base: Path, scores: ScoreTable | None, progress: Progress) -> list[PosePictures | None]:
    """The pictures of every pose.

    Parameters
    ----------
    edl : Edl
        The programme.
    base : Path
        The folder that media paths are relative to.
    scores : ScoreTable or None
        The visible field of each camera over time, if it is known; see `clearest`.
    progress : Progress
        Where it is told how far it has come.

    Returns
    -------
    list of PosePictures or None
        None for a pose in which no camera has a picture.

    Raises
    ------
    McslError
        Whatever reading the media raises.
    """
    size = proxy_size(edl.size, WIDTH)
    small = proxy_edl(edl, size)
    footage = Footage(small.cameras, rate=edl.rate, frames=edl.frames, base=base)
    compositor = Compositor(small, footage, filler=proxy_filler(edl, size))
    coverage = Coverage(small, footage, filler=proxy_filler(edl, size))
    made: list[PosePictures | None] = []
    progress.stage("Taking the report's pictures", len(edl.poses), "poses")
    with closing(compositor):
        for index, pose in enumerate(small.poses):
            frame = clearest(pose, scores)
            planes = {c.name: compositor.picture(c.name, frame) for c in small.cameras}
            pictures = {name: own for name, own in planes.items() if own is not None}
            made.append(_of_pose(small, pose, frame, pictures, compositor, coverage) if pictures else None)
            progress.advance(index + 1)
    return made


def clearest(pose: Pose, scores: ScoreTable | None) -> int:
    """The frame a pose is shown at: of those it was solved from, the one in which the cameras see most together.

    Parameters
    ----------
    pose : Pose
        The pose.
    scores : ScoreTable or None
        The visible field of each camera over time; without it, the middle one of the frames.

    Returns
    -------
    int
        A programme frame of the pose.
    """
    candidates = pose.solved_from or ((pose.range.start + pose.range.stop) // 2,)
    inside = [frame for frame in candidates if frame in pose.range] or [(pose.range.start + pose.range.stop) // 2]
    if scores is None or not len(scores.frames):
        return inside[len(inside) // 2]
    rows = [int(np.abs(scores.frames - frame).argmin()) for frame in inside]
    sums = [float(np.nansum(scores.visible[row])) for row in rows]
    return inside[int(np.argmax(sums))]


def _of_pose(
    edl: Edl,
    pose: Pose,
    frame: int,
    pictures: Mapping[str, Planes],
    compositor: Compositor,
    coverage: Coverage,
) -> PosePictures:
    decision = next(decision for piece, decision in resolve(edl) if frame in piece)
    plain = {name: Placement(scaling(own.size, edl.size)) for name, own in pictures.items()}
    placed = {name: camera_placement(edl, pose, name, surface=decision.surface) for name in pictures}
    aligned = {name: placement for name, placement in placed.items() if placement is not None}
    shares = {name: float(share.mean()) for name, share in coverage.shares(frame).items()}
    order = sorted(shares, key=lambda name: (name != decision.camera, -shares[name]))
    return PosePictures(
        frame,
        decision.camera,
        before=data_url(superimposed(pictures, plain, edl.size)),
        after=data_url(superimposed(pictures, aligned, edl.size)),
        programme=data_url(planes_to_bgr(next(iter(compositor.frames(FrameRange(frame, frame + 1)))))),
        field=_field(edl, frame, pictures, aligned),
        views=len(aligned),
        size=edl.size,
        shares={name: shares[name] for name in order if shares[name] >= 0.005},
    )


def _field(edl: Edl, frame: int, pictures: Mapping[str, Planes], aligned: Mapping[str, Placement]) -> str:
    """The field's outline on what the reference camera sees, or the first camera that has a picture."""
    stretch = field_at(edl, frame)
    name = edl.reference if edl.reference in aligned else next(iter(aligned), None)
    if stretch is None or name is None:
        return ""
    return data_url(outlined(planes_to_bgr(laid(pictures[name], aligned[name], edl.size)), stretch))


def superimposed(pictures: Mapping[str, Planes], placements: Mapping[str, Placement], size: tuple[int, int]) -> Picture:
    """Pictures laid over each other: the mean at each pixel, so that what agrees stays sharp.

    Parameters
    ----------
    pictures : mapping of str to Planes
        By camera.
    placements : mapping of str to Placement
        By camera: where its picture lies; only the cameras named here are used.
    size : (int, int)
        Width and height of the programme.

    Returns
    -------
    (H, W, 3) uint8
        BGR, black where no picture reaches.
    """
    total = np.zeros((size[1], size[0], 3), np.float32)
    weight = np.zeros((size[1], size[0]), np.float32)
    for name, placement in placements.items():
        own = pictures[name]
        white = Planes(np.full_like(own.y, 235), np.full_like(own.u, 128), np.full_like(own.v, 128))
        inside = (laid(white, placement, size).y.astype(np.float32) - 16) / 219
        total += planes_to_bgr(laid(own, placement, size)) * (inside > 0)[..., None]
        weight += inside
    return np.round(total / np.maximum(weight, 1)[..., None]).clip(0, 255).astype(np.uint8)


def data_url(picture: Picture) -> str:
    """A JPEG as text for the page."""
    options: Sequence[int] = [cv2.IMWRITE_JPEG_QUALITY, _QUALITY]
    data = cv2.imencode(".jpg", picture, options)[1].tobytes()
    return "data:image/jpeg;base64," + base64.b64encode(data).decode()
