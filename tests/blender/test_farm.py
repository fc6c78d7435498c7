"""An operation rendered as a farm does it: by the program of Open Job Description, and Blender by pieces."""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
from pathlib import Path

import attrs
import av
import numpy as np
import pytest
from blender_recording import FRAMES, ground_of, number_of

from mcsl_core import edl as edls
from mcsl_core.archive import openjd
from mcsl_core.blender.installation import Blender
from mcsl_core.blender.render import render
from mcsl_core.delivery.presets import preset_of

# `blender` where Blender is a module of a Python: those of its options that the template has, in their order.
AS_A_PROGRAM = """
import sys
import bpy
words = sys.argv[1:]
while words:
    word = words.pop(0)
    scene = bpy.context.scene
    if word == "-b":
        bpy.ops.wm.open_mainfile(filepath=words.pop(0))
    elif word == "--python-exit-code":
        words.pop(0)
    elif word == "--python-expr":
        exec(words.pop(0), {})
    elif word == "-o":
        scene.render.filepath = words.pop(0)
    elif word == "-s":
        scene.frame_start = int(words.pop(0))
    elif word == "-e":
        scene.frame_end = int(words.pop(0))
    elif word == "-a":
        bpy.ops.render.render(animation=True, scene=scene.name)
    else:
        sys.exit("no option " + word)
"""


def program(path: Path, *words: str) -> Path:
    quoted = " ".join(f"'{word}'" for word in words)
    path.write_text(f'#!/bin/sh\nexec {quoted} "$@"\n')
    path.chmod(0o755)
    return path


def as_a_program(blender: Blender, folder: Path) -> Path:
    if blender.kind == "binary":
        return program(folder / "blender", *blender.command)
    (folder / "as_a_program.py").write_text(AS_A_PROGRAM)
    return program(folder / "blender", *blender.command, str(folder / "as_a_program.py"))


def pictures(path: Path) -> list[np.ndarray]:
    with av.open(str(path)) as container:
        stream = container.streams.video[0]
        found = list(container.decode(stream))
        assert [round(frame.time * float(stream.average_rate or 0)) for frame in found] == list(range(len(found)))
        return [f.reformat(format="yuv420p").to_ndarray()[: f.height].copy() for f in found]


def sound(path: Path) -> np.ndarray:
    with av.open(str(path)) as container:
        return np.concatenate([frame.to_ndarray()[0] for frame in container.decode(audio=0)])


@pytest.mark.slow
@pytest.mark.parametrize("preset", ["h264", "prores"])
def test_a_farm_makes_the_video_that_one_machine_makes(
    project: Path, tmp_path: Path, blender: Blender, preset: str
) -> None:
    pytest.importorskip("openjd.cli", reason="the extra `test` is not installed")
    out, wanted = tmp_path / "out", preset_of(preset)
    shutil.copytree(project, out / "op1")
    name = f"programme.{wanted.container}"
    film = openjd.Film("op1", FRAMES, 2, "standard", "cam1", preset, wanted, name, edited=False)
    template = tmp_path / "farm.yaml"
    template.write_text(json.dumps(openjd.template([film], "out", length=25)))
    mcsl = program(tmp_path / "mcsl", sys.executable, "-m", "mcsl_core.cli", "--progress", "lines")
    command = [sys.executable, "-m", "openjd", "run", str(template), "--step", "Join", "--run-dependencies"]
    command += ["-p", f"Mcsl={mcsl}", "-p", f"Blender={as_a_program(blender, tmp_path)}"]
    done = subprocess.run(command, capture_output=True, text=True, timeout=500)
    assert done.returncode == 0, done.stdout[-4000:] + done.stderr[-2000:]

    joined = out / "op1" / name
    pieces = sorted(path.name for path in (out / "op1" / "pieces").iterdir() if path.stem != "sound")
    assert pieces == [f"{a:07d}-{b:07d}.{wanted.container}" for a, b in ((1, 25), (26, 50), (51, 60))]
    alone = render(project / "edl.json", tmp_path / f"alone.{wanted.container}", preset=preset, blender=blender)
    made, expected = pictures(joined), pictures(alone)
    assert [(number_of(m), ground_of(m)) for m in made] == [(number_of(e), ground_of(e)) for e in expected]
    assert len(made) == edls.load(project / "edl.json").frames
    heard, whole = sound(joined), sound(alone)
    length = min(len(heard), len(whole))
    assert abs(len(heard) - len(whole)) <= 2048  # a block of the coder or two
    assert np.corrcoef(heard[:length].astype(float), whole[:length].astype(float))[0, 1] > 0.98


def test_more_than_a_template_holds_is_rendered_in_longer_pieces_or_refused() -> None:
    film = openjd.Film(
        "op1", 600 * 1500, 9, "standard", "cam1", "h264", preset_of("h264"), "programme.mp4", edited=True
    )
    steps = {step["name"]: step for step in openjd.template([film], ".")["steps"]}
    assert set(steps) == {"Conform", "Render", "Sound", "Join"}  # an editor's own timeline is not made anew
    lists = {d["name"]: d["range"] for d in steps["Render"]["parameterSpace"]["taskParameterDefinitions"]}
    assert len(lists["Piece"]) == 750
    assert (lists["First"][0], lists["First"][1], lists["Last"][-1]) == ("1", "1201", "900000")
    with pytest.raises(openjd.UsageError, match="1024 tasks"):
        openjd.template([attrs.evolve(film, key=f"op{n}") for n in range(200)], ".")
