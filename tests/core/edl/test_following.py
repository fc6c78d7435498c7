"""Where pictures lie while the lamp moves, between a movement's views; and what the document refuses of them."""

from __future__ import annotations

from fractions import Fraction

import attrs
import numpy as np
import pytest
from builders import small_edl

from mcsl_core import edl as edls
from mcsl_core.compositing.proxy import proxy_edl
from mcsl_core.documents import canonical_json
from mcsl_core.edl import Clock, Colour, Movement, MovementView, Relief
from mcsl_core.edl.dependencies import movement_over
from mcsl_core.edl.following import followed_movement, placed_pose, shown_at
from mcsl_core.edl.placement import placement_matrix
from mcsl_core.errors import DocumentError, Fault
from mcsl_core.imaging.geometry import scaling, transform_points
from mcsl_core.report.anonymous import nameless
from mcsl_core.timing import FrameRange


def shifted(x: float) -> edls.Matrix:
    return (1.0, 0.0, x), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)


def moving(**changes) -> edls.Edl:
    """A movement from frame 100 to 120 in which every camera's picture shifts by a pixel a frame."""
    made = small_edl()
    names = [camera.name for camera in made.cameras]
    views = tuple(MovementView(f, {name: shifted(f - 98.0) for name in names}) for f in (98, 110, 122))
    before, after = FrameRange(0, 110), FrameRange(110, made.frames)
    pose = attrs.evolve(made.poses[0], homographies={name: edls.IDENTITY for name in names}, weak=())
    poses = (attrs.evolve(pose, range=before), attrs.evolve(pose, range=after, anchor=shifted(24)))
    movements = (Movement(FrameRange(100, 120), 1.0, views),)
    return attrs.evolve(made, movements=movements, poses=poses, **changes)


def place(edl: edls.Edl, frame: int, camera: str) -> float:
    matrix = placement_matrix(edl, placed_pose(edl, frame), camera)
    assert matrix is not None
    return matrix[0][2]


def test_cameras_lie_on_a_line_between_views_and_as_the_poses_beyond() -> None:
    edl = moving()
    for camera in edl.cameras:
        assert place(edl, 50, camera.name) == 0
        assert [place(edl, f, camera.name) for f in (98, 101, 110, 117, 122)] == pytest.approx([0, 3, 12, 19, 24])
        assert place(edl, 200, camera.name) == 24
    assert followed_movement(edl, 97) is None
    assert followed_movement(edl, 98) is edl.movements[0]
    held = attrs.evolve(edl, movements=(Movement(FrameRange(100, 120)),))
    assert place(held, 117, edl.reference) == 24, "without views the pose after begins in the middle"


def test_a_picture_counts_when_it_was_taken() -> None:
    """A camera half as fast shows every picture for two frames; one that runs late shows what was a little before."""
    edl = moving()
    slow = attrs.evolve(edl.cameras[1], rate=edl.rate / 2)
    assert [shown_at(slow, f, edl.rate) for f in (100, 101, 102)] == pytest.approx([100, 100, 102])
    late = attrs.evolve(edl.cameras[1], clock=Clock(offset_s=0.25 / float(edl.rate)))
    assert shown_at(late, 100, edl.rate) == pytest.approx(99.25, abs=1e-4)
    edl = attrs.evolve(edl, cameras=(edl.cameras[0], slow, *edl.cameras[2:]))
    assert place(edl, 105, slow.name) == pytest.approx(6)
    assert place(edl, 105, edl.reference) == pytest.approx(7)


def test_relief_goes_over_from_pose_to_pose() -> None:
    edl = moving()
    seen = ((1.0, 0.0, 0.0, 0.0), (0.0, 1.0, 0.0, 0.0), (0.0, 0.0, 1.0, 0.0))
    flat = [((value,) * 3,) * 2 for value in (0.0, 2.0)]
    reliefs = [Relief({edl.reference: seen}, gamma, ((80,) * 3,) * 2) for gamma in flat]
    poses = tuple(attrs.evolve(pose, relief=r) for pose, r in zip(edl.poses, reliefs, strict=True))
    views = tuple(attrs.evolve(view, projections={edl.reference: seen}) for view in edl.movements[0].views)
    edl = attrs.evolve(edl, poses=poses, movements=(attrs.evolve(edl.movements[0], views=views),))
    heights = [placed_pose(edl, frame).relief for frame in (98, 110, 122)]
    assert [r.gamma[0][0] for r in heights if r is not None] == pytest.approx([0, 1, 2])
    assert heights[1] is not None
    assert heights[1].confidence == ((80,) * 3,) * 2
    beside_a_plane = attrs.evolve(edl, poses=(edl.poses[0], attrs.evolve(edl.poses[1], relief=None)))
    fading = [placed_pose(beside_a_plane, frame).relief for frame in (98, 110, 122)]
    assert [r.confidence[0][0] for r in fading if r is not None] == [80, 40, 0]


def test_what_pictures_depend_on_while_the_lamp_moves_can_be_written_down() -> None:
    """With colours and reliefs, as every analysis has them: keys of conformed pictures are hashes of it."""
    seen = ((1.0, 0.0, 0.0, 0.0), (0.0, 1.0, 0.0, 0.0), (0.0, 0.0, 1.0, 0.0))
    relief = Relief({"cam1": seen}, ((0.5,) * 3,) * 2, ((80,) * 3,) * 2)
    grey = Colour(((0.9, 0.0, 0.0, 2.0), (0.0, 0.9, 0.0, 2.0), (0.0, 0.0, 0.9, 2.0)))
    edl = moving()
    told = [canonical_json(movement_over(edl, FrameRange(115, 200)))]
    for changed in ({"colour": {"cam2": grey}}, {"relief": relief}):
        poses = tuple(attrs.evolve(pose, **changed) for pose in edl.poses)
        told.append(canonical_json(movement_over(attrs.evolve(edl, poses=poses), FrameRange(115, 200))))
    assert len(set(told)) == 3
    assert movement_over(edl, FrameRange(0, 98)) == movement_over(edl, FrameRange(123, 300)) == []


def test_views_are_kept_by_the_document(tmp_path) -> None:
    edl = moving()
    edls.save(edl, tmp_path / "edl.json")
    assert edls.load(tmp_path / "edl.json") == edl
    assert '"views"' not in edls.dumps(small_edl()), "a document without is as it was"


def test_views_that_fall_or_name_nobody_are_refused() -> None:
    edl = moving()
    movement = edl.movements[0]
    with pytest.raises(Fault, match=r"frame 98 does not rise"):
        attrs.evolve(edl, movements=(attrs.evolve(movement, views=(movement.views[0], movement.views[0])),))
    stranger = MovementView(130, {"nobody": edls.IDENTITY})
    with pytest.raises(Fault, match=r"nobody"):
        attrs.evolve(edl, movements=(attrs.evolve(movement, views=(*movement.views, stranger)),))


def test_the_document_says_where_a_view_is_wrong() -> None:
    value = edls.to_json(moving())
    value["movements"][0]["views"][1]["frame"] = -3
    with pytest.raises(DocumentError, match=r"movements\[0\]\.views\[1\]\.frame"):
        edls.from_json(value)


def test_rates_are_exact() -> None:
    camera = attrs.evolve(moving().cameras[0], rate=Fraction(30000, 1001))
    assert shown_at(camera, 90_000, Fraction(30000, 1001)) == pytest.approx(90_000)


def test_a_smaller_programme_lies_as_the_whole_does() -> None:
    edl = moving()
    half = proxy_edl(edl, (edl.size[0] // 2, edl.size[1] // 2))
    for frame in (50, 104, 117, 200):
        for camera in edl.cameras:
            whole = placement_matrix(edl, placed_pose(edl, frame), camera.name)
            small = placement_matrix(half, placed_pose(half, frame), camera.name)
            assert whole is not None
            assert small is not None
            at = transform_points(np.array(whole), np.array([[40.0, 30.0]]))
            to_half, of_camera = scaling(edl.size, half.size), scaling(camera.size, half.camera(camera.name).size)
            there = transform_points(np.array(small), transform_points(of_camera, np.array([[40.0, 30.0]])))
            assert there == pytest.approx(transform_points(to_half, at), abs=1e-6)


def test_a_nameless_programme_is_followed_as_well() -> None:
    made, _ = nameless(moving(), None)
    assert {name for view in made.movements[0].views for name in view.homographies} == {c.name for c in made.cameras}
