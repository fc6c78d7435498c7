"""The cut's clips, frame by frame against what the footage shows: nothing rounds, nothing outlasts its media."""

from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, settings
from interchange_cuts import R, facts_of, film, films

from mcsl_core.edl import Clock
from mcsl_core.edl.placement import placement_matrix
from mcsl_core.errors import Fault, UsageError
from mcsl_core.interchange.model import Clip, Medium
from mcsl_core.interchange.similarity import nearest_transform


def pictures(clips):
    """Programme frame -> (file, picture) that an editor shows: its clip's first, then one after another."""
    found = {}
    for clip in clips:
        for n in clip.range:
            assert n not in found
            picture = clip.source + (n - clip.range.start) * clip.medium.rate / clip.rate
            found[n] = str(clip.medium.path), picture
    return found


@given(films())
@settings(max_examples=60)
def test_every_frame_shows_the_picture_that_the_footage_shows(made):
    cut = made.cut()
    for angle in cut.angles:
        shown = pictures(angle.clips)
        for n in range(made.edl.frames):
            assert shown.get(n) == made.picture_at(angle.camera, n)
    shown = pictures(cut.shown())
    for n in range(made.edl.frames):
        assert shown.get(n) == made.picture_at(made.camera_at(n), n)


@given(films(mixed_rates=True))
@settings(max_examples=40)
def test_at_another_rate_a_picture_is_at_most_one_off_and_none_is_beyond_the_file(made):
    for angle in made.cut().angles:
        for n, (path, picture) in pictures(angle.clips).items():
            wanted = made.picture_at(angle.camera, n)
            assert wanted is not None
            assert wanted[0] == path
            assert abs(wanted[1] - picture) < 1


def test_a_clock_that_drifts_is_cut_where_it_has_run_ahead_by_a_picture():
    files = {"cam2": [facts_of("2.mp4", Fraction(25), 200)]}
    made = film(cameras={"cam2": {"clock": Clock(drift_ppm=100_000)}}, files=files)
    clips = made.cut().angle("cam2").clips
    assert [(clip.range.start, clip.source - clip.range.start) for clip in clips] == [(10 * k, k) for k in range(10)]


def test_a_gap_and_the_end_of_a_file_leave_the_angle_empty():
    made = film(cameras={"cam2": {"gaps": (R(10, 20),)}}, files={"cam2": [facts_of("2.mp4", Fraction(25), 60)]})
    assert [clip.range for clip in made.cut().angle("cam2").clips] == [R(0, 10), R(20, 60)]


def test_files_follow_one_another_and_a_timecode_does_not_shift_them():
    files = [facts_of("a.mp4", Fraction(25), 30, timecode="10:00:00:00"), facts_of("b.mp4", Fraction(25), 90)]
    clips = film(files={"cam1": files}).cut().angle("cam1").clips
    assert [(clip.medium.path.name, clip.range, clip.source) for clip in clips] == [
        ("a.mp4", R(0, 30), 0),
        ("b.mp4", R(30, 100), 0),
    ]
    assert clips[0].medium.start == 10 * 3600 * 25


def test_a_clip_beyond_its_media_cannot_be_made():
    medium = Medium(facts_of("a.mp4", Fraction(25), 30).path, Fraction(25), 30, size=(16, 16))
    Clip("a", R(5, 35), medium, Fraction(0), Fraction(25))
    with pytest.raises(Fault, match="which has 30"):
        Clip("a", R(5, 36), medium, Fraction(0), Fraction(25))


@pytest.mark.parametrize("rate", [Fraction(25, 2), Fraction(299, 10)])
def test_a_rate_that_is_no_broadcast_rate_is_refused(rate):
    with pytest.raises(UsageError, match="editors know"):
        film(rate).cut()


@given(films())
@settings(max_examples=30)
def test_the_transform_is_as_near_to_the_homography_as_any_that_is_tried(made):
    edl, pose = made.edl, made.edl.poses[0]
    width, height = edl.size
    grid = np.array([(x, y) for x in np.linspace(0, width, 13) for y in np.linspace(0, height, 13)])
    weight = np.exp(-0.5 * (np.linalg.norm(grid - [(width - 1) / 2, (height - 1) / 2], axis=1) / (0.3 * width)) ** 2)
    for camera in edl.cameras:
        matrix = placement_matrix(edl, pose, camera.name)
        found = nearest_transform(edl, camera, pose)
        if matrix is None:
            assert (found.x, found.y, found.scale, found.rotation) == (0, 0, 1, 0)
            continue
        back = np.column_stack([grid, np.ones(len(grid))]) @ np.linalg.inv(np.array(matrix)).T
        source = back[:, :2] / back[:, 2:]
        inside = ((source >= 0) & (source < np.array(camera.size))).all(axis=1)

        def miss(x, y, scale, rotation, source=source, inside=inside, size=camera.size):
            turn = np.deg2rad(rotation)
            rows = scale * np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])
            shown = (source - (np.array(size) - 1) / 2) @ rows.T + [x + (width - 1) / 2, y + (height - 1) / 2]
            return (weight[inside] * ((shown - grid)[inside] ** 2).sum(axis=1)).sum()

        best = miss(found.x, found.y, found.scale, found.rotation)
        for dx, dy, ds, dr in [(9, 0, 0, 0), (-9, 0, 0, 0), (0, 9, 0, 0), (0, 0, 0.02, 0), (0, 0, 0, 2), (0, 0, 0, -2)]:
            assert best <= miss(found.x + dx, found.y + dy, found.scale + ds, found.rotation + dr)
