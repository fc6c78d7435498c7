"""Edits of time itself are refused by name and place; what may be meant so is told."""

from __future__ import annotations

from fractions import Fraction

import attrs
import pytest
from blender_recording import FRAMES, RATE, SIZE, an_edl

from blender_addon.core.strip_plan import make_plan, tracks_key
from blender_addon.core.times import FoundFilm, FoundShot, SceneTime, check_times, remarks
from mcsl_core.errors import InputError

EDL = an_edl()
SCENE = SceneTime(
    rate=Fraction(30) / Fraction(1.0010000467300415), step=1, stretched=False, first=1, last=FRAMES, size=SIZE
)
CAMERA = FoundFilm("camera", "cam2", 3, 30, 3, 57, "cam2.mp4", 3)
EXACT = FoundFilm("conformed", "conformed", 0, 60, 0, 60, "x", 0)
SOUND = FoundFilm("sound", "sound", 0, 60, 0, 60, "x", 0)
SHOTS = [FoundShot(f"shot-{a:07d}", f"{a}", a, b) for a, b in ((0, 20), (20, 40), (40, 45), (45, 60))]


def test_as_built_nothing_is_said():
    check_times(EDL, SCENE, [CAMERA, EXACT, SOUND], SHOTS)
    assert remarks(EDL, SCENE, [CAMERA, EXACT, SOUND]) == ()


@pytest.mark.parametrize(
    ("scene", "message"),
    [
        (
            {"rate": Fraction(50)},
            r"runs at 50 frames/s, the programme at 29\.97.*Set it back to 30 with the base 1\.001",
        ),
        ({"rate": Fraction(30)}, "runs at 30 frames/s"),  # a frame off after 33 s
        ({"step": 2}, "every 2. frame"),
        ({"stretched": True}, "stretched time"),
    ],
)
def test_another_rate_is_refused(scene, message):
    with pytest.raises(InputError, match=message):
        check_times(EDL, attrs.evolve(SCENE, **scene), [], [])


@pytest.mark.parametrize(
    ("film", "message"),
    [
        (attrs.evolve(CAMERA, content=8, start=8), r"camera strip 'cam2', frame 9: stands 5 frames later"),
        (attrs.evolve(CAMERA, content=2), "1 frame earlier"),
        (
            attrs.evolve(EXACT, content=-10, start=-10, stop=50),
            "conformed strip 'conformed', frame -9: stands 10 frames earlier",
        ),
        (attrs.evolve(EXACT, stop=70), "drawn out beyond its pictures"),
        (attrs.evolve(CAMERA, odd=("retimed",)), "frame 4: is retimed"),
        (attrs.evolve(EXACT, odd=("reversed", "shown every 2 frames")), "is reversed, shown every 2 frames"),
    ],
)
def test_a_film_out_of_time_is_refused(film, message):
    with pytest.raises(InputError, match=message):
        check_times(EDL, SCENE, [SOUND, film], SHOTS)


def test_the_first_of_a_ripple_is_named_and_the_rest_counted():
    slid = [attrs.evolve(CAMERA, name=f"cam2.{n}", start=20 + n, content=-2) for n in range(4)]
    with pytest.raises(
        InputError, match=r"'cam2\.0', frame 21: stands 5 frames earlier .* and 3 more strips .*cannot be cut"
    ):
        check_times(EDL, SCENE, slid[::-1], SHOTS)


def test_what_is_muted_and_what_older_timelines_do_not_say():
    check_times(
        EDL, SCENE, [attrs.evolve(CAMERA, content=9, muted=True), attrs.evolve(CAMERA, content=9, laid=None)], SHOTS
    )
    older = attrs.evolve(CAMERA, content=9, laid=None)
    with pytest.raises(InputError, match="6 frames later"):
        check_times(EDL, SCENE, [older], SHOTS, tracks_key(make_plan(EDL).cameras))


def shifted(first: int, by: int) -> list[FoundShot]:
    return [attrs.evolve(s, start=s.start + by, stop=s.stop + by) if s.start >= first else s for s in SHOTS]


@pytest.mark.parametrize("by", [-7, 7])
def test_a_rippled_programme_is_refused(by):
    with pytest.raises(InputError, match=r"strip '20', frame \d+: and the 2 after it stand 7 frames"):
        check_times(EDL, SCENE, [], shifted(20, by))


def test_cuts_that_were_moved_are_no_ripple():
    check_times(EDL, SCENE, [], [SHOTS[0], attrs.evolve(SHOTS[1], start=15), *SHOTS[2:]])
    check_times(EDL, SCENE, [], shifted(45, -5))  # the last shot alone: both its cuts were moved
    check_times(EDL, SCENE, [], [*SHOTS[:3], attrs.evolve(SHOTS[3], stop=50), attrs.evolve(SHOTS[3], start=50)])


def test_what_may_be_meant_so_is_told():
    notes = remarks(
        EDL,
        attrs.evolve(SCENE, first=10, last=20, size=(640, 180)),
        [attrs.evolve(SOUND, content=-2), attrs.evolve(EXACT, muted=True), attrs.evolve(SOUND, odd=("retimed",))],
    )
    assert [
        text
        for text in ("frames 10 to 20", "640 x 180", "2 frames earlier", "retimed", "muted by hand")
        if text not in str(notes)
    ] == []
    assert remarks(EDL, attrs.evolve(SCENE, size=(SIZE[0] - 1, SIZE[1] - 3)), []) == ()  # made even for a codec
    assert Fraction(RATE) == EDL.rate
