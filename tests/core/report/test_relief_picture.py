"""The relief as a shaded picture: which way is up, and what is not known."""

from __future__ import annotations

import base64
from fractions import Fraction

import attrs
import cv2
import numpy as np
import pytest
from numpy.typing import NDArray
from relief_scene import pose_of

from mcsl_core.edl import IDENTITY, Camera, Edl, Media, Pose, Relief, Shot
from mcsl_core.imaging.geometry import inverse, to_edl_matrix, to_edl_projection
from mcsl_core.report.relief_picture import relief_picture, shaded, upwards
from mcsl_core.timing import FrameRange

SIZE = (320, 180)


def programme(pose: Pose, names: str) -> Edl:
    cameras = tuple(Camera(name, (Media(f"{name}.mp4", 100),), SIZE, Fraction(25)) for name in names)
    shots = (Shot(pose.range, names[0]),)
    return Edl(
        rate=Fraction(25), size=SIZE, frames=100, reference=names[0], cameras=cameras, poses=(pose,), shots=shots
    )


def lamp_camera(x: float, y: float, roll: float) -> NDArray:
    """(3, 4), of a camera 0.9 m above the table and aside of its middle, which it looks at, rolled by some radians."""
    centre = np.array([x, y, 0.9])
    forward = -centre / np.linalg.norm(centre)
    right = np.cross(forward, [0, 1, 0])
    right /= np.linalg.norm(right)
    turn = np.array([[np.cos(roll), np.sin(roll), 0], [-np.sin(roll), np.cos(roll), 0], [0, 0, 1]])
    rotation = turn @ np.stack([right, np.cross(forward, right), forward])
    inside = np.array([[400, 0, SIZE[0] / 2], [0, 400, SIZE[1] / 2], [0, 0, 1.0]])
    return inside @ np.column_stack([rotation, -rotation @ centre])


def lamp_pose(cameras: dict[str, NDArray], sign: int, anchor: NDArray) -> Pose:
    """The first is the reference; gamma grows towards it by ``sign``, over programme pixels after ``anchor``."""
    first = next(iter(cameras.values()))
    table = np.eye(4)[:, [0, 1, 3]]  # a place on it -> space
    scene = np.column_stack([table @ inverse(first @ table) @ inverse(anchor), np.zeros(4)])
    _, _, rows = np.linalg.svd(first)
    centre = rows[-1] / rows[-1][3]
    scene[:, 3] = sign * 1e-3 * centre * np.sign((scene[:, :3] @ [SIZE[0] / 2, SIZE[1] / 2, 1])[3])
    projections = {name: to_edl_projection(camera @ scene) for name, camera in cameras.items()}
    homographies = {
        name: IDENTITY if camera is first else to_edl_matrix(first @ table @ inverse(camera @ table))
        for name, camera in cameras.items()
    }
    nodes = tuple((0.0,) * 4 for _ in range(3))
    relief = Relief(projections, nodes, tuple((100,) * 4 for _ in range(3)))
    return Pose(FrameRange(0, 100), homographies, anchor=to_edl_matrix(anchor), relief=relief)


@pytest.mark.parametrize("sign", [1, -1])
@pytest.mark.parametrize("rolls", [(0, 0, 0, 0), (1, 2, 3, 4), (0, 1.5, -1.5, 0.5)])
@pytest.mark.parametrize("anchor", [np.eye(3), np.array([[1.1, 0.2, -20], [-0.2, 0.9, 30], [1e-3, -8e-4, 1]])])
@pytest.mark.parametrize("lamp", [(0.0, 0.0), (0.35, -0.2)])
def test_up_is_towards_the_cameras(sign: int, rolls: tuple[float, ...], anchor: NDArray, lamp: tuple) -> None:
    """Of three or four cameras round the lamp, whatever their roll, the lamp's tilt and the pose's anchor."""
    aside = [(0.0, 0.0), (0.25, 0.05), (-0.1, 0.25), (-0.15, -0.2)]
    cameras = {
        name: lamp_camera(lamp[0] + x, lamp[1] + y, roll)
        for name, (x, y), roll in zip("abcd", aside, rolls, strict=True)
    }
    for names in ("abcd", "abc", "ac"):
        pose = lamp_pose({name: cameras[name] for name in names}, sign, anchor)
        assert pose.relief is not None
        assert upwards(programme(pose, names), pose, pose.relief) == sign, names


def test_light_falls_from_the_upper_left() -> None:
    x, y = np.meshgrid(np.linspace(-1, 1, 96), np.linspace(-1, 1, 54))
    hill = (8 * np.exp(-3 * (x**2 + y**2))).astype(np.float32)
    made = shaded(hill, np.ones_like(hill), SIZE, SIZE[0], (0, 8)).sum(axis=2).astype(int)
    hollow = shaded(-hill, np.ones_like(hill), SIZE, SIZE[0], (-8, 0)).sum(axis=2).astype(int)
    assert made[60, 107] > made[120, 213] + 60
    assert hollow[60, 107] < hollow[120, 213] - 60


def test_what_is_not_known_is_a_hatched_ground() -> None:
    """Whatever stands there."""
    heights = np.random.default_rng(3).normal(0, 9, (54, 96)).astype(np.float32)
    confidence = np.zeros((54, 96), np.float32)
    confidence[:, 48:] = 1
    made = shaded(heights, confidence, SIZE, SIZE[0], (-9, 9))
    assert {tuple(colour) for colour in made[:, :120].reshape(-1, 3)} == {(120,) * 3, (190,) * 3}
    assert len(np.unique(made[:, 200:].reshape(-1, 3), axis=0)) > 100


def test_a_relief_is_shown_and_a_plane_is_not() -> None:
    pose = pose_of(100, SIZE, height=6.0)
    edl = programme(pose, "ab")
    made = relief_picture(edl, pose)
    assert made is not None
    shown = cv2.imdecode(np.frombuffer(base64.b64decode(made.url.partition(",")[2]), np.uint8), cv2.IMREAD_COLOR)
    assert shown is not None
    assert shown.shape == (*made.size[::-1], 3) == (180, 320, 3)
    assert made.moves == "7 pixels", "a hill of 6 and a valley of 3, but for the highest and lowest 2 %"
    assert len(set(made.tints)) == 9
    assert relief_picture(edl, attrs.evolve(pose, relief=None)) is None
    flat = relief_picture(edl, pose_of(100, SIZE, height=0.0))
    assert flat is not None
    assert flat.moves == "1 pixel", "noise is no mountain"
