# SPDX-License-Identifier: GPL-3.0-or-later
"""A render preset's Blender half -> the scene's output settings.

The values come as plain JSON (mcsl_core/presets.py checks them): format, codec, quality, speed, gop, prores_profile,
depth, audio_codec, audio_kbps, scale_percent. Pictures are never stamped and the file carries no times, paths or names.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import bpy  # pyright: ignore[reportMissingImports]

STAMPS = ("time", "date", "frame", "frame_range", "camera", "lens", "scene", "note", "marker", "filename")
STAMPS += ("sequencer_strip", "render_time", "memory", "hostname")


def apply(scene: Any, preset: Mapping[str, Any], filepath: str, *, sound: bool) -> None:
    """Sets format, codecs and size. filepath may begin with // (beside the .blend). sound: False writes no track."""
    render = scene.render
    render.resolution_percentage = preset["scale_percent"]
    render.resolution_x = _even(render.resolution_x, preset["scale_percent"])
    render.resolution_y = _even(render.resolution_y, preset["scale_percent"])
    image = render.image_settings
    if bpy.app.version >= (5, 0, 0):
        image.media_type = "VIDEO"
    image.file_format = "FFMPEG"
    image.color_mode = "RGB"
    image.color_management = "FOLLOW_SCENE"
    ffmpeg = render.ffmpeg
    ffmpeg.format = preset["format"]
    ffmpeg.codec = preset["codec"]
    ffmpeg.constant_rate_factor = preset["quality"]
    ffmpeg.ffmpeg_preset = preset["speed"]
    ffmpeg.gopsize = preset["gop"]
    ffmpeg.use_max_b_frames = False
    ffmpeg.use_autosplit = False
    ffmpeg.use_lossless_output = False
    if preset["prores_profile"]:
        ffmpeg.ffmpeg_prores_profile = preset["prores_profile"]
    image.color_depth = preset["depth"]
    ffmpeg.audio_codec = preset["audio_codec"] if sound else "NONE"
    ffmpeg.audio_bitrate = preset["audio_kbps"]
    ffmpeg.audio_mixrate = 48000
    ffmpeg.audio_channels = "STEREO"
    render.use_file_extension = False  # with it Blender adds the frame range to a name that lacks the extension
    render.filepath = filepath
    for stamp in STAMPS:
        setattr(render, f"use_stamp_{stamp}", False)


def _even(size: int, percent: int) -> int:
    """The largest size up to ``size`` that is even when delivered: 4:2:0 codecs refuse others. Takes 3 pixels at most
    off a programme at 50 %, half of them on each side.
    """
    while size * percent // 100 % 2:
        size -= 1
    return size
