# SPDX-License-Identifier: GPL-3.0-or-later
"""The time in which the timeline runs, as found: the scene's, and that of every strip of ours that plays a file."""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction
from pathlib import PurePath
from typing import Any

from ..core.times import FoundFilm, SceneTime
from .compat import content_start, ends
from .scene_properties import FALLEN, placed_of, role_of

_FILMS = {"MOVIE": ("camera", "conformed"), "SOUND": ("sound",)}
_SLOWER = ("SPEED",)  # effects that show other frames than those that are due


def read_scene_time(scene: Any) -> SceneTime:
    """How the scene counts and shows time."""
    render = scene.render
    return SceneTime(
        rate=Fraction(render.fps) / Fraction(render.fps_base),
        step=scene.frame_step,
        stretched=render.frame_map_old != render.frame_map_new,
        first=scene.frame_start,
        last=scene.frame_end,
        size=(render.resolution_x, render.resolution_y),
    )


def read_films(scene: Any) -> tuple[FoundFilm, ...]:
    """Camera, conformed, sound and Centering strips; those of the sound in meta strips too."""
    every = [(strip, strip.type) for strip in scene.sequence_editor.strips_all]
    speeds = {e.input_1.name: e.name for e, kind in every if kind in _SLOWER and e.input_1 is not None}
    films = (strip for strip, kind in every if kind in _FILMS and role_of(strip) in _FILMS[kind])
    return tuple(_film(strip, speeds) for strip in films)


def _film(strip: Any, speeds: dict[str, str]) -> FoundFilm:
    start, stop = ends(strip)
    if strip.type == "SOUND":
        file = "" if strip.sound is None else PurePath(strip.sound.filepath.removeprefix("//")).name
    else:
        file = PurePath(strip.filepath.removeprefix("//")).name
    placed = placed_of(strip)
    role = role_of(strip)
    laid = placed[0] if placed is not None and placed[1] == file else None
    if laid is None and role == "conformed" and file.split("-")[0].isdigit():
        laid = int(file.split("-")[0])  # a conformed file says itself where it belongs
    if laid is None and role == "sound" and file.startswith("sound-"):
        laid = 0
    return FoundFilm(
        role=role,
        name=strip.name,
        start=start,
        stop=stop,
        content=content_start(strip),
        frames=strip.frame_duration,
        file=file,
        laid=laid,
        muted=bool(strip.mute) and FALLEN not in strip,
        odd=tuple(_odd(strip, speeds)),
    )


def _odd(strip: Any, speeds: dict[str, str]) -> Iterator[str]:
    if len(getattr(strip, "retiming_keys", ())):
        yield "retimed"
    if getattr(strip, "use_reverse_frames", False):
        yield "reversed"
    if getattr(strip, "strobe", 1.0) > 1:
        yield f"shown every {strip.strobe:g} frames"
    if strip.name in speeds:
        yield f"under the Speed effect {speeds[strip.name]!r}"
