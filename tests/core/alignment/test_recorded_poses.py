"""Which samples a pose is solved from, and whose view it is solved in."""

from __future__ import annotations

from io import BytesIO

import pytest

from mcsl_core.alignment.features import RootSift
from mcsl_core.alignment.joint import JointPlane
from mcsl_core.alignment.pose_solver import PoseSolver
from mcsl_core.alignment.recorded_poses import RecordedPoses, pose_ranges
from mcsl_core.alignment.settings import SolveSettings
from mcsl_core.edl import Movement
from mcsl_core.recording.sample_store import SampleStore
from mcsl_core.timing import FrameRange

SIZES = dict.fromkeys(("cam1", "cam2", "cam3"), (64, 36))


def poses(*shown: str, movements: tuple[Movement, ...] = ()) -> RecordedPoses:
    """A sample every ten frames, in each of which those cameras have a picture: "13" is cam1 and cam3."""
    index = [{f"cam{n}": (0, 0, 10 * k) for n in names} for k, names in enumerate(shown)]
    samples = SampleStore([10 * k for k in range(len(shown))], tuple(SIZES), index, BytesIO())
    solver = PoseSolver(SIZES, "cam1", RootSift(), JointPlane(), SolveSettings())
    return RecordedPoses.of(solver, samples, movements, 10 * len(shown))


def test_ranges_reach_to_the_middles_of_movements_and_tile_the_recording() -> None:
    movements = [Movement(FrameRange(40, 60)), Movement(FrameRange(80, 91)), Movement(FrameRange(99, 101))]
    assert pose_ranges(movements, 100) == [FrameRange(0, 50), FrameRange(50, 85), FrameRange(85, 100)]
    assert pose_ranges([], 100) == [FrameRange(0, 100)]


def test_a_movement_in_which_the_recording_begins_or_ends_parts_no_poses() -> None:
    movements = [
        Movement(FrameRange(0, 10), 0.2),
        Movement(FrameRange(40, 60), 1.0),
        Movement(FrameRange(90, 100), 1.0),
    ]
    assert pose_ranges(movements, 100) == [FrameRange(0, 50), FrameRange(50, 100)]


def test_a_pose_is_solved_from_samples_in_which_the_lamp_stands_unless_it_never_does() -> None:
    found = poses(*["123"] * 10, movements=(Movement(FrameRange(35, 65)), Movement(FrameRange(66, 99))))
    assert found.standing == [[0, 1, 2, 3], [5, 6, 7, 8], [9]]
    assert len(found) == 3


@pytest.mark.parametrize(
    ("shown", "cameras"),
    [
        (["12", "12", "123", "2", "2"], {"cam1", "cam2", "cam3"}),
        (["12", "12", "3", "23", "2"], set()),  # two with the reference: too few to solve it in its view
        (["1", "12"], {"cam1", "cam2"}),  # there are no more
        (["2", "12"], set()),
        (["2", "2", "23"], set()),
    ],
)
def test_a_pose_is_solved_in_the_references_view_where_that_has_three_pictures(
    shown: list[str], cameras: set[str]
) -> None:
    assert poses(*shown).shown(0) == cameras
