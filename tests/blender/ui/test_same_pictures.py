"""What is exact stays so where an analysis decides nothing anew."""

from __future__ import annotations

from blender_recording import in_blender
from panel_scripts import MCSL, ON


def test_an_analysis_that_changes_nothing_keeps_the_exact_pictures(built, blender):
    code = (
        ON
        + MCSL
        + """
    from pathlib import Path
    from blender_addon.sequencer import conformed
    from blender_addon.ui.operators.timeline import build_into
    def there():
        return [[span.start, span.stop, bool(s.mute)] for s, span in conformed.conformed_strips(scene)]
    refresh.refresh_timeline(scene)
    bpy.ops.mcsl.conform()
    wait(120)
    out = [there()]
    build_into(scene, Path(bpy.path.abspath(scene["mcsl_edl"])))  # as an analysis does at its end
    refresh.refresh_timeline(scene)
    out += [there(), state.outstanding_s, state.lost_s]
    bpy.ops.mcsl.set_look(aid="fill", on=False, whole=True)
    bpy.ops.mcsl.pull_overrides()
    build_into(scene, Path(bpy.path.abspath(scene["mcsl_edl"])))
    out += [[muted for *_, muted in there()]]
    """
    )
    before, after, outstanding, lost, others = in_blender(blender, built, code, save=False)
    assert before == after == [[0, 60, False]]
    assert outstanding == lost == 0
    assert all(others), "pictures of other decisions are not shown"
