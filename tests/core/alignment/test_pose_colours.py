"""From files to colours that do not pump: a camera drifts, a camera pumps between two samples, and one does neither."""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path

import attrs
import cv2
import numpy as np
import pytest

from mcsl_core.alignment.aligned_views import AlignedPose
from mcsl_core.alignment.colour_match import apply_colour, as_matrix, colour_at
from mcsl_core.alignment.observations import SolvedPose
from mcsl_core.alignment.pose_colours import PoseColours, follow_drift
from mcsl_core.edl import IDENTITY, Camera, Colour, Media, Movement, Pose
from mcsl_core.imaging.planes import bgr_to_planes, planes_to_bgr
from mcsl_core.media.writing import Encoding, VideoWriter
from mcsl_core.progress import Silent
from mcsl_core.recording.footage import Footage
from mcsl_core.recording.sample_store import SampleStore
from mcsl_core.timing import FrameRange

SIZE, RATE, FRAMES = (320, 180), Fraction(10), 160
PINK = as_matrix(np.array([1.0, 0.9, 1.1]), np.zeros(3))


def scene() -> np.ndarray:
    rng = np.random.default_rng(3)
    folds = cv2.GaussianBlur(rng.normal(0, 70, SIZE[::-1]).astype(np.float32), (0, 0), 3)
    return np.array((90, 120, 70), np.float32) + folds[..., None]


def filmed(folder: Path, name: str, gains: np.ndarray) -> Camera:
    """A camera's file: (FRAMES, 3) gains of B, G, R on the scene; a head wanders before it for five seconds."""
    rng = np.random.default_rng(len(name))
    encoding = Encoding(options={"preset": "ultrafast", "crf": "12"})
    with VideoWriter(folder / f"{name}.mp4", size=SIZE, rate=RATE, encoding=encoding, keyframe_interval=10) as writer:
        for n, gain in enumerate(gains):
            shown = scene()
            if 40 <= n < 90:
                cv2.circle(shown, (60 + 4 * (n - 40), 90), 70, (160, 110, 60), -1)
            writer.write(np.clip(shown * gain + rng.normal(0, 1, shown.shape), 0, 255).astype(np.uint8))
    return Camera(name, (Media(f"{name}.mp4", FRAMES),), SIZE, RATE)


def followed(folder: Path, gains: dict[str, np.ndarray], movements=()) -> tuple[Pose, PoseColours]:
    """The pose as it was solved, the first camera its reference, and its colours."""
    cameras = [filmed(folder, name, own) for name, own in gains.items()]
    footage = Footage(cameras, rate=RATE, frames=FRAMES, base=folder)
    names = tuple(gains)
    aligned = AlignedPose(
        SIZE, names[0], {n: np.eye(3) for n in names}, dict.fromkeys(names, SIZE), np.ones(SIZE[::-1], bool)
    )
    pose = Pose(FrameRange(0, FRAMES), dict.fromkeys(names, IDENTITY), colour={names[1]: PINK})
    samples = SampleStore.record(footage, folder / "samples", Silent())
    solved = SolvedPose(pose, aligned, tuple(samples.standing(pose.range, movements)), {})
    (found,) = follow_drift(samples, [solved], footage, movements, Silent())
    samples.close()
    return pose, found


def mean_colours(pose: Pose, name: str, gains: np.ndarray, frames: range) -> np.ndarray:
    """(n, 3): the scene's mean colour as the programme shows it by this camera."""
    found = []
    for frame in frames:
        planes = bgr_to_planes(np.clip(scene() * gains[frame], 0, 255).astype(np.uint8))
        colour: Colour | None = colour_at(pose, name, (frame,))
        shown = planes if colour is None else apply_colour(planes, colour)
        found.append(planes_to_bgr(shown).reshape(-1, 3).mean(axis=0))
    return np.array(found)


@pytest.mark.slow
def test_the_programme_stands_still_while_reference_and_camera_drift_and_pump(tmp_path) -> None:
    t = np.arange(FRAMES) / 10
    settles = np.exp(-0.4 * np.exp(-t / 2))
    pumps = np.interp(t, [0, 4.2, 4.7, 8.3, 8.8, 16], [1, 1, 1.2, 1.2, 1, 1])
    tint = np.exp(0.12 * np.sin(t / 4)[:, None] * [1, 0, -1])
    gains = {"cam1": settles[:, None] * np.ones(3), "cam2": 0.9 * pumps[:, None] * tint}
    pose, found = followed(tmp_path, gains)
    assert set(found.colour_keys) == {"cam1", "cam2"}
    assert max(map(len, found.colour_keys.values())) < 40
    level = found.of(pose)
    shown = {name: mean_colours(level, name, own, range(FRAMES)) for name, own in gains.items()}
    for colours in shown.values():
        assert np.abs(colours - np.median(colours, axis=0)).max() < 4
    assert np.abs(np.median(shown["cam1"], axis=0) - np.median(shown["cam2"], axis=0)).max() < 3


def test_without_drift_the_pose_keeps_the_match_that_it_has(tmp_path) -> None:
    flat = np.ones((FRAMES, 3))
    pose, found = followed(tmp_path, {"cam1": flat, "cam2": 0.9 * flat})
    assert found.of(pose) == pose


def test_what_changes_while_the_lamp_moves_is_no_drift(tmp_path) -> None:
    gains = np.interp(np.arange(FRAMES), [0, 120, 125, FRAMES], [1, 1, 0.6, 0.6])[:, None] * np.ones(3)
    pose, found = followed(tmp_path, {"cam1": gains, "cam2": gains}, (Movement(FrameRange(115, FRAMES)),))
    assert attrs.evolve(found.of(pose)) == pose


def test_a_camera_that_one_pose_cannot_match_is_matched_as_the_nearest_pose_has_it(tmp_path: Path) -> None:
    still = np.ones((FRAMES, 3))
    pose, _ = followed(tmp_path, {"a": still, "b": still})
    ranges = (FrameRange(0, 60), FrameRange(60, 110), FrameRange(110, FRAMES))
    colours = ({"b": PINK}, {}, {})
    cameras = [Camera(n, (Media(f"{n}.mp4", FRAMES),), SIZE, RATE) for n in ("a", "b")]
    footage = Footage(cameras, rate=RATE, frames=FRAMES, base=tmp_path)
    samples = SampleStore.record(footage, tmp_path / "again", Silent())
    aligned = AlignedPose(
        SIZE, "a", dict.fromkeys("ab", np.eye(3)), dict.fromkeys("ab", SIZE), np.ones(SIZE[::-1], bool)
    )
    solved = [
        SolvedPose(attrs.evolve(pose, range=piece, colour=own), aligned, tuple(samples.within(piece)), {})
        for piece, own in zip(ranges, colours, strict=True)
    ]
    found = follow_drift(samples, solved, footage, (), Silent())
    samples.close()
    assert [own.colour for own in found] == [{"b": PINK}] * 3


def test_where_no_pose_has_a_match_what_is_steady_tells(tmp_path: Path) -> None:
    pose, _ = followed(tmp_path, {"a": np.ones((FRAMES, 3)), "b": np.full((FRAMES, 3), 0.8)})
    cameras = [Camera(n, (Media(f"{n}.mp4", FRAMES),), SIZE, RATE) for n in ("a", "b")]
    footage = Footage(cameras, rate=RATE, frames=FRAMES, base=tmp_path)
    samples = SampleStore.record(footage, tmp_path / "again", Silent())
    aligned = AlignedPose(
        SIZE, "a", dict.fromkeys("ab", np.eye(3)), dict.fromkeys("ab", SIZE), np.ones(SIZE[::-1], bool)
    )
    solved = SolvedPose(attrs.evolve(pose, colour={}), aligned, tuple(samples.within(pose.range)), {})
    (found,) = follow_drift(samples, [solved], footage, (), Silent())
    samples.close()
    shown = {
        name: mean_colours(found.of(pose), name, np.full((FRAMES, 3), g), range(3))
        for name, g in (("a", 1), ("b", 0.8))
    }
    assert np.abs(shown["a"] - shown["b"]).max() < 4
