"""A hand that crosses the chosen picture's edge goes on beyond it, whatever its height above the relief."""

from __future__ import annotations

import cv2
import numpy as np
import pytest
from attrs import field, frozen
from plain_context import PlainContext

from mcsl_core.filling.crossings import find_crossings, grid_cell
from mcsl_core.filling.footprint import FootprintFiller
from mcsl_core.imaging.planes import Planes
from mcsl_core.imaging.rect import Rect

SIZE = (640, 368)
EDGE = 400  # the chosen camera shows the columns before it


def drape(seed=3):
    rng = np.random.default_rng(seed)
    noise = cv2.GaussianBlur(rng.uniform(0, 255, SIZE[::-1]).astype(np.float32), (0, 0), 2.0)
    return np.clip(120 + 2 * (noise - 128), 60, 180).astype(np.uint8)


def pictures(at=None, glove=230, slope=0.4, width=44, tip=330):
    """A drape with an arm that comes from the right to column ``tip``, its middle at row ``at`` there."""
    y, u, v = (
        drape(),
        np.full((SIZE[1] // 2, SIZE[0] // 2), 118, np.uint8),
        np.full((SIZE[1] // 2, SIZE[0] // 2), 140, np.uint8),
    )
    if at is not None:
        rows, columns = np.indices(y.shape)
        arm = (np.abs(rows - at - slope * (columns - tip)) < width / 2) & (columns > tip + 6 * np.sin(rows / 5))
        y[arm] = np.clip(glove - 0.15 * (columns[arm] - tip), 20, 235)
        half = arm[::2, ::2]
        u[half], v[half] = 100, 160
    return Planes(y, u, v)


def masks(reach=(200, SIZE[0])):
    inside = np.zeros((SIZE[1] // 2, SIZE[0] // 2), np.uint8)
    inside[:, : EDGE // 2] = 255
    seen = np.zeros_like(inside)
    seen[:, reach[0] // 2 : reach[1] // 2] = 255
    return inside, seen


def crossings(mine, theirs):
    return find_crossings((mine, pictures()), (theirs, pictures()), *masks())


@pytest.mark.parametrize("lower", [-34, -20, 16, 30])
@pytest.mark.parametrize("at", [100, 160])
def test_an_arm_that_lies_beside_itself_is_moved_onto_it(at, lower):
    (found,) = crossings(pictures(at), pictures(at + lower))
    x, y = found.shift
    assert abs(y - 0.4 * x + lower) < 4, "along the arm all fit alike; across it does not"
    assert found.shown.max() > 0.9
    cell = grid_cell(SIZE[0])
    column = (EDGE + 60) // cell
    middle = float(np.average(np.arange(len(found.shown)), weights=found.shown[:, column])) * cell
    assert abs(middle - (at + 0.4 * (EDGE + 60 - 330))) < 6


def test_an_arm_in_its_place_stays_untouched():
    assert crossings(pictures(140), pictures(140)) == ()


@pytest.mark.parametrize("mine", [None, 300])
def test_what_the_chosen_camera_does_not_show_at_the_edge_stays_where_it_is(mine):
    """Nobody there; somebody far from it."""
    assert crossings(pictures(mine, slope=0.0), pictures(60, slope=0.0)) == ()


def test_somebody_unlike_is_not_laid_on_him():
    assert crossings(pictures(140, width=30), pictures(150, glove=20, width=110)) == ()


def test_nothing_that_moves_is_nothing_that_crosses():
    assert crossings(pictures(), pictures()) == ()


@frozen(eq=False)
class TwoCameras(PlainContext):
    """The chosen camera "a" and "b" behind it, each with a picture now and a median."""

    now: dict = field(factory=dict)

    @property
    def front(self):
        return self.picture("a", Rect(0, 0, *SIZE))

    def picture(self, camera, rect, median_of=(), blur_px=0.0, *, parallax_corrected=False, shift=(0.0, 0.0)):
        if camera not in self.now:
            return None
        planes = pictures() if median_of else self.now[camera]
        moved = []
        for plane, scale in zip(planes, (1, 2, 2), strict=True):
            matrix = np.array([[1, 0, shift[0] / scale], [0, 1, shift[1] / scale]])
            moved.append(cv2.warpAffine(plane, matrix, plane.shape[::-1]))
        return rect.of(Planes(*moved))

    def footprint(self, camera, frame=None, *, parallax_corrected=False):
        return masks()[0 if camera == "a" else 1]

    def change(self, camera, median_of):
        off = cv2.absdiff(self.now[camera].y, pictures().y)
        return cv2.resize(off, (-(-SIZE[0] // 16), -(-SIZE[1] // 16)), interpolation=cv2.INTER_AREA).astype(np.float32)


@pytest.mark.parametrize("lower", [-30, 24])
def test_the_filled_picture_shows_one_arm(lower):
    at = 120
    now = {"a": pictures(at), "b": pictures(at + lower)}
    context = TwoCameras({"a": (0, EDGE), "b": (200, SIZE[0])}, {}, "a", size=SIZE, now=now)
    filled = FootprintFiller().fill(context).y.astype(int)
    whole, broken = pictures(at).y.astype(int), pictures(at + lower).y.astype(int)
    beyond = np.s_[:, EDGE + 10 : EDGE + 120]
    off, before = np.abs(filled - whole)[beyond].mean(), np.abs(broken - whole)[beyond].mean()
    assert off < 0.35 * before
