# SPDX-License-Identifier: GPL-3.0-or-later
"""A render preset's Blender half -> the scene's output settings.

Pictures are never stamped, and the file carries no times, paths or names.
"""

from __future__ import annotations

from typing import Any

import bpy  # pyright: ignore[reportMissingImports]

from mcsl_core.delivery.presets import Preset

STAMPS = ("time", "date", "frame", "frame_range", "camera", "lens", "scene", "note", "marker", "filename")
STAMPS += ("sequencer_strip", "render_time", "memory", "hostname")


def apply(scene: Any, preset: Preset, filepath: str, *, sound: bool) -> None:
    """Sets format, codecs and size. filepath may begin with // (beside the .blend). sound: False writes no track."""
    render, wanted = scene.render, preset.blender
    render.resolution_percentage = preset.scale_percent
    render.resolution_x = _even(render.resolution_x, preset.scale_percent)
    render.resolution_y = _even(render.resolution_y, preset.scale_percent)
    image = render.image_settings
    if bpy.app.version >= (5, 0, 0):
        image.media_type = "VIDEO"
    image.file_format = "FFMPEG"
    image.color_mode = "RGB"
    image.color_management = "FOLLOW_SCENE"
    ffmpeg = render.ffmpeg
    ffmpeg.format = wanted.format
    ffmpeg.codec = wanted.codec
    ffmpeg.constant_rate_factor = wanted.quality
    ffmpeg.ffmpeg_preset = wanted.speed
    ffmpeg.gopsize = wanted.gop
    ffmpeg.use_max_b_frames = False
    ffmpeg.use_autosplit = False
    ffmpeg.use_lossless_output = False
    if wanted.prores_profile:
        ffmpeg.ffmpeg_prores_profile = wanted.prores_profile
    image.color_depth = wanted.depth
    ffmpeg.audio_codec = wanted.audio_codec if sound else "NONE"
    ffmpeg.audio_bitrate = wanted.audio_kbps
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
