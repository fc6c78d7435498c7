# SPDX-License-Identifier: GPL-3.0-or-later
"""A scene that shows of another's programme what is not removed, closed up, picture and sound."""

from __future__ import annotations

import time
import wave
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import bpy  # pyright: ignore[reportMissingImports]
import numpy as np

from mcsl_core.errors import BlenderError, InputError
from mcsl_core.fades import FADE_FRAMES, gain
from mcsl_core.timing import FrameRange

from .compat import set_content_start, set_ends
from .scene_properties import DELIVERED, MARK

_PATIENCE_S = 60  # without a sample more


def delivered_scene(scene: Any, pieces: Sequence[FrameRange], folder: Path, *, sound: bool) -> Any:
    """A new scene of ``scene``'s settings that plays these programme frames one after another.

    Scene strips show the other's sequencer. They would play its sound as well, but a quarter of a frame late and a
    frame too long (5.0.1): so that is mixed into a file in ``folder``, cut there and laid beside them.

    Raises
    ------
    InputError
        ``scene`` does not play the programme from frame 1 on, so that other frames would be shown.
    BlenderError
        The sound does not come.
    """
    if scene.frame_start != 1 or scene.frame_end < pieces[-1].stop:
        raise InputError(
            f"plays frames {scene.frame_start} to {scene.frame_end}, where what is removed cannot be left out",
            where=f"scene {scene.name!r}",
            remedy=f"Set its frame range to 1 to {pieces[-1].stop} or more",
        )
    new = scene.copy()
    new.name = f"{scene.name} delivered"
    for name in [name for name in new.keys() if name.startswith(MARK)]:  # noqa: SIM118 - a scene is no mapping
        del new[name]  # it is no timeline
    new[DELIVERED] = True
    new.use_preview_range = False
    new.animation_data_clear()  # a copy shares the programme's keys
    new.sequence_editor_clear()
    strips = new.sequence_editor_create().strips
    at = 0
    for piece in pieces:
        strip = strips.new_scene(name=str(piece.start), scene=scene, channel=1, frame_start=1 + scene.frame_end + at)
        strip.scene_input = "SEQUENCER"
        strip.volume = 0.0
        set_ends(strip, *(scene.frame_end + at + end for end in (piece.start, piece.stop)))
        set_content_start(strip, at - piece.start)
        at += len(piece)
    new.frame_start, new.frame_end = 1, at
    if sound:
        mixed = _mixed(scene, folder / "mixed.wav")
        _close_up(mixed, pieces, scene.render.fps / scene.render.fps_base, folder / "delivered.wav")
        strips.new_sound(name="sound", filepath=str(folder / "delivered.wav"), channel=2, frame_start=1)
    return new


def drop_delivered() -> None:
    """Removes every scene that `delivered_scene` made, also of a file that was saved while one was rendered."""
    for scene in [scene for scene in bpy.data.scenes if scene.get(DELIVERED)]:
        bpy.data.scenes.remove(scene)


def _mixed(scene: Any, path: Path) -> Path:
    """All that is heard of a scene, as a file. BlenderError where it does not come."""
    with bpy.context.temp_override(scene=scene):
        bpy.ops.sound.mixdown(filepath=str(path), container="WAV", codec="PCM", format="S16", accuracy=1024)
    size, since = -1, time.monotonic()  # from 5.2 on it is mixed in the background, whatever is returned
    while not _is_whole(path):
        now = path.stat().st_size if path.is_file() else -1
        if now != size:
            size, since = now, time.monotonic()
        elif time.monotonic() - since > _PATIENCE_S:
            raise BlenderError("Blender did not mix the sound", where=str(path), remedy="See whether the disk is full")
        time.sleep(0.05)
    return path


def _is_whole(path: Path) -> bool:
    """Whether a WAV file has all that its header promises, which is written last; until then that is 4 GiB."""
    try:
        with wave.open(str(path)) as sound:
            promised = sound.getnframes() * sound.getnchannels() * sound.getsampwidth()
    except (OSError, EOFError, wave.Error):
        return False
    return 0 < promised <= path.stat().st_size


def _close_up(source: Path, pieces: Sequence[FrameRange], rate: float, path: Path) -> None:
    """The sound of these frames one after another; it falls to silence where one ends, and rises at the next."""
    with wave.open(str(source)) as whole, wave.open(str(path), "wb") as out:
        out.setparams(whole.getparams())
        a_frame, channels = whole.getframerate() / rate, whole.getnchannels()
        frames = given = 0
        for number, piece in enumerate(pieces):
            frames += len(piece)
            count = round(frames * a_frame) - given
            given += count
            whole.setpos(min(round(piece.start * a_frame), whole.getnframes()))
            seams = {"rises": number > 0, "falls": number < len(pieces) - 1}
            for at in range(0, count, whole.getframerate()):  # by the second: a piece may last for hours
                length = min(whole.getframerate(), count - at)
                sound = np.zeros((length, channels))
                read = np.frombuffer(whole.readframes(length), "<i2").reshape(-1, channels)
                sound[: len(read)] = read
                sound *= gain(at, length, count, round(FADE_FRAMES * a_frame), **seams)[:, None]
                out.writeframes(np.round(sound).astype("<i2").tobytes())
