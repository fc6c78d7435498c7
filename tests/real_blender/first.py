"""The first minute: a new file, the timeline of an EDL built into it; nothing is touched before the picture."""

import bpy
from hands import OUT, area, check, picture, press_button, seen, strips


def new():
    """File > New > Video Editing."""
    bpy.ops.wm.read_homefile(app_template="Video_Editing", use_factory_startup=False)


def build():
    window = bpy.context.window_manager.windows[0]
    bpy.ops.wm.save_as_mainfile(filepath=str(OUT.parent / "tmp" / "first.blend"))
    check("workspace", window.workspace.name, "Video Editing")
    press_button("mcsl.build_timeline", filepath=str(OUT.parent / "project" / "edl.json"))


def look():
    _, timeline, regions = area()
    check("the sidebar is open", timeline.spaces.active.show_region_ui, True)
    check("its tab", regions["UI"].active_panel_category, "mcsl")
    view, last = regions["WINDOW"].view2d, max(stop for _, stop in strips("programme"))
    left, right = (view.region_to_view(x, 0)[0] for x in (0, regions["WINDOW"].width))
    check("all of the programme is in view", left <= 1 and right >= last, True)
    check(
        "nothing of ours is selected",
        [s.name for s in bpy.context.sequencer_scene.sequence_editor.strips if s.select],
        [],
    )
    seen["frames"] = last
    picture("first")


STEPS = [new, lambda: None, build, lambda: None, lambda: None, look]
