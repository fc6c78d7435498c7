"""A small recording whose pictures carry coded numbers, its EDL, and scripts run in a Blender on it."""

from __future__ import annotations

import json
import subprocess
import textwrap
from fractions import Fraction
from pathlib import Path

import numpy as np

from mcsl_core.blender.child import search_paths
from mcsl_core.blender.installation import Blender
from mcsl_core.edl import IDENTITY, Camera, Clock, Edl, Media, Movement, Override, Pose, Shot
from mcsl_core.media.writing import Encoding, VideoWriter
from mcsl_core.timing import FrameRange

R = FrameRange
SIZE = (320, 180)
RATE = Fraction(30000, 1001)
FRAMES = 60
BITS = 8
BLOCK = 16  # pixels a side of one bit, several macroblock edges clear of its neighbours
LIGHT = {"cam1": 60, "cam2": 100, "cam3": 140}  # each camera's ground, so that a picture tells where it is from

SWITCH_ON = f"""
    import warnings
    warnings.simplefilter("error")
    sys.path.extend({search_paths()!r})
    import blender_addon
    blender_addon.register()
"""


def picture(number: int, ground: int = 60, size: tuple[int, int] = SIZE) -> np.ndarray:
    """BGR: ``number`` as black and white blocks in two rows round the middle, on a grey ground with a few marks."""
    width, height = size
    image = np.full((height, width, 3), ground, np.uint8)
    image[: height // 4, :, 0] = np.linspace(20, 220, width).astype(np.uint8)  # colours and edges, clear of the blocks
    image[-height // 4 :, :, 2] = np.linspace(220, 20, width).astype(np.uint8)
    image[8:28, 30:60], image[-30:-8, -70:-40] = (40, 40, 200), (60, 180, 40)
    left, top = width // 2 - 2 * (BLOCK + 8), height // 2 - BLOCK - 4
    for bit in range(BITS):
        x, y = left + (bit % 4) * (BLOCK + 8), top + (bit // 4) * (BLOCK + 8)
        image[y : y + BLOCK, x : x + BLOCK] = 235 if number >> bit & 1 else 16
    return image


def number_of(luma: np.ndarray) -> int:
    """The number in the blocks of a luma picture of any size; AssertionError when a block is neither dark nor light."""
    height = luma.shape[0]
    scale = height / SIZE[1]
    value = 0
    for bit in range(BITS):
        x = SIZE[0] // 2 - 2 * (BLOCK + 8) + (bit % 4) * (BLOCK + 8)
        y = SIZE[1] // 2 - BLOCK - 4 + (bit // 4) * (BLOCK + 8)
        x0, x1, y0, y1 = (round(v * scale) for v in (x + 4, x + BLOCK - 4, y + 4, y + BLOCK - 4))
        level = float(luma[y0:y1, x0:x1].mean())
        assert level < 90 or level > 165, f"bit {bit} at {level:.0f}"
        value |= int(level > 165) << bit
    return value


def ground_of(luma: np.ndarray) -> str:
    """The camera whose ground the picture has at its left edge, inside limited range."""
    height, width = luma.shape
    level = float(luma[height // 3 : height // 2, width // 8 : width // 5].mean())
    codes = {name: 16 + light * 219 / 255 for name, light in LIGHT.items()}
    return min(codes, key=lambda name: abs(codes[name] - level))


def write_camera(path: Path, name: str, frames: int, *, first: int = 0, sound: bool = True) -> None:
    """A camera's file: pictures numbered from ``first``, and a tone."""
    samples = round(48000 * frames / RATE)
    with VideoWriter(
        path,
        size=SIZE,
        rate=RATE,
        encoding=Encoding(options={"preset": "ultrafast", "crf": "12"}),
        keyframe_interval=15,
        audio_rate=48000 if sound else None,
    ) as writer:
        for number in range(first, first + frames):
            writer.write(picture(number, LIGHT[name]))
        if sound:
            tone = 0.25 * np.sin(2 * np.pi * 440 * np.arange(samples) / 48000)
            writer.write_audio(tone.astype(np.float32)[:, None])


def an_edl(**fields) -> Edl:
    """Two poses, a movement, three shots, an override; identity homographies, so that the blocks stay readable."""
    late = Clock(offset_s=float(3 / RATE), method="audio", confidence=0.9)
    given = {
        "rate": RATE,
        "size": SIZE,
        "frames": FRAMES,
        "reference": "cam1",
        "cameras": (
            Camera("cam1", (Media("cam1_a.mp4", 40), Media("cam1_b.mp4", FRAMES - 40)), SIZE, RATE),
            Camera("cam2", (Media("cam2.mp4", FRAMES - 3),), SIZE, RATE, late),
            Camera("cam3", (Media("cam3.mp4", FRAMES),), SIZE, RATE),
        ),
        "movements": (Movement(R(28, 32)),),
        "poses": (
            Pose(R(0, 30), dict.fromkeys(LIGHT, IDENTITY)),
            Pose(R(30, FRAMES), dict.fromkeys(LIGHT, IDENTITY), perspective=1),
        ),
        "shots": (Shot(R(0, 20), "cam1"), Shot(R(20, 40), "cam2"), Shot(R(40, FRAMES), "cam3")),
        "overrides": (Override(R(45, 50), camera="cam1", note="kept"),),
    }
    return Edl(**{**given, **fields})


def in_blender(blender: Blender, blend: Path, code: str, *, save: bool = True):
    """Runs ``code`` on an open .blend as an editor's script would, saves, and returns what it put into ``out``.

    ``scene``, ``strips`` (by name lookups), ``bpy`` and ``at(channel, frame)`` (a programme frame) are at hand.
    """
    answer, script = blend.parent / ".answer.json", blend.parent / ".script.py"
    script.write_text(
        f"""
import bpy, json, os, sys, traceback
code = 1
try:
    bpy.ops.wm.open_mainfile(filepath={str(blend)!r})
    scene = next(s for s in bpy.data.scenes if s.get("mcsl_edl"))
    strips = scene.sequence_editor.strips
    def span(s):
        if hasattr(s, "left_handle"): return [int(s.left_handle) - 1, int(s.right_handle) - 1]
        return [int(s.frame_final_start) - 1, int(s.frame_final_end) - 1]
    def at(channel, frame):
        return next(s for s in strips if s.channel == channel and span(s)[0] <= frame < span(s)[1])
    def cut(s, start, stop):
        if hasattr(s, "left_handle"): s.left_handle, s.right_handle = start + 1, stop + 1
        else: s.frame_final_start, s.frame_final_end = start + 1, stop + 1
    out = None
{textwrap.indent(textwrap.dedent(code), "    ")}
    with open({str(answer)!r}, "w") as stream: json.dump(out, stream)
    if {save}: bpy.ops.wm.save_mainfile()
    code = 0
except BaseException:
    traceback.print_exc()
sys.stderr.flush()
os._exit(code)
""",
        encoding="utf-8",
    )
    start = ["-b", "--factory-startup", "-P"] if blender.kind == "binary" else ["-W", "ignore"]
    done = subprocess.run([*blender.command, *start, str(script)], capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stdout[-2000:] + done.stderr[-3000:]
    return json.loads(answer.read_text())
