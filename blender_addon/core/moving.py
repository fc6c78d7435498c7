# SPDX-License-Identifier: GPL-3.0-or-later
"""Where a camera's picture is shown while the lamp moves and is followed: keys of its strip's transform. No bpy.

A similarity fitted to each view for itself (`similarity.closest`) trembles by a pixel, because points of its grid enter
and leave the picture, and takes a millisecond. So it is fitted at both ends, as the standing strips beside them are,
and carried between them by the similarity that touches the homography at the field's middle: within 1.5 px of the fits
over the field of recordings 640 px wide, a hundred times as steady, and twenty times as fast.
"""

from __future__ import annotations

from itertools import pairwise
from math import pi

import attrs
from attrs import frozen

from mcsl_core.edl import Camera, Edl, Matrix, Movement, Pose
from mcsl_core.edl.checks import IDENTITY
from mcsl_core.edl.following import homographies_at, poses_beside, shown_at
from mcsl_core.edl.placement import multiply
from mcsl_core.timing import FrameRange

from .camera_places import corrected, field_middle
from .similarity import Transform, closest, fitted, invert, matrix_of, touching, transform_of


@frozen
class TransformKey:
    """A strip's transform at a frame, linear to the next key; ``hold`` keeps it until then.

    planned: the transform without any correction.
    """

    frame: int
    transform: Transform
    planned: Transform
    hold: bool = False


def followed_ranges(edl: Edl) -> list[tuple[FrameRange, Movement]]:
    """The frames over which the lamp is followed, in order, and the movement of each."""
    return [(FrameRange(m.views[0].frame, m.views[-1].frame + 1), m) for m in edl.movements if m.views]


def moving_keys(edl: Edl, camera: Camera, movement: Movement) -> tuple[TransformKey, ...]:
    """A key at every view of a movement, and at both sides of where a pose begins: there corrections change.

    A camera that is not known at a view is shown upright and whole, as in a pose.
    """
    first, last = movement.views[0].frame, movement.views[-1].frame
    begin = [pose.range.start for pose in edl.poses if first < pose.range.start <= last]
    frames = sorted({*(view.frame for view in movement.views), *begin, *(frame - 1 for frame in begin)})
    shown = {n: homographies_at(movement, {camera.name: shown_at(camera, n, edl.rate)}) for n in frames}
    planned = _carried(edl, camera, movement, {n: h[camera.name] for n, h in shown.items() if h})
    keys: list[TransformKey] = []
    for n in frames:
        bare = planned.get(n) or fitted(camera.size, edl.size)
        pose = Pose(FrameRange(n, n + 1), shown[n], anchor=IDENTITY)
        keys.append(TransformKey(n, corrected(edl, camera, pose, bare), bare))
    held = [(a.frame in planned) != (b.frame in planned) for a, b in pairwise(keys)]
    keys = [attrs.evolve(key, hold=hold) for key, hold in zip(keys, [*held, False], strict=True)]
    return tuple(_unwound(keys))


def _carried(edl: Edl, camera: Camera, movement: Movement, homographies: dict[int, Matrix]) -> dict[int, Transform]:
    """The transform at each frame of ``homographies``; the closest one at the first and at the last of them."""
    if not homographies:
        return {}
    fields = [field_middle(edl, pose) for pose in poses_beside(edl, movement)]
    first, last = min(homographies), max(homographies)
    ways = {n: (n - first) / max(last - first, 1) for n in homographies}
    touch = {n: touching(matrix, fields[0] + ways[n] * (fields[1] - fields[0])) for n, matrix in homographies.items()}
    fits = {n: closest(homographies[n], camera.size, edl.size, at) for n, at in zip((first, last), fields, strict=True)}
    ends = [(matrix_of(fits[n], camera.size, edl.size), touch[n]) for n in (first, last)]
    rests = [multiply(fit, invert(rough)) for fit, rough in ends if rough is not None]
    found = {}
    for n, rough in touch.items():
        carried = None
        if rough is not None and len(rests) == 2:
            carried = transform_of(multiply(_between(rests[0], rests[1], ways[n]), rough), camera.size, edl.size)
        # the field lies outside of what the camera can see: rare, and nothing to touch
        found[n] = carried or closest(homographies[n], camera.size, edl.size, fields[0])
    return found | fits


def _between(a: Matrix, b: Matrix, part: float) -> Matrix:
    rows = [tuple(x + part * (y - x) for x, y in zip(*row, strict=True)) for row in zip(a, b, strict=True)]
    return rows[0], rows[1], rows[2]  # pyright: ignore[reportReturnType]


def _unwound(keys: list[TransformKey]) -> list[TransformKey]:
    """Every turn is the one nearest to that of the key before, so that nothing spins round between the two."""
    found: list[TransformKey] = []
    for key in keys:
        if found:
            before = found[-1]
            shown = _nearest(key.transform, before.transform)
            key = attrs.evolve(key, transform=shown, planned=_nearest(key.planned, before.planned))
        found.append(key)
    return found


def _nearest(transform: Transform, before: Transform) -> Transform:
    turns = round((before.rotation - transform.rotation) / (2 * pi))
    return attrs.evolve(transform, rotation=transform.rotation + 2 * pi * turns)
