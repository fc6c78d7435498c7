"""What a variant's points go through: the planes, or the relief, as its pictures do."""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path

import attrs
import cv2
import numpy as np
import pytest

from mcsl_core.edl import IDENTITY, Camera, Edl, Look, Media, Pose, Relief, Shot
from mcsl_core.evaluation.evaluate import evaluate
from mcsl_core.imaging.planes import bgr_to_planes
from mcsl_core.media.writing import VideoWriter
from mcsl_core.timing import FrameRange

SIZE, RATE, FRAMES = (320, 180), Fraction(25), 12
TURN = np.vstack([cv2.getRotationMatrix2D(((SIZE[0] - 1) / 2, (SIZE[1] - 1) / 2), 20, 1), [0, 0, 1]])
TURN[:2, 2] += 12, -6
TO_REFERENCE = {"a": np.eye(3), "b": TURN}


def rows(matrix: np.ndarray):
    return tuple(tuple(float(v) for v in row) for row in matrix)


@pytest.fixture(scope="module")
def still(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two cameras that see one still texture, the second turned and shifted."""
    folder = tmp_path_factory.mktemp("still")
    coarse = np.random.default_rng(3).integers(40, 216, (60, 80, 3)).astype(np.uint8)
    texture = cv2.resize(coarse, (640, 480), interpolation=cv2.INTER_CUBIC)
    shift = np.array([[1, 0, -160], [0, 1, -150], [0, 0, 1.0]])
    for name, matrix in TO_REFERENCE.items():
        view = cv2.warpPerspective(texture, np.linalg.inv(matrix) @ shift, SIZE, flags=cv2.INTER_CUBIC)
        with VideoWriter(folder / f"{name}.mp4", size=SIZE, rate=RATE) as writer:
            for _ in range(FRAMES):
                writer.write(bgr_to_planes(view))
    return folder


def programme(off: float) -> Edl:
    """Planes that lay b so many pixels off, and a relief that is right."""
    move = np.array([[1, 0, off], [0, 1, 0], [0, 0, 1.0]])
    seen = {name: np.column_stack([np.linalg.inv(m), np.zeros(3)]) for name, m in TO_REFERENCE.items()}
    relief = Relief(
        {name: rows(p / p[2, 2]) for name, p in seen.items()},
        gamma=((0.0,) * 9,) * 6,
        confidence=((100,) * 9,) * 6,
    )
    pose = Pose(FrameRange(0, FRAMES), {"a": IDENTITY, "b": rows(move @ TURN)}, relief=relief)
    return Edl(
        rate=RATE, size=SIZE, frames=FRAMES, reference="a", poses=(pose,), centering=((0, -4.0, 0.0),),
        cameras=tuple(Camera(n, (Media(f"{n}.mp4", FRAMES),), SIZE, RATE) for n in TO_REFERENCE),
        shots=(Shot(FrameRange(0, 6), "a"), Shot(FrameRange(6, FRAMES), "b")),
    )  # fmt: skip


def test_a_relief_has_a_row_of_its_own_beside_the_planes(still: Path) -> None:
    edl = programme(6)
    for look, same in ((Look(), "surface"), (Look(surface=False), "plane")):
        done = evaluate(attrs.evolve(edl, look=look), still, every=0)
        assert [m.name for m in done.measured] == ["no", "plane", "surface", "auto", "centered", "filled", "delivered"]
        assert done.row("plane").switches.av_speed_px == pytest.approx(6, abs=0.6)
        assert done.row("surface").switches.av_speed_px < 0.6
        assert done.row("surface").switches.av_speed_field_px < 0.6
        assert done.row("surface").switches.itf_valid_db > done.row("plane").switches.itf_valid_db + 3
        assert done.row("auto").switches == done.row(same).switches
        speeds = [done.row(name).switches.av_speed_px for name in (same, "centered", "delivered")]
        assert speeds == pytest.approx([speeds[0]] * 3, abs=0.1), "centering moves all alike"
    small = evaluate(edl, still, every=0, width=160)
    assert small.row("surface").switches.av_speed_px < 0.5
    assert small.row("plane").switches.av_speed_px == pytest.approx(3, abs=0.5)
