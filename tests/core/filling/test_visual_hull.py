"""Where a camera's rays lead in the others' pictures, against a scene whose cameras are known."""

from __future__ import annotations

import numpy as np
import peopled_scene as scene
import pytest

from mcsl_core.filling.visual_hull import HANDS, grid_size, rays_of, taken
from mcsl_core.imaging.relief import ReliefMap

CELLS = grid_size(scene.SIZE)
FLAT = ReliefMap(np.zeros((4, 4), np.float32), np.ones((4, 4), np.float32), scene.SIZE)
SIZES = dict.fromkeys(scene.CAMERAS, scene.SIZE)


def rays(camera: str, flip: float = 1.0):
    upright = np.diag([1, 1, 1, flip])
    found = rays_of(camera, {name: scene.projection_of(name) @ upright for name in scene.CAMERAS}, SIZES, FLAT)
    assert found is not None
    return found


def cell_of(camera: str, x: float, y: float, height: float) -> int:
    """The cell of a camera's picture that shows a place at a height, mm."""
    u, v, w = scene.at_height(camera, height) @ [x, y, 1.0]
    return int((v / w + 0.5) * CELLS[1] / scene.SIZE[1]) * CELLS[0] + int((u / w + 0.5) * CELLS[0] / scene.SIZE[0])


def apart(a: int, b: int) -> int:
    """Cells between two, the larger of both ways."""
    return max(abs(a // CELLS[0] - b // CELLS[0]), abs(a % CELLS[0] - b % CELLS[0]))


@pytest.mark.parametrize("camera", scene.CAMERAS)
def test_the_programme_and_a_cameras_picture_lead_to_each_other(camera):
    found = rays(camera)
    index = np.arange(CELLS[0] * CELLS[1], dtype=np.float32).reshape(CELLS[::-1])
    there_and_back = taken(taken(index, found.programme, -1), found.own, -1)
    inside = (there_and_back >= 0) & (found.own < index.size)
    assert inside.mean() > 0.3
    assert max(apart(int(a), int(b)) for a, b in zip(index[inside], there_and_back[inside], strict=True)) <= 1


@pytest.mark.parametrize("flip", [1.0, -1.0])
@pytest.mark.parametrize("camera", ["cam1", "cam3"])
def test_a_hand_is_met_along_the_ray_below_hand_height_and_a_head_is_not(camera, flip):
    found = rays(camera, flip)
    for height, met in ((20.0, True), (scene.HAND, True), (scene.HEAD, False)):
        x, y = scene.above(camera, (12.0, -8.0), height)
        seen_at = int(found.programme.ravel()[cell_of(camera, x, y, height)])
        other = "cam5" if camera == "cam1" else "cam4"
        along = found.along[other].reshape(len(found.along[other]), -1)[:, seen_at]
        nearest = min(apart(int(cell), cell_of(other, x, y, height)) for cell in along if cell < CELLS[0] * CELLS[1])
        assert (nearest <= 3) == met, (height, nearest)


def test_hand_height_is_a_share_of_the_pictures_width():
    found = rays("cam1")
    middle = found.own.shape[0] // 2, found.own.shape[1] // 2
    moved = [apart(int(cells[(-1, *middle)]), int(cells[(1, *middle)])) for cells in found.along.values()]
    assert max(moved) == pytest.approx(HANDS * CELLS[0], abs=5)


def test_without_a_way_up_there_are_no_rays():
    level = {name: np.eye(3, 4) for name in scene.CAMERAS}
    assert rays_of("cam1", level, SIZES, FLAT) is None
