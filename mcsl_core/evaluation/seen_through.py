"""What a programme shows under heads from other cameras: when, how much of the surgical field, and whose pictures."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import closing
from pathlib import Path

import cv2
import numpy as np

from mcsl_core.compositing.compositor import Compositor
from mcsl_core.compositing.proxy import ProxyFootage, proxy_edl, proxy_size
from mcsl_core.edl import Edl
from mcsl_core.edl.dependencies import sees_through
from mcsl_core.edl.field import field_at
from mcsl_core.edl.resolve import resolve_by_pose
from mcsl_core.filling.visual_hull import COLUMNS, Cells
from mcsl_core.imaging.masks import polygon_mask
from mcsl_core.progress import Progress
from mcsl_core.timing import FrameRange

from .results import SeenThrough

_LOOK_S = 0.5  # from one look to the next
_LEAST = 0.005  # of the field: less is not told


def seen_through(edl: Edl, base: Path, progress: Progress) -> tuple[SeenThrough, ...]:
    """The stretches in which a programme sees through heads, by a look twice a second.

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
    tuple of SeenThrough
        In order; empty, and nothing decoded, where nothing is to be seen through.
    """
    parts = [(part, d.camera) for part, d, i in resolve_by_pose(edl) if sees_through(edl.poses[i], d)]
    step = max(1, round(_LOOK_S * edl.rate))
    looks = [(part, camera, range(part.start, part.stop, step)) for part, camera in parts]
    if not looks:
        return ()
    size, found, done = proxy_size(edl.size, 4 * COLUMNS), [], 0
    progress.stage("Measuring what is seen through", sum(len(frames) for _, _, frames in looks), "frames")
    with closing(ProxyFootage(edl, base, size)) as footage, Compositor(proxy_edl(edl, size), footage) as compositor:
        for part, camera, frames in looks:
            shares = []
            for frame in frames:
                shares.append(_shares(edl, frame, compositor.seen_through(frame)))
                done += 1
                progress.advance(done)
            found += _stretches(part, camera, frames, shares)
    return tuple(found)


def _shares(edl: Edl, frame: int, weights: Mapping[str, Cells]) -> dict[str, float]:
    """By camera, of the field, or of the middle that stands for it; of the picture where the EDL knows neither."""
    if not weights:
        return {}
    stretch, shape = field_at(edl, frame), next(iter(weights.values())).shape
    inside = np.ones(shape, np.float32)
    if stretch is not None:
        full = polygon_mask([np.array(polygon) for polygon in stretch.polygons], edl.size)
        inside = cv2.resize(full.astype(np.float32), shape[::-1], interpolation=cv2.INTER_AREA)
    whole = max(float(inside.sum()), 1e-6)
    return {name: float((weight * inside).sum()) / whole for name, weight in weights.items()}


def _stretches(
    part: FrameRange, camera: str, frames: range, shares: Sequence[Mapping[str, float]]
) -> list[SeenThrough]:
    """What was looked at in one part of the programme, as stretches in which something is seen through."""
    found: list[SeenThrough] = []
    run: list[int] = []
    for n in range(len(frames) + 1):
        if n < len(frames) and sum(shares[n].values()) >= _LEAST:
            run.append(n)
        elif run:
            own = [shares[i] for i in run]
            sums = [sum(each.values()) for each in own]
            names = sorted({name for each in own for name in each})
            by = {name: float(np.mean([each.get(name, 0.0) for each in own])) for name in names}
            stretch = FrameRange(frames[run[0]], min(frames[run[-1]] + frames.step, part.stop))
            found.append(SeenThrough(stretch, camera, float(np.mean(sums)), max(sums), by))
            run = []
    return found
