"""What a pose's plane and its relief leave between the cameras, measured on the pictures: where the same place lies."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from attrs import frozen

from mcsl_core.alignment.correspondences import Correspondences
from mcsl_core.alignment.dense_matching import AlignedCamera, DenseSettings, match_densely, pixels_of
from mcsl_core.compositing.placement import camera_placement
from mcsl_core.compositing.proxy import proxy_edl, proxy_size
from mcsl_core.edl import Edl, Pose
from mcsl_core.edl.field import field_at
from mcsl_core.imaging.geometry import Array
from mcsl_core.imaging.masks import Mask, central_ellipse, polygon_mask
from mcsl_core.imaging.relief import Placement
from mcsl_core.progress import Progress
from mcsl_core.recording.footage import Footage

from .pictures import Picture

_WIDTH = 480  # of the pictures compared: a fifth of a pixel of theirs is seen
_FRAMES = 5  # of a pose, of which ...
_AGREE = 2  # ... so many must show a place alike: hands that move do not


@frozen
class Left:
    """Between a camera and the others, in programme pixels: at half of the places, and at 95 % of them."""

    median: float
    most: float

    def __str__(self) -> str:
        return f"{self.median:.1f} / {self.most:.1f}"


@frozen
class Residuals:
    """Of one camera, by the pose's planes and by its relief."""

    plane: Left
    surface: Left


def residuals(edl: Edl, base: Path, progress: Progress) -> list[Mapping[str, Residuals]]:
    """The cameras of every pose that its relief is of, over the surgical field.

    Parameters
    ----------
    edl : Edl
        The programme.
    base : Path
        The folder that media paths are relative to.
    progress : Progress
        Where it is told how far it has come.

    Returns
    -------
    list of mapping of str to Residuals
        By pose; without cameras that share too little with the others. Empty for a pose without a relief.

    Raises
    ------
    McslError
        Whatever reading the media raises.

    Notes
    -----
    The pictures are matched densely as the relief lays them; the places found are laid by either way.
    """
    small = proxy_edl(edl, proxy_size(edl.size, _WIDTH))
    footage = Footage(small.cameras, rate=edl.rate, frames=edl.frames, base=base)
    reliefs = [pose for pose in small.poses if pose.relief is not None]
    if reliefs:
        progress.stage("Comparing plane and surface", len(reliefs), "poses")
    found: list[Mapping[str, Residuals]] = []
    for pose in small.poses:
        found.append(_of_pose(small, pose, footage, edl.size[0] / small.size[0]) if pose in reliefs else {})
        progress.advance(sum(map(bool, found)))
    return found


def _of_pose(edl: Edl, pose: Pose, footage: Footage, larger: float) -> dict[str, Residuals]:
    assert pose.relief is not None
    frames = _some(pose.solved_from or range(pose.range.start, pose.range.stop))
    cameras: dict[str, AlignedCamera] = {}
    ways: dict[str, tuple[Placement, Placement]] = {}
    for name in pose.relief.projections:
        plane, surface = (camera_placement(edl, pose, name, surface=by) for by in (False, True))
        if plane is None or surface is None:
            continue
        ways[name] = plane, surface
        places = surface.to_camera(pixels_of(edl.size)).reshape(edl.size[1], edl.size[0], 2).astype(np.float32)
        cameras[name] = AlignedCamera(_pictures(footage, name, frames), places, edl.camera(name).size)
    matches = match_densely(cameras, _area(edl, frames[0]), DenseSettings(moments=_AGREE))
    made = {}
    for name in cameras:
        pairs = [(pair, found) for pair, found in matches.items() if name in pair]
        if pairs:
            by = (np.concatenate([_apart(ways, pair, found, way) for pair, found in pairs]) for way in (0, 1))
            made[name] = Residuals(*(Left(*(larger * np.percentile(apart, [50, 95])).tolist()) for apart in by))
    return made


def _apart(ways: Mapping[str, Sequence[Placement]], pair: tuple[str, str], found: Correspondences, way: int) -> Array:
    """How far apart the places of a pair's matches are laid, in pixels of the pictures compared."""
    a, b = (ways[name][way].to_programme(at) for name, at in zip(pair, (found.a, found.b), strict=True))
    return np.hypot(*(a - b).T)


def _some(frames: Sequence[int]) -> list[int]:
    """A few of them, evenly."""
    return sorted({frames[int((i + 0.5) * len(frames) / _FRAMES)] for i in range(_FRAMES)})


def _pictures(footage: Footage, camera: str, frames: Sequence[int]) -> list[Picture | None]:
    shown = dict(footage.pictures(camera, frames))
    return [shown[frame] for frame in frames]


def _area(edl: Edl, frame: int) -> Mask:
    stretch = field_at(edl, frame)
    if stretch is None or not stretch.polygons:
        return central_ellipse(edl.size)
    return polygon_mask([np.array(polygon, np.float64) for polygon in stretch.polygons], edl.size)
