"""What an editor did to the sound stays done, whatever is made anew: heard in what is delivered."""

from __future__ import annotations

import wave

import attrs
import av
import numpy as np
import pytest
from blender_recording import FRAMES, RATE, SWITCH_ON, in_blender
from notes import Notes
from panel_scripts import HERE

from mcsl_core import edl as edls
from mcsl_core.blender.child import run_task
from mcsl_core.blender.messages import RefreshRequest
from mcsl_core.blender.render import render
from mcsl_core.blender.timeline import build_timeline, pull_overrides


def levels(path) -> np.ndarray:
    """The sound's level in every programme frame, (frames, channels); the recording's tone has 0.18."""
    with av.open(str(path)) as container:
        parts = [f.to_ndarray().reshape(-1, f.layout.nb_channels).T for f in container.decode(audio=0)]
        assert container.streams.audio[0].rate in (44100, 48000)
    heard = np.concatenate(parts, axis=1).astype(float)
    step = 48000 / RATE
    spans = [(round(float(n * step)) + 200, round(float((n + 1) * step)) - 200) for n in range(FRAMES)]
    return np.array([np.sqrt(np.mean(heard[:, a:b] ** 2, axis=1)) for a, b in spans if b <= heard.shape[1]])


def conformed_sound(built, key: str):
    """What `mcsl conform` lays down: the programme's sound from frame 0, here a tone."""
    path = built.parent / "edl.conformed" / f"sound-{key}.wav"
    path.parent.mkdir(exist_ok=True)
    tone = 0.25 * np.sin(2 * np.pi * 440 * np.arange(round(48000 * FRAMES / RATE)) / 48000)
    with wave.open(str(path), "wb") as stream:
        stream.setparams((1, 2, 48000, 0, "NONE", ""))
        stream.writeframes((tone * 32767).astype("<i2").tobytes())
    return path


def delivered(built, blender, code="", progress=None, sound="0a1b") -> np.ndarray:
    """The levels of the timeline's sound after the editor's ``code`` and a refresh with the conformed sound."""
    if code:
        in_blender(blender, built, code)
    path = None if sound is None else conformed_sound(built, sound)
    edl = built.parent / "edl.json"
    run_task(blender, RefreshRequest(edl=edl, blend=built, conformed=(), sound=path), progress)
    mixed = built.parent / "mixed.wav"
    mix = f'bpy.ops.sound.mixdown(filepath={str(mixed)!r}, container="WAV", codec="PCM", format="F32")'
    in_blender(blender, built, mix, save=False)
    return levels(mixed)


FORGET = 'scene.pop("mcsl_sound"); [s.pop("mcsl_placed", None) for s in strips]'
SOUND = 'sound = sorted((s for s in scene.sequence_editor.strips_all if s.get("mcsl") == "sound"), key=span)\n'
LISTING = SOUND + "out = [[*span(s), s.channel, s.mute, round(s.volume, 3)] for s in sound]"
NAME_MUTED = (
    SOUND
    + """
middle = sound[0].split(frame=12 + 1, split_method="SOFT")
middle.split(frame=24 + 1, split_method="SOFT")
middle.mute = True
"""
)


def quiet(level: np.ndarray) -> list[int]:
    return [n for n, value in enumerate(level.max(axis=1)) if value < 0.01]


@pytest.mark.both_blenders
def test_a_muted_piece_stays_muted_over_the_same_frames(built, blender):
    """Conformed sound takes the place of the camera's, then the camera's that of the conformed, then again."""
    muted = list(range(13, 23))  # the frames at its ends hold a sample or two of the neighbours in the encoder's blocks
    level = delivered(built, blender, NAME_MUTED)
    assert set(muted) <= set(quiet(level)) <= set(range(12, 24))
    assert level[[*range(2, 10), *range(26, FRAMES - 2)]].min() > 0.1
    found = in_blender(blender, built, LISTING, save=False)
    assert [piece[:4] for piece in found] == [
        [0, 12, 1, False],
        [12, 24, 1, True],
        [24, 40, 1, False],
        [40, 60, 1, False],
    ]
    assert set(muted) <= set(quiet(delivered(built, blender, sound=None))) <= set(range(12, 24))
    assert in_blender(blender, built, LISTING, save=False) == found
    assert set(muted) <= set(quiet(delivered(built, blender, sound="2c3d"))) <= set(range(12, 24))


@pytest.mark.both_blenders
def test_level_place_and_keys_survive(built, blender):
    code = (
        SOUND
        + """
first, second = sound
first.volume, first.pan = 0.25, -1.0

second.channel = 12
for frame, volume in ((41, 1.0), (60, 0.0)):
    second.volume = volume
    second.keyframe_insert("volume", frame=frame)
"""
    )
    level = delivered(built, blender, code)
    assert level[5:35, 0].max() < 0.1  # a quarter of 0.18
    fade = level[42:58, 0]
    assert (np.diff(fade) < 0).all()
    assert fade[-1] < 0.03
    found = in_blender(blender, built, LISTING, save=False)
    assert [piece[:3] for piece in found] == [[0, 40, 1], [40, 60, 12]]
    code = SOUND + "out = [sound[0].volume, sound[0].pan, [s.sound.filepath[:22] for s in sound]]"
    assert in_blender(blender, built, code, save=False) == [0.25, -1, ["//edl.conformed/sound-"] * 2]


@pytest.mark.both_blenders
def test_sound_taken_out_stays_out(built, blender):
    code = SOUND + 'sound[1].split(frame=50 + 1, split_method="SOFT"); strips.remove(sound[1])'
    heard = Notes()
    level = delivered(built, blender, code, heard)
    assert set(range(41, 49)) <= set(quiet(level)) <= set(range(39, 51))
    heard = Notes()
    assert quiet(delivered(built, blender, SOUND + "for s in sound: strips.remove(s)", heard)) == list(range(FRAMES))
    assert any("stays silent" in note for note in heard.notes)


@pytest.mark.slow
def test_a_film_is_delivered_without_the_muted_name(built, blender):
    """Pull, conform and render, twice, as `mcsl render edit.blend` does it."""
    in_blender(blender, built, NAME_MUTED)
    for _ in range(2):
        render(built, built.parent / "out.mov", preset="prores", blender=blender)
        assert set(range(13, 23)) <= set(quiet(levels(built.parent / "out.mov"))) <= set(range(12, 24))


def test_moved_sound_stays_moved(built, blender):
    code = SOUND + "for s in sound: s.frame_start -= 5"
    level = delivered(built, blender, code)
    assert set(range(56, 60)) <= set(quiet(level)) <= set(range(54, 60))
    assert in_blender(blender, built, SOUND + "out = [s.frame_start for s in sound]", save=False) == [-4, -4]


def test_a_file_of_the_editors_own_in_our_strip_is_his(built, blender):
    code = (
        SOUND
        + """
import shutil
shutil.copy(bpy.path.abspath("//cam1_a.mp4"), bpy.path.abspath("//cleaned.mp4"))
sound[0].sound = bpy.data.sounds.load(bpy.path.abspath("//cleaned.mp4"))
strips.remove(sound[1])
"""
    )
    delivered(built, blender, code)
    code = SOUND + "out = [s.sound.filepath for s in sound]"
    assert in_blender(blender, built, code, save=False) == ["//cleaned.mp4"]


def test_sound_in_a_meta_strip_is_not_doubled(built, blender):
    code = (
        SOUND
        + """
meta = strips.new_meta(name="quiet", channel=20, frame_start=1)
for s in sound: s.move_to_meta(meta)
meta.mute = True
"""
    )
    assert quiet(delivered(built, blender, code)) == list(range(FRAMES))
    assert len(in_blender(blender, built, LISTING, save=False)) == 2


@pytest.mark.parametrize("blind", [False, True])
def test_a_muted_audio_channel_stays_muted(built, blender, blind):
    """blind: also in a timeline of an mcsl that noted nothing about where its sound was laid."""
    forget = 'scene.pop("mcsl_sound"); [s.pop("mcsl_placed", None) for s in strips]' if blind else ""
    level = delivered(built, blender, f"scene.sequence_editor.channels[1].mute = True\n{forget}")
    assert quiet(level) == list(range(FRAMES))


def test_an_older_timelines_pieces_stay_as_they_are(built, blender):
    level = delivered(
        built, blender, NAME_MUTED + 'scene.pop("mcsl_sound"); [s.pop("mcsl_placed", None) for s in strips]'
    )
    assert set(range(13, 23)) <= set(quiet(level)) <= set(range(12, 24))


def test_an_older_timelines_end_that_was_cut_off_stays_off(built, blender):
    code = SOUND + 'strips.remove(sound[1].split(frame=50 + 1, split_method="SOFT"))\n' + FORGET
    level = delivered(built, blender, code)
    assert set(range(51, FRAMES)) <= set(quiet(level)) <= set(range(49, FRAMES))


def test_a_retimed_strip_is_silent_rather_than_wrong(built, blender):
    code = (
        SOUND
        + """
for w in bpy.data.workspaces:
    if hasattr(w, "sequencer_scene"): w.sequencer_scene = scene
strips.remove(sound[1])
for s in strips: s.select = s == sound[0]
scene.sequence_editor.active_strip = sound[0]
bpy.ops.sequencer.retiming_segment_speed_set(speed=50.0)
"""
    )
    heard = Notes()
    in_blender(blender, built, code)
    level = delivered(built, blender, "", heard)
    assert quiet(level) == list(range(FRAMES))
    assert any("'sound' (frame 1) is retimed" in note for note in heard.notes)


def test_a_new_timeline_is_scrubbed_by_ear_and_what_the_editor_switches_off_stays_off(built, blender):
    waveforms = SOUND + "out = [scene.use_audio_scrub, [s.show_waveform for s in sound]]"
    scrub, shown = in_blender(blender, built, waveforms, save=False)
    assert scrub
    assert shown
    assert all(shown)
    off = SOUND + "scene.use_audio_scrub = False\nfor s in sound: s.show_waveform = False\n"
    delivered(built, blender, off)
    scrub, shown = in_blender(blender, built, waveforms, save=False)
    assert not scrub
    assert shown
    assert not any(shown)


CHOOSE = (
    SWITCH_ON
    + """
    from blender_addon.ui.operators.timeline import pull
    def heard(): return sorted(
        [*span(s), bpy.path.basename(s.sound.filepath), s.mute] for s in strips if s.type == "SOUND")
    def choose(source):
        assert bpy.ops.mcsl.sound_from(source=source) == {"FINISHED"}
        return [heard(), pull(scene)[0].audio_from]
"""
)


def test_another_cameras_sound_is_chosen_and_taken_back(built, blender):
    code = CHOOSE + '\n    out = [choose(s) for s in ("CAMERA cam2", "NONE", "CAMERA cam2", "AUTOMATIC")]'
    second = [[[3, FRAMES, "cam2.mp4", False]], "cam2"]
    first = [[[0, 40, "cam1_a.mp4", False], [40, FRAMES, "cam1_b.mp4", False]], None]
    assert in_blender(blender, built, code) == [second, [[], "none"], second, first]


def test_what_was_muted_stays_mute_when_another_sound_is_chosen(built, blender):
    code = (
        CHOOSE
        + """
    strip = at(1, 10)
    middle = strip.split(frame=10 + 1, split_method="SOFT")
    middle.split(frame=20 + 1, split_method="SOFT")
    middle.mute = True
    choose("CAMERA cam2")
    out = heard()
    """
    )
    found = in_blender(blender, built, code)
    assert {name for _, _, name, _ in found} == {"cam2.mp4"}
    mute = {n for start, stop, _, silent in found if silent for n in range(start, stop)}
    assert mute == set(range(10, 20))


def test_the_edls_choice_is_laid(built, blender):
    path = built.parent / "edl.json"
    edls.save(attrs.evolve(edls.load(path), audio_from="cam2"), path)
    build_timeline(path, built, blender=blender, force=True)
    code = CHOOSE + "\n    out = heard()"
    assert in_blender(blender, built, code, save=False) == [[3, FRAMES, "cam2.mp4", False]]
    assert pull_overrides(built, blender=blender).audio_from == "cam2"


def test_a_microphone_whose_file_is_gone_changes_nothing(built, blender):
    code = (
        CHOOSE
        + """
    os.rename(bpy.path.abspath("//cam2.mp4"), bpy.path.abspath("//gone.mp4"))
    before = heard()
    try: bpy.ops.mcsl.sound_from(source="CAMERA cam2")
    except RuntimeError as error: told = str(error)
    out = ["cam2.mp4" in told, heard() == before, scene.get("mcsl_sound_from"), len(before)]
    """
    )
    assert in_blender(blender, built, code, save=False) == [True, True, None, 2]


def test_panel_and_sound_say_what_the_edl_says_once_a_pull_and_the_choice_are_undone(built, blender):
    """What was pulled stays in the EDL: the timeline follows it, as it does where somebody else has changed it."""
    code = (
        CHOOSE
        + """
    import panel_recorder as recorder
    from blender_addon.ui import refresh
    def told():
        global scene, strips
        scene = next(s for s in bpy.data.scenes if s.get("mcsl_edl"))  # an undo makes another object of it
        strips = scene.sequence_editor.strips
        refresh.refresh_timeline(scene)
        said = [text for _, text, _ in recorder.draw(["MCSL_PT_render"])]
        return [said[said.index("Sound") + 1], *heard()]
    bpy.ops.ed.undo_push(message="before")
    bpy.ops.mcsl.sound_from(source="CAMERA cam2")
    bpy.ops.ed.undo_push(message="chosen")
    bpy.ops.mcsl.pull_overrides()
    bpy.ops.ed.undo_push(message="pulled")
    out = [told()]
    for _ in range(2):
        bpy.ops.ed.undo()
        out.append(told())
    path = bpy.path.abspath("//edl.json")
    text = open(path).read().replace('"audio_from": "cam2"', '"audio_from": "none"')
    open(path, "w").write(text)
    out.append(told())
    """
    )
    code = f"    import sys; sys.path.append({HERE!r})\n" + code
    second = ["cam2", [3, FRAMES, "cam2.mp4", False]]
    assert in_blender(blender, built, code, save=False) == [second, second, second, ["None"]]
