"""Where the chosen camera has no picture a viewer sees another camera's, and is told whose."""

from __future__ import annotations

from fractions import Fraction

import attrs
import pytest
from coded_video import SIZE, read_number, write_coded
from notes import Notes

from mcsl_core.compositing.compositor import Compositor
from mcsl_core.delivery.chunk_keys import plan_chunks
from mcsl_core.delivery.conform import conform
from mcsl_core.delivery.direct import write_direct
from mcsl_core.delivery.source import ProgrammeSource
from mcsl_core.edl import Camera, Clock, Edl, Look, Media, Override, Pose, Shot, Weak
from mcsl_core.imaging.planes import planes_to_bgr
from mcsl_core.recording.footage import footage_of
from mcsl_core.timing import FrameRange

FRAMES, RATE = 30, Fraction(30)
GAP = FrameRange(10, 20)
WHOLE = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
ASIDE = ((1.0, 0.0, 40.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
BLACK = 0  # what reads as no bit at all


def programme(folder, *, fill, gaps, placed="abc", media=None, shown="b"):
    """Cameras a (the reference), b, c and d of which each picture says which it is: 1, 2, 3 and 4."""
    cameras = []
    for number, name in enumerate("abcd", start=1):
        length = (media or {}).get(name, FRAMES)
        if not (folder / f"{name}.mp4").exists():
            write_coded(folder / f"{name}.mp4", [number] * length)
        found = Media(f"{name}.mp4", length)
        cameras.append(Camera(name, (found,), SIZE, RATE, Clock(), (GAP,) if name in gaps else ()))
    homographies = {name: ASIDE if name == "c" else WHOLE for name in placed}
    weak = tuple(Weak(name, "nothing matches") for name in "abcd" if name not in placed)
    return Edl(
        rate=RATE,
        size=SIZE,
        frames=FRAMES,
        reference="a",
        cameras=tuple(cameras),
        poses=(Pose(FrameRange(0, FRAMES), homographies, weak=weak),),
        shots=(Shot(FrameRange(0, FRAMES), "a"),),
        overrides=(Override(FrameRange(0, FRAMES), camera=shown),),
        look=Look(centering=False, fill=fill, colour=False),
    )


def numbers(edl, folder):
    with Compositor(edl, footage_of(edl, folder, threads=1)) as compositor:
        return [read_number(planes_to_bgr(planes)) for planes in compositor.frames(FrameRange(0, FRAMES))]


@pytest.mark.parametrize("fill", [False, True])
@pytest.mark.parametrize(
    ("gaps", "placed", "stands_in"),
    [
        ("b", "abc", 1),  # the reference
        ("ab", "abd", 4),  # another whose place is known, before one whose place is not
        ("abd", "abd", 3),  # one whose place is not known, before black
        ("abc", "ab", 4),
        ("abcd", "abc", BLACK),
    ],
)
def test_a_viewer_sees_the_nearest_camera_that_has_a_picture(tmp_path, fill, gaps, placed, stands_in):
    edl = programme(tmp_path, fill=fill, gaps=gaps, placed=placed)
    assert numbers(edl, tmp_path) == [stands_in if frame in GAP else 2 for frame in range(FRAMES)]


@pytest.mark.parametrize("fill", [False, True])
def test_cameras_that_have_ended_too(tmp_path, fill):
    edl = programme(tmp_path, fill=fill, gaps="", placed="abd", media={"a": 8, "b": 12})
    assert numbers(edl, tmp_path) == [2] * 12 + [4] * 18


@pytest.mark.parametrize("way", ["conform", "direct"])
def test_it_is_told_who_stands_in(tmp_path, way):
    notes = Notes()
    source = ProgrammeSource(programme(tmp_path, fill=False, gaps="ab", placed="abd"), tmp_path)
    if way == "conform":
        conform(source, tmp_path / "out", progress=notes)
    else:
        write_direct(source, tmp_path / "out.mp4", progress=notes)
    (told,) = [note for note in notes.notes if "in its place" in note]
    assert told == "b has no picture from 0:00:00.3 to 0:00:00.7 (frames [10, 20)), d is shown in its place"


def test_nobody_is_told_anything_where_all_is_there(tmp_path):
    notes = Notes()
    write_direct(ProgrammeSource(programme(tmp_path, fill=True, gaps=""), tmp_path), tmp_path / "o.mp4", progress=notes)
    assert not [note for note in notes.notes if "no picture" in note]


def test_chunks_follow_whoever_may_stand_in_and_nobody_else(tmp_path):
    """Where the reference is whole the names of chunks stay as they were, however the other cameras lie."""

    def names(edl):
        return [chunk.name for chunk in plan_chunks(edl, tmp_path)]

    def moved(edl):
        pose = attrs.evolve(edl.poses[0], homographies={**edl.poses[0].homographies, "c": WHOLE})
        return attrs.evolve(edl, poses=(pose,))

    both = programme(tmp_path, fill=False, gaps="ab")
    assert names(moved(both)) != names(both)
    one = programme(tmp_path, fill=False, gaps="b")
    assert names(moved(one)) == names(one)
