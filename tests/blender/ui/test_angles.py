"""The angles without a window: the button does not answer, and what it would show is known all the same."""

from __future__ import annotations

import pytest
from blender_recording import in_blender
from panel_scripts import ON


@pytest.mark.both_blenders
def test_without_a_window_it_does_not_answer_and_knows_the_cameras(built, blender):
    code = (
        ON
        + """
    from blender_addon.ui import angle_marks
    from blender_addon.ui.operators import angles
    refresh.refresh_timeline(scene)
    channels = angle_marks.camera_channels(scene)
    out = [bpy.ops.mcsl.angles.poll(), channels, [channels[c] for c in angles._in_order(scene, channels)]]
    """
    )
    answers, channels, order = in_blender(blender, built, code, save=False)
    assert not answers
    assert channels == {"2": "cam2", "3": "cam3", "4": "cam1"}
    assert order == ["cam1", "cam2", "cam3"]
