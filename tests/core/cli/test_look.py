"""Switching the aids in an EDL, and the picture that shows where each pixel came from."""

from fractions import Fraction

import attrs
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from plain_context import PlainContext
from strategies import edls as any_edl

from mcsl_core import edl as edls
from mcsl_core.cli.commands.look import AIDS, change_file
from mcsl_core.cli.main import main
from mcsl_core.edl.edits import change_look
from mcsl_core.edl.resolve import resolve
from mcsl_core.errors import UsageError
from mcsl_core.filling.footprint import FootprintFiller
from mcsl_core.filling.paper import PaperFiller
from mcsl_core.filling.provenance import TINTS, ShowProvenance
from mcsl_core.imaging.planes import Planes
from mcsl_core.timing import FrameRange

aids = st.fixed_dictionaries({}, optional={name: st.booleans() for name in AIDS})


@settings(max_examples=25)
@given(any_edl(), aids)
def test_the_whole_is_switched_and_stretches_stay(edl, given):
    made = change_look(edl, **given)
    assert made.overrides == edl.overrides
    assert attrs.evolve(made, look=edl.look) == edl
    assert all(getattr(made.look, name) == given.get(name, getattr(edl.look, name)) for name in AIDS)


@settings(max_examples=25)
@given(any_edl(), aids, st.data())
def test_a_stretch_is_switched_and_nothing_else(edl, given, data):
    start = data.draw(st.integers(0, edl.frames - 1))
    piece = FrameRange(start, data.draw(st.integers(start + 1, edl.frames)))
    made = change_look(edl, piece=piece, **given)
    before, after = resolve(edl), resolve(made)
    for frame in {0, max(0, start - 1), start, piece.stop - 1, min(piece.stop, edl.frames - 1), edl.frames - 1}:
        was, now = (next(d for p, d in decisions if frame in p) for decisions in (before, after))
        wanted = attrs.evolve(was, **given) if frame in piece else was
        # A centre by hand eases over its own ends, and where centering is switched there is another end.
        assert attrs.evolve(now, overridden=False, eases=()) == attrs.evolve(wanted, overridden=False, eases=())


def test_the_command_writes_what_it_says(tmp_path, capsys, small_edl):
    path = tmp_path / "edl.json"
    edls.save(small_edl, path)
    assert main(["look", str(path), "--no-fill"]) == 0
    assert "fill off" in capsys.readouterr().out
    assert main(["look", str(path), "--from", "1", "--to", "0:02", "--fill", "--centre", "12,-7.5"]) == 0
    made = edls.load(path)
    assert not made.look.fill
    assert made.overrides[-1].fill
    assert made.overrides[-1].offset == (12.0, -7.5)
    assert made.overrides[-1].range == FrameRange(int(made.rate), 2 * int(made.rate))
    unchanged = path.read_bytes()
    assert main(["look", str(path)]) == 0
    assert "12,-7.5" in capsys.readouterr().out
    assert path.read_bytes() == unchanged


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"start": "2", "stop": "1", "fill": True}, "no frame"),
        ({"start": "1"}, "nothing to switch"),
        ({"start": "soon", "fill": True}, "no time"),
        ({"centre": "left"}, "no shift"),
        ({"centre": "nan,0"}, "--centre nan,0"),
        ({"centre": "1e9,0"}, "--centre 1e9,0"),
        ({"centre": "5,1e308", "start": "1", "stop": "2"}, "--centre 5,1e308"),
    ],
)
def test_a_wrong_call_says_what_is_wrong(tmp_path, small_edl, given, said):
    path = tmp_path / "edl.json"
    edls.save(small_edl, path)
    before = path.read_bytes()
    with pytest.raises(UsageError, match=said):
        change_file(path, **given)
    assert path.read_bytes() == before


@pytest.fixture
def small_edl():
    return edls.Edl(
        rate=Fraction(25),
        size=(320, 180),
        frames=100,
        reference="a",
        cameras=(edls.Camera("a", (edls.Media("a.mp4", 100),), (320, 180), Fraction(25)),),
        poses=(edls.Pose(FrameRange(0, 100), {"a": edls.IDENTITY}),),
        shots=(edls.Shot(FrameRange(0, 100), "a"),),
    )


# ------------------------------------------------------------------------------------------------------- show-origin


def chroma_at(planes: Planes, x: int) -> tuple[int, int]:
    return int(planes.u[80, x // 2]), int(planes.v[80, x // 2])


@pytest.mark.parametrize("filler", [FootprintFiller(16), PaperFiller()])
def test_every_pixel_has_the_tint_of_its_camera(filler):
    view = PlainContext({"ref": (0, 320), "a": (160, 320)}, {"ref": 100, "a": 180}, "a")
    plain, shown = filler.fill(view), ShowProvenance(filler, ["ref", "a"]).fill(view)
    assert np.array_equal(plain.y[100:], shown.y[100:])  # below the legend
    for x, camera in ((60, 0), (300, 1)):
        expected = [128 + 0.6 * (t - 128) for t in TINTS[camera]]
        assert chroma_at(shown, x) == pytest.approx(expected, abs=1.5)
    edge = [chroma_at(shown, x)[0] for x in range(130, 230, 2)]
    assert np.abs(np.diff(edge)).max() < 20  # blended as the pictures are


def test_looks_at_other_moments_are_darker_and_black_has_no_origin():
    columns = {"ref": (0, 160), "a": (60, 160), "c": (100, 260)}
    view = PlainContext(columns, {"ref": 100, "a": 180, "c": 100}, "a")
    shown = ShowProvenance(FootprintFiller(16), ["ref", "a", "c"]).fill(view)
    assert shown.y[150, 220] == pytest.approx(16 + 0.7 * (100 - 16), abs=2)
    assert chroma_at(shown, 300) == (128, 128)


def test_without_fill_the_chosen_camera_is_tinted_alone():
    view = PlainContext({"ref": (0, 320), "a": (160, 320)}, {"ref": 100, "a": 180}, "a")
    shown = ShowProvenance(FootprintFiller(16), ["ref", "a"]).unfilled(view)
    assert (shown.y[120:, :150] == 16).all()
    assert chroma_at(shown, 300) != (128, 128)
