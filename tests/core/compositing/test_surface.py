"""The look `surface`: pictures of a scene with a relief, laid by it, against what the reference sees."""

from __future__ import annotations

from fractions import Fraction

import attrs
import cv2
import numpy as np
import pytest
import relief_scene as scene

from mcsl_core.compositing.compositor import Compositor
from mcsl_core.edl import Camera, Correction, Edl, Look, Media, Override, Shot
from mcsl_core.imaging.planes import planes_to_bgr
from mcsl_core.media.writing import Encoding, VideoWriter
from mcsl_core.recording.footage import Footage
from mcsl_core.timing import FrameRange

SIZE, RATE, FRAMES = (192, 128), Fraction(25), 6
LOSSLESS = Encoding(options={"preset": "ultrafast", "qp": "0"})
OFF = Look(centering=False, fill=False, colour=False, surface=False)
ON = attrs.evolve(OFF, surface=True)


def camera(folder, name, picture):
    """A camera that stands before a still picture."""
    size = picture.shape[1::-1]
    with VideoWriter(folder / f"{name}.mp4", size=size, rate=RATE, encoding=LOSSLESS, keyframe_interval=5) as writer:
        for _ in range(FRAMES):
            writer.write(picture)
    return Camera(name.partition("_")[0], (Media(f"{name}.mp4", FRAMES),), size, RATE)


def compose(edl, base, piece=None):
    footage = Footage(edl.cameras, rate=edl.rate, frames=edl.frames, base=base)
    with Compositor(edl, footage) as compositor:
        return list(compositor.frames(piece or FrameRange(0, edl.frames)))


@pytest.fixture
def edl(tmp_path):
    rng = np.random.default_rng(7)
    noise = cv2.GaussianBlur(rng.uniform(0, 255, (SIZE[1], SIZE[0], 3)), (0, 0), 2.0)
    smooth = np.clip(128 + 4 * (noise - 128), 0, 255).astype(np.uint8)
    return Edl(
        rate=RATE,
        size=SIZE,
        frames=FRAMES,
        reference="a",
        cameras=(camera(tmp_path, "a", smooth), camera(tmp_path, "b", scene.picture_of(smooth))),
        poses=(scene.pose_of(FRAMES, SIZE),),
        shots=(Shot(FrameRange(0, FRAMES), "b"),),
        look=ON,
    )


def luma(planes):
    return planes.y.astype(float)[16:-16, 16:-16]


def off(planes, others):
    return float(np.abs(luma(planes) - luma(others)).mean())


def test_two_cameras_laid_by_the_relief_agree_where_planes_leave_pixels(edl, tmp_path):
    reference = compose(attrs.evolve(edl, shots=(Shot(FrameRange(0, 6), "a"),)), tmp_path)[0]
    by_surface, by_plane = compose(edl, tmp_path)[0], compose(attrs.evolve(edl, look=OFF), tmp_path)[0]
    assert off(by_surface, reference) < 0.25 * off(by_plane, reference)
    assert off(by_surface, reference) < 4


def test_the_reference_camera_keeps_every_bit(edl, tmp_path):
    edl = attrs.evolve(edl, shots=(Shot(FrameRange(0, 6), "a"),))
    for a, b in zip(compose(edl, tmp_path)[0], compose(attrs.evolve(edl, look=OFF), tmp_path)[0], strict=True):
        assert np.array_equal(a, b)


@pytest.mark.parametrize("fill", [False, True])
def test_without_a_relief_and_where_nothing_is_known_of_it_pictures_are_as_by_planes(edl, tmp_path, fill):
    look = attrs.evolve(ON, fill=fill)
    pose = edl.poses[0]
    expected = compose(attrs.evolve(edl, poses=(attrs.evolve(pose, relief=None),), look=look), tmp_path)[0]
    unknown = attrs.evolve(edl, poses=(scene.pose_of(6, SIZE, confidence=0),), look=attrs.evolve(look, fill=False))
    if not fill:
        assert np.array_equal(compose(unknown, tmp_path)[0].y, expected.y)
    plain = attrs.evolve(edl, look=attrs.evolve(look, surface=False))
    assert np.array_equal(compose(plain, tmp_path)[0].y, expected.y)


def test_an_override_switches_it_for_a_stretch(edl, tmp_path):
    edl = attrs.evolve(edl, overrides=(Override(FrameRange(2, 4), surface=False),))
    on, between = compose(edl, tmp_path)[1:3]
    plane = compose(attrs.evolve(edl, look=OFF, overrides=()), tmp_path)[0]
    assert np.array_equal(between.y, plane.y)
    assert off(on, plane) > 2


def test_it_moves_with_the_centering_and_with_a_correction_by_hand(edl, tmp_path):
    centred = attrs.evolve(edl, look=attrs.evolve(ON, centering=True), centering=((0, 10.0, -8.0),))
    still = compose(edl, tmp_path)[0].y
    assert np.abs(compose(centred, tmp_path)[0].y[:-8, 10:].astype(int) - still[8:, :-10])[20:-20, 20:-20].max() <= 3
    matrix = ((1.0, 0.0, 10.0), (0.0, 1.0, -8.0), (0.0, 0.0, 1.0))
    by_hand = attrs.evolve(edl, corrections=(Correction(FrameRange(0, 6), "b", matrix),))
    moved = compose(by_hand, tmp_path)[0].y
    assert np.abs(moved[:-8, 10:].astype(int) - still[8:, :-10])[20:-20, 20:-20].mean() < 1.5


def test_frames_of_a_moving_centering_are_as_each_would_be_alone(edl, tmp_path):
    look = attrs.evolve(ON, centering=True, fill=True)
    edl = attrs.evolve(edl, look=look, centering=((0, 0.0, 0.0), (5, 7.5, -4.0)))
    together = compose(edl, tmp_path)
    for frame in (1, 4):
        alone = compose(edl, tmp_path, FrameRange(frame, frame + 1))[0]
        assert np.array_equal(alone.y, together[frame].y)


def test_what_fills_comes_by_the_relief_too(tmp_path, edl):
    """The front picture is cut off in the middle of the hill: what continues it meets it there."""
    b = scene.picture_of(planes_to_bgr(compose(attrs.evolve(edl, shots=(Shot(FrameRange(0, 6), "a"),)), tmp_path)[0]))
    narrow = camera(tmp_path, "b_narrow", np.ascontiguousarray(b[:, : SIZE[0] // 2]))
    cut = attrs.evolve(edl, cameras=(edl.cameras[0], narrow), look=attrs.evolve(ON, fill=True))
    reference = compose(attrs.evolve(edl, shots=(Shot(FrameRange(0, 6), "a"),)), tmp_path)[0]
    assert off(compose(cut, tmp_path)[0], reference) < 4
