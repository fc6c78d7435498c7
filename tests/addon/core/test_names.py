# SPDX-License-Identifier: GPL-3.0-or-later
"""Names from the disk and from other packages that are no valid text: numbered, shown and noted, not refused."""

from __future__ import annotations

from pathlib import Path

import pytest

from blender_addon.core.camera_files import as_text, plugin_number
from blender_addon.core.identity import home_of

NUMBERS = {"consensus": 466309182, "learned": 2084277605, "Übung": 1509236809}
ODD = ["Endoskop-\udce4", "\ud800", "\udfff\ud800", "\udc80" * 40]


@pytest.mark.parametrize("name", ODD)
def test_a_plugin_whose_name_is_no_text_has_a_number_and_can_be_shown(name: str) -> None:
    assert 0 < plugin_number(name) < 2**31
    assert "\\ud" in as_text(name)
    assert as_text(name).encode()


def test_numbers_that_saved_timelines_hold_stay() -> None:
    assert {name: plugin_number(name) for name in ("consensus", "learned", "Übung")} == NUMBERS
    assert as_text("Übung 日本") == "Übung 日本"


def test_a_folder_whose_name_is_no_text_is_a_timelines_home() -> None:
    homes = {home_of(Path("/rooms") / name) for name in ("Saal-\udce4", "Saal-\udcf6", "Saal-a")}
    assert len(homes) == 3
