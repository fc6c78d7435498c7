"""The panel and its buttons, as an editor presses them, in the oldest and a new Blender."""

from __future__ import annotations

import shutil

import pytest
from conftest import in_blender

from mcsl_core import edl as edls
from mcsl_core.blender_child import search_paths
from mcsl_core.edl import Look

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
    assert "2.0 s outstanding: the preview is shown there" in " ".join(shown).replace("\u00a0", " ")


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


MCSL = f"""
    os.environ["MCSL"] = {shutil.which("mcsl")!r}
"""


def test_conforming_puts_the_exact_pictures_in_place_and_a_decision_takes_them_away(built, blender):
    code = (
        ON
        + MCSL
        + """
    from blender_addon import conformed
    def there():
        return [[span.start, span.stop, bool(s.mute)] for s, span in conformed.found(scene)]
    watching.look(scene)
    before = state.outstanding_s
    bpy.ops.mcsl.conform()
    status = running.wait(120)
    out = [[round(before, 2), status.outcome, running.desk.message], there(), state.outstanding_s]
    go(25)
    bpy.ops.mcsl.switch_camera(camera="cam3")
    watching.look(scene)
    out += [there(), round(state.outstanding_s, 3), round(state.lost_s, 3), texts("MCSL_PT_conform")]
    bpy.ops.mcsl.revert()
    out += [there(), state.outstanding_s]
    bpy.ops.mcsl.set_look(aid="fill", on=False, whole=True)
    out += [there(), round(state.outstanding_s, 2)]
    """
    )
    done, whole, none_left, cut, outstanding, lost, shown, back, again, all_gone, rest = in_blender(
        blender, built, code
    )
    assert done == [2.0, "done", "Conforming: done"]
    assert whole == [[0, 60, False]]
    assert none_left == 0
    assert cut == [[0, 25, False], [25, 40, True], [40, 60, False]]
    assert outstanding == lost == pytest.approx(15 * 1.001 / 30, abs=0.001)
    assert "0.5 s of exact pictures fell away" in " ".join(shown).replace("\u00a0", " ")
    assert back == [[0, 25, False], [25, 40, False], [40, 60, False]]
    assert again == 0
    assert all(muted for _, _, muted in all_gone)
    assert rest == 2.0
    edl = edls.load(built.parent / "edl.json")
    assert edl.look == Look(), "conforming wrote the EDL, the look came after"
