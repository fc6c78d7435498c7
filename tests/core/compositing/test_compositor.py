"""Programme frames against an oracle that resamples one pixel at a time in float64, sharing no code with them."""

import weakref
from fractions import Fraction

import attrs
import cv2
import numpy as np
import pytest
from cycles import left_in_cycles
from pictures import psnr

from mcsl_core.alignment.colour_match import as_matrix
from mcsl_core.compositing.compositor import Compositor
from mcsl_core.compositing.placement import programme_matrix
from mcsl_core.edl import Camera, Edl, Look, Media, Override, Pose, Shot, Weak
from mcsl_core.edl.placement import fit_matrix
from mcsl_core.errors import DocumentError
from mcsl_core.filling.footprint import FootprintFiller
from mcsl_core.filling.paper import PaperFiller
from mcsl_core.imaging.planes import Planes, bgr_to_planes
from mcsl_core.imaging.rect import Rect
from mcsl_core.imaging.warp import warp_planes
from mcsl_core.media.writing import Encoding, VideoWriter
from mcsl_core.recording.footage import Footage
from mcsl_core.timing import FrameRange

SIZE = (192, 128)
RATE = Fraction(30)
LOSSLESS = Encoding(options={"preset": "ultrafast", "qp": "0"})
TILTED = ((0.94, -0.2, 18.0), (0.17, 0.9, -6.0), (3e-4, -2e-4, 1.0))
BLACKS = (16, 128, 128)


def texture(seed, size=SIZE, dark=40):
    rng = np.random.default_rng(seed)
    coarse = rng.integers(dark, 230, (size[1] // 8, size[0] // 8, 3), dtype=np.uint8)
    return cv2.resize(coarse, size, interpolation=cv2.INTER_CUBIC).clip(dark, 240).astype(np.uint8)


def film(path, pictures, size=SIZE):
    with VideoWriter(path, size=size, rate=RATE, encoding=LOSSLESS, keyframe_interval=5) as writer:
        for picture in pictures:
            writer.write(picture)
    return Media(path.name, len(pictures))


def make(tmp_path, *, frames=6, cameras=None, **changes):
    """Three cameras of different still textures; the second tilted, the third weak unless told otherwise."""
    media = cameras or {n: [texture(i)] * frames for i, n in enumerate(("a", "b", "c"))}
    made = tuple(
        Camera(name=n, media=(film(tmp_path / f"{n}.mp4", p, p[0].shape[1::-1]),), size=p[0].shape[1::-1], rate=RATE)
        for n, p in media.items()
    )
    values = {
        "rate": RATE,
        "size": SIZE,
        "frames": frames,
        "reference": "a",
        "cameras": made,
        "poses": (
            Pose(
                range=FrameRange(0, frames),
                homographies={"a": ((1, 0, 0), (0, 1, 0), (0, 0, 1)), "b": TILTED},
                weak=(Weak("c", "nothing matches"),),
            ),
        ),
        "shots": (Shot(FrameRange(0, frames), "a"),),
        "look": Look(centering=False, fill=False, colour=False),
        **changes,
    }
    return Edl(**values)


def compose(edl, base, piece=None, **options):
    footage = Footage(edl.cameras, rate=edl.rate, frames=edl.frames, base=base)
    with Compositor(edl, footage, **options) as compositor:
        return list(compositor.frames(piece or FrameRange(0, edl.frames)))


def oracle(plane, matrix, size, edge, *, chroma):
    """Bilinear, pixel by pixel, in luma coordinates: chroma (i, j) lies at luma (2i, 2j + 0.5)."""
    out = np.zeros((size[1], size[0]))
    inverse = np.linalg.inv(matrix)
    height, width = plane.shape
    padded = np.full((height + 2, width + 2), edge, float)
    padded[1:-1, 1:-1] = plane
    for j in range(size[1]):
        for i in range(size[0]):
            x, y = (2 * i, 2 * j + 0.5) if chroma else (i, j)
            u, v, w = inverse @ (x, y, 1)
            u, v = u / w, v / w
            if chroma:
                u, v = u / 2, (v - 0.5) / 2
            u, v = min(max(u, -1), width), min(max(v, -1), height)
            left, top = min(int(np.floor(u)), width - 1), min(int(np.floor(v)), height - 1)
            fu, fv = u - left, v - top
            cell = padded[top + 1 : top + 3, left + 1 : left + 3]
            out[j, i] = (cell * np.outer([1 - fv, fv], [1 - fu, fu])).sum()
    return out


def assert_same(found: Planes, expected: Planes):
    for a, b in zip(found, expected, strict=True):
        assert np.array_equal(a, b)


@pytest.mark.parametrize("size", [(191, 128), (192, 127), (1, 1)])
def test_an_odd_programme_is_refused_in_words(tmp_path, size):
    """From an EDL written by hand; it was an internal error."""
    edl = make(tmp_path)
    with pytest.raises(DocumentError, match=f"size of the EDL: is {size[0]}x{size[1]}; a programme's size is even"):
        compose(attrs.evolve(edl, size=size), tmp_path)


def test_the_reference_passes_bit_for_bit(tmp_path):
    edl = make(tmp_path)
    for planes in compose(edl, tmp_path):
        assert_same(planes, bgr_to_planes(texture(0)))
    planes = bgr_to_planes(texture(0))
    assert warp_planes(planes, np.eye(3) * 2, Rect(0, 0, *SIZE)) is planes  # not resampled by luck


@pytest.mark.parametrize(
    "matrix", [TILTED, ((0, -1, 150.0), (1, 0, -20.0), (0, 0, 1)), ((1, 0, 3.0), (0, 1, -5.0), (0, 0, 1))]
)
def test_each_plane_is_resampled_where_it_lies(matrix):
    source = bgr_to_planes(texture(3))
    found = warp_planes(source, np.array(matrix, float), Rect(0, 0, *SIZE))
    half = (SIZE[0] // 2, SIZE[1] // 2)
    for index, (plane, size) in enumerate(zip(source, (SIZE, half, half), strict=True)):
        expected = oracle(plane, np.array(matrix, float), size, BLACKS[index], chroma=index > 0)
        error = np.abs(tuple(found)[index] - expected)
        # Rounding is 0.5. OpenCV 4 resamples at 1/32 pixel: 1/64 of the contrast between neighbours (up to 60 here).
        assert error.mean() < 0.5
        assert np.percentile(error, 99.5) < 2.5


def test_a_part_is_the_same_as_the_part_of_the_whole():
    source = bgr_to_planes(texture(3))
    whole = warp_planes(source, np.array(TILTED), Rect(0, 0, *SIZE))
    part = Rect(32, 20, 64, 50)
    for a, b in zip(warp_planes(source, np.array(TILTED), part), part.of(whole), strict=True):
        assert np.abs(a.astype(int) - b).max() <= 2


def test_matrix_is_offset_after_anchor_after_homography(tmp_path):
    pose = Pose(
        FrameRange(0, 6),
        {"a": ((1, 0, 0), (0, 1, 0), (0, 0, 1)), "b": TILTED},
        anchor=((1.1, 0, 4), (0, 0.9, 2), (0, 0, 1)),
        weak=(Weak("c", ""),),
    )
    edl = make(tmp_path, poses=(pose,))
    point = np.array([40.0, 70.0, 1])
    moved = np.array(TILTED) @ point
    moved = moved / moved[2]
    expected = (1.1 * moved[0] + 4 + 7.5, 0.9 * moved[1] + 2 - 3)
    found = programme_matrix(edl, pose, "b", (7.5, -3.0)) @ point
    assert found[:2] / found[2] == pytest.approx(expected)


def test_decisions_come_from_resolve_and_centering_moves_the_picture(tmp_path):
    edl = make(
        tmp_path,
        frames=12,
        shots=(Shot(FrameRange(0, 4), "a"), Shot(FrameRange(4, 12), "b")),
        overrides=(Override(FrameRange(6, 8), camera="a"), Override(FrameRange(7, 9), centering=True)),
        centering=((0, 10.0, 4.0),),
    )
    got = compose(edl, tmp_path)
    a, b = bgr_to_planes(texture(0)), bgr_to_planes(texture(1))
    whole = Rect(0, 0, *SIZE)
    tilted, shift = np.array(TILTED), np.array([[1, 0, 10.0], [0, 1, 4.0], [0, 0, 1]])
    expected = [a] * 4 + [warp_planes(b, tilted, whole)] * 2 + [a, warp_planes(a, shift, whole)]
    expected += [warp_planes(b, shift @ tilted, whole)] + [warp_planes(b, tilted, whole)] * 3
    for found, wanted in zip(got, expected, strict=True):
        assert_same(found, wanted)
    later = compose(edl, tmp_path, FrameRange(5, 9))
    for found, wanted in zip(later, expected[5:9], strict=True):
        assert_same(found, wanted)


def test_a_weak_camera_an_editor_chose_fills_the_frame(tmp_path):
    small = texture(7, (96, 64))
    edl = make(
        tmp_path,
        cameras={"a": [texture(0)] * 3, "b": [texture(1)] * 3, "c": [small] * 3},
        frames=3,
        overrides=(Override(FrameRange(0, 3), camera="c"),),
        look=Look(centering=True, fill=True),
        centering=((0, 50.0, 0.0),),
    )
    planes = compose(edl, tmp_path)[0]
    expected = cv2.resize(bgr_to_planes(small).y, SIZE, interpolation=cv2.INTER_LINEAR)
    assert psnr(planes.y[4:-4, 4:-4], expected[4:-4, 4:-4]) > 40
    corners = np.array(fit_matrix((96, 64), SIZE)) @ np.array([[-0.5, 95.5], [-0.5, 63.5], [1, 1]])
    assert corners[:2].T.tolist() == [[-0.5, -0.5], [191.5, 127.5]]


def test_without_picture_the_reference_stands_in_else_black(tmp_path):
    edl = make(tmp_path, frames=9, cameras={"a": [texture(0)] * 6, "b": [texture(1)] * 3, "c": [texture(2)] * 3})
    edl = attrs.evolve(edl, shots=(Shot(FrameRange(0, 9), "b"),))
    got = compose(edl, tmp_path)
    assert not np.array_equal(got[2].y, got[3].y)
    assert_same(got[4], bgr_to_planes(texture(0)))
    assert {int(v) for plane in got[8] for v in np.unique(plane)} == {16, 128}


def test_only_the_cameras_needed_are_opened(tmp_path):
    edl = make(tmp_path)
    (tmp_path / "b.mp4").unlink()
    (tmp_path / "c.mp4").unlink()
    assert len(compose(edl, tmp_path)) == 6
    filled = attrs.evolve(edl, look=Look(centering=False, fill=True, colour=True))
    assert len(compose(filled, tmp_path)) == 6  # the reference covers its own frame: nobody else is asked


def test_a_closed_compositor_holds_nothing(tmp_path):
    edl = make(tmp_path, shots=(Shot(FrameRange(0, 6), "b"),), look=Look(centering=False, fill=True, colour=False))
    held = []

    def run():
        footage = Footage(edl.cameras, rate=edl.rate, frames=edl.frames, base=tmp_path)
        with Compositor(edl, footage) as compositor:
            held.extend(map(weakref.ref, (compositor, compositor._warper, footage)))
            for _ in compositor.frames(FrameRange(0, 3)):
                pass
        del compositor, footage
        assert [one() for one in held] == [None] * 3

    assert left_in_cycles(run) == set()
    assert held


def test_fill_takes_the_reference_where_the_camera_does_not_reach(tmp_path):
    edl = make(tmp_path, shots=(Shot(FrameRange(0, 6), "b"),), look=Look(centering=False, fill=True, colour=False))
    filled = compose(edl, tmp_path)[0]
    bare = compose(edl, tmp_path, look=Look(False, False, False))[0]
    reference = bgr_to_planes(texture(0))
    ones = np.full((SIZE[1], SIZE[0]), 255, np.uint8)
    seen = cv2.warpPerspective(ones, np.array(TILTED), SIZE, flags=cv2.INTER_NEAREST)
    far_out = cv2.dilate(seen, np.ones((5, 5))) == 0
    far_in = cv2.erode(seen, np.ones((57, 57)), borderType=cv2.BORDER_REPLICATE) != 0
    assert far_out.mean() > 0.05
    assert far_in.mean() > 0.2
    assert np.array_equal(filled.y[far_out], reference.y[far_out])
    assert np.abs(filled.y[far_in].astype(int) - bare.y[far_in]).max() <= 1
    # Between, never darker or brighter than both.
    low, high = np.minimum(bare.y, reference.y).astype(int), np.maximum(bare.y, reference.y).astype(int)
    edge = (cv2.erode(seen, np.ones((5, 5)), borderType=cv2.BORDER_REPLICATE) != 0) & ~far_in
    assert ((filled.y[edge] >= low[edge] - 2) & (filled.y[edge] <= high[edge] + 2)).all()


def test_colour_matches_the_camera_before_the_fill(tmp_path):
    """Camera b shows the reference's picture in other colours; matched and warped straight back, no seam is left."""
    picture = texture(0, dark=60)
    dim = np.clip(picture.astype(float) * [0.8, 0.7, 0.9] + [5, 10, 0], 0, 255).astype(np.uint8)
    gains, offsets = 1 / np.array([0.8, 0.7, 0.9]), -np.array([5, 10, 0]) / np.array([0.8, 0.7, 0.9])
    pose = Pose(
        FrameRange(0, 2),
        {"a": ((1, 0, 0), (0, 1, 0), (0, 0, 1)), "b": ((1, 0, 30.0), (0, 1, 0), (0, 0, 1))},
        colour={"b": as_matrix(gains, offsets)},
        weak=(Weak("c", ""),),
    )
    shifted = np.roll(dim, -30, axis=1)
    edl = make(
        tmp_path,
        cameras={"a": [picture] * 2, "b": [shifted] * 2, "c": [picture] * 2},
        frames=2,
        poses=(pose,),
        shots=(Shot(FrameRange(0, 2), "b"),),
        look=Look(False, True, True),
    )
    planes = compose(edl, tmp_path)[0]
    assert psnr(planes.y, bgr_to_planes(picture).y) > 38
    assert psnr(planes.v, bgr_to_planes(picture).v) > 38
    plain = compose(edl, tmp_path, look=Look(False, True, False))[0]
    assert psnr(plain.y, bgr_to_planes(picture).y) < 25


@pytest.mark.parametrize("fill", [False, True])
def test_a_camera_that_drifts_looks_the_same_in_every_frame(tmp_path, fill):
    """Camera b grows darker and bluer, the reference brighter; the keys take both back, in the fill's medians too."""
    picture, frames = texture(0, dark=60) * 0.8, 8
    steps = {"a": np.array([0.03, 0.03, 0.03]), "b": np.array([0, -0.04, -0.05])}
    gains = {name: [1 + step * n for n in range(frames)] for name, step in steps.items()}
    keys = {name: tuple((n, *(1 / g[::-1]).tolist()) for n, g in enumerate(own)) for name, own in gains.items()}
    seen = {name: [np.clip(picture * g, 0, 255).astype(np.uint8) for g in own] for name, own in gains.items()}
    seen["b"] = [np.roll(shown, -30, axis=1) for shown in seen["b"]]
    homographies = {"a": ((1, 0, 0), (0, 1, 0), (0, 0, 1)), "b": ((1, 0, 30.0), (0, 1, 0), (0, 0, 1))}
    pose = Pose(FrameRange(0, frames), homographies, weak=(Weak("c", ""),), colour_keys=keys)
    shots = (Shot(FrameRange(0, 4), "b"), Shot(FrameRange(4, frames), "a"))
    cameras = {**seen, "c": seen["a"]}
    look = Look(False, fill, True)
    edl = make(tmp_path, cameras=cameras, frames=frames, poses=(pose,), shots=shots, look=look)
    wanted = bgr_to_planes(picture.astype(np.uint8))
    part = (slice(None), slice(0 if fill else 32, None))
    for planes in compose(edl, tmp_path):
        assert psnr(planes.y[part], wanted.y[part]) > 35
    plain = compose(edl, tmp_path, look=Look(False, fill, False))
    assert psnr(plain[3].y[part], wanted.y[part]) < 28


def test_the_papers_filler_keeps_the_past_where_nobody_sees(tmp_path):
    """The reference itself, shifted by the centering after some frames: what it lost comes from the frame before."""
    edl = make(
        tmp_path,
        frames=6,
        look=Look(centering=True, fill=True, colour=False),
        centering=((0, 0.0, 0.0), (2, 0.0, 0.0), (3, 24.0, 0.0)),
    )
    edl = attrs.evolve(
        edl,
        poses=(
            attrs.evolve(
                edl.poses[0], homographies={"a": ((1, 0, 0), (0, 1, 0), (0, 0, 1))}, weak=(Weak("b", ""), Weak("c", ""))
            ),
        ),
    )
    got = compose(edl, tmp_path, filler=PaperFiller())
    strip = [p.y[20:-20, 2:20].astype(float) for p in got]
    assert strip[3].mean() > 50  # not black
    assert np.abs(strip[3] - strip[2]).mean() < 12  # the same place a frame ago, blurred
    assert strip[5].std() < strip[3].std()  # and more so with age
    bare = compose(edl, tmp_path)
    assert bare[3].y[20:-20, 2:20].max() == 16
    again = compose(edl, tmp_path, FrameRange(4, 6), filler=PaperFiller())
    assert psnr(again[0].y, got[4].y) > 45  # a range made alone is the same


def test_one_filler_serves_programmes_of_different_geometry(tmp_path):
    """What it keeps goes by geometry, and equal numbers of pose and camera do not make that equal."""
    shots, look = (Shot(FrameRange(0, 6), "b"),), Look(centering=False, fill=True, colour=False)
    edl = make(tmp_path, shots=shots, look=look)
    away = ((1, 0, 60.0), (0, 1, 0), (0, 0, 1))
    other = attrs.evolve(
        edl, poses=(attrs.evolve(edl.poses[0], homographies={**edl.poses[0].homographies, "b": away}),)
    )
    filler = FootprintFiller()
    compose(edl, tmp_path, filler=filler)
    assert_same(compose(other, tmp_path, filler=filler)[0], compose(other, tmp_path)[0])


@pytest.mark.parametrize("filler", [FootprintFiller, PaperFiller])
def test_a_stretch_made_alone_is_the_same_bit_for_bit(tmp_path, monkeypatch, filler):
    """Frames of a run against the same frames made alone, across blocks, poses, centering and a gap."""
    monkeypatch.setattr("mcsl_core.compositing.compositor.BLOCK_S", 1)
    moving = [np.roll(texture(3), 5 * n, axis=1) for n in range(100)]
    eye = ((1, 0, 0), (0, 1, 0), (0, 0, 1))
    side, up = ((1, 0, 40.0), (0, 1, 9.0), (0, 0, 1)), ((1, 0, 0), (0, 1, -30.0), (0, 0, 1))
    edl = make(
        tmp_path,
        cameras={"a": [texture(0)] * 100, "b": moving, "c": moving[::-1]},
        frames=100,
        poses=(
            Pose(FrameRange(0, 52), {"a": eye, "b": side, "c": up}),
            Pose(FrameRange(52, 100), {"a": eye, "b": TILTED, "c": side}, anchor=((1, 0, 6.0), (0, 1, 0), (0, 0, 1))),
        ),
        shots=(Shot(FrameRange(0, 20), "b"), Shot(FrameRange(20, 70), "a"), Shot(FrameRange(70, 100), "b")),
        look=Look(True, True, False),
        centering=((0, 14.0, 4.0), (35, 14.0, 4.0), (65, -24.0, -8.0)),
    )
    edl = attrs.evolve(
        edl, cameras=(edl.cameras[0], edl.cameras[1], attrs.evolve(edl.cameras[2], gaps=(FrameRange(30, 34),)))
    )
    run = compose(edl, tmp_path, filler=filler())
    for piece in (FrameRange(31, 36), FrameRange(50, 64), FrameRange(90, 100)):
        for frame, alone in zip(piece, compose(edl, tmp_path, piece, filler=filler()), strict=True):
            assert_same(alone, run[frame])


class Remembering:
    """Notes at which frames there is one before."""

    name, version, remembers = "remembering", 1, True

    def __init__(self):
        self.had = {}

    def fill(self, view):
        self.had[view.frame] = view.previous is not None
        return view.front


@pytest.mark.parametrize(("perspective", "kept"), [(0, True), (1, False)])
def test_a_new_perspective_begins_without_the_frame_before(tmp_path, perspective, kept):
    known = {"a": ((1, 0, 0), (0, 1, 0), (0, 0, 1)), "b": TILTED}
    weak = (Weak("c", "nothing matches"),)
    poses = (
        Pose(FrameRange(0, 3), known, weak=weak),
        Pose(FrameRange(3, 6), known, weak=weak, perspective=perspective),
    )
    edl = make(tmp_path, poses=poses, look=Look(centering=False, fill=True, colour=False))
    filler = Remembering()
    compose(edl, tmp_path, filler=filler)
    assert filler.had == {0: False, 1: True, 2: True, 3: kept, 4: True, 5: True}
