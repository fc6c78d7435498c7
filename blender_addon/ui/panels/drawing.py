# SPDX-License-Identifier: GPL-3.0-or-later
"""What the panels share: where they stand, texts of several lines, a job's bar and its last message."""

from __future__ import annotations

import bpy  # pyright: ignore[reportMissingImports]

from ...sequencer.compat import sequencer_scene
from ...sequencer.scene_properties import has_timeline
from .. import job_runner

WIDTH = 44  # letters of a line where there is no sidebar to measure
LETTER_PX = 6.2  # at a scale of 1; what stands beside the text takes 70 pixels


class SidebarPanel:
    """A panel in the sequencer's sidebar, tab mcsl."""

    bl_space_type = "SEQUENCE_EDITOR"
    bl_region_type = "UI"
    bl_category = "mcsl"


class TimelinePanel(SidebarPanel):
    """A panel that is shown where the scene holds a timeline."""

    @classmethod
    def poll(cls, context):
        return has_timeline(sequencer_scene(context))


def wrapped(layout, text: str, icon: str = "NONE") -> None:
    """A text of several lines: a label has but one. Japanese letters count double and break anywhere."""
    region, width = bpy.context.region, WIDTH
    if region is not None and region.type == "UI":
        scale = bpy.context.preferences.system.ui_scale
        width = max(20, int((region.width / scale - 70) / LETTER_PX))
    column = layout.column(align=True)
    column.scale_y = 0.85
    for index, line in enumerate(lines_of(text, width)):
        column.label(text=line, icon=icon if index == 0 else ("NONE" if icon == "NONE" else "BLANK1"), translate=False)


def lines_of(text: str, width: int) -> list[str]:
    """``text`` in lines of at most ``width`` columns, broken at spaces, or anywhere in a word that is longer."""
    lines, line, used = [], "", 0
    for word in text.split(" "):
        size = _columns(word)
        if line and used + 1 + size > width:
            lines.append(line)
            line, used = "", 0
        if line:
            line, used = f"{line} ", used + 1
        for letter in word:
            step = _columns(letter)
            if used + step > width:
                lines.append(line)
                line, used = "", 0
            line, used = line + letter, used + step
    return [*lines, line]


def _columns(text: str) -> int:
    return sum(2 if ord(letter) > 0x2E7F else 1 for letter in text)


def draw_job(layout, title: str) -> bool:
    """The bar and the cancel button of the job of that title; whether it runs."""
    run = job_runner.desk.running
    if run is None or run.title != title:
        return False
    row = layout.row(align=True)
    row.progress(factor=job_runner.fraction(run), text=job_runner.describe(run))
    row.operator("mcsl.cancel", text="", icon="X")
    return True


def draw_notices(layout, state) -> None:
    """What there is to know before pictures are made, a box each."""
    for notice in state.notices.splitlines():
        wrapped(layout.box(), notice, "INFO")


def draw_message(layout, *about: str) -> None:
    """The last message, if it is about one of these jobs, until the next one starts."""
    if job_runner.desk.message and job_runner.desk.about in about and not job_runner.busy():
        icon = {"ERROR": "ERROR", "WARNING": "INFO"}.get(job_runner.desk.level, "CHECKMARK")
        box = layout.box()
        box.alert = job_runner.desk.level == "ERROR"
        wrapped(box, job_runner.desk.message, icon)
