"""How long the programme is, and what is told of what lies outside the reference camera's recording."""

from fractions import Fraction
from pathlib import Path

import pytest
from coded_video import SIZE, read_number, write_coded
from notes import Notes

from mcsl_core.edl import Camera, Clock, Media
from mcsl_core.errors import InputError
from mcsl_core.recording.cameras import programme_length
from mcsl_core.recording.footage import Footage
from mcsl_core.timing import FrameRange

RATE = Fraction(30)


def footage(folder: Path, *cameras: tuple[str, int, Clock]) -> Footage:
    made = []
    for name, pictures, clock in cameras:
        path = write_coded(folder / f"{name}.mp4", range(pictures), bframes=0)
        made.append(Camera(name, (Media(str(path), pictures),), SIZE, RATE, clock=clock))
    return Footage(made, rate=RATE, frames=1, base=Path("/"))


@pytest.mark.parametrize(
    ("pictures", "offset_s", "drift_ppm", "expected"),
    [
        (120, 0.0, 0.0, 120),  # the reference stops after a third
        (40, 3.0, 0.0, 130),
        (150, -2.0, 0.0, 90),
        (120, 0.5, 400.0, 135),
        (60, 0.5, 0.0, 75),
        (60, 0.3, 0.0, 40),  # 0.97 s: what recorders stopped one after another leave
    ],
)
def test_the_programme_lasts_until_the_last_camera_ends(tmp_path, pictures, offset_s, drift_ppm, expected):
    progress = Notes()
    both = footage(tmp_path, ("a", 40, Clock()), ("b", pictures, Clock(offset_s=offset_s, drift_ppm=drift_ppm)))
    assert programme_length(both, "a", progress) == expected
    told = [note for note in progress.notes if "a, the reference camera, ends at 0:00:01.3" in note]
    assert len(told) == (expected > 40)
    whole = Footage(both.cameras, rate=RATE, frames=expected, base=Path("/"))
    shown = [[None if p is None else read_number(p.y) for p in whole.planes(n, FrameRange(0, expected))] for n in "ab"]
    assert shown[0] == [*range(40), *[None] * (expected - 40)]
    assert shown[1][-1] == pictures - 1 or expected == 40


def test_what_begins_before_the_reference_camera_is_told(tmp_path):
    progress = Notes()
    both = footage(tmp_path, ("a", 40, Clock()), ("b", 100, Clock(offset_s=-2.0)))
    assert programme_length(both, "a", progress) == 40
    (note,) = progress.notes
    assert note.startswith("b begins 2.0 s before a, the reference camera")


def test_a_clock_that_leads_to_days_is_refused_before_any_work(tmp_path):
    both = footage(tmp_path, ("a", 40, Clock()), ("b", 40, Clock(offset_s=200_000.0)))
    with pytest.raises(InputError, match=r"camera b: lasts until 200001 s, at most 48 hours"):
        programme_length(both, "a", Notes())


def test_a_camera_that_ends_much_earlier_than_the_programme_is_told(tmp_path):
    """Where a file promises no end, only the other cameras tell that some of it, or a whole file, is missing."""
    progress = Notes()
    three = footage(tmp_path, ("a", 400, Clock()), ("b", 30, Clock()), ("c", 150, Clock()))
    assert programme_length(three, "a", progress) == 400
    (note,) = progress.notes  # c ends 8 s before: recorders are stopped one after another
    assert note.startswith("b ends at 0:00:01.0, 12 s before the programme")
