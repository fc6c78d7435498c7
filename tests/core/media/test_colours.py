"""Colours come out as BT.709 whatever they were coded as; the oracle is the standards' formulas, written again here."""

from fractions import Fraction
from types import SimpleNamespace
from typing import Any

import av
import cv2
import numpy as np
import pytest
from coded_video import DATA

from mcsl_core.errors import MediaError
from mcsl_core.imaging.planes import planes_to_bgr
from mcsl_core.media.frames import to_planes
from mcsl_core.media.probing import probe
from mcsl_core.media.reading import VideoReader

HDR = DATA / "faults" / "hdr"
PATCHES = np.array(
    [(255,) * 3, (0,) * 3, (200, 30, 30), (30, 180, 60), (40, 60, 200), (230, 180, 150), (128,) * 3, (180, 20, 120)]
)  # fmt: skip
KR_KB = {
    1: (0.2126, 0.0722), 4: (0.30, 0.11), 5: (0.299, 0.114), 6: (0.299, 0.114), 7: (0.212, 0.087), 9: (0.2627, 0.0593)
}  # fmt: skip
TO_2020 = np.array([[0.6274, 0.3293, 0.0433], [0.0691, 0.9195, 0.0114], [0.0164, 0.0880, 0.8956]])  # ITU-R BT.2087
TO_P3 = np.array([[0.8225, 0.1774, 0.0], [0.0332, 0.9669, 0.0], [0.0171, 0.0724, 0.9108]])


def srgb_light(codes):
    return np.where(codes <= 0.04045, codes / 12.92, ((codes + 0.055) / 1.055) ** 2.4)


def hlg_codes(light):
    """Of light relative to diffuse white at 75 %, seen through a gamma of 1.2."""
    scene = (light ** (1 / 1.2)) * 0.26496
    upper = 0.17883277 * np.log(np.maximum(12 * scene - 0.28466892, 1e-6)) + 0.55991073
    return np.where(scene <= 1 / 12, np.sqrt(3 * scene), upper)


def pq_codes(light):
    """Of light relative to diffuse white at 203 cd/m2."""
    y = (light * 203 / 10_000) ** 0.1593017578125
    return ((0.8359375 + 18.8515625 * y) / (1 + 18.6875 * y)) ** 78.84375


def frame_of(codes, *, matrix, full=False, bits=8, size=(256, 128), trc=2, primaries=2):
    """A 4:2:0 frame of eight patches with R'G'B' ``codes``, 0..1."""
    kr, kb = KR_KB[matrix]
    luma = codes @ [kr, 1 - kr - kb, kb]
    values = np.stack([luma, (codes[:, 2] - luma) / 2 / (1 - kb), (codes[:, 0] - luma) / 2 / (1 - kr)], 1)
    step = 1 << (bits - 8)
    scale, zero = ((255 * step + step - 1,) * 3, (0, 128 * step, 128 * step)) if full else (
        (219 * step, 224 * step, 224 * step), (16 * step, 128 * step, 128 * step))  # fmt: skip
    frame: Any = av.VideoFrame(size[0], size[1], "yuv420p" if bits == 8 else f"yuv420p{bits}le")
    for k, plane in enumerate(frame.planes):
        rows = np.frombuffer(plane, np.uint8 if bits == 8 else np.uint16).reshape(plane.height, -1)[:, : plane.width]
        numbers = np.round(values[:, k] * scale[k] + zero[k]).reshape(2, 4)
        rows[:] = numbers.repeat(plane.height // 2, 0).repeat(plane.width // 4, 1)
    frame.colorspace, frame.color_range = matrix, 2 if full else 1
    frame.color_trc, frame.color_primaries = trc, primaries
    return frame


def write(path, frame, count=3):
    """The frame as a lossless film with its tags."""
    with av.open(str(path), "w") as container:
        stream = container.add_stream("ffv1", rate=25)
        stream.width, stream.height, stream.pix_fmt = frame.width, frame.height, frame.format.name
        for tag in ("colorspace", "color_range", "color_trc", "color_primaries"):
            setattr(stream.codec_context, tag, getattr(frame, tag))
        for k in range(count):
            frame.pts, frame.time_base = k, Fraction(1, 25)
            container.mux(stream.encode(frame))
        container.mux(stream.encode(None))
    return path


def patches_of(picture):
    height, width = picture.shape[:2]
    return np.array(
        [picture[height // 4 + height // 2 * (i // 4), width // 8 + width // 4 * (i % 4)] for i in range(8)]
    ).astype(int)


def shown(path):
    """(8, 3) R, G, B of the patches, and their lumas."""
    facts = probe(path)
    planes = to_planes(next(VideoReader(facts).read(Fraction(0)))[1], facts)
    return patches_of(planes_to_bgr(planes))[:, ::-1], patches_of(planes.y)


@pytest.mark.parametrize("size", [(256, 128), (1280, 720)])
@pytest.mark.parametrize("full", [False, True])
@pytest.mark.parametrize("matrix", KR_KB)
def test_every_matrix_and_range(tmp_path, matrix, full, size):
    frame = frame_of(PATCHES / 255, matrix=matrix, full=full, size=size)
    rgb, _ = shown(write(tmp_path / "a.mkv", frame, 1))
    assert np.abs(rgb - PATCHES).max() <= 5


@pytest.mark.parametrize(("size", "matrix"), [((640, 480), 5), ((720, 576), 5), ((1280, 720), 1), ((1920, 1080), 1)])
def test_without_a_tag_the_size_decides(tmp_path, size, matrix):
    frame = frame_of(PATCHES / 255, matrix=matrix, size=size)
    frame.colorspace = 2
    rgb, _ = shown(write(tmp_path / "a.mkv", frame, 1))
    assert np.abs(rgb - PATCHES).max() <= 5


@pytest.mark.parametrize("bits", [8, 10, 12])
@pytest.mark.parametrize(("trc", "codes_of"), [(18, hlg_codes), (16, pq_codes)], ids=["hlg", "pq"])
def test_hdr_is_shown_as_the_sdr_picture_it_holds(tmp_path, trc, codes_of, bits):
    codes = codes_of(srgb_light(PATCHES / 255) @ TO_2020.T)
    frame = frame_of(codes, matrix=9, bits=bits, trc=trc, primaries=9)
    path = write(tmp_path / "a.mkv", frame)
    rgb, luma = shown(path)
    assert np.abs(rgb - PATCHES).max() <= (8 if bits > 8 else 14)  # 8 bits of HDR are 2 to 4 of SDR in the shadows
    assert luma[0] == pytest.approx(235, abs=8)
    assert probe(path).conversions == ({18: "hlg bt2020", 16: "pq bt2020"}[trc],)


def test_hdr_whose_other_tags_are_missing_is_taken_as_bt2020(tmp_path):
    codes = hlg_codes(srgb_light(PATCHES / 255) @ TO_2020.T)
    frame = frame_of(codes, matrix=9, bits=10, trc=18)
    frame.colorspace = 2
    rgb, _ = shown(write(tmp_path / "a.mkv", frame))
    assert np.abs(rgb - PATCHES).max() <= 8


def test_highlights_are_rolled_off_in_order(tmp_path):
    light = np.array([0.5, 0.9, 1, 1.3, 2, 3, 4, 4.9])
    _, luma = shown(
        write(tmp_path / "a.mkv", frame_of(hlg_codes(light)[:, None].repeat(3, 1), matrix=9, bits=10, trc=18))
    )
    assert (np.diff(luma) >= 0).all()
    assert luma[2] == pytest.approx(235, abs=8)
    assert luma[3] < luma[5] <= luma[7] <= 235


@pytest.mark.parametrize(("primaries", "to"), [(9, TO_2020), (12, TO_P3)], ids=["bt2020", "p3"])
def test_wide_gamuts_of_sdr(tmp_path, primaries, to):
    light = srgb_light(PATCHES / 255) @ to.T
    codes = np.where(light <= 0.0031308, light * 12.92, 1.055 * light ** (1 / 2.4) - 0.055)
    frame = frame_of(codes, matrix=9 if primaries == 9 else 1, bits=10, trc=14, primaries=primaries)
    rgb, _ = shown(write(tmp_path / "a.mkv", frame))
    assert np.abs(rgb - PATCHES).max() <= 5


EIGHT = "rgb24 bgra gbrp yuva420p yuv411p yuv410p yuv440p nv12 uyvy422 yuyv422 yuvj444p"
DEEP = "rgba64le gbrp12le yuv422p12le yuv444p16le p010le yuva444p10le"


@pytest.mark.parametrize("form", [*EIGHT.split(), *DEEP.split()])
def test_every_way_of_storing_pixels(form):
    picture = PATCHES.reshape(2, 4, 3).astype(np.uint8).repeat(64, 0).repeat(64, 1)
    source = av.VideoFrame.from_ndarray(picture, format="rgb24")
    frame = source.reformat(format=form, dst_colorspace="ITU709", dst_color_range="JPEG" if "yuvj" in form else "MPEG")
    frame.colorspace = 0 if frame.format.is_rgb else 1
    facts: Any = SimpleNamespace(size=(256, 128), rotation=0, mirrored=False)
    assert np.abs(patches_of(planes_to_bgr(to_planes(frame, facts)))[:, ::-1] - PATCHES).max() <= 6


@pytest.mark.parametrize(("form", "wide"), [("gray", np.uint8), ("gray10le", np.uint16), ("gray16le", np.uint16)])
def test_grey_film(tmp_path, form, wide):
    """FFmpeg holds all of it for full range."""
    top = {"gray": 255, "gray10le": 1023, "gray16le": 65535}[form]
    greys = np.array([255, 0, 30, 60, 90, 128, 180, 220])
    frame: Any = av.VideoFrame(256, 128, form)
    plane = frame.planes[0]
    rows = np.frombuffer(plane, wide).reshape(128, -1)[:, :256]
    rows[:] = np.round(greys / 255 * top).reshape(2, 4).repeat(64, 0).repeat(64, 1)
    frame.color_range = 2
    rgb, _ = shown(write(tmp_path / "a.mkv", frame))
    assert np.abs(rgb - greys[:, None]).max() <= 3


@pytest.mark.parametrize("size", [(257, 129), (255, 127)])
def test_odd_sizes(tmp_path, size):
    picture: Any = cv2.resize(PATCHES.reshape(2, 4, 3).astype(np.uint8), size, interpolation=cv2.INTER_NEAREST)
    source = av.VideoFrame.from_ndarray(picture, format="rgb24")
    frame = source.reformat(format="yuv444p", dst_colorspace="ITU709", dst_color_range="MPEG")
    frame.colorspace, frame.color_range = 1, 1
    rgb, _ = shown(write(tmp_path / "a.mkv", frame))
    assert np.abs(rgb - PATCHES).max() <= 5


@pytest.mark.parametrize(("matrix", "name"), [(8, "YCgCo"), (14, "ICtCp")])
def test_colours_that_cannot_be_read_are_refused_by_name(tmp_path, matrix, name):
    frame = frame_of(PATCHES / 255, matrix=1)
    frame.colorspace = matrix
    with pytest.raises(MediaError, match=name) as caught:
        probe(write(tmp_path / "a.mkv", frame))
    assert caught.value.remedy


@pytest.mark.skipif(not HDR.is_dir(), reason="the folder ../shared/data/faults/hdr is not here")
def test_a_phones_hlg():
    picture: Any = cv2.imread(str(HDR / "hdr.png"))
    right = patches_of(picture[:, :320])[:, ::-1]
    rgb, luma = shown(HDR / "hlg.mp4")
    assert luma[0] == pytest.approx(235, abs=8)
    assert np.abs(rgb - right).max() <= 8
