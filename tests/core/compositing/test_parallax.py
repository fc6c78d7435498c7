"""Bending parallax out of pictures: the resampling against a plain warp, the flow against bends that are known."""

from fractions import Fraction

import cv2
import numpy as np
import pytest
from pictures import psnr

from mcsl_core.compositing.compositor import Compositor
from mcsl_core.compositing.parallax import residual_parallax
from mcsl_core.edl import Camera, Edl, Look, Media, Pose, Shot
from mcsl_core.filling.footprint import FootprintFiller
from mcsl_core.imaging.geometry import translation
from mcsl_core.imaging.planes import bgr_to_planes, planes_to_bgr
from mcsl_core.imaging.rect import Rect
from mcsl_core.imaging.warp import (
    WarpField,
    footprint,
    remap_planes,
    warp_field_footprint,
    warp_field_maps,
    warp_planes,
    warp_planes_by_field,
)
from mcsl_core.media.writing import Encoding, VideoWriter
from mcsl_core.recording.footage import Footage
from mcsl_core.timing import FrameRange

SIZE = (480, 270)
RATE = Fraction(10)
EYE = ((1.0, 0, 0), (0, 1.0, 0), (0, 0, 1.0))
TILTED = np.array([[0.94, -0.2, 18.0], [0.17, 0.9, -6.0], [6e-5, -4e-5, 1.0]])


def texture(seed, size=SIZE, fine=1.5):
    rng = np.random.default_rng(seed)
    made = sum(
        cv2.GaussianBlur(rng.normal(0, 1, (*size[::-1], 3)), (0, 0), fine * 3**k) * 3**k * (0.5 + k) for k in range(3)
    )
    return np.clip(128 + 60 * made / np.std(made), 25, 235).astype(np.uint8)


def level(x, y):
    return WarpField(np.full((20, 30, 2), (x, y), np.float32), (-120.0, -80.0), 24.0)


@pytest.mark.parametrize("rect", [Rect(0, 0, *SIZE), Rect(100, 42, 202, 66), Rect(-16, -8, 64, 32)])
@pytest.mark.parametrize("shift", [(0.0, 0.0), (4.5, -3.25)])
def test_a_bend_that_is_a_shift_is_a_warp(rect, shift):
    planes = bgr_to_planes(texture(1))
    offset = (3.25, -7.5)
    maps = warp_field_maps(TILTED, level(*shift), rect, offset)
    found = remap_planes(planes, maps)
    expected = warp_planes(planes, translation(offset[0] - shift[0], offset[1] - shift[1]) @ TILTED, rect)
    for a, b in zip(found, expected, strict=True):
        assert np.abs(a.astype(int) - b).max() <= 2  # what resamples at 1/32 pixel rounds otherwise
        assert np.abs(a.astype(int) - b).mean() < 0.25


@pytest.mark.parametrize("rect", [Rect(0, 0, *SIZE), Rect(100, 42, 202, 66), Rect(-16, -8, 64, 302), Rect(6, 4, 8, 2)])
@pytest.mark.parametrize("resampling", ["linear", "lanczos"])
def test_in_bands_or_through_whole_tables_a_picture_is_the_same(rect, resampling):
    planes, offset = bgr_to_planes(texture(1)), (3.25, -7.5)
    waves = WarpField(4 * np.sin(np.indices((20, 30)).transpose(1, 2, 0)).astype(np.float32), (-120.0, -80.0), 24.0)
    expected = remap_planes(planes, warp_field_maps(TILTED, waves, rect, offset), resampling)
    found = warp_planes_by_field(planes, TILTED, waves, rect, offset, resampling)
    for a, b in zip(found, expected, strict=True):
        assert a.shape == b.shape
        assert np.abs(a.astype(int) - b).max() <= 1
        assert (a != b).mean() < 0.01


def test_footprints_bend_along():
    found = warp_field_footprint(SIZE, TILTED, level(6, 4), SIZE)
    assert np.abs(found.astype(int) - footprint(SIZE, translation(-6, -4) @ TILTED, SIZE)).max() <= 8


def test_a_taper_bends_where_the_camera_does_not_see_and_fades_inside():
    warp_field = WarpField(np.full((60, 90, 2), 8, np.float32), (-120.0, -75.0), 8.0)
    tapered = warp_field.tapered((240, 200), np.eye(3), 48.0)
    x, y = np.meshgrid(np.array([-40.0, 4, 24, 40, 60, 120], np.float32), np.array([100.0], np.float32))
    at = tapered.at(x, y)[0, :, 0]
    assert at[0] == 8
    assert 6.5 < at[1] < 8
    assert 2 < at[2] < 6
    assert at[4] == at[5] == 0
    assert (np.diff(at) <= 0).all()


def known(size=SIZE):
    """Where a picture has what the guide has: up to 11 pixels away, smoothly."""
    y, x = np.mgrid[0 : size[1], 0 : size[0]].astype(np.float32)
    return np.stack([9 * np.sin(x / 90) + 2, 6 * np.cos(y / 70 + x / 200)], axis=-1).astype(np.float32)


def bent_away(guide, way):
    """A picture in which guide's pixel p lies at p + way(p): the inverse of what is to be found, by iteration."""
    y, x = np.mgrid[0 : guide.shape[0], 0 : guide.shape[1]].astype(np.float32)
    back = np.zeros_like(way)
    for _ in range(30):
        back = -cv2.remap(way, x + back[..., 0], y + back[..., 1], cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    return cv2.remap(guide, x + back[..., 0], y + back[..., 1], cv2.INTER_CUBIC, borderMode=cv2.BORDER_REFLECT)


def luma(picture):
    return bgr_to_planes(picture).y


@pytest.mark.parametrize("seed", range(3))
def test_a_known_bend_is_found_and_goes_on_beyond_the_overlap(seed):
    way, guide = known(), luma(texture(seed))
    picture = np.clip(0.8 * bent_away(guide, way) + 25, 0, 255).astype(np.uint8)  # another camera's exposure
    seen, whole = np.zeros_like(guide), np.full_like(guide, 255)
    seen[:, 80:] = 255
    hidden = np.where(seen > 0, picture, 16).astype(np.uint8)
    found = residual_parallax(guide, whole, hidden, seen, 5.0)
    assert found is not None
    error = np.hypot(*np.moveaxis(found - way, 2, 0))
    inside = error[24:-24, 110:-24]
    assert np.median(inside) < 0.5
    assert np.percentile(inside, 95) < 2
    assert np.abs(found[24:-24, 76] - found[24:-24, 100]).max() < 4
    assert np.abs(found).max() < 16


@pytest.mark.parametrize("fine", [1.5, 4.0])
def test_pictures_of_different_things_are_not_bent_into_each_other(fine):
    whole = np.full(SIZE[::-1], 255, np.uint8)
    for seed in range(4):
        a, b = (luma(texture(seed + 50 * k, fine=fine)) for k in (0, 1))
        assert residual_parallax(a, whole, b, whole, 5.0) is None


def test_pictures_that_share_nothing_are_left_alone():
    a = luma(texture(1))
    left, right = np.zeros_like(a), np.zeros_like(a)
    left[:, :200], right[:, 220:] = 255, 255
    assert residual_parallax(a, left, a, right, 5.0) is None


def test_one_picture_is_not_bent():
    a = luma(texture(2))
    whole = np.full_like(a, 255)
    found = residual_parallax(a, whole, a, whole, 5.0)
    assert found is None or np.abs(found).max() < 0.05


# ------------------------------------------------------------------------------------------------- in the programme


WIDE = (720, 270)


def film(folder, name, shown):
    size = (shown.shape[1], shown.shape[0])
    lossy = Encoding(options={"qp": "4"})
    with VideoWriter(folder / f"{name}.mp4", size=size, rate=RATE, encoding=lossy, keyframe_interval=5) as writer:
        for _ in range(40):
            writer.write(shown)
    return Camera(name, (Media(f"{name}.mp4", 40),), size, RATE)


@pytest.fixture(scope="module")
def relief(tmp_path_factory):
    """a, the reference, sees the middle of a wide picture. All of it, displaced, is seen by c, its right part by b."""
    folder = tmp_path_factory.mktemp("displaced")
    picture = texture(7, WIDE)
    displaced = cv2.merge([bent_away(plane, known(WIDE)) for plane in cv2.split(picture)])
    shown = {"a": picture[:, 120:600], "b": displaced[:, 280:600], "c": displaced}
    return folder, picture, displaced, tuple(film(folder, name, part) for name, part in shown.items())


def programme(cameras, shot, shift=0.0):
    places = {"a": EYE, "b": ((1.0, 0, 160.0), *EYE[1:]), "c": ((1.0, 0, -120.0), *EYE[1:])}
    return Edl(
        rate=RATE,
        size=SIZE,
        frames=40,
        reference="a",
        cameras=cameras,
        poses=(Pose(FrameRange(0, 40), places),),
        shots=(Shot(FrameRange(0, 40), shot),),
        look=Look(centering=True, fill=True, colour=False),
        centering=((0, shift, 0.0),),
    )


def frame_of(edl, folder, **options):
    footage = Footage(edl.cameras, rate=edl.rate, frames=edl.frames, base=folder)
    with Compositor(edl, footage, **options) as compositor:
        return next(iter(compositor.frames(FrameRange(20, 21))))


def test_what_another_camera_fills_lies_where_the_reference_would_have_it(relief):
    folder, picture, displaced, cameras = relief
    made = planes_to_bgr(frame_of(programme(cameras, "a", shift=60.0), folder))
    right, warped = picture[:, 60:540], displaced[:, 60:540]
    assert psnr(made[:, 80:], right[:, 80:]) > 35  # the reference's own
    beyond = slice(36, 56)
    assert psnr(made[:, beyond], right[:, beyond]) > psnr(warped[:, beyond], right[:, beyond]) + 4


def test_the_chosen_cameras_edge_bends_over_into_the_reference_and_its_middle_is_left_alone(relief):
    folder, picture, displaced, cameras = relief
    made = planes_to_bgr(frame_of(programme(cameras, "b"), folder))
    right, warped = picture[:, 120:600], displaced[:, 120:600]
    assert psnr(made[:, :150], right[:, :150]) > 35
    edge, middle = slice(172, 180), slice(220, 440)
    assert psnr(made[:, edge], right[:, edge]) > psnr(warped[:, edge], right[:, edge]) + 3
    assert psnr(made[40:-40, middle], warped[40:-40, middle]) > 33


def test_a_picture_that_leaves_nothing_open_is_left_as_it_is(relief):
    folder, _, displaced, cameras = relief
    made = planes_to_bgr(frame_of(programme(cameras, "c"), folder))
    assert psnr(made, displaced[:, 120:600]) > 35


def test_a_frame_is_the_same_whether_made_alone_or_in_a_run(relief):
    folder, _, _, cameras = relief
    edl = programme(cameras, "b", shift=30.0)
    footage = Footage(edl.cameras, rate=edl.rate, frames=edl.frames, base=folder)
    with Compositor(edl, footage) as compositor:
        run = list(compositor.frames(FrameRange(15, 25)))
    alone = frame_of(edl, folder, filler=FootprintFiller())
    for a, b in zip(run[5], alone, strict=True):
        assert np.array_equal(a, b)


# ------------------------------------------------------------------------------------------------------------ medians


@pytest.fixture(scope="module")
def rising(tmp_path_factory):
    """40 frames, each 5 codes brighter than the one before, a keyframe at every fifth; no picture from 30 to 33."""
    folder = tmp_path_factory.mktemp("rising")
    lossless = Encoding(options={"preset": "ultrafast", "qp": "0"})
    with VideoWriter(folder / "a.mp4", size=(64, 48), rate=RATE, encoding=lossless, keyframe_interval=5) as writer:
        for n in range(40):
            writer.write(np.full((48, 64, 3), 20 + 5 * n, np.uint8))
    camera = Camera("a", (Media("a.mp4", 40),), (64, 48), RATE, gaps=(FrameRange(30, 34),))
    return Footage((camera,), rate=RATE, frames=40, base=folder)


def number(planes):
    return round((float(planes_to_bgr(planes).mean()) - 20) / 5)


@pytest.mark.parametrize(
    ("frames", "within", "shown"),
    [
        ((7,), FrameRange(0, 40), 7),  # one alone is that frame
        ((2, 12, 23), FrameRange(0, 40), 10),  # of keyframes 0, 10, 25
        ((12, 22, 27), FrameRange(11, 30), 20),  # of 12 itself, since 10 lies outside, 20 and 25
        ((12, 13, 14), FrameRange(0, 40), 13),  # none is near enough
        ((6, 16, 31), FrameRange(0, 40), 5),  # where there is no picture is none; of two the lower
    ],
)
def test_medians_take_keyframes_near_by_and_only_of_the_stretch(rising, frames, within, shown):
    assert number(rising.median("a", frames, within)) == shown


def test_a_median_of_nothing_is_nothing_and_one_is_made_once(rising):
    assert rising.median("a", (31, 32), FrameRange(0, 40)) is None
    whole = FrameRange(0, 40)
    assert rising.median("a", (1, 9, 17), whole) is rising.median("a", (1, 9, 17), whole)
