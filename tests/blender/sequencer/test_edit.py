"""Transforms that an editor set on the camera strips become a Manual-alignment: the docs' script, in a real Blender."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pytest
from blender_recording import SIZE, in_blender

from blender_addon.core.camera_places import corrected, planned_transform
from mcsl_core import edl as edls
from mcsl_core.evaluation.manual_alignment import StripTransform, load_manual

pytestmark = pytest.mark.both_blenders

PAGE = Path(__file__).parents[3] / "docs" / "how-to" / "evaluation.md"


def test_the_script_of_the_docs_prints_what_the_editor_set(built, blender):
    """As built, the strips hold the add-on's own transforms; one is then turned by hand."""
    (script,) = (b for b in re.findall(r"```python\n(.*?)```", PAGE.read_text("utf-8"), re.DOTALL) if "C.seq" in b)
    code = f"""
        strip = next(s for s in strips if s.type == "MOVIE" and s["mcsl_camera"] == "cam3" and span(s)[0] == 30)
        strip.transform.offset_x, strip.transform.offset_y, strip.transform.rotation = 12.0, -7.0, 0.5
        strip.transform.scale_x, strip.transform.scale_y = 1.25, 0.75
        import contextlib, io, types
        said = io.StringIO()
        with contextlib.redirect_stdout(said):
            exec({script!r}, {{"C": types.SimpleNamespace(sequencer_scene=scene)}})
        out = json.loads(said.getvalue())
    """
    found = in_blender(blender, built, code, save=False)
    path = built.with_name("hand.json")
    path.write_text(json.dumps(found), "utf-8")
    edl = edls.load(built.with_name("edl.json"))
    by_hand = load_manual(path, edl)
    turned = StripTransform(12, -7, 1.25, 0.5, 0.75).matrix(SIZE, SIZE)
    np.testing.assert_allclose(by_hand[1]["cam3"], turned, atol=1e-4)
    for index, pose in enumerate(edl.poses):
        for camera in edl.cameras:
            if (index, camera.name) != (1, "cam3"):
                t = corrected(edl, camera, pose, planned_transform(edl, camera, pose))
                own = StripTransform(t.offset_x, t.offset_y, t.scale, t.rotation).matrix(camera.size, edl.size)
                np.testing.assert_allclose(by_hand[index][camera.name], own, atol=1e-3)
