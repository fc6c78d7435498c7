"""Which poses are solved when, and by which rigs: a pose that lacks a camera looks ahead for one that has it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from notes import Notes

from mcsl_core.alignment.aligned_views import AlignedPose
from mcsl_core.alignment.observations import SolvedPose
from mcsl_core.alignment.relief.rig import Rig
from mcsl_core.alignment.rig_sharing import RigSharing
from mcsl_core.edl import Pose
from mcsl_core.progress import Progress
from mcsl_core.timing import FrameRange

MANY, FEW = 2000, 300


class Recorded:
    """Poses that each tie their cameras by so many places; what they do not tie a rig tells that is sure of it.

    calls: (which pose was solved, the rigs it was given, by the pose each is of).
    """

    def __init__(self, *places: Mapping[str, int], shown: Mapping[int, set[str]] | None = None) -> None:
        self.places = places
        self.names = dict.fromkeys(range(len(places)), set().union(*places)) | (shown or {})
        self.calls: list[tuple[int, list[int]]] = []
        self.of: dict[int, int] = {}

    def __len__(self) -> int:
        return len(self.places)

    def shown(self, at: int) -> set[str]:
        return self.names[at]

    def solve(self, at: int, earlier: Sequence[SolvedPose], rigs: Sequence[Rig], progress: Progress) -> SolvedPose:
        self.calls.append((at, [self.of[id(rig)] for rig in rigs]))
        progress.note(f"pose {at}, {len(rigs)} rigs")
        transferred = set().union(*(rig.sure() for rig in rigs)) - self.places[at].keys()
        matches = {**self.places[at], **dict.fromkeys(transferred, 0)}
        rig = Rig({name: np.eye(3, 4) for name in matches}, matches)
        self.of[id(rig)] = at
        aligned = AlignedPose((16, 9), "ref", {}, {}, np.zeros((9, 16), bool))
        return SolvedPose(Pose(FrameRange(10 * at, 10 * at + 10), {}), aligned, (at,), {}, rig=rig)


def solved(recorded: Recorded) -> tuple[list[SolvedPose], Notes]:
    """All poses in order; what is told of those that count."""
    progress, poses = Notes(), []
    sharing = RigSharing(recorded, progress)
    for at in range(len(recorded)):
        attempt = sharing.attempt(at, poses)
        attempt.notes.tell()
        poses.append(attempt.pose)
    return poses, progress


def sees(*names: str, few: Sequence[str] = ()) -> dict[str, int]:
    return {**dict.fromkeys(("ref", *names), MANY), **dict.fromkeys(few, FEW)}


def test_poses_that_see_every_camera_are_solved_once_and_in_order() -> None:
    recorded = Recorded(sees("b", "c"), sees("b", "c"), sees("b", "c"))
    solved(recorded)
    assert recorded.calls == [(0, []), (1, [0]), (2, [0, 1])]


def test_a_camera_that_a_pose_lacks_is_told_by_the_one_after_it_which_is_not_solved_twice() -> None:
    recorded = Recorded(sees("b"), sees("b", "c"), sees("b", "c"))
    poses, progress = solved(recorded)
    assert recorded.calls == [(0, []), (1, [0]), (0, [1]), (2, [0, 1])]
    assert poses[0].rig is not None
    assert poses[0].rig.transferred() == {"c"}
    assert progress.notes == ["pose 0, 1 rigs", "pose 1, 1 rigs", "pose 2, 2 rigs"], "of the attempts that count alone"


def test_two_poses_that_lack_each_a_camera_of_the_other_tell_each_other() -> None:
    recorded = Recorded(sees("b", "c"), sees("b", "d"))
    poses, _ = solved(recorded)
    assert recorded.calls == [(0, []), (1, [0]), (0, [1])]
    assert [pose.rig and pose.rig.transferred() for pose in poses] == [{"d"}, {"c"}]


def test_a_camera_tied_by_few_places_is_lacking_too_until_a_rig_is_sure_of_it() -> None:
    recorded = Recorded(sees("b", few="c"), sees("b", few="c"), sees("b", "c"))
    solved(recorded)
    assert recorded.calls[:4] == [(0, []), (1, [0]), (2, [0]), (0, [2])]
    before = Recorded(sees("b", "c"), sees("b", few="c"), sees("b", "c"))
    solved(before)
    assert before.calls == [(0, []), (1, [0]), (2, [0, 1])], "a rig before is sure of it"


def test_what_was_solved_ahead_is_solved_again_where_a_rig_is_known_since_that_helps() -> None:
    recorded = Recorded(sees("b"), sees("b", "c", few="d"), sees("b", "d"), shown={0: {"ref", "b", "d"}})
    solved(recorded)
    assert recorded.calls == [(0, []), (1, [0]), (2, [0]), (0, [2]), (1, [0, 2]), (2, [0, 1])]


def test_no_more_than_two_poses_are_solved_ahead() -> None:
    recorded = Recorded(sees("b"), sees("b"), sees("b"), sees("b", "c"))
    solved(recorded)
    assert recorded.calls[:3] == [(0, []), (1, [0]), (2, [0])]
    assert (3, [0, 1]) in recorded.calls, "on the second pose's turn, which lacks the camera too"
    assert [at for at, _ in recorded.calls].count(0) == 1


def test_where_the_reference_camera_has_no_picture_nothing_is_lacking_and_nothing_is_told() -> None:
    recorded = Recorded(sees("b"), sees("b", "c"), sees("b", "c"), shown={1: set()})
    solved(recorded)
    assert recorded.calls == [(0, []), (2, [0]), (0, [2]), (1, [0])]
    last = Recorded(sees("b", "c"), sees("b"), sees("b", "c"), shown={1: set()})
    solved(last)
    assert [at for at, _ in last.calls] == [0, 1, 2]
