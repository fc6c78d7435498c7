"""A marked recording rendered by Blender: none of the marks comes out."""

from __future__ import annotations

import pytest
from marked_recording import MADE, marked_recording, marks_in
from traces import MARK, traces

import mcsl_core as mcsl
from mcsl_core.blender.render import render
from mcsl_core.delivery.presets import load_preset

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def edl(tmp_path_factory):
    recording = marked_recording(tmp_path_factory.mktemp("marks"))
    path = recording.parent / f"{MARK}.json"
    mcsl.analyse(recording, path)
    return path


@pytest.mark.parametrize("preset", ["review", "archive"])
def test_no_mark_is_in_what_blender_renders(edl, tmp_path, blender, preset):
    out = tmp_path / f"out.{load_preset(preset).container}"
    render(edl, out, preset=preset, engine="blender", blender=blender)
    assert marks_in(out) == set()
    assert traces(out) == []
    assert MADE[:10].encode() not in out.read_bytes()
