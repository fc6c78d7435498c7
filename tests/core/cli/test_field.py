"""`mcsl field`: drawn on the command line, shown as a picture, told."""

from __future__ import annotations

import json
from fractions import Fraction

import cv2
import numpy as np
import pytest

from mcsl_core import edl as edls
from mcsl_core.cli.main import main
from mcsl_core.edl import IDENTITY, Camera, Edl, FieldStretch, Media, Pose, Shot
from mcsl_core.imaging.planes import bgr_to_planes
from mcsl_core.media.writing import VideoWriter
from mcsl_core.timing import FrameRange

SIZE, FRAMES = (320, 180), 20
ANCHOR = ((1.0, 0.0, 12.0), (0.0, 1.0, -6.0), (0.0, 0.0, 1.0))


@pytest.fixture
def path(tmp_path):
    """Two poses of one grey camera at 5 frames/s; the second lies 12 pixels right and 6 up in the programme."""
    with VideoWriter(tmp_path / "cam1.mp4", size=SIZE, rate=Fraction(5)) as film:
        for _ in range(FRAMES):
            film.write(bgr_to_planes(np.full((SIZE[1], SIZE[0], 3), 90, np.uint8)))
    edl = Edl(
        rate=Fraction(5),
        size=SIZE,
        frames=FRAMES,
        reference="cam1",
        cameras=(Camera("cam1", (Media("cam1.mp4", FRAMES),), SIZE, Fraction(5)),),
        poses=(
            Pose(FrameRange(0, 8), {"cam1": IDENTITY}, solved_from=(2, 5)),
            Pose(FrameRange(8, FRAMES), {"cam1": IDENTITY}, anchor=ANCHOR),
        ),
        shots=(Shot(FrameRange(0, FRAMES), "cam1"),),
        fields=(FieldStretch(FrameRange(0, FRAMES), "middle", (((100, 60), (220, 60), (160, 140)),)),),
        centering=((0, 40.0, 0.0),),
    )
    edls.save(edl, tmp_path / "edl.json")
    return tmp_path / "edl.json"


def test_it_says_where_the_field_lies_and_changes_nothing(path, capsys) -> None:
    before = path.read_bytes()
    assert main(["field", str(path)]) == 0
    assert "nothing shows it, the middle of the picture is taken (x 100 to 220" in capsys.readouterr().out
    assert path.read_bytes() == before


def test_it_is_drawn_over_the_whole_over_frames_and_over_times(path, capsys) -> None:
    assert main(["field", str(path), "--polygon", "10,10 90,10; 90,70 10,70", "--note", "wound"]) == 0
    assert "`mcsl analyse` uses what is drawn now" in capsys.readouterr().out
    assert main(["field", str(path), "--polygon", "30,30 60,30 40,60", "--range", "5:10"]) == 0
    assert main(["field", str(path), "--polygon", "1,1 9,1 1,9", "--polygon", "50,1 90,1 90,30", "--from", "3.2"]) == 0
    made = edls.load(path)
    assert [(drawn.range, len(drawn.polygons)) for drawn in made.drawn_fields] == [
        (FrameRange(0, 5), 1),
        (FrameRange(10, 16), 1),
        (FrameRange(5, 10), 1),
        (FrameRange(16, 20), 2),
    ]
    assert made.drawn_fields[0].note == "wound"
    assert made.drawn_fields[0].polygons[0][2] == (90, 70)
    assert main(["field", str(path), "--clear", "--range", ":10"]) == 0
    assert [drawn.range for drawn in edls.load(path).drawn_fields] == [FrameRange(10, 16), FrameRange(16, 20)]
    assert main(["field", str(path), "--clear"]) == 0
    assert edls.load(path).drawn_fields == ()
    assert attrs_without(edls.load(path)) == attrs_without(made)


def attrs_without(edl: Edl) -> dict:
    return {name: value for name, value in edls.to_json(edl).items() if name != "drawn_fields"}


def test_programs_are_told(path, capsys) -> None:
    assert main(["--progress", "json", "field", str(path), "--polygon", "10,10 90,10 90,70"]) == 0
    told = json.loads(capsys.readouterr().out.splitlines()[-1])["result"]
    assert told["awaits_analysis"] is True
    assert told["fields"] == [{"range": [0, 20], "by": "hand", "polygons": [[[10, 10], [90, 10], [90, 70]]]}]


@pytest.mark.parametrize(
    ("options", "what"),
    [
        (["--polygon", "1,1 2,2"], "'1,1 2,2' has 2 points"),
        (["--polygon", "10,10 90,10 90,70", "--polygon", "1,1 5,5 9,9"], "'1,1 5,5 9,9' has no area"),
        (["--polygon", "a lot"], "'a lot' is no polygon"),
        (["--polygon", ""], "is no polygon"),
        (["--polygon", "1,1,1 2,2 3,9"], "is no polygon"),
        (["--polygon", "nan,1 2,2 3,9"], "must be"),
        (["--polygon", "900,1 950,1 910,80"], "outside of the programme's 320x180"),
        (["--polygon", "10,10 90,10 90,70", "--range", "5"], "is no range of frames"),
        (["--polygon", "10,10 90,10 90,70", "--range", "9:5"], "is no range of frames"),
        (["--polygon", "10,10 90,10 90,70", "--range", "5:500"], "is not in the programme"),
        (["--polygon", "10,10 90,10 90,70", "--range", "5:9", "--from", "1"], "--range is given in frames"),
        (["--polygon", "10,10 90,10 90,70", "--from", "noon"], "'noon' is no time"),
        (["--polygon", "10,10 90,10 90,70", "--clear"], "two wishes"),
        (["--range", "5:9"], "nothing to do there"),
    ],
)
def test_a_wrong_call_changes_nothing_and_says_what_to_do(path, capsys, options, what) -> None:
    before = path.read_bytes()
    assert main(["field", str(path), *options]) == 2
    told = capsys.readouterr().err.strip()
    assert what in told
    assert "\n" not in told
    assert path.read_bytes() == before


def test_the_picture_shows_the_outline_where_corners_are_counted(path, tmp_path, capsys) -> None:
    """Corners are programme pixels before centering, and so are the picture's."""
    out = tmp_path / "field.png"
    corners = "60,50 180,50 180,120 60,120"
    assert main(["field", str(path), "--polygon", corners, "--show", str(out), "--range", "14:15"]) == 0
    assert "frame 14" in capsys.readouterr().out
    picture = cv2.imread(str(out)).astype(int)
    assert picture.shape == (180, 320, 3)
    yellow = (picture[..., 1] > 180) & (picture[..., 2] > 180) & (picture[..., 0] < 140)
    rows, columns = np.nonzero(yellow)
    assert abs(columns.min() - 60) <= 2
    assert abs(columns.max() - 180) <= 2
    assert abs(rows.min() - 50) <= 2
    assert abs(rows.max() - 120) <= 2
    assert (picture[125, :10] < 20).all(), "the second pose's picture lies 12 pixels to the right"
    assert main(["field", str(path), "--show", str(out)]) == 0, "what mcsl wrote it may write again"
    out.write_bytes(b"mine")
    assert main(["field", str(path), "--show", str(out)]) == 3
    assert main(["field", str(path), "--show", str(path)]) == 3
    before = path.read_bytes()
    assert main(["field", str(path), "--polygon", corners, "--show", str(path)]) == 3
    assert path.read_bytes() == before, "what cannot be shown is refused before anything is drawn"
    assert edls.load(path).drawn_fields
