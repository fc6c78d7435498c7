"""What is held, through the real compositor: three cameras of one brightness each, side by side."""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path

import attrs
import numpy as np
import pytest
from mcsl_hold_filler import HoldFiller

from mcsl_core.compositing.compositor import Compositor
from mcsl_core.edl import Camera, Edl, Look, Media, Pose
from mcsl_core.hooks import Footage, FrameRange, Planes, Shot, discover
from mcsl_core.media.writing import Encoding, VideoWriter

SIZE, RATE, FRAMES = (128, 64), 4, 96
VALUES = {"ref": 90, "left": 150, "right": 210}
PLACES = {"ref": 0, "left": -64, "right": 64}  # columns by which each camera's picture lies aside


def grey(value: int) -> Planes:
    half = (SIZE[1] // 2, SIZE[0] // 2)
    return Planes(np.full(SIZE[::-1], value, np.uint8), np.full(half, 128, np.uint8), np.full(half, 128, np.uint8))


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Each camera gets brighter by one every two seconds."""
    folder = tmp_path_factory.mktemp("hold")
    for name, value in VALUES.items():
        encoding = Encoding(options={"preset": "ultrafast", "qp": "0"})
        with VideoWriter(folder / f"{name}.mp4", size=SIZE, rate=Fraction(RATE), encoding=encoding) as writer:
            for n in range(FRAMES):
                writer.write(grey(value + n // 8))
    return folder


def programme(*shots: tuple[int, str]) -> Edl:
    stops = [*(start for start, _ in shots[1:]), FRAMES]
    pose = Pose(FrameRange(0, FRAMES), {n: ((1, 0, x), (0, 1, 0), (0, 0, 1)) for n, x in PLACES.items()})
    return Edl(
        rate=Fraction(RATE),
        size=SIZE,
        frames=FRAMES,
        reference="ref",
        cameras=tuple(Camera(n, (Media(f"{n}.mp4", FRAMES, ""),), SIZE, Fraction(RATE)) for n in VALUES),
        poses=(pose,),
        shots=tuple(Shot(FrameRange(start, stop), name) for (start, name), stop in zip(shots, stops, strict=True)),
        look=Look(centering=False, fill=True, colour=False),
    )


def made(edl: Edl, folder: Path, start: int, stop: int) -> list[Planes]:
    footage = Footage(edl.cameras, rate=edl.rate, frames=edl.frames, base=folder)
    with Compositor(edl, footage, filler=discover().choose("filler", "hold").checked) as compositor:
        return list(compositor.frames(FrameRange(start, stop)))


def left_and_right(planes: Planes) -> tuple[int, int]:
    """The brightness of either half, which must be even but for the columns about the edge."""
    left, right = planes.y[:, :58], planes.y[:, 68:]
    assert len(np.unique(left)) == len(np.unique(right)) == 1
    return int(left[0, 0]), int(right[0, 0])


def test_what_was_shown_last_stays_and_what_nobody_showed_is_black(folder: Path) -> None:
    frames = made(programme((0, "left"), (16, "right"), (32, "left")), folder, 0, 40)
    assert left_and_right(frames[10]) == (151, 16)
    assert left_and_right(frames[20]) == (150 + 1, 210 + 2), "the last that the left one showed, at frame 15"
    assert left_and_right(frames[31]) == (151, 213)
    assert left_and_right(frames[39]) == (154, 213)
    assert (frames[39].u == 128).all()


def test_the_edge_is_hard_and_no_darker_than_either_side(folder: Path) -> None:
    row = made(programme((0, "ref"), (16, "right")), folder, 30, 31)[0].y[32].astype(int)
    assert set(row.tolist()) == {91, 213}


@pytest.mark.parametrize("start", [0, 3, 39, 40, 41, 77])
def test_a_frame_is_the_same_in_whatever_stretch_it_is_made(folder: Path, start: int) -> None:
    edl = programme((0, "ref"), (7, "left"), (21, "right"), (50, "left"), (83, "right"))
    whole = made(edl, folder, 0, FRAMES)
    for number, planes in enumerate(made(edl, folder, start, min(FRAMES, start + 14)), start):
        for a, b in zip(planes, whole[number], strict=True):
            np.testing.assert_array_equal(a, b)


def test_one_that_sees_all_is_handed_through() -> None:
    assert HoldFiller().remembers
    view = attrs.make_class("View", ["front", "previous", "camera", "footprint"])(
        grey(70), grey(90), "ref", lambda camera: np.full((32, 64), 255, np.uint8)
    )
    assert HoldFiller().fill(view) is view.front
