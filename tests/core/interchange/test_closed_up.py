"""What is removed is not in the document, whose shots close up; what an editor changes there is read as ever."""

from __future__ import annotations

from fractions import Fraction

import attrs
import pytest
from apple_structure import faults_of
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from interchange_cuts import R, film, films
from interchange_readers import by_fcp_adapter, by_lxml, by_otio, expanded, of_multicam, of_track, otio, seconds
from lxml import etree

from mcsl_core.edl.removal import delivered, remove
from mcsl_core.errors import Fault
from mcsl_core.interchange.changes import find_changes
from mcsl_core.interchange.formats import FORMATS
from mcsl_core.interchange.origin import exported, origin_of
from mcsl_core.interchange.three_way import compared

FLAVOURS = [(suffix, exact) for suffix in FORMATS for exact in (False, True)]


@st.composite
def cut_films(draw: st.DrawFn, **how):
    """Films of which some is removed, and something left."""
    made = draw(films(**how))
    edl = made.edl
    for _ in range(draw(st.integers(1, 3))):
        start = draw(st.integers(0, edl.frames - 1))
        try:
            edl = remove(edl, R(start, draw(st.integers(start + 1, edl.frames))))
        except Fault:
            assume(edl.removed)
    return attrs.evolve(made, edl=edl)


def kept(edl):
    """The programme frame at each place of the sequence."""
    return [n for piece in delivered(edl) for n in piece]


def whole(made):
    return attrs.evolve(made, edl=attrs.evolve(made.edl, removed=()))


def read(made, suffix, document, folder):
    path = folder / f"back{suffix}"
    path.write_bytes(document)
    form = FORMATS[suffix]
    return compared(made.cut(), made.edl, form.read(path, made.edl.rate), form.layout)


def frames_of(pieces):
    return {n for piece in pieces for n in piece}


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("closed")


# ------------------------------------------------------------------------------------------------------ what is shown


@pytest.mark.parametrize("exact", [False, True])
@given(made=cut_films())
@settings(max_examples=25)
def test_each_track_shows_what_it_showed_closed_up(made, exact):
    """Read by opentimelineio and its adapter, against an export of the whole programme."""
    at = kept(made.edl)
    for suffix, reader in ((".otio", by_otio), (".xml", by_fcp_adapter)):
        ours, all_of_it = (reader(FORMATS[suffix].write(m.cut(exact=exact))) for m in (made, whole(made)))
        assert len(ours.video_tracks()) == len(all_of_it.video_tracks())
        for one, other in zip(ours.video_tracks(), all_of_it.video_tracks(), strict=True):
            before = expanded(of_track(other))
            assert expanded(of_track(one)) == {place: before[n] for place, n in enumerate(at) if n in before}


@given(made=cut_films())
@settings(max_examples=25)
def test_the_storyline_closes_up_and_the_multicam_clip_stays_whole(made):
    ours, all_of_it = (FORMATS[".fcpxml"].write(m.cut()) for m in (made, whole(made)))
    before = expanded(of_multicam(all_of_it))
    assert expanded(of_multicam(ours)) == {place: before[n] for place, n in enumerate(kept(made.edl)) if n in before}
    root, other = by_lxml(ours), by_lxml(all_of_it)
    assert etree.tostring(root.find(".//multicam")) == etree.tostring(other.find(".//multicam"))
    assert seconds(root.find(".//sequence").get("duration")) == len(kept(made.edl)) / made.edl.rate


def test_sound_and_markers_close_up_and_a_seam_stays_a_cut():
    made = film(Fraction(25), 90)
    made = attrs.evolve(made, edl=remove(made.edl, R(10, 20)))
    timeline = by_otio(FORMATS[".otio"].write(made.cut(exact=True)))
    shots = list(timeline.video_tracks()[-1])
    assert [(clip.name, int(clip.duration().value)) for clip in shots] == [
        ("cam1", 10), ("cam1", 10), ("cam2", 30), ("cam3", 30)
    ]  # fmt: skip
    [sound] = timeline.audio_tracks()
    starts = [(int(clip.source_range.start_time.value), int(clip.duration().value)) for clip in sound]
    assert starts == [(0, 10), (20, 70)]
    root = by_lxml(FORMATS[".fcpxml"].write(made.cut(exact=True)))
    heard = [clip for clip in root.findall(".//spine/asset-clip/asset-clip") if clip.get("lane") == "-2"]
    assert [seconds(clip.get("start")) * 25 for clip in heard] == [0, 20]
    assert [seconds(clip.get("duration")) * 25 for clip in heard] == [10, 70]
    assert [seconds(clip.get("offset")) * 25 for clip in heard] == [0, 20]  # in their shots' own time


@given(made=cut_films(), exact=st.booleans())
@settings(max_examples=25)
def test_in_fcpxml_the_sound_fades_over_two_frames_beside_what_is_removed(made, exact):
    cut = made.cut(exact=exact)
    assume(cut.sound)
    root = by_lxml(FORMATS[".fcpxml"].write(cut))
    assert faults_of(root) == []
    heard = root.findall(".//spine/asset-clip/asset-clip[@lane='-2']") if exact else root.findall(".//spine/mc-clip")
    assert heard
    rate, pieces = made.edl.rate, delivered(made.edl)
    for clip in heard:
        lasts = seconds(clip.get("duration")) * rate
        first = (seconds(clip.get("start")) - (0 if exact else cut.start_s)) * rate
        fades = {fade.tag: seconds(fade.get("duration")) * rate for fade in clip.findall("./adjust-volume/param/*")}
        most = min(2, lasts // 2)
        expected = {}
        if most and first in [piece.start for piece in pieces[1:]]:
            expected["fadeIn"] = most
        if most and first + lasts in [piece.stop for piece in pieces[:-1]]:
            expected["fadeOut"] = most
        assert fades == expected


def test_a_longer_fade_is_the_editors_and_named(tmp_path):
    made = film(Fraction(25), 90)
    made = attrs.evolve(made, edl=remove(made.edl, R(40, 50)))
    root = by_lxml(FORMATS[".fcpxml"].write(made.cut()))
    [fade] = root.findall(".//fadeIn")
    fade.set("duration", "3/25s")
    changes = read(made, ".fcpxml", etree.tostring(root), tmp_path).changes
    assert changes.notes == ("adjust-volume of 'cam2' at frame 40",)


# ----------------------------------------------------------------------------------------------------- what is read


@pytest.mark.parametrize(("suffix", "exact"), FLAVOURS)
@given(made=cut_films(mixed_rates=True))
@settings(max_examples=20)
def test_what_nobody_touched_says_nothing(made, suffix, exact, folder):
    cut = made.cut(exact=exact)
    assume(cut.shown())
    found = read(made, suffix, FORMATS[suffix].write(cut), folder)
    changes = found.changes
    assert (changes.cameras, changes.removed, changes.brought_back) == ((), (), ())
    assert (found.kept, found.overruled) == ((), ())
    assert [note for note in changes.notes if not note.startswith("the marker")] == []


@pytest.mark.parametrize(("suffix", "exact"), FLAVOURS)
@given(made=films(), data=st.data())
@settings(max_examples=10)
def test_what_is_removed_after_the_export_stays_removed(made, suffix, exact, folder, data):
    """Also of documents that were exported before exports closed up: they say nothing of it, and hold everything."""
    cut = made.cut(exact=exact)
    assume(cut.shown() and made.edl.frames > 1)
    at = data.draw(st.integers(0, made.edl.frames - 2))
    now = attrs.evolve(made, edl=remove(made.edl, R(at, at + 1)))
    found = read(now, suffix, FORMATS[suffix].write(cut), folder)
    assert (found.changes.cameras, found.changes.removed, found.changes.brought_back) == ((), (), ())


@given(made=cut_films(), data=st.data(), exact=st.booleans())
@settings(max_examples=40)
def test_more_is_cut_out(made, exact, folder, data):
    cut = made.cut(exact=exact)
    shots = list(cut.held_shots())
    assume(len(shots) > 1)
    gone = data.draw(st.sets(st.integers(0, len(shots) - 1), min_size=1, max_size=len(shots) - 1))
    root = by_lxml(FORMATS[".fcpxml"].write(cut))
    spine, at_s = root.find(".//spine"), cut.start_s
    for n, clip in enumerate(list(spine)):
        if n in gone:
            spine.remove(clip)
        else:
            clip.set("offset", f"{at_s.numerator}/{at_s.denominator}s")
            at_s += seconds(clip.get("duration"))
    changes = read(made, ".fcpxml", etree.tostring(root), folder).changes
    assert (changes.cameras, changes.brought_back) == ((), ())
    assert frames_of(changes.removed) == {n for i in gone for n in shots[i].range}


@given(made=cut_films(), data=st.data(), exact=st.booleans())
@settings(max_examples=40)
def test_a_clip_made_longer_over_a_seam_brings_back(made, exact, folder, data):
    cut = made.cut(exact=exact)
    shots = list(cut.held_shots())
    ends = [(n, gone) for n, shot in enumerate(shots) for gone in made.edl.removed if gone.start == shot.range.stop]
    assume(ends)
    n, gone = data.draw(st.sampled_from(ends))
    more = data.draw(st.integers(1, len(gone)))
    root = by_lxml(FORMATS[".fcpxml"].write(cut))
    clips, by = root.findall(".//spine/*"), more / cut.rate
    longer = seconds(clips[n].get("duration")) + by
    clips[n].set("duration", f"{longer.numerator}/{longer.denominator}s")
    for clip in clips[n + 1 :]:
        later = seconds(clip.get("offset")) + by
        clip.set("offset", f"{later.numerator}/{later.denominator}s")
    changes = read(made, ".fcpxml", etree.tostring(root), folder).changes
    back = R(gone.start, gone.start + more)
    assert (changes.removed, changes.brought_back) == ((), (back,))
    whom = {m: shot.camera for shot in cut.shots for m in shot.range}
    differs = {m: shots[n].camera for m in back if whom[m] != shots[n].camera}
    assert {m: camera for piece, camera in changes.cameras for m in piece} == differs


def test_without_the_note_nothing_is_brought_back(tmp_path):
    made = film(Fraction(25), 90)
    document = FORMATS[".otio"].write(made.cut())
    made = attrs.evolve(made, edl=remove(made.edl, R(10, 20)))
    timeline = by_otio(document)
    timeline.metadata.clear()
    text = otio.adapters.write_to_string(timeline, "otio_json").encode()
    changes = read(made, ".otio", text, tmp_path).changes
    assert (changes.cameras, changes.removed, changes.brought_back) == ((), (), ())


def test_a_title_in_place_of_a_shot_beside_a_seam_covers_it(tmp_path):
    made = film(Fraction(25), 90)
    made = attrs.evolve(made, edl=remove(made.edl, R(30, 45)))
    timeline = by_otio(FORMATS[".otio"].write(made.cut(exact=True)))
    del timeline.tracks[0:3]  # the cameras
    track = timeline.video_tracks()[0]
    span = otio.opentime.TimeRange(otio.opentime.RationalTime(0, 25), otio.opentime.RationalTime(15, 25))
    track[1] = otio.schema.Clip("title", otio.schema.ExternalReference("title.mov", span), span)
    form, path = FORMATS[".otio"], tmp_path / "back.otio"
    for covered in (True, False):
        path.write_bytes(otio.adapters.write_to_string(timeline, "otio_json").encode())
        changes = find_changes(made.cut(), form.read(path, made.edl.rate), form.layout)
        assert changes.removed == (() if covered else (R(45, 60),))
        del track[1]


@given(made=cut_films())
@settings(max_examples=40)
def test_the_document_says_what_was_removed(made):
    said, now = origin_of(made.edl), attrs.evolve(made.edl, removed=())
    assert exported(said, now).removed == made.edl.removed
    assert exported(" ".join(said.split()[:2]), made.edl).removed == made.edl.removed
    assert exported(" ".join(said.split()[:2]), now) is None
    assert exported(origin_of(now), made.edl).removed == ()
