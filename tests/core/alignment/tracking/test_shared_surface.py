"""One surface for the poses of a perspective: heights and confidences that are known."""

from __future__ import annotations

from collections.abc import Mapping

import attrs
import numpy as np
import pytest

from mcsl_core.alignment.aligned_views import AlignedPose
from mcsl_core.alignment.observations import SolvedPose
from mcsl_core.alignment.relief.pose_relief import relief_document
from mcsl_core.alignment.tracking.shared_surface import with_shared_surface
from mcsl_core.alignment.tracking.standing_poses import StandingPose
from mcsl_core.edl import IDENTITY, Pose
from mcsl_core.timing import FrameRange

SIZE, SHAPE = (960, 540), (54, 96)
LEFT, RIGHT = (slice(None), slice(0, 40)), (slice(None), slice(56, 96))
NAMES: tuple[str, ...] = ("cam1", "cam2")


def standing(number: int, gamma: float, left: float, right: float) -> StandingPose:
    """A pose of that height, so sure of it in the picture's left and right."""
    heights, sure = np.full(SHAPE, gamma), np.full(SHAPE, 0.5 * (left + right))
    sure[LEFT], sure[RIGHT] = left, right
    seen = {"cam1": np.eye(3, 4), "cam2": np.column_stack([np.eye(3), [1.0, number, 0.0]])}
    relief = relief_document(seen, heights, sure)
    homographies = dict.fromkeys(NAMES, IDENTITY)
    pose = Pose(FrameRange(10 * number, 10 * number + 10), homographies, relief=relief)
    aligned = AlignedPose(
        SIZE, "cam1", dict.fromkeys(NAMES, np.eye(3)), dict.fromkeys(NAMES, SIZE), np.ones((540, 960), bool)
    )
    made = StandingPose.of(SolvedPose(pose, aligned, (number,), {}))
    assert made is not None
    return made


def heights(poses: Mapping[int, StandingPose], number: int) -> tuple[float, float]:
    """The mean height in the left and right of a pose's document."""
    relief = poses[number].pose.pose.relief
    assert relief is not None
    gamma = np.array(relief.gamma)
    return float(gamma[LEFT].mean()), float(gamma[RIGHT].mean())


def test_a_pose_has_from_another_what_that_knows_better_and_keeps_the_rest() -> None:
    poses = {0: standing(0, 10.0, 0.8, 0.0), 1: standing(1, 13.0, 0.7, 0.8)}
    shared = with_shared_surface(poses)
    assert heights(shared, 0) == (10.0, 13.0)
    assert heights(shared, 1) == pytest.approx((13.0 - 3 * 0.2, 13.0))  # nearly sure of its own: so little nearer
    assert np.allclose(shared[0].confidence[RIGHT], 0.8)
    for number, pose in shared.items():
        before = poses[number]
        assert pose.pose.pose.homographies == before.pose.pose.homographies
        assert pose.projections.keys() == before.projections.keys()
        assert all(np.array_equal(pose.projections[name], before.projections[name]) for name in NAMES)
        assert pose.view is before.view


def test_the_surest_of_three_is_taken_and_one_alone_stays() -> None:
    poses = {0: standing(0, 5.0, 0.25, 0.25), 1: standing(1, 8.0, 0.9, 0.4), 4: standing(4, 2.0, 0.4, 0.9)}
    assert heights(with_shared_surface(poses), 0) == (8.0, 2.0)
    alone = {0: poses[0]}
    assert with_shared_surface(alone) == alone


def test_a_height_goes_over_by_degrees() -> None:
    """From sure to unknown in a ramp: nowhere a step of more than its share."""
    sloping = standing(0, 0.0, 0.8, 0.0)
    ramp = np.linspace(0.8, 0.0, SHAPE[1])[None].repeat(SHAPE[0], 0)
    relief = relief_document(sloping.projections, sloping.gamma, ramp)
    other = standing(1, 3.0, 0.4, 0.4)
    pose = attrs.evolve(sloping.pose, pose=attrs.evolve(sloping.pose.pose, relief=relief))
    made = StandingPose.of(pose)
    assert made is not None
    found = with_shared_surface({0: made, 1: other})[0].gamma[0]
    assert found[0] == 0
    assert found[-1] == 3
    assert np.diff(found).max() < 0.15
    assert np.diff(found).min() >= 0


def test_poses_that_contradict_each_other_share_nothing() -> None:
    """One that was not tied to the other's scene: its heights mean something else."""
    poses = {0: standing(0, 10.0, 0.6, 0.3), 1: standing(1, 30.0, 0.6, 0.9), 2: standing(2, 12.0, 0.6, 0.7)}
    shared = with_shared_surface(poses)
    assert heights(shared, 0) == (10.0, 12.0)
    assert heights(shared, 1) == (30.0, 30.0)
