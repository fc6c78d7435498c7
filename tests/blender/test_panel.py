"""The panel and its buttons, as an editor presses them, in the oldest and a new Blender."""

from __future__ import annotations

from conftest import in_blender

from mcsl_core.blender_child import search_paths

HERE = __file__.rpartition("/")[0]
ON = f"""
    import warnings
    warnings.simplefilter("error")
    sys.path.extend({[*search_paths(), HERE]!r})
    import blender_addon, recorder
    from blender_addon import running, watching
    blender_addon.register()
    state = bpy.context.window_manager.mcsl_state
    def texts(*names):
        return [text for _, text, _ in recorder.draw(names or None)]
    def go(frame):
        scene.frame_set(frame + 1)
"""


def test_it_shows_the_work_in_order(built, blender):
    code = (
        ON
        + """
    watching.look(scene)
    order = [k.bl_label for k in sorted((getattr(bpy.types, n) for n in dir(bpy.types) if n.startswith("MCSL_PT_")
             and not hasattr(getattr(bpy.types, n), "bl_parent_id")), key=lambda k: k.bl_order)]
    out = [order, texts()]
    """
    )
    order, shown = in_blender(blender, built, code, save=False)
    assert order == ["Recording", "Analyse", "Shots", "Look", "Conform", "Render"]
    print(shown)
    assert "2.0 s outstanding: the preview is shown there" in " ".join(shown)


def test_the_list_of_shots_says_what_the_viewer_gets(built, blender):
    code = (
        ON
        + """
    watching.look(scene)
    out = [[i.start, i.stop, i.camera, i.overridden, i.time] for i in state.shots]
    """
    )
    assert in_blender(blender, built, code, save=False) == [
        [0, 20, "cam1", False, "0:00:00:00"],
        [20, 40, "cam2", False, "0:00:00:20"],
        [40, 45, "cam3", False, "0:00:01:10"],
        [45, 50, "cam1", True, "0:00:01:15"],
        [50, 60, "cam3", False, "0:00:01:20"],
    ]
