"""What a clip shows is what it is taken from: names, keys and places that say otherwise mislead nobody."""

from __future__ import annotations

import math
from fractions import Fraction
from itertools import product

import attrs
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from interchange_cuts import R, facts_of, film, films
from interchange_readers import by_lxml, by_otio, otio
from lxml import etree

from mcsl_core.edl import Override
from mcsl_core.interchange.changes import find_changes
from mcsl_core.interchange.formats import FORMATS
from mcsl_core.interchange.three_way import compared


def read(made, suffix, document, folder):
    """What is found changed in a document."""
    path = folder / f"back{suffix}"
    path.write_bytes(document)
    form = FORMATS[suffix]
    return find_changes(made.cut(), form.read(path, made.edl.rate), form.layout)


def of_otio(timeline):
    return otio.adapters.write_to_string(timeline, "otio_json").encode()


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("placed")


# -------------------------------------------------------------------------------------------- conformed, renamed


@pytest.mark.parametrize("by", [-5, -1, 0, 1, 5])
def test_a_conformed_clip_without_its_name_shows_whom_most_of_it_showed(by, tmp_path):
    made = film(Fraction(25), 90)
    root = by_lxml(FORMATS[".xml"].write(made.cut(exact=True)))
    first, second, third = root.findall("./sequence/media/video/track")[-1].findall("clipitem")
    for item in (first, second, third):
        item.find("name").text = "cut.programme.mp4"
    for item, tag in ((first, "end"), (first, "out"), (second, "start"), (second, "in")):
        item.find(tag).text = str(30 + by)
    changes = read(made, ".xml", etree.tostring(root), tmp_path)
    expected = {-5: ((R(25, 30), "cam2"),), -1: ((R(29, 30), "cam2"),), 0: ()}
    expected |= {1: ((R(30, 31), "cam1"),), 5: ((R(30, 35), "cam1"),)}
    assert (changes.cameras, changes.removed) == (expected[by], ())


def test_whom_it_showed_is_asked_of_what_was_exported(tmp_path):
    made = film(Fraction(25), 90)
    root = by_lxml(FORMATS[".xml"].write(made.cut(exact=True)))
    for item in root.findall("./sequence/media/video/track")[-1].findall("clipitem"):
        item.find("name").text = "cut.programme.mp4"
    path = tmp_path / "back.xml"
    path.write_bytes(etree.tostring(root))
    now = attrs.evolve(made, edl=attrs.evolve(made.edl, overrides=(Override(R(0, 25), camera="cam3"),)))
    found = compared(now.cut(), now.edl, FORMATS[".xml"].read(path, now.edl.rate), "layers")
    assert (found.changes.cameras, found.kept) == ((), ((R(0, 25), "cam3"),))


# -------------------------------------------------------------------------------------------- OpenTimelineIO's media


@pytest.mark.parametrize("renamed", [False, True])
def test_a_clips_file_replaced_under_the_same_key_is_another_camera(renamed, tmp_path):
    files = {"cam2": [facts_of("1/cam2.mp4", Fraction(25), 90, timecode="10:00:00:00")]}
    made = film(Fraction(25), 90, files=files)
    timeline = by_otio(FORMATS[".otio"].write(made.cut()))
    first, second, _ = timeline.video_tracks()[-1].find_clips()
    first.media_reference = second.media_reference.clone()
    begin = second.media_reference.available_range.start_time
    first.source_range = otio.opentime.TimeRange(begin, first.source_range.duration)
    assert first.active_media_reference_key == "cam1"
    if renamed:
        first.name = "cam2"
    changes = read(made, ".otio", of_otio(timeline), tmp_path)
    assert (changes.cameras, changes.removed) == (((R(0, 30), "cam2"),), ())


@pytest.mark.parametrize("exact", [False, True])
def test_a_clips_file_replaced_by_one_of_no_camera_is_named(exact, tmp_path):
    made = film(Fraction(25), 90)
    timeline = by_otio(FORMATS[".otio"].write(made.cut(exact=exact)))
    first = timeline.video_tracks()[-1].find_clips()[0]
    span = first.media_reference.available_range
    first.set_media_references(
        {**first.media_references(), "DEFAULT_MEDIA": otio.schema.ExternalReference("file:///logo.mov", span)},
        "DEFAULT_MEDIA",
    )
    changes = read(made, ".otio", of_otio(timeline), tmp_path)
    assert changes.cameras == ()
    assert any("is none of the programme's media" in note for note in changes.notes)


@given(made=films(), data=st.data())
@settings(max_examples=40)
def test_an_angle_switched_and_synchronised_by_hand_is_where_it_lies(made, folder, data):
    """The source range in the time of the medium that is shown now, as OpenTimelineIO means it."""
    timeline = by_otio(FORMATS[".otio"].write(made.cut()))
    clips = [c for c in timeline.video_tracks()[-1].find_clips() if len(c.media_references()) > 1]
    assume(clips)
    clip = data.draw(st.sampled_from(clips))
    others = sorted(set(clip.media_references()) - {clip.active_media_reference_key})
    key = data.draw(st.sampled_from(others))
    place = clip.range_in_parent()
    start, length = int(place.start_time.value), int(place.duration.value)
    _, picture = made.picture_at(key, start)
    clip.active_media_reference_key = key
    begin = clip.media_reference.available_range.start_time
    clip.source_range = otio.opentime.TimeRange(
        otio.opentime.RationalTime(begin.value + picture, begin.rate), clip.source_range.duration
    )
    changes = read(made, ".otio", of_otio(timeline), folder)
    assert dict.fromkeys(range(start, start + length), key) == {n: c for piece, c in changes.cameras for n in piece}
    assert changes.removed == ()


# ------------------------------------------------------------------------------------------------- names and files


@pytest.mark.parametrize("suffix", [".fcpxml", ".xml", ".otio", ".edl"])
def test_names_and_paths_with_accents_written_apart_are_the_same(suffix, tmp_path):
    """As file systems of Macs give them; in a URL each byte is escaped."""
    made = film(Fraction(25), 90, names=("Süd", "cam2", "cam3"))
    text = FORMATS[suffix].write(made.cut()).decode()
    apart = text.replace("S\u00fcd", "Su\u0308d").replace("S%C3%BCd", "Su%CC%88d")
    assert apart != text
    changes = read(made, suffix, apart.encode(), tmp_path)
    assert (changes.cameras, changes.removed, changes.notes) == ((), (), ())


@pytest.mark.parametrize("alike", [False, True])
def test_of_files_without_a_timecode_a_list_means_the_one_that_lies_there(alike, tmp_path):
    """Where only a camera's name is left, or its files are called alike."""
    rate = Fraction(25)
    parts = [facts_of("a/GH01.mov", rate, 45), facts_of("b/GH01.mov" if alike else "b/GH02.mov", rate, 45)]
    made = film(rate, 90, files={"cam3": parts})
    lines = FORMATS[".edl"].write(made.cut(sound=None)).decode().splitlines()
    text = "\n".join(line for line in lines if "SOURCE FILE" not in line)
    changes = read(made, ".edl", text.encode(), tmp_path)
    assert (changes.cameras, changes.removed, changes.notes) == ((), (), ())


@pytest.mark.parametrize(("by", "down"), [*product([-13, -2, 2, 7], [False, True]), (-1, True), (1, False)])
def test_a_cut_moved_into_a_camera_of_another_rate_is_where_it_lies(by, down, tmp_path):
    """An editor moves the picture by whole ones, rounded either way."""
    rate = Fraction(30000, 1001)
    made = film(rate, 300, files={"cam3": [facts_of("2/cam3.mp4", Fraction(25), 251)]})
    root = by_lxml(FORMATS[".xml"].write(made.cut()))
    second, third = root.findall("./sequence/media/video/track")[-1].findall("clipitem")[1:]
    pictures = by * Fraction(25) / rate
    for item, tag, shift in (
        *((second, "end", by), (second, "out", by), (third, "start", by)),
        (third, "in", math.floor(pictures) if down else math.ceil(pictures)),
    ):
        item.find(tag).text = str(int(item.find(tag).text) + shift)
    changes = read(made, ".xml", etree.tostring(root), tmp_path)
    expected = (R(200, 200 + by), "cam2") if by > 0 else (R(200 + by, 200), "cam3")
    assert (changes.cameras, changes.removed) == ((expected,), ())


def test_an_exact_list_without_its_files_and_with_another_reel_is_of_conformed_media(tmp_path):
    made = film(Fraction(25), 90, files={"cam2": [facts_of("1/cam2.mp4", Fraction(25), 90, timecode="10:00:00:00")]})
    cut = made.cut(exact=True)
    lines = [line for line in FORMATS[".edl"].write(cut).decode().splitlines() if "SOURCE FILE" not in line]
    text = "\n".join(lines).replace("  MCSL  ", "  AX    ")
    changes = read(made, ".edl", text.encode(), tmp_path)
    assert (changes.cameras, changes.removed, changes.notes) == ((), (), ())


# --------------------------------------------------------------------------------------------- FCPXML's angles


def test_a_switch_to_an_angle_that_nobody_knows_is_named(tmp_path):
    root = by_lxml(FORMATS[".fcpxml"].write(film(Fraction(25), 90).cut()))
    angles = root.findall(".//mc-angle")
    angle = next(a for a in angles if a.get("name") == "cam3")
    angle.set("name", "Left")
    root.find(".//spine/mc-clip/mc-source").set("angleID", angle.get("angleID"))
    changes = read(film(Fraction(25), 90), ".fcpxml", etree.tostring(root), tmp_path)
    assert changes.cameras == ()
    assert "the clip 'cam1' at [0, 30): Left is none of the programme's media" in changes.notes
    for source in root.findall(".//spine/mc-clip/mc-source"):
        source.set("angleID", "gone")  # nothing but the clip's name is left to say it
    changes = read(film(Fraction(25), 90), ".fcpxml", etree.tostring(root), tmp_path)
    assert (changes.cameras, changes.removed, changes.notes) == ((), (), ())
