"""Blender delivers the right pictures: as tests/test_frame_exactness.py, from an EDL and from a timeline."""

from __future__ import annotations

import pytest
from frame_cases import CASES, DELIVERED, FRAMES, delivered, edl_of, wrong

from mcsl_core import edl as edls
from mcsl_core.blender.render import render
from mcsl_core.blender.timeline import build_timeline
from mcsl_core.delivery import chunk_keys


@pytest.mark.slow
@pytest.mark.parametrize("name", [*DELIVERED, "open groups", "early", "lost pictures"])
def test_a_render_by_blender_shows_the_right_pictures(tmp_path, monkeypatch, blender, name):
    """Chunks of a second, so that several of them join in the timeline."""
    monkeypatch.setattr(chunk_keys, "CHUNK_S", 1)
    case, edl = CASES[name], tmp_path / "edl.json"
    edls.save(edl_of(case, tmp_path), edl)
    render(edl, tmp_path / "edl.mp4", blender=blender)
    assert wrong(case, delivered(tmp_path / "edl.mp4"), range(FRAMES)) == {}


@pytest.mark.slow
@pytest.mark.parametrize("name", ["variable", "drift"])
def test_a_timeline_that_is_rendered_shows_the_right_pictures(tmp_path, monkeypatch, blender, name):
    """Built before there are exact pictures: they come over the preview."""
    monkeypatch.setattr(chunk_keys, "CHUNK_S", 1)
    case, edl, blend = CASES[name], tmp_path / "edl.json", tmp_path / "edit.blend"
    edls.save(edl_of(case, tmp_path), edl)
    build_timeline(edl, blend, blender=blender)
    render(blend, tmp_path / "blend.mp4", blender=blender)
    assert wrong(case, delivered(tmp_path / "blend.mp4"), range(FRAMES)) == {}
