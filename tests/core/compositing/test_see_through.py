"""The look `see_through`: heads go, hands stay, nothing flickers, and off it is as if it were not there."""

from __future__ import annotations

import attrs
import numpy as np
import peopled_scene as scene
import pytest
from peopled_scene import HAND, HEAD, Filmed, Thing, above, programme
from pictures import psnr

from mcsl_core.compositing.compositor import Compositor
from mcsl_core.edl import Movement, Override, Weak
from mcsl_core.filling.footprint import FootprintFiller
from mcsl_core.filling.provenance import ShowProvenance
from mcsl_core.imaging.planes import bgr_to_planes
from mcsl_core.timing import FrameRange

MIDDLE = (0.0, 0.0)
CAP, GLOVE = (150, 90, 40), (190, 200, 215)
FROM = 35  # the head comes


def head(camera: str, *, since: int = FROM, place: tuple[float, float] = MIDDLE, radius: float = 50) -> Thing:
    at = above(camera, place, HEAD)
    return Thing(HEAD, lambda frame: at if frame >= since else None, radius, CAP)


def hand(frame: int) -> tuple[float, float] | None:
    return (50 + 30 * np.sin(frame / 2), -40.0 + 2 * (frame % 30))


def shown(edl, film, piece: FrameRange, **options) -> list:
    with Compositor(edl, film, **options) as compositor:
        return list(compositor.frames(piece))


def one(edl, film, frame: int, **options):
    return shown(edl, film, FrameRange(frame, frame + 1), **options)[0]


def inside(radius: float) -> np.ndarray:
    y, x = np.mgrid[: scene.SIZE[1], : scene.SIZE[0]]
    return np.hypot(x - scene.SIZE[0] / 2, y - scene.SIZE[1] / 2) < radius


@pytest.mark.parametrize("camera", ["cam1", "cam2", "cam4"])
def test_the_field_is_seen_under_a_head(camera):
    edl, film = programme(camera), Filmed([head(camera)])
    without = one(edl, Filmed([]), 50)
    plain = one(programme(camera, see_through=False), film, 50)
    seen = one(edl, film, 50)
    assert psnr(plain.y, without.y, inside(40)) < 22
    assert psnr(seen.y, without.y, inside(40)) > 28
    assert psnr(seen.y, without.y, inside(90)) > 28, "nor is there an outline of it"


def test_a_head_that_stays_all_the_time_is_seen_through_as_well():
    film = Filmed([head("cam1", since=0)])
    without = one(programme("cam1"), Filmed([]), 50)
    assert psnr(one(programme("cam1"), film, 50).y, without.y, inside(90)) > 28


def test_two_cameras_that_come_out_of_the_shade_of_heads_are_believed_at_once():
    """All medians but one show heads: what the field looks like, only pictures of now tell."""

    def until_now(camera: str) -> Thing:
        at = above(camera, MIDDLE, HEAD)
        return Thing(HEAD, lambda frame: at if frame < 50 else None, 50, CAP)

    film = Filmed([head("cam1", since=0), *(until_now(camera) for camera in ("cam2", "cam3", "cam4"))])
    without = one(programme("cam1"), Filmed([]), 56)
    assert psnr(one(programme("cam1"), film, 56).y, without.y, inside(40)) > 28


def test_a_hand_that_rests_all_the_time_is_seen_under_a_head():
    """No two cameras show the same of it at the relief, now or ever, but two show it alike at its height."""
    rests = Thing(100.0, lambda frame: (100.0, 0.0), 120, GLOVE)
    plain, seen = (one(programme("cam1", see_through=on), Filmed([rests, head("cam1")]), 50) for on in (False, True))
    within = slice(42, 48), slice(84, 86)
    cap, glove = (bgr_to_planes(np.full((2, 2, 3), colour, np.uint8)) for colour in (CAP, GLOVE))
    assert abs(float(plain.u[within].mean()) - cap.u.mean()) < 3
    assert abs(float(seen.u[within].mean()) - glove.u.mean()) < 3


def test_a_hand_stays_to_the_last_pixel():
    film = Filmed([Thing(HAND, hand, 35, GLOVE)])
    for camera in ("cam1", "cam3"):
        plain, seen = (shown(programme(camera, see_through=on), film, FrameRange(30, 40)) for on in (False, True))
        for a, b in zip(plain, seen, strict=True):
            assert np.array_equal(a.y, b.y)


@pytest.mark.parametrize("camera", ["cam1", "cam2"])
def test_a_hand_that_rests_in_every_median_and_then_moves_a_little_stays(camera):
    film = Filmed([Thing(20.0, lambda frame: (30.0 + 6 * (frame >= 48), -20.0), 45, GLOVE)])
    plain, seen = (one(programme(camera, see_through=on), film, 52) for on in (False, True))
    assert np.array_equal(plain.y, seen.y)


def test_a_hand_beside_a_head_stays():
    away = Thing(HAND, lambda frame: (-170.0 + frame % 9, 90.0), 25, GLOVE)
    film = Filmed([away, head("cam1")])
    plain, seen = (one(programme("cam1", see_through=on), film, 50) for on in (False, True))
    assert np.array_equal(plain.y[:75, :75], seen.y[:75, :75])
    assert (plain.y != seen.y)[inside(40)].mean() > 0.8


def test_where_all_are_covered_the_cover_shows():
    film = Filmed([head(camera, since=0, radius=400) for camera in scene.CAMERAS])
    plain, seen = (one(programme("cam1", see_through=on), film, 50) for on in (False, True))
    assert np.array_equal(plain.y, seen.y)


def test_the_only_camera_that_sees_the_field_keeps_its_picture():
    film = Filmed([head(camera, since=0, radius=70) for camera in scene.CAMERAS[1:]])
    plain, seen = (one(programme("cam1", see_through=on), film, 50) for on in (False, True))
    middle = inside(20)
    assert np.array_equal(plain.y[middle], seen.y[middle]), "four caps of one colour are no majority"


def test_a_camera_whose_colours_do_not_match_keeps_its_picture():
    film = Filmed([], gains={"cam1": 0.7})
    plain, seen = (one(programme("cam1", see_through=on), film, 50) for on in (False, True))
    assert np.array_equal(plain.y, seen.y)


@pytest.mark.parametrize("black", ["cam1", "cam2"])
def test_a_camera_that_shows_nothing_is_no_trouble(black):
    film = Filmed([head("cam1")], gains={black: 0.0})
    plain, seen = (one(programme("cam1", see_through=on), film, 50) for on in (False, True))
    assert (black == "cam1") or (plain.y != seen.y)[inside(30)].mean() > 0.8


def test_a_camera_that_comes_out_of_a_long_shade_shows_its_own_picture():
    at = above("cam1", MIDDLE, HEAD)
    film = Filmed([Thing(HEAD, lambda frame: at if frame < 50 else None, 50, CAP)])
    plain, seen = (one(programme("cam1", see_through=on), film, 60) for on in (False, True))
    assert np.array_equal(plain.y, seen.y)


def test_colours_meet_at_the_border():
    film = Filmed([head("cam1")], gains={"cam2": 0.9, "cam3": 1.08, "cam4": 0.92, "cam5": 1.1})
    without = one(programme("cam1"), Filmed([]), 50)
    seen = one(programme("cam1"), film, 50)
    assert abs(float((seen.y.astype(float) - without.y)[inside(55)].mean())) < 3


def test_a_still_scene_does_not_flicker():
    quiet = shown(programme("cam1"), Filmed([]), FrameRange(50, 58))
    seen = shown(programme("cam1"), Filmed([head("cam1", since=0)]), FrameRange(50, 58))

    def most(frames):
        pairs = zip(frames, frames[1:], strict=False)
        small = [np.abs(a.y.astype(float) - b.y).reshape(45, 4, 80, 4).mean((1, 3)) for a, b in pairs]
        return float(np.max(small))

    assert most(seen) < most(quiet) + 2


def test_a_frame_is_the_same_in_whatever_range_it_is_made():
    film = Filmed([head("cam1"), Thing(HAND, hand, 35, GLOVE)])
    whole = shown(programme("cam1"), film, FrameRange(30, 40))
    for frame in (30, 35, 39):
        for a, b in zip(one(programme("cam1"), film, frame), whole[frame - 30], strict=True):
            assert np.array_equal(a, b)


def test_going_forward_each_picture_is_decoded_once():
    film = Filmed([head("cam1")])
    shown(programme("cam1"), film, FrameRange(40, 50))
    assert max(film.decoded.count(each) for each in set(film.decoded) if each[1] > 41) == 1


def test_an_override_switches_a_stretch_and_movements_that_are_not_followed_have_none():
    film, plain = Filmed([head("cam1")]), programme("cam1", see_through=False)
    as_it_is = shown(plain, film, FrameRange(48, 56))
    some = attrs.evolve(plain, overrides=(Override(FrameRange(50, 54), see_through=True),))
    moving = programme("cam1", movements=(Movement(FrameRange(52, 70)),))
    for made, on in ((some, range(50, 54)), (moving, range(48, 52))):
        same = [np.array_equal(a.y, b.y) for a, b in zip(shown(made, film, FrameRange(48, 56)), as_it_is, strict=True)]
        assert same == [frame not in on for frame in range(48, 56)]


def everywhere(lamp_frame: int) -> Thing:
    """A head that stands all the time, and hides the middle from cam1 as it lies at a frame."""
    by = np.array(scene.moved(lamp_frame))
    place = np.array(above("cam1", MIDDLE, HEAD)) + by * HEAD / 1000
    return Thing(HEAD, lambda frame: (float(place[0]), float(place[1])), 50, CAP)


@pytest.mark.parametrize("frame", [scene.MOVES.start, scene.MOVES.start + 6, scene.MOVES.stop - 1])
def test_heads_are_seen_through_while_the_lamp_moves(frame):
    edl, plainly = scene.followed_programme("cam1"), scene.followed_programme("cam1", see_through=False)
    film = Filmed([everywhere(frame)], lamp=scene.moved)
    without = one(edl, Filmed([], lamp=scene.moved), frame)
    assert psnr(one(plainly, film, frame).y, without.y, inside(40)) < 22
    assert psnr(one(edl, film, frame).y, without.y, inside(90)) > 28


def test_hands_stay_while_the_lamp_moves():
    film = Filmed([Thing(HAND, hand, 35, GLOVE)], lamp=scene.moved)
    for camera in ("cam1", "cam3"):
        ways = (scene.followed_programme(camera, see_through=on) for on in (False, True))
        plain, seen = (shown(edl, film, scene.MOVES) for edl in ways)
        assert all(np.array_equal(a.y, b.y) for a, b in zip(plain, seen, strict=True))


def test_a_frame_is_the_same_in_whatever_range_it_is_made_where_the_lamp_begins_to_move():
    film, edl = Filmed([everywhere(36)], lamp=scene.moved), scene.followed_programme("cam1")
    whole = shown(edl, film, FrameRange(30, 44))
    for frame in (31, 33, 36, 43):
        for a, b in zip(one(edl, film, frame), whole[frame - 30], strict=True):
            assert np.array_equal(a, b)


def test_a_camera_of_which_nobody_knows_how_it_lies_while_the_lamp_moves_shows_nothing_then():
    """It is decided where the lamp stood that it shows what is under the head; the others do, from the first frame."""
    made = scene.followed_programme("cam1")
    (movement,), (before, after) = made.movements, made.poses

    def less(known: dict) -> dict:
        return {name: value for name, value in known.items() if name != "cam2"}

    views = tuple(
        attrs.evolve(v, homographies=less(v.homographies), projections=less(v.projections)) for v in movement.views
    )
    relief = attrs.evolve(after.relief, projections=less(after.relief.projections))
    after = attrs.evolve(after, homographies=less(after.homographies), relief=relief, weak=(Weak("cam2", "hidden"),))
    edl = attrs.evolve(made, movements=(attrs.evolve(movement, views=views),), poses=(before, after))
    first = movement.views[0].frame
    film, lamp = Filmed([everywhere(first)], lamp=scene.moved), scene.moved
    for frame in (first - 1, first, first + 1):
        assert psnr(one(edl, film, frame).y, one(edl, Filmed([], lamp=lamp), frame).y, inside(40)) > 28


def test_what_was_worked_out_is_let_go_of():
    edl, film = scene.followed_programme("cam1"), Filmed([everywhere(36)], lamp=scene.moved)
    with Compositor(edl, film) as compositor:
        list(compositor.frames(FrameRange(32, 37)))
        moments = compositor._see_through._moments
        assert moments._known_rays.bytes == 0, "a range that has been made is closed"
        assert len(compositor.seen_through(36)) > 0
        assert moments._known_rays.bytes > 0


def test_provenance_tells_what_was_replaced():
    film = Filmed([head("cam1")])
    show = ShowProvenance(FootprintFiller(), list(scene.CAMERAS))
    plain, seen = (one(programme("cam1", see_through=on), film, 50, filler=show) for on in (False, True))
    half = inside(30)[::2, ::2]
    assert np.abs(seen.u.astype(float) - plain.u)[half].mean() > 5
    assert np.array_equal(plain.y[:40, :40], seen.y[:40, :40]), "under the legend"
