"""The fillers alone, through the same small interface that plugins get."""

import numpy as np
import pytest
from attrs import field, frozen

from mcsl_core.filling import FootprintFiller, Rect, ReferenceFiller, strips
from mcsl_core.images import Planes

SIZE = (320, 192)


def grey(value, size=SIZE):
    half = (size[1] // 2, size[0] // 2)
    return Planes(np.full(size[::-1], value, np.uint8), np.full(half, 128, np.uint8), np.full(half, 128, np.uint8))


@frozen(eq=False)
class Scene:
    """Cameras of one brightness each, seeing columns [left, right) of the programme."""

    columns: dict
    values: dict
    camera: str
    previous: Planes | None = None
    frame: int = 0
    size: tuple[int, int] = SIZE
    looked: list = field(factory=list)

    @property
    def others(self):
        return [c for c in self.columns if c != self.camera]

    @property
    def geometry(self):
        return (self.camera, tuple(self.columns.items()))

    @property
    def front(self):
        return self.look(self.camera, Rect(0, 0, *SIZE))

    def footprint(self, camera):
        left, right = self.columns[camera]
        mask = np.zeros((SIZE[1] // 2, SIZE[0] // 2), np.uint8)
        mask[:, left // 2 : right // 2] = 255
        return mask

    def look(self, camera, rect):
        self.looked.append(camera)
        if self.values[camera] is None:
            return None
        planes = grey(16)
        left, right = self.columns[camera]
        planes.y[:, left:right] = self.values[camera]
        return rect.of(planes)


def scene(columns, values, camera, **options):
    return Scene(columns, values, camera, **options)


def test_others_stand_behind_in_order_softly_and_the_rest_is_black():
    columns = {"ref": (0, 200), "near": (100, 260), "far": (200, 300)}
    view = scene(columns, {"ref": 100, "near": 180, "far": 60}, "near")
    filled = FootprintFiller(feather_px=16).fill(view)
    row = filled.y[96].astype(int)
    assert (row[:98] == 100).all()
    assert (row[120:240] == 180).all()
    assert (row[264:296] == 60).all()  # nearly to its edge: nothing stands behind that it would have to fade into
    assert (row[302:] == 16).all()
    assert (np.diff(row[96:122]) >= 0).all()  # a soft edge, no dark seam
    assert np.abs(np.diff(row[96:122])).max() < 20
    assert (filled.u == 128).all()


def test_nothing_to_fill_gives_the_same_object_and_asks_nobody():
    view = scene({"a": (0, 320), "b": (0, 320)}, {"a": 90, "b": 10}, "a")
    front = view.front
    view.looked.clear()
    filled = FootprintFiller().fill(view)
    assert np.array_equal(filled.y, front.y)
    assert set(view.looked) == {"a"}


def test_a_camera_that_adds_nothing_is_not_asked():
    view = scene({"a": (0, 200), "b": (0, 320), "c": (0, 320)}, {"a": 90, "b": 120, "c": 50}, "a")
    FootprintFiller().fill(view)
    assert "c" not in view.looked


def test_a_camera_without_picture_lets_the_next_shine_through():
    view = scene({"a": (0, 200), "b": (0, 260), "c": (0, 320)}, {"a": 90, "b": None, "c": 50}, "a")
    row = FootprintFiller(16).fill(view).y[50]
    assert (row[270:] == 50).all()


@pytest.mark.parametrize("seed", range(5))
def test_strips_cover_what_is_missing_and_are_even_and_apart(seed):
    rng = np.random.default_rng(seed)
    missing = np.zeros((135, 240), bool)
    for _ in range(4):
        x, y = rng.integers(0, 200), rng.integers(0, 120)
        missing[y : y + rng.integers(3, 60), x : x + rng.integers(3, 60)] = True
    covered = np.zeros((270, 480), int)
    for rect in strips(missing):
        assert not any(v % 2 for v in (rect.x, rect.y, rect.width, rect.height))
        assert rect.x + rect.width <= 480
        assert rect.y + rect.height <= 270
        covered[rect.y : rect.y + rect.height, rect.x : rect.x + rect.width] += 1
    assert covered.max() <= 1
    assert (covered[::2, ::2][missing] == 1).all()
    assert strips(np.zeros((10, 10), bool)) == ()


def test_the_papers_filler_blends_by_brightness():
    view = scene({"ref": (0, 320), "a": (100, 320)}, {"ref": 100, "a": 180}, "a")
    row = ReferenceFiller().fill(view).y[96].astype(int)
    assert np.abs(row[:70] - 100).max() <= 1
    assert np.abs(row[130:] - 180).max() <= 1
    dark = scene({"ref": (0, 320), "a": (0, 320)}, {"ref": 100, "a": 18}, "a")  # below 10 of 255 counts as missing
    assert np.abs(ReferenceFiller().fill(dark).y.astype(int) - 100).max() <= 1
