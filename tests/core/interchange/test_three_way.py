"""Decisions of the EDL that are younger than the document stay, unless the editor decided in just those frames."""

from __future__ import annotations

import re
from fractions import Fraction

import attrs
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from interchange_cuts import R, film, films
from interchange_readers import by_lxml
from lxml import etree

from mcsl_core.edl import Override
from mcsl_core.edl.resolve import resolve
from mcsl_core.interchange.changes import with_cameras
from mcsl_core.interchange.formats import FORMATS
from mcsl_core.interchange.origin import basis_of, exported, origin_of, shots_of
from mcsl_core.interchange.three_way import compared

LATER = Override(R(10, 20), camera="cam3", note="the surgeon wants this")


def shown(edl):
    """Whom the programme shows, frame by frame."""
    return [decision.camera for piece, decision in resolve(edl) for _ in piece]


def decided(made, *overrides):
    return attrs.evolve(made, edl=attrs.evolve(made.edl, overrides=overrides))


def pulled(made, suffix, document, folder):
    """(what became of it, the EDL afterwards) of a document pulled into ``made`` as it is now."""
    path = folder / f"back{suffix}"
    path.write_bytes(document)
    form = FORMATS[suffix]
    found = compared(made.cut(), made.edl, form.read(path, made.edl.rate), form.layout)
    return found, with_cameras(made.edl, found.changes.cameras)


def switched(document, frames, camera):
    """An FCPXML whose clip of just these frames shows another angle."""
    root = by_lxml(document)
    angles = {angle.get("name"): angle.get("angleID") for angle in root.iter("mc-angle")}
    clips = root.findall(".//spine/mc-clip")
    lengths = [Fraction(c.get("duration").rstrip("s")) * 25 for c in clips]
    starts = [sum(lengths[:n]) for n in range(len(lengths))]
    clip = clips[[(a, a + b) for a, b in zip(starts, lengths, strict=True)].index(frames)]
    clip.find("mc-source").set("angleID", angles[camera])
    return etree.tostring(root)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("later")


@pytest.mark.parametrize("suffix", FORMATS)
@pytest.mark.parametrize("exact", [False, True])
@given(made=films(), data=st.data())
@settings(max_examples=15)
def test_what_nobody_touched_takes_no_later_decision_back(made, suffix, exact, folder, data):
    cut = made.cut(exact=exact)
    assume(cut.shown())
    start = data.draw(st.integers(0, made.edl.frames - 1))
    piece = R(start, data.draw(st.integers(start + 1, made.edl.frames)))
    later = Override(piece, camera=data.draw(st.sampled_from([c.name for c in made.edl.cameras])), note="later")
    earlier = made.edl.overrides[data.draw(st.integers(0, len(made.edl.overrides))) :]  # some were taken back as well
    now = decided(made, *earlier, later)
    found, new = pulled(now, suffix, FORMATS[suffix].write(cut), folder)
    assert new == now.edl
    assert (found.changes.cameras, found.changes.removed, found.changes.notes, found.overruled) == ((), (), (), ())
    differs = {n for n, (a, b) in enumerate(zip(shown(made.edl), shown(now.edl), strict=True)) if a != b}
    assert {n: camera for one, camera in found.kept for n in one} == {n: shown(now.edl)[n] for n in differs}


def test_the_editors_decision_holds_beside_a_later_one_and_overrules_it_by_name_where_they_meet(tmp_path):
    made = film(Fraction(25), 90, overrides=(Override(R(40, 50), camera="cam1", note="earlier"),))
    document = FORMATS[".fcpxml"].write(made.cut())
    now = decided(made, *made.edl.overrides, LATER)
    found, new = pulled(now, ".fcpxml", switched(document, (60, 90), "cam2"), tmp_path)
    assert new.overrides == (*now.edl.overrides, Override(R(60, 90), camera="cam2"))
    assert (found.kept, found.overruled) == (((R(10, 20), "cam3"),), ())
    found, new = pulled(now, ".fcpxml", switched(document, (0, 30), "cam2"), tmp_path)  # where the later one lies
    assert (found.kept, found.overruled) == ((), ((R(10, 20), "cam3"),))
    assert new.overrides == (now.edl.overrides[0], Override(R(0, 30), camera="cam2"))  # up to the next shot
    found, new = pulled(now, ".fcpxml", switched(document, (0, 30), "cam3"), tmp_path)  # the same as the later one
    assert (found.changes.cameras, found.overruled) == (((R(0, 10), "cam3"), (R(20, 30), "cam3")), ())
    assert LATER in new.overrides
    found, new = pulled(now, ".fcpxml", switched(document, (40, 50), "cam2"), tmp_path)  # the earlier one taken back
    assert new.overrides == (LATER,)


@pytest.mark.parametrize("suffix", FORMATS)
@pytest.mark.parametrize("lost", ["all", "stretches"])
def test_where_the_document_does_not_say_what_it_showed_nothing_is_taken_back(suffix, lost, tmp_path):
    made = film(Fraction(25), 90, overrides=(Override(R(40, 50), camera="cam1"),))
    document = FORMATS[suffix].write(made.cut(sound=None)).decode()
    if lost == "all":
        document = re.sub(r"mcsl cut|MCSL CUT|\"cut\": \"", lambda said: "x" * len(said[0]), document)
        document = document if suffix != ".otio" else document.replace("xxxxxxxx", '"c": "')
    else:
        document = document.replace("40-50:0", "")
    now = decided(made, *made.edl.overrides, LATER)
    found, new = pulled(now, suffix, document.encode(), tmp_path)
    assert new == now.edl
    assert (found.changes.cameras, found.kept) == ((), ((R(10, 20), "cam3"),))
    third = decided(made, *made.edl.overrides, attrs.evolve(LATER, range=R(30, 60)))  # over the exported one
    found, new = pulled(third, suffix, document.encode(), tmp_path)
    assert found.overruled == ((R(40, 50), "cam3"),)
    assert found.kept == ((R(30, 40), "cam3"), (R(50, 60), "cam3"))


@given(made=films())
@settings(max_examples=60)
def test_a_document_says_just_what_it_showed(made):
    origin = origin_of(made.edl)
    plain = attrs.evolve(made.edl, overrides=())
    assert exported(origin, plain).shots == shots_of(made.edl)
    assert exported(" ".join(origin.split()[:2]), made.edl).shots == shots_of(made.edl)
    assert exported(basis_of(made.edl), made.edl) is None
    if shots_of(plain) != shots_of(made.edl):
        assert exported(" ".join(origin.split()[:2]), plain) is None
        assert exported(origin[:-1], plain) is None


def test_what_is_too_long_for_a_note_is_left_out_and_known_by_its_digest():
    frames = 60_000
    overrides = tuple(Override(R(n, n + 3), camera="cam2") for n in range(0, 20_000, 5))
    edl = film(Fraction(25), frames, overrides=overrides).edl
    assert len(origin_of(edl)) == 33
    assert exported(origin_of(edl), edl).shots == shots_of(edl)
    assert exported(origin_of(edl), attrs.evolve(edl, overrides=overrides[:-1])) is None
