"""Where corners and centres can be clicked: a preview that can be seen and shows the programme."""

from __future__ import annotations

import pytest

from blender_addon.core.preview import Shows, moves_view, shows


@pytest.mark.parametrize(
    ("view", "size", "channel", "centering", "expected"),
    [
        ("PREVIEW", (640, 360), 0, 6, Shows.PROGRAMME),
        ("SEQUENCER_PREVIEW", (640, 360), 0, None, Shows.PROGRAMME),
        ("SEQUENCER", (640, 360), 0, 6, Shows.NOTHING),  # the hidden one of a plain timeline
        ("SEQUENCER_PREVIEW", (1, 360), 0, 6, Shows.NOTHING),  # folded away
        ("SEQUENCER_PREVIEW", (640, 0), 0, 6, Shows.NOTHING),
        ("PREVIEW", (640, 360), 2, 6, Shows.CHANNEL),
        ("PREVIEW", (640, 360), 5, 6, Shows.CHANNEL),  # the Programme, before it is centred
        ("PREVIEW", (640, 360), 6, 6, Shows.PROGRAMME),
        ("PREVIEW", (640, 360), 7, 6, Shows.PROGRAMME),
        ("PREVIEW", (640, 360), 2, None, Shows.PROGRAMME),
    ],
)
def test_what_a_preview_shows(view, size, channel, centering, expected):
    assert shows(view, size, channel, centering) is expected


def test_zoom_and_pan_are_left_to_blender_and_clicks_are_not():
    moving = ("MIDDLEMOUSE", "WHEELUPMOUSE", "TRACKPADPAN", "TRACKPADZOOM", "HOME", "NDOF_MOTION")
    assert all(map(moves_view, moving))
    assert not any(map(moves_view, ("LEFTMOUSE", "RET", "ESC", "BACK_SPACE", "MOUSEMOVE", "TIMER")))
