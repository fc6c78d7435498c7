"""Changes of sound made in another editor: none is read, all are named with where they stand, in every format."""

from __future__ import annotations

import copy
from fractions import Fraction

import attrs
import pytest
from interchange_cuts import R, facts_of, film
from interchange_readers import by_lxml, by_otio, otio
from lxml import etree

from mcsl_core.edl import Clock
from mcsl_core.edl.removal import remove
from mcsl_core.interchange.changes import find_changes
from mcsl_core.interchange.formats import FORMATS

RATE = Fraction(25)
AUDIBLE = [".fcpxml", ".xml", ".otio", ".edl"]


def read(made, suffix, document, folder):
    """What is found changed in a document."""
    path = folder / f"back{suffix}"
    path.write_bytes(document)
    form = FORMATS[suffix]
    return find_changes(made.cut(), form.read(path, made.edl.rate), form.layout)


def told(made, suffix, document, folder):
    """What is named, where nothing else was changed."""
    changes = read(made, suffix, document, folder)
    assert (changes.cameras, changes.removed, changes.brought_back) == ((), (), ())
    return changes.notes


def written(timeline):
    return otio.adapters.write_to_string(timeline, "otio_json").encode()


def sounds_of(root):
    """The clips of an exact FCPXML that are heard."""
    return [clip for clip in root.findall(".//project//asset-clip") if clip.get("lane") == "-2"]


def drop_sound(suffix, document):
    """The document without any sound: pictures alone."""
    if suffix == ".fcpxml":
        root = by_lxml(document)
        for source in root.findall(".//project//mc-source"):
            if source.get("srcEnable") == "audio":
                source.getparent().remove(source)
            else:
                source.set("srcEnable", "video")
        for clip in sounds_of(root):
            clip.getparent().remove(clip)
        return etree.tostring(root)
    if suffix == ".xml":
        root = by_lxml(document)
        for track in root.findall("./sequence/media/audio/track"):
            track.getparent().remove(track)
        return etree.tostring(root)
    if suffix == ".otio":
        timeline = by_otio(document)
        for track in timeline.audio_tracks():
            timeline.tracks.remove(track)
        return written(timeline)
    blocks = document.decode().split("\n\n")
    return "\n\n".join(block for block in blocks if " A " not in block.split("\n")[0]).encode()


# -------------------------------------------------------------------------------------------- muted, taken out


@pytest.mark.parametrize("exact", [False, True])
@pytest.mark.parametrize("suffix", AUDIBLE)
def test_sound_that_was_taken_out_is_named(suffix, exact, tmp_path):
    made = film(RATE, 90)
    document = drop_sound(suffix, FORMATS[suffix].write(made.cut(exact=exact)))
    of = "the conformed sound" if exact else "the sound of cam1"
    assert told(made, suffix, document, tmp_path) == (f"{of} is not heard at frames [0, 90)",)


@pytest.mark.parametrize("suffix", AUDIBLE)
def test_of_what_was_exported_without_sound_none_is_missed(suffix, tmp_path):
    made = film(RATE, 90)
    assert told(made, suffix, FORMATS[suffix].write(made.cut(sound=None)), tmp_path) == ()
    assert told(made, suffix, FORMATS[suffix].write(made.cut(sound="cam3")), tmp_path) == ()


def test_a_muted_clip_is_named(tmp_path):
    made = film(RATE, 90)
    root = by_lxml(FORMATS[".fcpxml"].write(made.cut(exact=True)))
    sounds_of(root)[0].set("enabled", "0")
    assert told(made, ".fcpxml", etree.tostring(root), tmp_path) == (
        "the conformed sound is not heard at frames [0, 90)",
    )
    root = by_lxml(FORMATS[".fcpxml"].write(made.cut()))
    root.findall(".//project//spine/mc-clip")[1].set("srcEnable", "video")
    assert told(made, ".fcpxml", etree.tostring(root), tmp_path) == (
        "the sound of cam1 is not heard at frames [30, 60)",
    )
    root = by_lxml(FORMATS[".xml"].write(made.cut()))
    root.find("./sequence/media/audio/track/clipitem/enabled").text = "FALSE"
    assert told(made, ".xml", etree.tostring(root), tmp_path) == ("the sound of cam1 is not heard at frames [0, 90)",)
    root = by_lxml(FORMATS[".xml"].write(made.cut()))
    root.find("./sequence/media/audio/track/enabled").text = "FALSE"
    assert told(made, ".xml", etree.tostring(root), tmp_path) == ("the sound of cam1 is not heard at frames [0, 90)",)
    for part in ("track", "clip"):
        timeline = by_otio(FORMATS[".otio"].write(made.cut()))
        [track] = timeline.audio_tracks()
        (track if part == "track" else track[0]).enabled = False
        assert told(made, ".otio", written(timeline), tmp_path) == ("the sound of cam1 is not heard at frames [0, 90)",)


def test_a_channel_that_is_muted_is_named(tmp_path):
    made = film(RATE, 90, files={"cam1": [facts_of("0/cam1.mp4", RATE, 90, channels=2)]})
    root = by_lxml(FORMATS[".xml"].write(made.cut()))
    second = root.findall("./sequence/media/audio/track/clipitem")[1]
    second.find("enabled").text = "FALSE"
    expected = ("channel 2 of the sound of cam1 is not heard at frames [0, 90)",)
    assert told(made, ".xml", etree.tostring(root), tmp_path) == expected


# ------------------------------------------------------------------------------------------ another microphone


def other_microphone(suffix, document):
    """The sound of the second shot from cam2, or of everything where the format has it in one clip."""
    if suffix == ".fcpxml":
        root = by_lxml(document)
        cam2 = root.find(".//mc-angle[@name='cam2']").get("angleID")
        clip = root.findall(".//project//spine/mc-clip")[1]
        clip.remove(clip.findall("mc-source")[1])
        clip.find("mc-source").set("srcEnable", "all")
        assert clip.find("mc-source").get("angleID") == cam2
        return etree.tostring(root), R(30, 60)
    if suffix == ".xml":
        root = by_lxml(document)
        file = next(f for f in root.iter("file") if f.findtext("name") == "cam2.mp4")
        item = root.find("./sequence/media/audio/track/clipitem")
        item.find("file").set("id", file.get("id"))
        return etree.tostring(root), R(0, 90)
    if suffix == ".otio":
        timeline = by_otio(document)
        medium = timeline.video_tracks()[-1][1].media_reference
        timeline.audio_tracks()[0][0].set_media_references({"cam2": medium.clone()}, "cam2")
        return written(timeline), R(0, 90)
    blocks = document.decode().split("\n\n")
    changed = [
        b.replace("CAM1", "CAM2").replace("0/cam1", "1/cam2") if " A " in b.split("\n")[0] else b for b in blocks
    ]
    return "\n\n".join(changed).encode(), R(0, 90)


@pytest.mark.parametrize("suffix", AUDIBLE)
def test_another_microphone_is_named_and_so_is_the_one_that_is_missed(suffix, tmp_path):
    made = film(RATE, 90)
    document, where = other_microphone(suffix, FORMATS[suffix].write(made.cut()))
    assert told(made, suffix, document, tmp_path) == (
        f"the sound of cam2 at frames {where}",
        f"the sound of cam1 is not heard at frames {where}",
    )


def test_music_is_named(tmp_path):
    made = film(RATE, 90)
    timeline = by_otio(FORMATS[".otio"].write(made.cut()))
    span = otio.opentime.TimeRange(otio.opentime.RationalTime(0, 25), otio.opentime.RationalTime(20, 25))
    music = otio.schema.Clip("music", otio.schema.ExternalReference("file:///music.wav", span), span)
    timeline.tracks.append(otio.schema.Track("music", [music], kind="Audio"))
    assert told(made, ".otio", written(timeline), tmp_path) == (
        "the sound 'music' at [0, 20): /music.wav is none of the programme's media",
    )


# ------------------------------------------------------------------------------------------ level, effects, fades


@pytest.mark.parametrize("kind", ["adjust-volume", "adjust-EQ", "filter-audio", "mute", "off"])
def test_levels_and_effects_are_named_in_fcpxml(kind, tmp_path):
    made = film(RATE, 90)
    for exact in (False, True):
        root = by_lxml(FORMATS[".fcpxml"].write(made.cut(exact=exact)))
        clip = sounds_of(root)[0] if exact else root.findall(".//project//spine/mc-clip")[1].find("mc-source")
        source = etree.SubElement(clip, "audio-channel-source" if exact else "audio-role-source")
        untouched = etree.tostring(root)
        assert told(made, ".fcpxml", untouched, tmp_path) == ()
        if kind == "off":
            source.set("enabled" if exact else "active", "0")
        elif kind == "mute":
            etree.SubElement(source, "mute")
        else:
            etree.SubElement(clip, kind, **({"amount": "-6dB"} if kind == "adjust-volume" else {}))
        [note] = told(made, ".fcpxml", etree.tostring(root), tmp_path)
        assert note.endswith("of 'cam1' at frame 0" if exact else "of 'cam2' at frame 30")


def test_what_editors_write_of_every_clip_is_no_change(tmp_path):
    made = film(RATE, 90)
    root = by_lxml(FORMATS[".fcpxml"].write(made.cut()))
    for clip in root.findall(".//project//spine/mc-clip"):
        etree.SubElement(clip, "adjust-conform", type="fit")
        etree.SubElement(clip, "adjust-transform", scale="1 1", anchor="0 0", position="0 0")
        etree.SubElement(clip, "adjust-volume", amount="0dB")
    assert told(made, ".fcpxml", etree.tostring(root), tmp_path) == ()
    root = by_lxml(FORMATS[".xml"].write(made.cut()))
    item = root.find("./sequence/media/audio/track/clipitem")
    item.append(effect("audiolevels", "level", "1"))
    item.append(effect("audiopan", "pan", "0"))
    shown = root.find("./sequence/media/video/track/clipitem")
    shown.append(effect("opacity", "opacity", "100"))
    assert told(made, ".xml", etree.tostring(root), tmp_path) == ()


def effect(kind, name, value, keyframes=()):
    """An effect of xmeml."""
    made = etree.Element("filter")
    inner = etree.SubElement(made, "effect")
    etree.SubElement(inner, "name").text = kind
    etree.SubElement(inner, "effectid").text = kind
    parameter = etree.SubElement(inner, "parameter")
    etree.SubElement(parameter, "parameterid").text = name
    etree.SubElement(parameter, "value").text = value
    for when in keyframes:
        key = etree.SubElement(parameter, "keyframe")
        etree.SubElement(key, "when").text = str(when)
        etree.SubElement(key, "value").text = value
    return made


@pytest.mark.parametrize(("value", "keyframes"), [("0.5", ()), ("1", (0, 20)), ("loud", ())])
def test_levels_are_named_in_xmeml(value, keyframes, tmp_path):
    made = film(RATE, 90)
    root = by_lxml(FORMATS[".xml"].write(made.cut()))
    root.find("./sequence/media/audio/track/clipitem").append(effect("audiolevels", "level", value, keyframes))
    assert told(made, ".xml", etree.tostring(root), tmp_path) == ("'audiolevels' of the sound 'cam1' at frame 0",)


def test_transitions_and_effects_of_sound_are_named(tmp_path):
    made = film(RATE, 90)
    made = attrs.evolve(made, edl=remove(made.edl, R(40, 50)))
    timeline = by_otio(FORMATS[".otio"].write(made.cut()))
    [track] = timeline.audio_tracks()
    half = otio.opentime.RationalTime(2, 25)
    track[1].effects.append(otio.schema.Effect("louder", "Gain"))
    track.insert(1, otio.schema.Transition("SMPTE_Dissolve", "mix", half, half))
    assert told(made, ".otio", written(timeline), tmp_path) == (
        "a transition of the sound at frame 40",
        "'Gain' of the sound 'cam1' at frame 40",
    )
    root = by_lxml(FORMATS[".xml"].write(made.cut()))
    track = root.find("./sequence/media/audio/track")
    between = etree.Element("transitionitem")
    for tag, text in (("start", "38"), ("end", "42"), ("alignment", "center")):
        etree.SubElement(between, tag).text = text
    track.insert(1, between)
    assert told(made, ".xml", etree.tostring(root), tmp_path) == ("a transition of the sound at frame 38",)
    lines = FORMATS[".edl"].write(made.cut()).decode()
    lines += "* AUDIO LEVEL AT 01:00:01:00 IS -6.00 DB  (REEL CAM1 A1)\n* AUDIO LEVEL AT 01:00:00:00 IS +0.00 DB\n"
    assert told(made, ".edl", lines.encode(), tmp_path) == ("a level of the sound of -6.00 dB at 01:00:01:00",)


# ------------------------------------------------------------------------------------------- split, moved, apart


def test_a_split_edit_is_named_where_sound_and_picture_part(tmp_path):
    """The second shot cut out, its sound left to run on under the third."""
    made = film(RATE, 90)
    root = by_lxml(FORMATS[".xml"].write(made.cut()))
    *cameras, shots = root.findall("./sequence/media/video/track")
    for track in cameras:
        track.getparent().remove(track)
    _, second, third = shots.findall("clipitem")
    shots.remove(second)
    third.find("start").text, third.find("end").text = "30", "60"
    changes = read(made, ".xml", etree.tostring(root), tmp_path)
    assert changes.removed == (R(30, 60),)
    assert changes.notes == (
        "the sound of cam1 is of another moment than the picture at frames [30, 60)",
        "the sound of cam1 is heard without its picture at frames [60, 90)",
    )


def test_sound_that_lasts_longer_than_its_picture_is_named_in_fcpxml(tmp_path):
    """A J-cut over a seam: the sound of the second shot begins before its picture."""
    made = film(RATE, 90, shots=film(RATE, 90).edl.shots)
    root = by_lxml(FORMATS[".fcpxml"].write(made.cut()))
    first, second, third = root.findall(".//project//spine/mc-clip")
    first.getparent().remove(second)
    third.set("offset", second.get("offset"))
    third.set("audioStart", f"{3600 * 25 + 50}/25s")
    third.set("audioDuration", "40/25s")
    first.set("audioStart", first.get("start"))
    first.set("audioDuration", "20/25s")
    changes = read(made, ".fcpxml", etree.tostring(root), tmp_path)
    assert changes.removed == (R(30, 60),)
    assert changes.notes == ("the sound of cam1 is of another moment than the picture at frames [20, 30)",)


def test_sound_slipped_by_a_frame_is_named(tmp_path):
    made = film(
        RATE, 90, cameras={"cam1": {"clock": Clock(offset_s=-0.4)}}, files={"cam1": [facts_of("0/cam1.mp4", RATE, 200)]}
    )
    timeline = by_otio(FORMATS[".otio"].write(made.cut()))
    clip = timeline.audio_tracks()[0][0]
    span = clip.source_range
    clip.source_range = otio.opentime.TimeRange(span.start_time + otio.opentime.RationalTime(1, 25), span.duration)
    expected = ("the sound of cam1 is of another moment than the picture at frames [0, 90)",)
    assert told(made, ".otio", written(timeline), tmp_path) == expected


def test_a_clip_cut_in_two_and_shots_cut_out_with_their_sound_say_nothing(tmp_path):
    made = film(RATE, 90)
    timeline = by_otio(FORMATS[".otio"].write(made.cut()))
    for track in timeline.tracks:
        time = otio.opentime.RationalTime
        clip = track[0]
        if track.kind == "Audio" or track.name != "Programme":
            halves = []
            for start, length in ((0, 30), (60, 30)):
                half = clip.clone()
                half.source_range = otio.opentime.TimeRange(time(start, 25), time(length, 25))
                halves.append(half)
            track[:] = halves
        else:
            del track[1]
    changes = read(made, ".otio", written(timeline), tmp_path)
    assert (changes.cameras, changes.removed, changes.notes) == ((), (R(30, 60),), ())


def test_without_the_note_the_sound_that_is_most_heard_counts_as_exported(tmp_path):
    made = film(RATE, 90)
    timeline = by_otio(FORMATS[".otio"].write(made.cut()))
    timeline.metadata.clear()
    [track] = timeline.audio_tracks()
    span = copy.deepcopy(track[0].source_range)
    track[0].source_range = otio.opentime.TimeRange(span.start_time, otio.opentime.RationalTime(80, 25))
    assert told(made, ".otio", written(timeline), tmp_path) == ("the sound of cam1 is not heard at frames [80, 90)",)
