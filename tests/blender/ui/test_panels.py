"""The panel and its buttons, as an editor presses them, in the oldest and a new Blender."""

from __future__ import annotations

import re
import sys
from pathlib import Path

import pytest
from blender_recording import R, in_blender
from panel_scripts import MCSL, ON

from mcsl_core import edl as edls
from mcsl_core.edl import Look


@pytest.mark.both_blenders
def test_it_shows_the_work_in_order(built, blender):
    code = (
        ON
        + """
    refresh.refresh_timeline(scene)
    order = [k.bl_label for k in sorted((getattr(bpy.types, n) for n in dir(bpy.types) if n.startswith("MCSL_PT_")
             and not hasattr(getattr(bpy.types, n), "bl_parent_id")), key=lambda k: k.bl_order)]
    out = [order, texts()]
    """
    )
    order, shown = in_blender(blender, built, code, save=False)
    assert order == ["Recording", "Analyse", "Shots", "Look", "Conform", "Render"]
    assert "2.0 s outstanding: the preview is shown there" in " ".join(shown).replace("\u00a0", " ")


@pytest.mark.both_blenders
def test_the_list_of_shots_says_what_the_viewer_gets(built, blender):
    code = (
        ON
        + """
    refresh.refresh_timeline(scene)
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


@pytest.mark.both_blenders
def test_conforming_puts_the_exact_pictures_in_place_and_a_decision_takes_them_away(built, blender):
    code = (
        ON
        + MCSL
        + """
    from blender_addon.sequencer import conformed
    def there():
        return [[span.start, span.stop, bool(s.mute)] for s, span in conformed.conformed_strips(scene)]
    refresh.refresh_timeline(scene)
    before = state.outstanding_s
    bpy.ops.mcsl.conform()
    status = wait(120)
    out = [[round(before, 2), status.outcome, job_runner.desk.message], there(), state.outstanding_s]
    go(25)
    bpy.ops.mcsl.switch_camera(camera="cam3")
    refresh.refresh_timeline(scene)
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


def test_pulling_from_outside_takes_stale_pictures_away_as_well(built, blender):
    """Conformed, then edited in a Blender without the extension: `mcsl pull` leaves a .blend that shows no lie."""
    from mcsl_core.blender.timeline import build_timeline, pull_overrides
    from mcsl_core.delivery.conform import conform, default_folder
    from mcsl_core.delivery.source import ProgrammeSource

    edl = built.parent / "edl.json"
    conform(ProgrammeSource(edls.load(edl), built.parent), default_folder(edl), jobs=1)
    build_timeline(edl, built, blender=blender)
    before = built.read_bytes()
    pull_overrides(built, blender=blender)
    assert built.read_bytes() == before, "nothing was decided, nothing is written"
    in_blender(blender, built, "at(5, 30).multicam_source = 3")
    pull_overrides(built, blender=blender)
    look = "out = sorted([*span(s), s.mute] for s in strips if s.get('mcsl') == 'conformed')"
    assert in_blender(blender, built, look, save=False) == [[0, 20, False], [20, 40, True], [40, 60, False]]
    assert not list(built.parent.glob(".*.blend"))
    in_blender(blender, built, "at(5, 30).multicam_source = 2")
    pull_overrides(built, blender=blender)
    assert [mute for *_, mute in in_blender(blender, built, look, save=False)] == [False, False, False]


SLOW = """
import json, time
def say(**message): print(json.dumps(message), flush=True)
say(step=2, of=3); say(stage="Scoring the views", total=1000, unit="samples"); say(done=0)
time.sleep(2.5); say(done=500); time.sleep(60)
"""


@pytest.mark.both_blenders
def test_a_running_job_says_which_stage_of_how_many_it_is_in_and_how_long_that_takes(built, blender):
    code = (
        ON
        + MCSL
        + f"""
    def stages(title, until):
        seen, deadline = [], time.monotonic() + 120
        while job_runner.pump() and time.monotonic() < deadline:
            for text in texts("MCSL_PT_" + title):
                if "Stage" in text and text not in seen: seen.append(text)
            if until in "".join(seen[-1:]): break
        return seen
    bpy.ops.mcsl.conform()
    out = [stages("conform", "never")]
    job_runner.start("Analysis", [{sys.executable!r}, "-c", {SLOW!r}])
    out.append(stages("analyse", "left")[-1])
    job_runner.desk.running.job.kill()
    """
    )
    conforming, analysis = in_blender(blender, built, code, save=False)
    told = [line.partition(",")[0] for line in conforming]
    assert told[-1] == "Stage 3 of 3: Conforming", told
    assert re.fullmatch(r"Stage 2 of 3: Scoring the views, 0:0[1-9] left", analysis)


FAULTS = {
    "no mcsl": ('os.environ["MCSL"] = "/no/such/mcsl"', "is not a program"),
    "broken EDL": ("open(edl, 'a').write('}')", "is not JSON"),
    "missing EDL": ("os.remove(edl)", "which is not there"),
    "missing media": ("os.remove(os.path.join(folder, 'cam3.mp4'))", "cam3.mp4: cannot be read"),
    "moved folder": (
        "os.rename(folder, folder + ' moved'); os.mkdir(folder)",
        "which is not there",
    ),
    "read-only folder": (
        "open(os.path.join(folder, 'edl.conformed'), 'w').close()",  # root may write anywhere, but not into a file
        "edl.conformed",
    ),
    "killed child": ("kill = True", "mcsl was ended from outside (SIGKILL)"),
    "cancelled": ("stop = True", "Conforming stopped; started again"),
}


@pytest.mark.parametrize("fault", FAULTS)
def test_a_fault_is_one_line_and_the_timeline_stays(built, blender, fault):
    spoil, message = FAULTS[fault]
    code = (
        ON
        + MCSL
        + f"""
    import signal
    folder, edl, kill, stop = {str(built.parent)!r}, {str(built.parent / "edl.json")!r}, False, False
    refresh.refresh_timeline(scene)
    def listing():
        return sorted([s.channel, *span(s), s.type, s.mute, getattr(s, "multicam_source", 0)] for s in strips)
    go(5)
    bpy.ops.mcsl.switch_camera(camera="cam3")
    before = listing()
    {spoil}
    said = ""
    try:
        bpy.ops.mcsl.conform()
        job = job_runner.desk.running.job
        if kill: os.kill(job._child.pid, signal.SIGKILL)
        assert "Conform" not in texts("MCSL_PT_conform")[2:], "a bar and Cancel in place of the button"
        if stop: bpy.ops.mcsl.cancel()
        wait(120)
        said = job_runner.desk.message
    except RuntimeError as error:
        said = str(error)
    refresh.refresh_timeline(scene)
    texts()  # the panel can still be drawn
    out = [said.strip(), listing() == before, job_runner.busy(), sorted(os.listdir(os.path.dirname(edl)))]
    """
    )
    said, same, busy, files = in_blender(blender, built, code, save=False)
    assert message in said
    assert len(said.splitlines()) == 1
    assert same
    assert not busy
    assert not [name for name in files if name.endswith((".part", ".tmp"))]


@pytest.mark.both_blenders
def test_every_decision_can_be_undone(built, blender):
    code = (
        ON
        + """
    def decided():
        return [[d.start, d.camera, d.overridden] for d in state.shots], refresh.last(scene).look.fill
    presses = {
        "switch": lambda: bpy.ops.mcsl.switch_camera(camera="cam3"),
        "look": lambda: bpy.ops.mcsl.set_look(aid="fill", on=False, whole=True),
        "shot": lambda: bpy.ops.mcsl.set_look(aid="colour", on=False),
        "centre": lambda: bpy.ops.mcsl.set_centre(x=100.0, y=80.0),
        "revert": lambda: bpy.ops.mcsl.revert(everything=True),
    }
    out = {}
    for name, press in presses.items():
        scene.frame_set(11)
        refresh.refresh_timeline(scene)
        before = decided()
        bpy.ops.ed.undo_push(message="before")
        press()
        scene = next(s for s in bpy.data.scenes if s.get("mcsl_edl"))
        refresh.refresh_timeline(scene)
        after = decided()
        bpy.ops.ed.undo_push(message="after")
        bpy.ops.ed.undo()
        scene = next(s for s in bpy.data.scenes if s.get("mcsl_edl"))
        refresh.refresh_timeline(scene)
        out[name] = [before != after, decided() == before]
    kinds = [getattr(bpy.types, name) for name in dir(bpy.types) if name.startswith("MCSL_OT_")]
    out["without"] = sorted(k.__name__ for k in kinds if not {"UNDO", "INTERNAL"} & set(k.bl_options))
    """
    )
    found = in_blender(blender, built, code, save=False)
    # These start long work; what follows from it makes a step of its own. Rendering changes nothing,
    # and angles are of the window, which is not undone.
    assert found.pop("without") == [
        "MCSL_OT_analyse",
        "MCSL_OT_angles",
        "MCSL_OT_conform",
        "MCSL_OT_export",
        "MCSL_OT_render",
    ]
    assert found == {name: [True, True] for name in found}


def test_looks_and_centres_by_hand_come_into_the_edl(built, blender):
    code = (
        ON
        + """
    refresh.refresh_timeline(scene)
    go(25)
    bpy.ops.mcsl.set_look(aid="fill", on=False)
    bpy.ops.mcsl.set_look(aid="colour", on=False)
    bpy.ops.mcsl.set_look(aid="centering", on=False, whole=True)
    bpy.ops.mcsl.set_centre(x=100.0, y=80.0)
    shown = texts("MCSL_PT_look")
    bpy.ops.mcsl.pull_overrides()
    kept = [key for strip in strips for key in strip.keys() if key in ("mcsl_fill", "mcsl_colour", "mcsl_offset")]
    bpy.ops.mcsl.pull_overrides()
    out = [shown, kept]
    """
    )
    shown, kept = in_blender(blender, built, code)
    edl = edls.load(built.parent / "edl.json")
    assert edl.look == Look(centering=False)
    made = edl.overrides[-1]
    assert (made.range, made.camera, made.fill, made.colour, made.centering) == (R(20, 40), None, False, False, True)
    assert made.offset == (59.5, 9.5), "the middle of 320x180 is (159.5, 89.5)"
    assert "Centre by hand: +60, +10 pixels" in shown or "Centre by hand: +60, +9 pixels" in shown
    assert kept == [], "what the EDL holds the strips need not say"


@pytest.mark.slow
def test_from_camera_files_to_a_timeline_and_again(simulated, built, blender):
    code = (
        ON
        + MCSL
        + f"""
    bpy.ops.wm.read_factory_settings()
    scene = bpy.data.scenes.new("operation")
    bpy.context.window.scene = scene
    for w in bpy.data.workspaces:
        if hasattr(w, "sequencer_scene"): w.sequencer_scene = scene
    blender_addon.unregister(); blender_addon.register()  # the factory settings took nothing of ours away
    state, work = bpy.context.window_manager.mcsl_state, scene.mcsl_work
    files = [dict(name=f"cam{{n}}.mp4") for n in (3, 1, 2)]
    bpy.ops.mcsl.add_cameras(directory={str(simulated)!r}, files=files)
    work.active_camera = 0
    bpy.ops.mcsl.move_camera(direction="DOWN"); bpy.ops.mcsl.move_camera(direction="DOWN")
    bpy.ops.mcsl.set_reference(camera="cam2")
    out = [[c.name for c in work.cameras]]
    bpy.ops.mcsl.read_plugins()
    while job_runner.pump_plugins(): pass
    work.filler = "reference"
    work.edl = {str(built.parent / "new.json")!r}
    out.append(work.plugin("filler"))
    bpy.ops.mcsl.analyse()
    out.append(wait(120).outcome)
    out.append([job_runner.desk.message, len(state.shots), texts("MCSL_PT_recording")])
    scene.frame_set(51)
    camera = next(c.name for c in work.cameras if c.name != state.shots[0].camera)
    bpy.ops.mcsl.switch_camera(camera=camera)
    bpy.ops.mcsl.analyse()
    out.append(wait(120).outcome)
    out.append([[s.start, s.overridden] for s in state.shots])
    """
    )
    order, filler, first, (said, shots, shown), second, rows = in_blender(blender, built, code, save=False)
    assert order == ["cam1", "cam2", "cam3"]
    assert filler == "reference"
    assert (first, second) == ("done", "done"), said
    assert shots == 1
    assert "The star is the reference camera" in shown
    assert rows == [[0, False], [50, True]], "what was decided by hand goes through an analysis"
    edl = edls.load(built.parent / "new.json")
    assert edl.reference == "cam2"
    assert edl.made_by is not None
    assert edl.made_by.plugins["filler"].startswith("reference")


@pytest.mark.both_blenders
def test_a_video_by_the_render_button(built, blender):
    code = (
        ON
        + f"""
    refresh.refresh_timeline(scene)
    scene.mcsl_work.preset = "review"
    scene.mcsl_work.video = {str(built.parent / "out.mov")!r}
    refused = ""
    try:
        bpy.ops.mcsl.apply_preset()
    except RuntimeError as error:
        refused = str(error)
    scene.mcsl_work.video = "//out.mp4"
    scene.frame_end = 10
    bpy.ops.mcsl.render()
    out = [refused, scene.render.filepath]
    """
    )
    refused, path = in_blender(blender, built, code, save=False)
    assert "the preset writes .mp4 files" in refused
    assert Path(path) == built.parent / "out.mp4"
    assert (built.parent / "out.mp4").stat().st_size > 1000
