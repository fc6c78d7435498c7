"""Every delivered picture is the right one: a counter burnt into every picture, read back from the pixels.

Through `Footage`, forward and at random, through conform and the direct engine; through Blender in
tests/blender/worker/test_frame_exactness.py. frame_cases.py is the oracle.
"""

from __future__ import annotations

import numpy as np
import pytest
from coded_video import read_number
from frame_cases import CASES, DELIVERED, FRAMES, delivered, edl_of, wrong

from mcsl_core.delivery import chunk_keys
from mcsl_core.delivery.conform import conform
from mcsl_core.delivery.direct import write_direct
from mcsl_core.delivery.source import ProgrammeSource
from mcsl_core.recording.footage import footage_of
from mcsl_core.timing import FrameRange


@pytest.mark.parametrize("name", CASES)
def test_every_frame_of_footage_is_the_right_picture(tmp_path, name):
    case = CASES[name]
    footage = footage_of(edl_of(case, tmp_path), tmp_path)
    forward = [None if p is None else read_number(p.y) for p in footage.planes("a", FrameRange(0, FRAMES))]
    assert wrong(case, forward, range(FRAMES)) == {}
    rng = np.random.default_rng(3)
    for _ in range(3):
        some = sorted(rng.choice(FRAMES, 7, replace=False).tolist())
        got = [None if p is None else read_number(p) for _, p in footage.pictures("a", some)]
        assert wrong(case, got, some) == {}
    for frame in rng.choice(FRAMES, 6).tolist():
        (picture,) = footage.planes("a", FrameRange(frame, frame + 1))
        assert wrong(case, [None if picture is None else read_number(picture.y)], [frame]) == {}


@pytest.mark.parametrize("name", DELIVERED)
def test_conform_and_the_direct_engine_deliver_the_right_pictures(tmp_path, monkeypatch, name):
    monkeypatch.setattr(chunk_keys, "CHUNK_S", 1)
    case = CASES[name]
    source = ProgrammeSource(edl_of(case, tmp_path), tmp_path)
    done = conform(source, tmp_path / "out")
    conformed = [number for chunk in done.chunks for number in delivered(done.path(chunk))]
    assert wrong(case, conformed, range(FRAMES)) == {}
    write_direct(source, tmp_path / "direct.mp4")
    assert wrong(case, delivered(tmp_path / "direct.mp4"), range(FRAMES)) == {}


def test_the_oracle_itself():
    """It tells a picture that is shown twice, left out or late, and judges nearly every frame."""
    for case in CASES.values():
        right = [case.shown(n) for n in range(FRAMES)]
        judged = [n for n in range(FRAMES) if not case.near_a_tie(n)]
        assert len(judged) > 0.6 * FRAMES
        shifted = [right[max(0, n - 1)] for n in range(FRAMES)]
        assert wrong(case, shifted, range(FRAMES))
