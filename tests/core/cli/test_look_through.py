"""The look `see_through` in the document: left out where nobody asked for it."""

from __future__ import annotations

import attrs
import pytest
from builders import small_edl as make

from mcsl_core import edl as edls
from mcsl_core.cli.main import main
from mcsl_core.edl import Look, Override, from_json, to_json
from mcsl_core.edl.resolve import resolve
from mcsl_core.errors import DocumentError
from mcsl_core.timing import FrameRange


@pytest.fixture
def small_edl():
    return make()


def test_it_is_off_and_not_written_until_it_is_asked_for(small_edl):
    value = to_json(small_edl)
    assert "see_through" not in value["look"]
    assert not from_json(value).look.see_through
    on = attrs.evolve(small_edl, look=Look(see_through=True))
    assert to_json(on)["look"]["see_through"] is True
    assert from_json(to_json(on)) == on


def test_a_stretch_is_switched(small_edl):
    edl = attrs.evolve(small_edl, overrides=(Override(FrameRange(3, 5), see_through=True),))
    assert {d.see_through for piece, d in resolve(edl) if 3 in piece} == {True}
    assert {d.see_through for piece, d in resolve(edl) if 5 in piece} == {False}
    assert to_json(edl)["overrides"] == [{"range": [3, 5], "see_through": True}]


def test_what_is_no_switch_is_refused(small_edl):
    value = to_json(small_edl)
    value["overrides"] = [{"range": [0, 1], "see_through": 1}]
    with pytest.raises(DocumentError, match=r"overrides\[0\]\.see_through"):
        from_json(value)


def test_the_command_line_switches_it(tmp_path, capsys, small_edl):
    path = tmp_path / "edl.json"
    edls.save(small_edl, path)
    before = path.read_bytes()
    assert main(["look", str(path), "--see-through"]) == 0
    assert "see through on" in capsys.readouterr().out
    assert edls.load(path).look.see_through
    assert main(["look", str(path), "--no-see-through"]) == 0
    assert path.read_bytes() == before
