"""Which EDL a timeline may write to, wherever it was copied."""

from __future__ import annotations

import attrs
import pytest
from blender_recording import an_edl

from blender_addon.core import identity
from blender_addon.core.strip_plan import automatic_cameras, automatic_to_text
from mcsl_core.edl import Shot
from mcsl_core.errors import InputError
from mcsl_core.timing import FrameRange as R


def with_prints(edl, salt=""):
    cameras = tuple(
        attrs.evolve(c, media=tuple(attrs.evolve(m, fingerprint=salt + m.path) for m in c.media)) for c in edl.cameras
    )
    return attrs.evolve(edl, cameras=cameras)


EDL = with_prints(an_edl())
OTHER = with_prints(
    attrs.evolve(
        an_edl(),
        cameras=tuple(
            attrs.evolve(c, media=(attrs.evolve(c.media[0], frames=17), *c.media[1:])) for c in an_edl().cameras
        ),
    ),
    "other",
)
AUTOMATIC = automatic_to_text(automatic_cameras(EDL))
RECUT = attrs.evolve(EDL, shots=(Shot(R(0, 60), "cam2"),))


def test_the_facts_survive_the_scene_and_odd_texts_say_nothing():
    facts = identity.facts_of(EDL)
    assert identity.facts_from_text(identity.facts_to_text(facts)) == facts
    for odd in ("", "[]", "3", "null", '{"cam1": 3}', '{"cam1": ["a"]}', "{"):
        assert identity.facts_from_text(odd) == {}


def check(edl, tmp_path, *, moved, noted=EDL, automatic=AUTOMATIC):
    identity.check_belongs(edl, tmp_path, identity.facts_of(noted), automatic=automatic, moved=moved)


@pytest.mark.parametrize("moved", [False, True])
def test_its_own_edl_belongs_to_it(tmp_path, moved):
    check(EDL, tmp_path, moved=moved)
    check(an_edl(), tmp_path, moved=moved)  # one without fingerprints


def test_where_it_lay_a_new_analysis_and_repaired_files_do(tmp_path):
    check(RECUT, tmp_path, moved=False)
    check(with_prints(EDL, "repaired "), tmp_path, moved=False)
    check(
        attrs.evolve(
            EDL,
            cameras=EDL.cameras[:1],
            shots=(Shot(R(0, 60), "cam1"),),
            overrides=(),
            poses=an_edl().poses[:0]
            + tuple(attrs.evolve(p, homographies={"cam1": p.homographies["cam1"]}) for p in EDL.poses),
        ),
        tmp_path,
        moved=False,
    )
    with pytest.raises(InputError, match="of another recording"):
        check(OTHER, tmp_path, moved=False)


def test_moved_it_takes_only_a_true_copy(tmp_path):
    with pytest.raises(InputError, match="other automatic decisions"):
        check(RECUT, tmp_path, moved=True)
    for other in (OTHER, with_prints(EDL, "repaired ")):
        with pytest.raises(InputError, match="of another recording"):
            check(other, tmp_path, moved=True)


def test_where_it_is_looked_for(tmp_path):
    here, there = tmp_path / "here", tmp_path / "there"
    for folder in (here, there):
        folder.mkdir()
    home = identity.home_of(there)
    assert identity.candidates("//../edl.json", here, home=home) == (here / ".." / "edl.json",)
    whole = str(there / "edl.json")
    assert identity.candidates(whole, there, home=home) == (there / "edl.json",)
    assert identity.candidates(whole, here, home=identity.home_of(here)) == (there / "edl.json",)
    assert identity.candidates(whole, here, home=home) == (here / "edl.json",)  # copied: never back into the other
    assert identity.candidates(whole, here, home="") == (here / "edl.json", there / "edl.json")  # an older timeline
