"""The EDL as a value: round trip, canonical bytes, resolve, centering offsets, carrying overrides over."""

from __future__ import annotations

import json
import random
from fractions import Fraction

import attrs
import numpy as np
import pytest
from builders import R, small
from hypothesis import given
from hypothesis import strategies as st
from strategies import centering_keys, decided_edls, edls

from mcsl_core import edl as edl_module
from mcsl_core.edl import (
    IDENTITY,
    SCHEMA,
    Clock,
    Correction,
    Edl,
    Media,
    Override,
    Pose,
    Relief,
    Shot,
    dumps,
    from_json,
    load,
    loads,
    save,
    to_json,
)
from mcsl_core.edl.edits import carry_over
from mcsl_core.edl.placement import fit_matrix, multiply, placement_matrix
from mcsl_core.edl.resolve import Decision, offset_at, resolve, shift_at
from mcsl_core.errors import DocumentError, InputError
from mcsl_core.timing import FrameRange, check_tiles

# ------------------------------------------------------------------------------------------------- round trip


@given(edls())
def test_what_is_written_reads_back_as_the_same_value_and_the_same_bytes(edl):
    text = dumps(edl)
    back = loads(text)
    assert back == edl
    assert dumps(back) == text


def test_a_file_reads_back_and_writing_it_again_changes_no_byte(tmp_path):
    path = tmp_path / "Aufnahme 手術" / "edl.json"
    edl = small(overrides=(Override(R(3, 9), camera="cam2", note="näher – 近い"),), centering=((0, 0.1, -0.0),))
    save(edl, path)
    before = path.read_bytes()
    assert load(path) == edl
    save(load(path), path)
    assert path.read_bytes() == before
    assert "近い" in before.decode("utf-8"), "text stays readable"
    assert [p.name for p in path.parent.iterdir()] == ["edl.json"]


@given(edls(), st.randoms(use_true_random=False))
def test_equal_values_give_equal_bytes_whatever_order_their_mappings_were_filled_in(edl, rng: random.Random):
    def shuffled(mapping):
        items = list(mapping.items())
        rng.shuffle(items)
        return dict(items)

    parts = ("homographies", "colour", "residual_px", "support")
    poses = tuple(attrs.evolve(p, **{n: shuffled(getattr(p, n)) for n in parts}) for p in edl.poses)
    made_by = edl.made_by and attrs.evolve(edl.made_by, settings=shuffled(edl.made_by.settings))
    other = attrs.evolve(edl, poses=poses, made_by=made_by)
    assert other == edl
    assert dumps(other) == dumps(edl)


def test_numbers_of_numpy_are_written_as_numbers():
    frames = np.int64(100)
    edl = small(
        frames=frames,
        shots=(Shot(R(np.int64(0), frames), "cam1", score=np.float32(0.5)),),  # pyright: ignore[reportArgumentType]
        centering=((np.int32(4), np.float64(1.5), np.float32(2)),),
    )
    assert loads(dumps(edl)) == edl


def test_a_file_name_that_is_not_utf8_survives():
    edl = small()
    media = (Media("caf\udce9.mp4", 100),)  # how Python spells the byte E9 in a file name
    edl = attrs.evolve(edl, cameras=(attrs.evolve(edl.cameras[0], media=media), edl.cameras[1]))
    assert loads(dumps(edl).encode("utf-8").decode("utf-8")) == edl


def test_nothing_that_json_cannot_hold_is_written(tmp_path):
    path = tmp_path / "edl.json"
    save(small(), path)
    before = path.read_bytes()
    for settings in ({"a": float("nan")}, {"a": {1, 2}}):
        with pytest.raises((ValueError, TypeError), match="a document holds"):
            save(small(made_by=edl_module.MadeBy("0", settings)), path)
    assert path.read_bytes() == before


def test_the_document_is_in_the_order_of_the_design_and_leaves_out_what_an_override_does_not_say():
    value = to_json(small(overrides=(Override(R(0, 5), fill=False),)))
    assert list(value) == [
        *("schema", "rate", "size", "frames", "reference", "cameras", "movements", "poses", "shots"),
        *("overrides", "look", "centering", "scores", "made_by"),
    ]
    assert value["overrides"] == [{"range": [0, 5], "fill": False}]


def test_every_key_shot_and_override_has_its_line():
    edl = small(
        shots=tuple(Shot(R(i, i + 1), "cam1", why="the field is clear here") for i in range(100)),
        centering=tuple((i, 0.5, 1.0) for i in range(0, 100, 2)),
    )
    lines = dumps(edl).splitlines()
    assert sum('"why"' in line for line in lines) == 100
    assert sum(line.strip().startswith("[") and "0.5, 1.0]" in line for line in lines) == 50


# ---------------------------------------------------------------------------------------------- other schemas


def test_an_older_schema_is_upgraded_step_by_step(monkeypatch, tmp_path):
    def from_1(value):
        return {**value, "schema": "mcsl.edl/0.5", "frames": value["length"]}

    def from_half(value):
        return {**{k: v for k, v in value.items() if k != "length"}, "schema": SCHEMA}

    monkeypatch.setattr("mcsl_core.edl.serialization._UPGRADES", {"mcsl.edl/0": from_1, "mcsl.edl/0.5": from_half})
    old = to_json(small())
    old["schema"] = "mcsl.edl/0"
    old["length"] = old.pop("frames")
    as_read = json.dumps(old)
    assert from_json(old) == small()
    assert json.dumps(old) == as_read, "what was handed in is not changed"


@given(edls())
def test_a_document_of_schema_1_means_what_it_meant(edl):
    """It has no reliefs: whatever the look says of them, its poses are planes."""
    plain = attrs.evolve(edl, poses=tuple(attrs.evolve(p, relief=None) for p in edl.poses))
    old = {**to_json(plain), "schema": "mcsl.edl/1"}
    old["look"] = {name: value for name, value in old["look"].items() if name != "surface"}
    assert from_json(old) == attrs.evolve(plain, look=attrs.evolve(plain.look, surface=True))


def test_a_relief_is_written_a_row_a_line():
    gamma = tuple(tuple(round(0.01 * (x - y), 2) for x in range(96)) for y in range(54))
    relief = Relief({"cam1": ((1.0, 0, 0, 1), (0, 1.0, 0, 0), (0, 0, 1.0, 0))}, gamma, ((50,) * 96,) * 54)
    edl = small()
    made = attrs.evolve(edl, poses=(attrs.evolve(edl.poses[0], relief=relief), *edl.poses[1:]))
    assert loads(dumps(made)) == made
    assert len(dumps(made).splitlines()) - len(dumps(edl).splitlines()) < 2 * 54 + 40


@pytest.mark.parametrize(
    ("schema", "what", "remedy"),
    [
        ("mcsl.edl/3", "is 'mcsl.edl/3', newer than this mcsl; expected 'mcsl.edl/2'", "Install a newer mcsl"),
        ("mcsl.edl/10", "newer than this mcsl", "Install a newer mcsl"),
        ("mcsl.edl/0", "is 'mcsl.edl/0'; expected", "Hand in the file"),
        ("mcsl.edl/²", "is 'mcsl.edl/²'; expected", "Hand in the file"),
        ("otio/9", "is 'otio/9'; expected", "Hand in the file"),
        (["mcsl.edl/1"], "expected 'mcsl.edl/2'", "Hand in the file"),
        (None, "is None; expected", "Hand in the file"),
    ],
)
def test_another_schema_is_refused_by_name(schema, what, remedy):
    with pytest.raises(DocumentError) as refused:
        from_json({**to_json(small()), "schema": schema}, where="edl.json")
    assert what in refused.value.what
    assert remedy in refused.value.remedy
    assert refused.value.where == "edl.json at $.schema"


def test_a_document_without_a_schema_is_refused():
    with pytest.raises(DocumentError, match=r"^\$\.schema: is missing; expected 'mcsl\.edl/2'"):
        from_json({"frames": 3})


def test_reading_changes_nothing_that_was_handed_in():
    value = to_json(small())
    from_json(value)
    assert value == to_json(small())


@pytest.mark.parametrize("value", [None, 3, [], "edl"])
def test_what_is_no_object_is_refused(value):
    with pytest.raises(DocumentError, match="an EDL is a JSON object"):
        from_json(value)


def test_a_missing_file_is_named(tmp_path):
    with pytest.raises(InputError, match=r"gone\.json: does not exist"):
        load(tmp_path / "gone.json")


# --------------------------------------------------------------------------------------------------- resolve


def decide_frame_by_frame(edl: Edl) -> list[tuple]:
    """The oracle: paints the overrides over the automatic decisions, one after another, frame by frame."""
    camera = [next(s.camera for s in edl.shots if s.range.start <= f < s.range.stop) for f in range(edl.frames)]
    look = edl.look
    rows = [[c, look.centering, look.fill, look.colour, look.surface, False, None, look.see_through] for c in camera]
    for o in edl.overrides:
        for f in range(o.range.start, o.range.stop):
            said = [o.camera, o.centering, o.fill, o.colour, o.surface, None, o.offset, o.see_through]
            for column, value in enumerate(said):
                if value is not None:
                    rows[f][column] = value
                    rows[f][5] = True
    return [tuple(row) for row in rows]


def frame_by_frame(pieces: tuple[tuple[FrameRange, Decision], ...]) -> list[tuple]:
    """All but the eases, which follow from the neighbours."""
    kept = attrs.filters.exclude("eases")
    return [tuple(attrs.asdict(d, filter=kept).values()) for r, d in pieces for _ in range(r.start, r.stop)]


@given(decided_edls())
def test_resolve_equals_painting_the_overrides_over_the_shots(edl):
    pieces = resolve(edl)
    check_tiles([r for r, _ in pieces], edl.frames, "pieces")
    assert frame_by_frame(pieces) == decide_frame_by_frame(edl)
    assert all(a[1] != b[1] for a, b in zip(pieces, pieces[1:], strict=False)), "equal neighbours are one stretch"


@given(decided_edls(), st.data())
def test_an_override_put_last_always_wins(edl, data):
    start = data.draw(st.integers(0, edl.frames - 1))
    stop = data.draw(st.integers(start + 1, edl.frames))
    camera = data.draw(st.sampled_from([c.name for c in edl.cameras]))
    look = {aid: data.draw(st.booleans()) for aid in ("centering", "fill", "colour", "surface", "see_through")}
    last = Override(R(start, stop), camera=camera, **look, offset=(2.0, -1.0))
    decided = frame_by_frame(resolve(attrs.evolve(edl, overrides=(*edl.overrides, last))))
    *first, see_through = look.values()
    assert set(decided[start:stop]) == {(camera, *first, True, (2.0, -1.0), see_through)}
    before = frame_by_frame(resolve(edl))
    assert decided[:start] == before[:start]
    assert decided[stop:] == before[stop:]


def test_of_two_overrides_the_later_in_the_list_wins_field_by_field():
    first = Override(R(10, 60), camera="cam2", fill=False)
    second = Override(R(50, 90), camera="cam1")
    pieces = resolve(small(overrides=(first, second)))
    assert [(str(r), d.camera, d.fill, d.overridden) for r, d in pieces] == [
        ("[0, 10)", "cam1", True, False),
        ("[10, 50)", "cam2", False, True),
        ("[50, 60)", "cam1", False, True),
        ("[60, 90)", "cam1", True, True),
        ("[90, 100)", "cam2", True, False),
    ]
    turned = resolve(small(overrides=(second, first)))
    assert [(str(r), d.camera) for r, d in turned][1:3] == [("[10, 60)", "cam2"), ("[60, 90)", "cam1")]


def test_a_bare_remark_overrides_nothing():
    assert resolve(small(overrides=(Override(R(0, 100), note="nice"),))) == resolve(small())


# ---------------------------------------------------------------------------------------------------- offsets


@given(centering_keys(500, most=8), st.floats(-50, 600))
def test_offsets_are_linear_between_keys_and_held_outside(keys, frame):
    expected = (0.0, 0.0)
    if keys:
        at = [k[0] for k in keys]
        expected = tuple(float(np.interp(frame, at, [k[column] for k in keys])) for column in (1, 2))
    # interp computes slope * (x - x0) + y0: the two orders differ in the last bits of numbers up to 500
    assert offset_at(keys, frame) == pytest.approx(expected, abs=1e-9)


@given(centering_keys(500, most=8))
def test_on_a_key_its_own_offset_holds_exactly(keys):
    for frame, dx, dy in keys:
        assert offset_at(keys, frame) == (dx, dy)


# ------------------------------------------------------------------------------------------------------ clocks


@given(st.floats(-100, 100), st.floats(-500, 500), st.floats(0, 20_000))
def test_camera_time_and_programme_time_are_each_others_inverse(offset_s, drift_ppm, time_s):
    clock = Clock(offset_s, drift_ppm)
    assert clock.programme_time(clock.camera_time(time_s)) == pytest.approx(time_s, abs=1e-9)


def test_a_clock_that_starts_late_and_runs_fast():
    clock = Clock(offset_s=2.0, drift_ppm=100.0)
    assert clock.camera_time(2) == 0
    assert clock.camera_time(Fraction(10_002)) == pytest.approx(10_001)


# -------------------------------------------------------------------------------------------------- look-ups


def test_camera_and_pose_are_found():
    edl = small(
        poses=(
            Pose(R(0, 30), {"cam1": IDENTITY, "cam2": IDENTITY}),
            Pose(R(30, 100), {"cam1": IDENTITY, "cam2": IDENTITY}, perspective=1),
        )
    )
    assert edl.camera("cam2").name == "cam2"
    assert [edl.pose_at(f).perspective for f in (0, 29, 30, 99)] == [0, 0, 1, 1]
    with pytest.raises(KeyError):
        edl.camera("cam9")
    for outside in (-1, 100):
        with pytest.raises(IndexError, match=r"outside \[0, 100\)"):
            edl.pose_at(outside)


# --------------------------------------------------------------------------------------------- analysing again


def test_analysing_again_keeps_overrides_and_look():
    decisions = (Override(R(5, 50), camera="cam2", note="hand in the way"), Override(R(20, 30), fill=False))
    old = small(overrides=decisions, look=edl_module.Look(colour=False))
    fresh = small(shots=(Shot(R(0, 100), "cam2"),))
    kept = carry_over(old, fresh)
    assert (kept.overrides, kept.look, kept.shots) == (decisions, old.look, fresh.shots)
    nudged = Correction(R(0, 100), "cam2", ((1.0, 0.0, 3.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)))
    assert carry_over(small(corrections=(nudged,)), fresh).corrections == (nudged,)


# ------------------------------------------------------------------------------------------- placed by hand


def shifted(dx: float, dy: float) -> edl_module.Matrix:
    return (1.0, 0.0, dx), (0.0, 1.0, dy), (0.0, 0.0, 1.0)


def test_a_correction_comes_after_anchor_and_homography_in_the_poses_it_covers_most_of():
    h = ((0.5, 0.1, 10.0), (-0.1, 0.5, 20.0), (1e-4, 0.0, 1.0))
    turned = ((0.0, -1.0, 100.0), (1.0, 0.0, 0.0), (0.0, 0.0, 1.0))
    both = {"cam1": IDENTITY, "cam2": h}
    poses = (Pose(R(0, 50), both, anchor=turned), Pose(R(50, 100), both))
    by_hand = (Correction(R(0, 40), "cam2", shifted(9, 9)), Correction(R(0, 51), "cam2", shifted(3, -2)))
    edl = small(poses=poses, corrections=by_hand)
    assert placement_matrix(edl, poses[0], "cam2") == multiply(shifted(3, -2), multiply(turned, h)), "of two, the later"
    assert placement_matrix(edl, poses[1], "cam2") == multiply(IDENTITY, h), "one frame of fifty is not most of it"
    assert placement_matrix(edl, poses[0], "cam1") == multiply(turned, IDENTITY)


def test_a_weak_camera_is_nowhere_until_someone_places_it():
    pose = Pose(R(0, 100), {"cam1": IDENTITY}, weak=(edl_module.Weak("cam2", "dark"),))
    assert placement_matrix(small(poses=(pose,)), pose, "cam2") is None
    edl = small(poses=(pose,), size=(640, 360), corrections=(Correction(R(0, 100), "cam2", shifted(5, 0)),))
    assert placement_matrix(edl, pose, "cam2") == multiply(shifted(5, 0), fit_matrix((320, 180), (640, 360)))


def test_a_centre_set_by_hand_stands_in_place_of_the_automatic_one():
    edl = small(centering=((0, 4.0, 8.0),), overrides=(Override(R(10, 20), offset=(-6.0, 1.5)),))
    shifts = {at: shift_at(edl, decision, at) for piece, decision in resolve(edl) for at in piece}
    assert shifts[5] == shifts[25] == (4.0, 8.0)
    assert all(-6.0 <= shifts[at][0] < 4.0 and 1.5 <= shifts[at][1] < 8.0 for at in range(10, 20)), (
        "it eases in and out"
    )
    off = small(centering=((0, 4.0, 8.0),), overrides=(Override(R(0, 100), offset=(1.0, 1.0), centering=False),))
    assert shift_at(off, resolve(off)[0][1], 50) == (0.0, 0.0), "off is off"


def test_an_override_that_fits_no_more_is_refused_and_named():
    old = small(overrides=(Override(R(0, 5)), Override(R(5, 90), camera="cam2")))
    cam1, cam2 = old.cameras
    renamed = small(
        cameras=(cam1, attrs.evolve(cam2, name="camB")),
        poses=(Pose(R(0, 100), {"cam1": IDENTITY, "camB": IDENTITY}),),
        shots=(Shot(R(0, 100), "cam1"),),
    )
    with pytest.raises(DocumentError, match=r"overrides\[1\] takes camera 'cam2'"):
        carry_over(old, renamed)
    with pytest.raises(DocumentError, match=r"overrides\[1\] ends at frame 90, after the new end 80"):
        carry_over(old, small(80))
    with pytest.raises(DocumentError, match=r"at 25 per second, the new analysis at 50.*--rate 25"):
        carry_over(old, small(rate=Fraction(50)))
    assert carry_over(small(), small(rate=Fraction(50))).rate == 50, "without overrides any rate will do"
    with pytest.raises(DocumentError, match=r"count from the first picture of cam1.*--reference cam1"):
        carry_over(old, small(reference="cam2"))
    assert carry_over(small(), small(reference="cam2")).reference == "cam2"
    larger = small(size=(640, 360))
    assert carry_over(old, larger).overrides == old.overrides, "frames and cameras are the same in any size"
    with pytest.raises(DocumentError, match=r"counts pixels of a programme of 320x180, the new analysis has 640x360"):
        carry_over(small(overrides=(Override(R(0, 5), offset=(3.0, 4.0)),)), larger)
