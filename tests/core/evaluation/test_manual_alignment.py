"""Alignments by hand: fits against least squares, Blender's numbers against the add-on's own, files and refusals."""

from __future__ import annotations

import cmath
import json
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from blender_addon.core.similarity import closest
from mcsl_core.edl import IDENTITY, Camera, Edl, Media, Pose, Shot
from mcsl_core.errors import McslError, UsageError
from mcsl_core.evaluation.manual_alignment import (
    StripTransform,
    aligned_by_hand,
    homography_from_points,
    load_manual,
    similarity_from_points,
)
from mcsl_core.timing import FrameRange

CAMERA, PROGRAMME = (640, 360), (1280, 720)
SQUARE = np.array([[100, 80], [500, 90], [480, 300], [120, 310]], float)


def through(matrix, points: np.ndarray) -> np.ndarray:
    moved = np.column_stack([points, np.ones(len(points))]) @ np.array(matrix).T
    return moved[:, :2] / moved[:, 2:]


@given(st.floats(-3.1, 3.1), st.floats(0.2, 5), st.floats(-900, 900), st.floats(-900, 900))
def test_a_similarity_is_found_again(angle: float, scale: float, dx: float, dy: float) -> None:
    turn = scale * cmath.exp(1j * angle)
    target = SQUARE @ [1, 1j] * turn + complex(dx, dy)
    found = similarity_from_points(SQUARE, np.column_stack([target.real, target.imag]))
    expected = [[turn.real, -turn.imag, dx], [turn.imag, turn.real, dy], [0, 0, 1]]
    np.testing.assert_allclose(found, expected, atol=1e-6)


def test_it_is_the_least_squares_of_noisy_points() -> None:
    """Against the linear system of the four unknowns."""
    rng = np.random.default_rng(5)
    target = SQUARE @ np.array([[0.8, 0.3], [-0.3, 0.8]]) + rng.normal(0, 5, SQUARE.shape)
    rows = [[x, -y, 1, 0] for x, y in SQUARE] + [[y, x, 0, 1] for x, y in SQUARE]
    a, b, c, d = np.linalg.lstsq(np.array(rows), target.T.ravel(), rcond=None)[0]
    np.testing.assert_allclose(similarity_from_points(SQUARE, target), [[a, -b, c], [b, a, d], [0, 0, 1]], atol=1e-9)


def test_a_homography_goes_through_its_four_points() -> None:
    target = np.array([[0, 0], [300, 20], [280, 220], [10, 160]], float)
    np.testing.assert_allclose(through(homography_from_points(SQUARE, target), SQUARE), target, atol=1e-6)


@pytest.mark.parametrize("fit", [similarity_from_points, homography_from_points])
@pytest.mark.parametrize(
    ("source", "target"),
    [([[1, 1]] * 4, SQUARE), (SQUARE, [[1, 1]] * 4), (SQUARE[:1], SQUARE[:1]), (SQUARE, SQUARE[:3])],
)
def test_points_that_fix_nothing_are_refused(fit, source, target) -> None:
    with pytest.raises(ValueError, match="point"):
        fit(source, target)


def test_points_on_a_line_fix_no_homography() -> None:
    line = np.array([[0, 0], [1, 1], [2, 2], [3, 3]], float)
    with pytest.raises(ValueError, match="line"):
        homography_from_points(line, line)


@given(st.floats(-3.1, 3.1), st.floats(0.3, 4), st.floats(-300, 300), st.floats(-300, 300))
def test_blenders_numbers_are_the_add_ons(angle: float, scale: float, x: float, y: float) -> None:
    """The add-on's transform of a similarity leads back to it; its own is checked by rendering in Blender."""
    matrix = StripTransform(x, y, scale, angle).matrix(CAMERA, PROGRAMME)
    again = closest(matrix, CAMERA, PROGRAMME, complex(*through(matrix, np.array([[320.0, 180.0]]))[0]))
    made = StripTransform(again.offset_x, again.offset_y, again.scale, again.rotation).matrix(CAMERA, PROGRAMME)
    np.testing.assert_allclose(made, matrix, rtol=1e-6, atol=1e-4)


def test_blenders_axes() -> None:
    """The picture's middle moves right and up; a quarter turn counter-clockwise brings its right edge to the top."""
    middle = np.array([[319.5, 179.5], [639.5, 179.5]])
    moved = through(StripTransform(100, 50, 0.5, np.pi / 2).matrix(CAMERA, PROGRAMME), middle)
    np.testing.assert_allclose(moved, [[739.5, 309.5], [739.5, 149.5]], atol=1e-9)
    flat = through(StripTransform(scale=1, scale_y=2).matrix(CAMERA, PROGRAMME), np.array([[319.5, 189.5]]))
    np.testing.assert_allclose(flat, [[639.5, 379.5]])


# ---------------------------------------------------------------------------------------------------------- files


@pytest.fixture
def edl() -> Edl:
    whole, half = FrameRange(0, 20), FrameRange(0, 10)
    names = ("a", "b", "c")
    pose = dict.fromkeys(names, IDENTITY)
    return Edl(
        rate=Fraction(25),
        size=PROGRAMME,
        frames=20,
        reference="a",
        cameras=tuple(Camera(n, (Media(f"{n}.mp4", 20),), CAMERA, Fraction(25)) for n in names),
        poses=(Pose(half, pose), Pose(FrameRange(10, 20), pose)),
        shots=(Shot(whole, "b"),),
    )


POINTS = [[*p, *q] for p, q in zip(SQUARE.tolist(), (2 * SQUARE + 5).tolist(), strict=True)]
DOUBLE = [[2, 0, 5], [0, 2, 5], [0, 0, 1]]


def write(path: Path, value: object) -> Path:
    path.write_text(value if isinstance(value, str) else json.dumps(value), "utf-8")
    return path


def test_a_json_file_of_all_three_kinds(edl: Edl, tmp_path: Path) -> None:
    entries = [
        {"camera": "b", "pose": 1, "homography": [[1, 0, 3], [0, 1, 4], [0, 0, 1]]},
        {"camera": "b", "points": POINTS},
        {"camera": "c", "transform": {"scale": 2, "offset_x": 7}},
    ]
    found = load_manual(write(tmp_path / "m.json", {"alignments": entries}), edl)
    np.testing.assert_allclose(found[0]["b"], DOUBLE, atol=1e-9)
    assert found[1]["b"] == ((1, 0, 3), (0, 1, 4), (0, 0, 1)), "one pose's wins over that of all"
    assert found[0]["c"] == found[1]["c"] == StripTransform(7, 0, 2, 0).matrix(CAMERA, PROGRAMME)
    exact = load_manual(write(tmp_path / "m.json", {"alignments": entries}), edl, fit="homography")
    np.testing.assert_allclose(exact[0]["b"], DOUBLE, atol=1e-6)


def test_a_pose_may_be_told_by_a_frame_in_it_and_only_once(edl: Edl, tmp_path: Path) -> None:
    moved = [{"camera": "b", "frame": f, "transform": {"offset_x": x}} for f, x in ((0, 1), (9, 1), (12, 2))]
    found = load_manual(write(tmp_path / "m.json", {"alignments": moved}), edl)
    assert found[0]["b"] == StripTransform(1).matrix(CAMERA, PROGRAMME)
    assert found[1]["b"] == StripTransform(2).matrix(CAMERA, PROGRAMME)
    moved[1]["frame"] = 13
    with pytest.raises(McslError, match="camera b: is aligned in two ways"):
        load_manual(write(tmp_path / "m.json", {"alignments": moved}), edl)


def test_thousands_in_a_csv_file_are_refused(edl: Edl, tmp_path: Path) -> None:
    lines = ["camera;x;y;programme_x;programme_y", *(f"b;{x};{y};1.100;{20 * x}" for x, y in ((1, 2), (9, 2), (9, 8)))]
    with pytest.raises(McslError, match=r"line 2: '1.100' may be 1100 or 1.1. Write 1100 for thousands"):
        load_manual(write(tmp_path / "m.csv", "\n".join(lines)), edl)


def test_a_csv_file(edl: Edl, tmp_path: Path) -> None:
    lines = ["pose,camera,x,y,programme_x,programme_y"]
    lines += [",".join(["", "b", *map(str, p)]) for p in POINTS] + [",".join(["1", "c", *map(str, p)]) for p in POINTS]
    found = load_manual(write(tmp_path / "m.csv", "\n".join(lines)), edl)
    np.testing.assert_allclose(found[1]["b"], DOUBLE, atol=1e-9)
    assert "c" not in found[0]
    np.testing.assert_allclose(found[1]["c"], DOUBLE, atol=1e-9)


def test_by_hand_every_camera_comes_where_it_was_put(edl: Edl) -> None:
    turned = StripTransform(5, 9, 1.2, 0.3).matrix(CAMERA, PROGRAMME)
    made = aligned_by_hand(edl, {0: {"a": turned, "b": DOUBLE}, 1: {"b": turned}})  # pyright: ignore[reportArgumentType]
    first, second = made.poses
    np.testing.assert_allclose(np.array(first.anchor) @ np.array(first.homographies["b"]), DOUBLE, atol=1e-9)
    np.testing.assert_allclose(first.anchor, turned, atol=1e-12)
    assert second.anchor == IDENTITY
    np.testing.assert_allclose(second.homographies["b"], turned, atol=1e-9)
    assert [w.camera for w in second.weak] == ["c"], "not shown, so it may lack"


@pytest.mark.parametrize(
    ("entry", "message"),
    [
        ({"camera": "z", "points": POINTS}, "camera z: the EDL has no such camera. It has a, b, c"),
        ({"camera": "b", "pose": 2, "points": POINTS}, "pose 2: the EDL has no such pose. It has 0 to 1"),
        ({"camera": "b", "points": POINTS[:3]}, "expected four or more point pairs, got 3"),
        ({"camera": "b", "points": [POINTS[0]] * 4}, "lie in one place"),
        ({"camera": "b", "frame": 20, "points": POINTS}, "the EDL has no frame 20. It has 0 to 19"),
        ({"camera": "b", "frame": 1, "pose": 0, "points": POINTS}, "got both"),
        ({"camera": "b"}, "expected one of points, transform, homography, got none"),
        ({"camera": "b", "points": POINTS, "transform": {}}, "got points and transform"),
        ({"camera": "b", "transform": {"scale": "big"}}, "expected a number"),
        ({"camera": "b", "points": [[1, 2, 3]] * 4}, "expected 4 values, got 3"),
        ({"camera": "b", "scale": 2}, "unknown key"),
        ({"camera": "b", "homography": [[1, 0, 3], [2, 0, 4], [0, 0, 1]]}, "is singular or nearly so"),
        ({"camera": "b", "homography": [[1, 0, 3], [1, 1e-9, 4], [0, 0, 1]]}, "is singular or nearly so"),
        ({"camera": "b", "homography": [[1, 0, 3], [0, 1, 4], [0, 0, 0]]}, "is singular or nearly so"),
        ({"camera": "b", "homography": [[1, 0, 3], [0, 1, 4], [0.01, 0, -1]]}, "behind the viewer"),
        ({"camera": "a", "homography": [[1e30, 0, 3], [0, 1e30, 4], [0, 0, 1]]}, "or huge. Correct the numbers"),
        ({"camera": "b", "transform": {"scale": 0}}, "is singular or nearly so"),
        ({"camera": "b", "transform": {"scale": 1, "scale_y": 1e-7}}, "is singular or nearly so"),
        ({"camera": "b", "points": [[*p[:2], 1e308, 5] for p in POINTS]}, "a point lies at 1e+308 pixels"),
    ],
)
def test_what_is_wrong_in_a_file_is_named(edl: Edl, tmp_path: Path, entry: dict, message: str) -> None:
    path = write(tmp_path / "m.json", {"alignments": [entry]})
    with pytest.raises(McslError) as refused:
        load_manual(path, edl)
    assert message in str(refused.value)
    assert "m.json" in str(refused.value)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("camera,x,y\nb,1,2\n", "lacks columns"),
        ("camera,x,y,programme_x,programme_y\nb,1,2,3,four\n", "line 2"),
        ("camera,x,y,programme_x,programme_y\nb,1,2,3,4\n", "four or more"),
        ("camera,x,y,programme_x,programme_y\nb,1,2,3,nan\n", "line 2: 'nan' is no number"),
        ("camera,x,y,programme_x,programme_y\nb,1,2,3,1e999\n", "line 2: '1e999' is too large"),
        ("camera,x,y,programme_x,programme_y\nb,1,2,3\n", "line 2: '' is no number"),
        ("pose,camera,x,y,programme_x,programme_y\none,b,1,2,3,4\n", "line 2: 'one' is no pose"),
        ("camera,x,y,programme_x,programme_y\n", "holds no point pairs"),
    ],
)
def test_what_is_wrong_in_a_csv_file_is_named(edl: Edl, tmp_path: Path, text: str, message: str) -> None:
    with pytest.raises(McslError) as refused:
        load_manual(write(tmp_path / "m.csv", text), edl)
    assert message in str(refused.value)


@pytest.mark.parametrize("side", [0, 1])
@pytest.mark.parametrize("wide", [0.0, 1e-7, 1e-2])
def test_points_nearly_on_a_line_fix_no_homography(edl: Edl, tmp_path: Path, side: int, wide: float) -> None:
    line = [[100.0 * n, 50.0 * n + wide * (n % 2)] for n in range(5)]
    spread = [[0.0, 0], [600, 10], [20, 300], [500, 330], [300, 100]]
    points = [[*a, *b] if side else [*b, *a] for a, b in zip(line, spread, strict=True)]
    path = write(tmp_path / "m.json", {"alignments": [{"camera": "b", "points": points}]})
    with pytest.raises(McslError, match=r"the points lie on a line\. Take points that are spread"):
        load_manual(path, edl, fit="homography")


def test_alignments_that_do_not_go_together_are_told(edl: Edl) -> None:
    """Each lays its own camera's picture well; through the other's, this one's corner lies at infinity."""
    anchor = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (-0.001, 0.0, 1.0))
    moved = ((1.0, 0.0, -1000.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
    with pytest.raises(McslError, match="pose 0: the cameras' alignments by hand do not go together"):
        aligned_by_hand(edl, {n: {"a": anchor, "b": moved} for n in (0, 1)})


def test_a_fit_that_there_is_not_lists_those_that_there_are(edl: Edl, tmp_path: Path) -> None:
    path = write(tmp_path / "m.json", {"alignments": [{"camera": "b", "points": POINTS}]})
    with pytest.raises(UsageError, match=r"'affine' is no fit for point pairs.*similarity, homography"):
        load_manual(path, edl, fit="affine")
