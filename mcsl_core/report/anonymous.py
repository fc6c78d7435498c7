"""A programme without names: what a report shows to people who may not know whose operation it was."""

from __future__ import annotations

import re
from collections.abc import Mapping
from functools import partial
from typing import Any

import attrs

from mcsl_core.analysis.measurements import Measurements
from mcsl_core.edl import Edl, Movement, MovementView, Pose

FILE = "recording"


def nameless(edl: Edl, measured: Measurements | None) -> tuple[Edl, Measurements | None]:
    """The same programme with cameras called cam A, cam B and so on, and without what people wrote into it.

    Its media can still be read by it; `fileless` takes their names away as well.
    """
    names = {camera.name: f"cam {_letters(index)}" for index, camera in enumerate(edl.cameras)}
    made = attrs.evolve(
        edl,
        reference=names[edl.reference],
        cameras=tuple(attrs.evolve(camera, name=names[camera.name]) for camera in edl.cameras),
        movements=tuple(_movement(movement, names) for movement in edl.movements),
        poses=tuple(_pose(pose, names) for pose in edl.poses),
        shots=tuple(attrs.evolve(shot, camera=names[shot.camera], why="") for shot in edl.shots),
        overrides=tuple(attrs.evolve(o, camera=o.camera and names[o.camera], note="") for o in edl.overrides),
        corrections=tuple(attrs.evolve(c, camera=names[c.camera], note="") for c in edl.corrections),
        drawn_fields=tuple(attrs.evolve(drawn, note="") for drawn in edl.drawn_fields),
        audio_from=names.get(edl.audio_from or "", edl.audio_from),
    )
    if measured is None:
        return made, None
    scores = attrs.evolve(measured.scores, cameras=tuple(names.get(name, "") for name in measured.scores.cameras))
    return made, attrs.evolve(measured, scores=scores)


def fileless(edl: Edl) -> Edl:
    """The same programme whose files are called nothing: it can be told of, but not read any more."""
    cameras = (
        attrs.evolve(camera, media=tuple(attrs.evolve(media, path="file", fingerprint="") for media in camera.media))
        for camera in edl.cameras
    )
    made_by = edl.made_by and attrs.evolve(edl.made_by, settings={}, plugins={})
    return attrs.evolve(edl, cameras=tuple(cameras), scores=None, made_by=made_by)


def untold(text: str) -> str:
    """What is lacking, without why: the reason names files."""
    return f"{text.partition(':')[0].rstrip('.')}." if text else ""


def _renamed(by_camera: Mapping[str, Any], names: Mapping[str, str]) -> dict[str, Any]:
    return {names[name]: value for name, value in by_camera.items()}


def _movement(movement: Movement, names: Mapping[str, str]) -> Movement:
    views = (
        MovementView(v.frame, _renamed(v.homographies, names), _renamed(v.projections, names)) for v in movement.views
    )
    return attrs.evolve(movement, views=tuple(views))


def _pose(pose: Pose, names: Mapping[str, str]) -> Pose:
    renamed = partial(_renamed, names=names)
    word = re.compile("|".join(rf"(?<!\w){re.escape(name)}(?!\w)" for name in sorted(names, key=len, reverse=True)))
    return attrs.evolve(
        pose,
        homographies=renamed(pose.homographies),
        colour=renamed(pose.colour),
        colour_keys=renamed(pose.colour_keys),
        residual_px=renamed(pose.residual_px),
        support=renamed(pose.support),
        relief=pose.relief and attrs.evolve(pose.relief, projections=renamed(pose.relief.projections)),
        weak=tuple(
            attrs.evolve(w, camera=names[w.camera], reason=word.sub(lambda found: names[found[0]], w.reason))
            for w in pose.weak
        ),
    )


def _letters(index: int) -> str:
    """A to Z, then AA, AB and so on."""
    before, own = divmod(index, 26)
    return (_letters(before - 1) if before else "") + chr(ord("A") + own)
