"""What goes by where pictures lie goes by the relief, as the pictures do."""

from __future__ import annotations

from fractions import Fraction

import attrs
import numpy as np
import pytest

from mcsl_core.compositing.camera_warper import CameraWarper
from mcsl_core.compositing.placement import fully_covered, surface_of
from mcsl_core.edl import IDENTITY, Camera, Edl, Media, Pose, Relief, Shot
from mcsl_core.imaging.planes import Planes
from mcsl_core.imaging.relief import Placement
from mcsl_core.timing import FrameRange

SIZE, MARGIN, FRAMES = (640, 368), 48, 4
WIDE = (SIZE[0] + 2 * MARGIN, SIZE[1] + 2 * MARGIN)
PIECE = FrameRange(0, FRAMES)


def sloped(side: str, most: float):
    """Heights that rise to ``most`` towards one side of the picture."""
    x, y = np.meshgrid(np.linspace(0, 1, 65), np.linspace(0, 1, 37))
    along = {"left": 1 - x, "right": x, "top": 1 - y, "bottom": y}[side]
    return tuple(map(tuple, (most * np.clip(2 * along - 1, 0, 1)).round(3).tolist()))


def programme(side="left", most=0.0, move=(1.0, 0.0), margin=MARGIN, offset=(0.0, 0.0)):
    """Camera b reaches ``margin`` beyond the programme on every side by its plane; its relief moves it to ``side``."""
    x, y = margin + offset[0], margin + offset[1]
    seen = ((1.0, 0.0, x, move[0]), (0.0, 1.0, y, move[1]), (0.0, 0.0, 1.0, 0.0))
    gamma = sloped(side, most)
    relief = Relief({"b": seen}, gamma, ((100,) * len(gamma[0]),) * len(gamma))
    place = ((1.0, 0.0, -x), (0.0, 1.0, -y), (0.0, 0.0, 1.0))
    size = (SIZE[0] + 2 * margin, SIZE[1] + 2 * margin)
    cameras = (
        Camera("a", (Media("a.mp4", FRAMES),), (64, 32), Fraction(25)),
        Camera("b", (Media("b.mp4", FRAMES),), size, Fraction(25)),
    )
    return Edl(
        rate=Fraction(25),
        size=SIZE,
        frames=FRAMES,
        reference="a",
        cameras=cameras,
        poses=(Pose(PIECE, {"a": IDENTITY, "b": place}, relief=relief),),
        shots=(Shot(PIECE, "b"),),
    )


class Pictures:
    """What camera b shows: ``before`` in its medians, ``now`` in each frame."""

    def __init__(self, now: Planes, before: Planes) -> None:
        self._now, self._before = now, before

    def player(self, camera):
        return self

    def at(self, frame):
        return self._now

    def median(self, camera, frames, within):
        return self._before

    def close(self):
        pass


def grey(size, value=100):
    chroma = np.full((size[1] // 2, size[0] // 2), 128, np.uint8)
    return Planes(np.full((size[1], size[0]), value, np.uint8), chroma, chroma)


@pytest.mark.parametrize(("side", "move"), [("left", (-1, 0)), ("right", (1, 0)), ("top", (0, -1)), ("bottom", (0, 1))])
def test_what_the_relief_moves_out_of_the_picture_is_not_covered(side, move):
    edl = programme(side, 75.0, move)
    assert fully_covered(edl, edl.poses[0], [(0, 0)])
    assert not fully_covered(edl, edl.poses[0], [(0, 0)], surface=True)
    footprint = CameraWarper(edl, Pictures(grey(WIDE), grey(WIDE)), "linear").footprint(0, "b", (0, 0), "surface")
    assert footprint.min() == 0


def test_what_the_relief_leaves_in_the_picture_is_covered_under_all_offsets():
    edl = programme("left", 20.0, (-1, 0))
    pose = edl.poses[0]
    assert fully_covered(edl, pose, [(0, 0), (8, -8)], surface=True)
    assert not fully_covered(edl, pose, [(0, 0), (40, 0)], surface=True)
    assert not fully_covered(edl, pose, [(-64, 0), (8, -8)], surface=True)
    without = attrs.evolve(pose, relief=None)
    assert fully_covered(edl, without, [(0, 0)], surface=True) == fully_covered(edl, without, [(0, 0)])


def test_what_the_relief_brings_in_is_covered():
    edl = programme("left", 75.0, (1, 0), margin=48, offset=(-72.0, 0.0))
    assert not fully_covered(edl, edl.poses[0], [(0, 0)])
    assert fully_covered(edl, edl.poses[0], [(0, 0)], surface=True)


@pytest.mark.parametrize("offset", [(0.0, 0.0), (21.0, -13.5)])
@pytest.mark.parametrize("x", [120, 560])
def test_a_change_is_where_the_picture_shows_it(x, offset):
    edl = programme("left", 75.0, (-1, 0))
    now = grey(WIDE)
    now.y[200:264, x : x + 64] = 220
    warper = CameraWarper(edl, Pictures(now, grey(WIDE)), "linear")
    middle = np.array([[x + 31.5, 231.5]])
    for laid in ("surface", "plane"):
        change = warper.change(0, "b", offset, 1, (0, 2), laid=laid)
        rows, columns = np.indices(change.shape)
        found = [(change * n).sum() / change.sum() * 16 + 7.5 for n in (columns, rows)]
        field = surface_of(edl, edl.poses[0], "b") if laid == "surface" else None
        matrix = np.array(edl.poses[0].homographies["b"])
        expected = Placement(matrix, field, offset).to_programme(middle)[0]
        assert np.abs(found - expected).max() < 8
