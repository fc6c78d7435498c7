"""The panel and other programs write one EDL at the same time: nothing is lost, and it is told who waits for whom."""

from __future__ import annotations

import sys
import textwrap

import attrs
import pytest
from blender_recording import R, in_blender
from notes import Notes
from panel_scripts import MCSL, ON

from mcsl_core import edl as edls
from mcsl_core.blender.timeline import pull_overrides
from mcsl_core.edl import Override

OTHER = textwrap.dedent("""
    import sys, time
    from pathlib import Path
    import attrs
    from mcsl_core import edl as edls
    from mcsl_core.edl import Override
    from mcsl_core.outputs.locks import changing
    from mcsl_core.timing import FrameRange

    path = Path(sys.argv[1])
    with changing(path):
        edl = edls.load(path)
        print("reading", flush=True)
        time.sleep(float(sys.argv[2]))
        edls.save(attrs.evolve(edl, overrides=(*edl.overrides, Override(FrameRange(2, 9), fill=False))), path)
""")


def beside(path, seconds: float) -> str:
    """Code that starts a program which reads the EDL, works, and writes it; it goes on once that has read it."""
    return f"""
    import subprocess
    environment = {{**os.environ, "PYTHONPATH": os.pathsep.join({sys.path!r})}}
    command = [{sys.executable!r}, "-c", {OTHER!r}, {str(path)!r}, "{seconds}"]
    other = subprocess.Popen(command, stdout=subprocess.PIPE, env=environment)
    assert other.stdout.readline() == b"reading\\n"
    """


@pytest.mark.both_blenders
def test_a_pull_waits_for_who_is_writing_the_edl(built, blender):
    edl = built.parent / "edl.json"
    code = f"""{ON}{beside(edl, 1.0)}
    at(5, 0).multicam_source = 2
    bpy.ops.mcsl.pull_overrides()
    out = [other.wait(), scene["mcsl_overrides"]]
    """
    assert in_blender(blender, built, code) == [0, 3]
    kept, theirs, ours = edls.load(edl).overrides
    assert kept.note == "kept"
    assert theirs == Override(R(2, 9), fill=False)
    assert ours == Override(R(0, 20), camera="cam2")
    assert not list(built.parent.glob(".*.lock"))


def test_who_holds_it_for_long_is_named_and_nothing_is_written(built, blender):
    edl = built.parent / "edl.json"
    code = f"""{ON}{beside(edl, 60)}
    from blender_addon.ui.operators import timeline
    timeline.PATIENCE_S = 0.3
    at(5, 0).multicam_source = 2
    with open({str(edl)!r}) as stream: before = stream.read()
    try:
        bpy.ops.mcsl.pull_overrides()
        said = "pulled"
    except RuntimeError as error:
        said = str(error)
    with open({str(edl)!r}) as stream: same = stream.read() == before
    other.kill(); other.wait()
    bpy.ops.mcsl.pull_overrides()
    out = [said, same, other.pid]
    """
    said, same, process = in_blender(blender, built, code)
    assert f"another mcsl (process {process}) is writing it" in said
    assert same
    assert edls.load(edl).overrides[-1] == Override(R(0, 20), camera="cam2"), "a killed one holds nothing"


def test_a_folder_that_cannot_be_written_to_is_no_fault_where_nothing_was_decided(built, blender):
    code = f"""{ON}
    import blender_addon.ui.operators.timeline as timeline
    def never(*_): raise AssertionError
    timeline.changing = never
    bpy.ops.mcsl.pull_overrides()
    out = True
    """
    assert in_blender(blender, built, code, save=False)


def test_a_camera_chosen_elsewhere_gives_way_but_not_without_a_word(built, blender):
    """By another timeline of the same EDL, say: this one shows what it showed, and is pulled after that."""
    path = built.parent / "edl.json"
    edl, progress = edls.load(path), Notes()
    others = attrs.evolve(edl, overrides=(*edl.overrides, Override(R(5, 9), camera="cam3")))
    edls.save(others, path)
    assert pull_overrides(built, blender=blender, progress=progress).overrides == edl.overrides
    expected = "programme frames 6 to 9: cam3, decided elsewhere since this timeline was last pulled or built"
    assert [note for note in progress.notes if note.startswith(expected)]
    edls.save(others, path)
    code = f"""{ON}
    from blender_addon.ui.operators.timeline import pull
    out = []
    pull(scene, lambda _, text: out.append(text))
    """
    (note,) = in_blender(blender, built, code)
    assert note.startswith(expected)
    assert edls.load(path) == edl


@pytest.mark.slow
def test_what_is_decided_while_the_panel_analyses_is_kept(simulated, built, blender):
    """In the timeline, and in the EDL by another program; both are there when the new timeline stands."""
    edl = built.parent / "new.json"
    code = f"""{ON}{MCSL}
    bpy.ops.wm.read_factory_settings()
    scene = bpy.data.scenes.new("operation")
    bpy.context.window.scene = scene
    for w in bpy.data.workspaces:
        if hasattr(w, "sequencer_scene"): w.sequencer_scene = scene
    blender_addon.unregister(); blender_addon.register()
    state, work = bpy.context.window_manager.mcsl_state, scene.mcsl_work
    files = [dict(name=f"cam{{n}}.mp4") for n in (1, 2, 3)]
    bpy.ops.mcsl.add_cameras(directory={str(simulated)!r}, files=files)
    work.edl = {str(edl)!r}
    bpy.ops.mcsl.analyse()
    assert wait(120).outcome == "done"
    camera = next(c.name for c in work.cameras if c.name != state.shots[0].camera)
    bpy.ops.mcsl.analyse()
    scene.frame_set(51)
    bpy.ops.mcsl.switch_camera(camera=camera)
    {textwrap.indent(textwrap.dedent(beside(edl, 0.1)), "    ").strip()}
    assert other.wait() == 0
    assert job_runner.desk.running.job.running, "both came while the analysis was at work"
    out = [wait(120).outcome, job_runner.desk.message, [[s.start, s.overridden] for s in state.shots], camera]
    """
    outcome, said, rows, camera = in_blender(blender, built, code, save=False)
    assert outcome == "done", said
    overrides = edls.load(edl).overrides
    assert overrides[0] == Override(R(2, 9), fill=False)
    assert overrides[1].camera == camera
    assert overrides[1].range.start == 50
    assert [50, True] in rows
