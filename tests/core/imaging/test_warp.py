"""What one resampling does to colours and sharpness, against scenes that are formulas: sampled anywhere, exactly."""

from fractions import Fraction

import av
import cv2
import numpy as np
import pytest

from mcsl_core.compositing.compositor import Compositor
from mcsl_core.delivery.conform import conform
from mcsl_core.delivery.quality import Quality
from mcsl_core.delivery.source import ProgrammeSource
from mcsl_core.edl import Camera, Edl, Look, Media, Pose, Shot
from mcsl_core.imaging.planes import Planes, bgr_to_planes
from mcsl_core.imaging.rect import Rect
from mcsl_core.imaging.warp import warp_planes
from mcsl_core.media.writing import Encoding, VideoWriter
from mcsl_core.recording.footage import Footage
from mcsl_core.timing import FrameRange

SIZE = (192, 128)
RATE = Fraction(30)
EYE = ((1.0, 0, 0), (0, 1.0, 0), (0, 0, 1.0))
LOSSLESS = Encoding(options={"preset": "ultrafast", "qp": "0"})
TILTED = np.array([[0.94, -0.2, 18.0], [0.17, 0.9, -6.0], [3e-4, -2e-4, 1.0]])
WHOLE = Rect(0, 0, *SIZE)


def moved(dx, dy):
    return np.array([[1, 0, dx], [0, 1, dy], [0, 0, 1]], float)


def at(x, y):
    """Y', Cb, Cr of the scene at luma coordinates: green above a slanting edge, red below it."""
    part = 1 / (1 + np.exp(-(x - 96 + 0.4 * (y - 64)) / 2.5))
    return [a + (b - a) * part for a, b in ((150, 70), (70, 110), (60, 200))]


def sampled(matrix=None):
    """The scene's planes, (H, W) and (H/2, W/2) float: each sample where MPEG-2 siting has it, seen through matrix."""
    inverse = np.linalg.inv(np.eye(3) if matrix is None else matrix)
    planes = []
    for index, (step, down) in enumerate(((1, 0.0), (2, 0.5), (2, 0.5))):
        x, y = np.meshgrid(np.arange(0, SIZE[0], step), np.arange(0, SIZE[1], step) + down)
        u, v, w = np.tensordot(inverse, np.stack([x, y, np.ones_like(x)]), 1)
        planes.append(at(u / w, v / w)[index])
    return planes


def coded(planes):
    return Planes(*(np.round(plane).astype(np.uint8) for plane in planes))


@pytest.mark.parametrize("resampling", ["linear", "lanczos"])
@pytest.mark.parametrize(
    "matrix",
    [
        moved(0.5, 0),
        moved(0, 0.5),
        moved(1, 0),
        moved(0, -1),
        moved(-3.3, 7.7),
        TILTED,
        moved(191, 0) @ np.diag([-1.0, 1, 1]),
    ],
)
def test_colours_stay_on_their_edge(matrix, resampling):
    found = warp_planes(coded(sampled()), matrix, WHOLE, resampling)
    inside = warp_planes(Planes(*(np.full_like(p, 200) for p in found)), matrix, WHOLE).u > 199
    inside = cv2.erode(inside.astype(np.uint8), np.ones((9, 9)), borderValue=0) != 0
    for plane, wanted in zip(found, sampled(matrix), strict=True):
        mask = inside if plane.shape == inside.shape else np.repeat(np.repeat(inside, 2, axis=0), 2, axis=1)
        error = (plane - wanted)[mask]
        assert mask.mean() > 0.3
        # Rounded twice; a bend of the edge between samples adds 1.5 codes at most to linear interpolation. Chroma half
        # a luma pixel off would be 7 codes off at the edge.
        assert np.abs(error).max() < 2.6
        assert abs(error.mean()) < 0.1


def test_that_oracle_sees_half_a_pixel():
    shifted = sampled(moved(0.5, 0))[2] - sampled()[2]
    assert np.abs(shifted).max() > 6


def test_moving_by_whole_pixels_changes_no_bit():
    rng = np.random.default_rng(2)
    for _ in range(60):
        width, height = 2 * rng.integers(1, 12, 2)
        planes = Planes(
            rng.integers(0, 256, (height, width), dtype=np.uint8),
            *(rng.integers(0, 256, (height // 2, width // 2), dtype=np.uint8) for _ in range(2)),
        )
        dx, dy = 2 * rng.integers(-8, 9, 2)
        x, y, w, h = 2 * rng.integers([-4, -4, 1, 1], [8, 8, 12, 12])
        found = warp_planes(planes, moved(dx, dy), Rect(int(x), int(y), int(w), int(h)))
        for index, (plane, got) in enumerate(zip(planes, found, strict=True)):
            n = 2 if index else 1
            far = np.full((200 // n, 200 // n), 128 if index else 16, np.uint8)
            top, left = (80 + dy) // n, (80 + dx) // n
            far[top : top + plane.shape[0], left : left + plane.shape[1]] = plane
            assert np.array_equal(got, far[(80 + y) // n : (80 + y + h) // n, (80 + x) // n : (80 + x + w) // n])


def programme(folder, pictures, **changes):
    with VideoWriter(folder / "a.mp4", size=SIZE, rate=RATE, encoding=LOSSLESS) as writer:
        for picture in pictures:
            writer.write(picture)
    piece = FrameRange(0, len(pictures))
    values = {
        "rate": RATE,
        "size": SIZE,
        "frames": len(pictures),
        "reference": "a",
        "cameras": (Camera("a", (Media("a.mp4", len(pictures)),), SIZE, RATE),),
        "poses": (Pose(piece, {"a": EYE}),),
        "shots": (Shot(piece, "a"),),
        "look": Look(centering=True, fill=False, colour=False),
        **changes,
    }
    return Edl(**values)


def shown(edl, base):
    with Compositor(edl, Footage(edl.cameras, rate=RATE, frames=edl.frames, base=base)) as compositor:
        return list(compositor.frames(FrameRange(0, edl.frames)))


def test_a_lossless_conform_holds_the_cameras_bits(tmp_path):
    """All codes of limited range, and what cameras write beyond it."""
    rng = np.random.default_rng(3)
    pictures = [
        Planes(*(rng.integers(1, 255, shape, dtype=np.uint8) for shape in ((128, 192), (64, 96), (64, 96))))
        for _ in range(4)
    ]
    edl = programme(tmp_path, pictures, look=Look(False, False, False))
    done = conform(ProgrammeSource(edl, tmp_path), tmp_path / "out", quality=Quality("lossless", LOSSLESS, 30))
    with av.open(str(done.path(done.chunks[0]))) as container:
        frames = list(container.decode(video=0))
    assert [(f.colorspace, f.color_range, f.format.name) for f in frames] == [(1, 1, "yuv420p")] * 4
    for frame, planes in zip(frames, pictures, strict=True):
        expected = np.concatenate([plane.ravel() for plane in planes])
        assert np.array_equal(frame.to_ndarray().ravel(), expected)


def test_a_pan_shifts_no_colour(tmp_path):
    """A patch of texture on grey, inside the frame all along: what it adds up to must not change by resampling."""
    rng = np.random.default_rng(4)
    picture = np.full((SIZE[1], SIZE[0], 3), 110, np.uint8)
    picture[48:80, 64:128] = rng.integers(30, 220, (32, 64, 3))
    planes = bgr_to_planes(picture)
    edl = programme(tmp_path, [planes] * 25, centering=((0, 0.0, 0.0), (24, 17.0, -9.4)))
    inner = [(slice(20, -20), slice(24, -24)), *[(slice(10, -10), slice(12, -12))] * 2]
    for pan in shown(edl, tmp_path):
        for plane, source, part in zip(pan, planes, inner, strict=True):
            assert abs(plane[part].mean() - source[part].mean()) < 0.1


def test_what_the_anchor_pushes_out_of_the_frame_comes_back_with_the_centering(tmp_path):
    source = coded(sampled())
    pose = Pose(FrameRange(0, 2), {"a": EYE}, anchor=((1.0, 0, -150.0), (0, 1.0, 40.0), (0, 0, 1.0)))
    edl = programme(tmp_path, [source] * 2, poses=(pose,), centering=((0, 150.0, -40.0),))
    for plane, original in zip(shown(edl, tmp_path)[1], source, strict=True):
        assert np.array_equal(plane, original)  # resampled not even once
    half = Pose(FrameRange(0, 2), {"a": EYE}, anchor=((1.0, 0, -150.3), (0, 1.0, 40.0), (0, 0, 1.0)))
    edl = programme(tmp_path, [source] * 2, poses=(half,), centering=((0, 145.9, -44.4),))
    found = shown(edl, tmp_path)[1]
    for plane, wanted in zip(found, sampled(moved(-4.4, -4.4)), strict=True):
        assert np.abs(plane - wanted)[3:-6, 3:-6].max() < 2.6  # and once only: twice would blur the edge


def test_lanczos_is_sharper_than_linear():
    """Lines of 3 pixels, moved by half a pixel, where interpolation has to guess most."""
    x = np.arange(SIZE[0])
    y = np.repeat((120 + 80 * np.cos(2 * np.pi * x / 3.0))[None], SIZE[1], axis=0).round().astype(np.uint8)
    grey = np.full((SIZE[1] // 2, SIZE[0] // 2), 128, np.uint8)
    wanted = 120 + 80 * np.cos(2 * np.pi * (x - 0.5) / 3.0)
    kept, errors = {}, {}
    for resampling in ("linear", "lanczos"):
        row = warp_planes(Planes(y, grey, grey), moved(0.5, 0), WHOLE, resampling).y[64, 16:-16].astype(float)
        kept[resampling] = row.std() / wanted[16:-16].std()
        errors[resampling] = np.abs(row - wanted[16:-16]).max()
    assert kept["linear"] == pytest.approx(np.cos(np.pi / 3), abs=0.02)  # the theory of linear interpolation
    assert kept["lanczos"] > 0.9
    assert errors["lanczos"] < errors["linear"] / 4


def test_lanczos_rings_to_nothing_outside_limited_range():
    planes = [np.full(shape, low, np.uint8) for shape, low in (((128, 192), 16), ((64, 96), 16), ((64, 96), 16))]
    for plane, high in zip(planes, (235, 240, 240), strict=True):
        plane[:, plane.shape[1] // 2 :] = high
    found = warp_planes(Planes(*planes), moved(0.5, 0.25), WHOLE, "lanczos")
    for plane, high in zip(found, (235, 240, 240), strict=True):
        assert plane.min() >= 16
        assert plane.max() <= high
    raw = cv2.warpPerspective(planes[0], moved(0.5, 0.25), SIZE, flags=cv2.INTER_LANCZOS4)
    assert raw.max() > 240  # it would have
    planes[0][20:40, 20:40] = 250  # whiter than white, as cameras write highlights: kept
    assert 245 <= warp_planes(Planes(*planes), moved(0.5, 0.25), WHOLE, "lanczos").y[25:35, 25:35].min() <= 250


class Counting(Footage):
    """Tells whose decoders were opened, and how often each was asked."""

    def __init__(self, *arguments, **options):
        super().__init__(*arguments, **options)
        self.played = []

    def player(self, camera):
        self.played.append(camera)
        return super().player(camera)


def test_a_steady_second_decodes_two_cameras(tmp_path):
    """Five cameras, none of which covers the frame, fill on: the shot's and the reference play, the others do not."""
    names = ("a", "b", "c", "d", "e")
    rng = np.random.default_rng(5)
    cameras = []
    for name in names:
        picture = rng.integers(30, 220, (SIZE[1], SIZE[0], 3), dtype=np.uint8)
        with VideoWriter(tmp_path / f"{name}.mp4", size=SIZE, rate=RATE, keyframe_interval=5) as writer:
            for _ in range(30):
                writer.write(picture)
        cameras.append(Camera(name, (Media(f"{name}.mp4", 30),), SIZE, RATE))
    places = {name: ((0.8, 0, 20.0 * i), (0, 0.8, 12.0 * i), (0, 0, 1.0)) for i, name in enumerate(names)}
    places |= {"a": EYE, "b": ((1.0, 0, -40.0), (0, 1.0, -20.0), (0, 0, 1.0))}
    piece = FrameRange(0, 30)
    edl = Edl(
        rate=RATE,
        size=SIZE,
        frames=30,
        reference="a",
        cameras=tuple(cameras),
        poses=(Pose(piece, places, anchor=((1.0, 0, 10.0), (0, 1.0, 6.0), (0, 0, 1.0))),),
        shots=(Shot(piece, "c"),),
        look=Look(centering=False, fill=True, colour=False),
    )
    footage = Counting(edl.cameras, rate=RATE, frames=30, base=tmp_path)
    with Compositor(edl, footage) as compositor:
        frames = list(compositor.frames(piece))
    assert sorted(footage.played) == ["a", "c"]
    assert np.mean(frames[15].y[:80, :8] > 16) > 0.9  # though left of the reference something was filled in
