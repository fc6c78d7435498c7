"""The list of shots, going back to the automatic choice, and the camera files that were picked."""

from __future__ import annotations

from fractions import Fraction

import attrs
import pytest
from builders import R, small_edl, state_of
from hypothesis import given
from hypothesis import strategies as st
from strategies import ranges

from blender_addon.core import camera_files, shot_list
from blender_addon.core.camera_files import STAGES
from blender_addon.core.read_overrides import read_edl
from blender_addon.core.revert import revert
from blender_addon.core.strip_plan import make_plan
from mcsl_core.edl import Override
from mcsl_core.edl.resolve import resolve
from mcsl_core.hooks import stages
from mcsl_core.recording.discovery import discover
from mcsl_core.timing import check_tiles

OVERRIDES = (Override(R(20, 40), camera="cam3"), Override(R(90, 120), fill=False, offset=(4.0, 0.0)))
EDL = small_edl(overrides=OVERRIDES)


def test_a_row_for_each_decision():
    rows = shot_list.rows_of(EDL)
    check_tiles((row.range for row in rows), EDL.frames, "rows")
    assert [(r.range.start, r.camera, r.automatic, r.overridden) for r in rows] == [
        (0, "cam1", "cam1", False),
        (20, "cam3", "cam1", True),
        (40, "cam1", "cam1", False),
        (90, "cam1", "cam1", True),
        (100, "cam2", "cam2", True),
        (120, "cam2", "cam2", False),
        (200, "cam3", "cam3", False),
    ]


def test_from_override_to_override():
    rows = shot_list.rows_of(EDL)
    assert [shot_list.row_at(rows, frame) for frame in (-1, 0, 19, 20, 299, 300)] == [-1, 0, 0, 1, 6, -1]
    assert [shot_list.next_override(rows, frame) for frame in (0, 20, 95, 100)] == [1, 3, 4, -1]
    assert [shot_list.next_override(rows, frame, back=True) for frame in (20, 21, 300)] == [-1, 1, 4]


def test_times_for_people():
    assert shot_list.time_text(0, Fraction(30)) == "0:00:00:00"
    assert shot_list.time_text(30 * 3725 + 7, Fraction(30000, 1001)) == "1:02:05:07"
    said = [shot_list.seconds_text(s).replace("\u00a0", " ") for s in (0, 4.21, 59.97, 83, 3725)]
    assert said == ["0.0 s", "4.2 s", "1:00", "1:23", "1:02:05"]


def reverted(edl, state, piece):
    """The state after the strips were set as `revert` says."""
    settings = revert(edl, state, piece)
    strips = []
    for strip in state.strips:
        for index, part in enumerate(settings.get(strip.name, ())):
            new = attrs.evolve(strip, name=f"{strip.name}.{index}", start=part.range.start, stop=part.range.stop)
            if part.source is not None:
                new = attrs.evolve(new, source=part.source, centering=None, fill=None, colour=None, offset=None)
                look = {aid: getattr(edl.look, aid) for aid in part.said & {"centering", "fill", "colour"}}
                new = attrs.evolve(new, **look, **({"offset": "automatic"} if "offset" in part.said else {}))
            strips.append(new)
        if strip.name not in settings:
            strips.append(strip)
    return attrs.evolve(state, strips=tuple(strips))


@given(ranges(300), st.lists(st.tuples(ranges(300), st.sampled_from(["cam1", "cam2", "cam3"])), max_size=3))
def test_after_reverting_the_automatic_choice_holds_there_and_nothing_else_changes(piece, decided):
    made = tuple(Override(span, camera=camera, fill=False) for span, camera in decided)
    edl = small_edl(overrides=(*OVERRIDES, *made))
    after = read_edl(edl, reverted(edl, state_of(make_plan(edl)), piece))
    automatic = attrs.evolve(edl, overrides=())

    def at(document, frame):
        found = next(d for stretch, d in resolve(document) if frame in stretch)
        return attrs.evolve(found, overridden=False, eases=())  # a shorter stretch eases elsewhere, rightly

    for frame in {0, piece.start - 1, piece.start, piece.stop - 1, piece.stop, 30, 95, 299} & set(range(300)):
        assert at(after, frame) == at(automatic if frame in piece else edl, frame), frame


def test_files_are_cameras_as_the_command_line_names_them(tmp_path):
    names = ["op_000.mp4", "op_001.mp4", "top.mp4", "GOPR_0001.mp4", "one_007.mp4", "cam-000.mp4", "cam-001.mp4"]
    for name in names:
        (tmp_path / name).touch()
    picked = camera_files.cameras_of([str(tmp_path / name) for name in names])
    assert [camera.name for camera in picked] == ["op", "top", "GOPR_0001", "one_007", "cam"]
    assert [len(camera.files) for camera in picked] == [2, 1, 1, 1, 2]


def test_as_the_command_line_groups_them(tmp_path, monkeypatch):
    monkeypatch.setattr("mcsl_core.recording.discovery._check", lambda file: None)  # these files are empty
    names = ["b_010.mp4", "b_002.mp4", "a.mov", "c-001.mkv", "c-002.mkv", "d_1.mp4", "e_0001.mp4"]
    paths = [tmp_path / name for name in names]
    for path in paths:
        path.touch()
    ours = [(c.name, c.files) for c in camera_files.cameras_of([str(p) for p in paths])]
    assert ours == [(name, tuple(map(str, files))) for name, files in discover(paths)]


def test_the_command():
    command = camera_files.analyse_command(
        "mcsl", ["a.mp4"], "e.json", reference="a", stages={"filler": "", "matcher": "x"}
    )
    assert command == [
        "mcsl",
        "--progress",
        "json",
        "analyse",
        "-o",
        "e.json",
        "--reference",
        "a",
        "--matcher",
        "x",
        "--",
        "a.mp4",
    ]


@pytest.mark.parametrize("stage", stages.STAGES)
def test_every_stage_of_the_analysis_is_offered(stage):
    assert stage in STAGES


@given(before=st.lists(st.sampled_from("abc")), now=st.lists(st.sampled_from("abc")))
def test_only_what_lies_between_rows_that_stay_is_filled_anew(before, now):
    first, after = shot_list.unchanged(before, now)
    assert first + after <= min(len(before), len(now))
    kept = before[len(before) - after :]
    assert before[:first] + now[first : len(now) - after] + kept == now
    if first < min(len(before), len(now)) - after:  # as many as there are
        assert before[first] != now[first]
        assert before[-1 - after] != now[-1 - after]


def test_from_cut_to_cut_and_shots_too_short_to_be_seen():
    rows = shot_list.rows_of(small_edl(overrides=(Override(R(150, 159), camera="cam3"),)))
    assert [row.range for row in rows] == [R(0, 100), R(100, 150), R(150, 159), R(159, 200), R(200, 300)]
    assert [shot_list.next_cut(rows, frame) for frame in (0, 99, 100, 158, 200, 299)] == [1, 1, 2, 3, -1, -1]
    assert [shot_list.next_cut(rows, frame, back=True) for frame in (0, 1, 100, 101, 299)] == [-1, 0, 0, 1, 4]
    assert shot_list.short(rows) == (2,)
    assert shot_list.short(shot_list.rows_of(small_edl(overrides=(Override(R(150, 160), camera="cam3"),)))) == ()
