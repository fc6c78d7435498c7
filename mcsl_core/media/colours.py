"""What colours a decoded frame has, by its tags; HDR and wide-gamut ones brought to BT.709 through a table.

The numbers are those of ITU-T H.273. HLG and PQ become what a screen of BT.709 shows of them: diffuse white, 203 cd/m2
(75 % of HLG; ITU-R BT.2408), becomes white, and what is brighter is rolled off into the last 4 % below it. HLG's system
gamma of 1.2 is applied to each of R, G and B: an SDR picture that was put into HLG comes back as it was, and it lies
near the conversion by scene light that BT.2408 advises where HLG and SDR cameras are cut together. See
docs/explanation/pictures.md.
"""

from __future__ import annotations

import threading
from functools import lru_cache
from itertools import product
from pathlib import Path
from typing import Any, Literal

import numpy as np
from attrs import frozen
from av.filter import Graph
from av.video.reformatter import Colorspace, VideoReformatter
from numpy.typing import NDArray

from mcsl_core.errors import MediaError
from mcsl_core.temporary import temporary_folder

BT709 = 1  # the same number for primaries, transfer and matrix
LIMITED, FULL = 1, 2  # AVCOL_RANGE_MPEG, AVCOL_RANGE_JPEG

_MATRICES = {
    1: Colorspace.ITU709, 4: Colorspace.FCC, 5: Colorspace.ITU601, 6: Colorspace.ITU601,
    7: Colorspace.SMPTE240M, 9: Colorspace.BT2020, 10: Colorspace.BT2020,
}  # fmt: skip
_UNKNOWN_MATRICES = {
    8: "YCgCo", 11: "YDzDx", 12: "chroma-derived", 13: "chroma-derived", 14: "ICtCp", 15: "IPT (Dolby Vision)",
    16: "YCgCo-R", 17: "YCgCo-R",
}  # fmt: skip
_LIGHT = {16: "pq", 18: "hlg"}
_GAMUTS = {9: "bt2020", 11: "p3", 12: "p3"}
_XY = {  # red, green, blue
    "bt709": ((0.64, 0.33), (0.30, 0.60), (0.15, 0.06)),
    "bt2020": ((0.708, 0.292), (0.170, 0.797), (0.131, 0.046)),
    "p3": ((0.680, 0.320), (0.265, 0.690), (0.150, 0.060)),
}
_D65 = (0.3127, 0.3290)

_NODES = 65  # of the table, a side; with 33, PQ white came out 5 codes too dark
_WHITE_CD_M2, _PEAK_CD_M2 = 203, 1000
_KNEE = 0.96  # of white, as coded: from here up to the peak everything is rolled off
_per_thread = threading.local()


@frozen
class WideColours:
    """Colours that BT.709 cannot hold as they are: "pq", "hlg" or "sdr" light, and the gamut of their primaries."""

    light: Literal["pq", "hlg", "sdr"]
    gamut: Literal["bt709", "bt2020", "p3"]


def wide_colours(frame: Any) -> WideColours | None:
    """What has to be converted in a frame's colours; None for ordinary ones. HDR without primaries has BT.2020's."""
    light = _LIGHT.get(frame.color_trc, "sdr")
    gamut = _GAMUTS.get(frame.color_primaries, "bt709")
    if light == "sdr" and gamut == "bt709":
        return None
    if light != "sdr" and frame.color_primaries in (0, 2, 3):
        gamut = "bt2020"
    return WideColours(light, gamut)  # pyright: ignore[reportArgumentType]


def refuse_colours(frame: Any, path: Path) -> None:
    """MediaError for pictures in a colour model that cannot be read: shown as another they would be silently wrong."""
    name = None if frame.format.is_rgb else _UNKNOWN_MATRICES.get(frame.colorspace)
    if name is None and frame.format.name != "yuv420p":
        try:
            _reformatter().reformat(frame, width=16, height=16, format="yuv420p")
        except (OSError, ValueError):  # FFmpeg's errors among them
            name = f"stored as {frame.format.name}"
    if name:
        raise MediaError(
            f"its colours are {name}, which mcsl cannot read",
            where=str(path),
            remedy="Convert it to BT.709, or export it so from the camera",
        )


def colour_note(frame: Any) -> str:
    """What its colours are called where they are not read as those of most files are; else empty."""
    wide = wide_colours(frame)
    if wide is not None:
        return f"{wide.light} {wide.gamut}"
    return {4: "fcc", 7: "smpte240m"}.get(frame.colorspace, "")


def matrix_of(frame: Any) -> Colorspace:
    """The matrix behind a frame's Y'CbCr.

    Notes
    -----
    Pictures without a tag are BT.2020 where their light is HDR, else BT.709 from 720 rows or 1280 columns up and BT.601
    below, as players take them. Y'CbCr that says it is RGB has no tag; of RGB and greys it does not matter.
    """
    if frame.format.is_rgb or len(frame.format.components) < 3:
        return Colorspace.ITU709
    if frame.colorspace in _MATRICES:
        return _MATRICES[frame.colorspace]
    if frame.color_trc in _LIGHT:
        return Colorspace.BT2020
    small = max(frame.width, frame.height) < 1280 and min(frame.width, frame.height) < 720
    return Colorspace.ITU601 if small else Colorspace.ITU709


def is_full_range(frame: Any) -> bool:
    """Whether black is 0 and white the highest code."""
    return frame.color_range == FULL or frame.format.name.startswith("yuvj") or frame.format.is_rgb


def to_bt709_rgb(frame: Any, wide: WideColours) -> Any:
    """The frame as 10-bit RGB of BT.709. Some 50 ms of CPU at 1080p."""
    rgb = _reformatter().reformat(
        frame,
        format="gbrp10le",
        src_colorspace=matrix_of(frame),
        dst_colorspace=matrix_of(frame),
        src_color_range=FULL if is_full_range(frame) else LIMITED,
        dst_color_range=FULL,
    )
    graph = _graph(wide, rgb.width, rgb.height)
    rgb.pts = 0
    graph.push(rgb)
    done: Any = graph.pull()
    done.color_trc = done.color_primaries = BT709
    return done


def _reformatter() -> VideoReformatter:
    """One per thread: it keeps its tables, and is not safe to share."""
    if not hasattr(_per_thread, "reformatter"):
        _per_thread.reformatter = VideoReformatter()
    return _per_thread.reformatter


def _graph(wide: WideColours, width: int, height: int) -> Graph:
    """FFmpeg's lut3d with the table of ``wide``; the latest is kept, one per thread."""
    key = wide, width, height
    if getattr(_per_thread, "key", None) != key:
        graph = Graph()
        source = f"video_size={width}x{height}:pix_fmt=gbrp10le:time_base=1/1000:colorspace=0:range={FULL}"
        with temporary_folder("colours") as folder:  # it reads its table from a file, once
            file = folder / "table.cube"
            file.write_text(_cube(wide), encoding="ascii")
            nodes = [graph.add("buffer", source), graph.add("lut3d", file=str(file), interp="tetrahedral")]
            graph.link_nodes(*nodes, graph.add("buffersink")).configure()
        _per_thread.key, _per_thread.graph = key, graph
    return _per_thread.graph


@lru_cache(maxsize=8)
def _cube(wide: WideColours) -> str:
    steps = np.linspace(0, 1, _NODES)
    codes = np.array([(r, g, b) for b, g, r in product(steps, repeat=3)])  # red runs fastest
    rows = "%.5f %.5f %.5f\n" * len(codes) % tuple(converted(codes, wide).ravel().tolist())
    return f"LUT_3D_SIZE {_NODES}\n{rows}"


def converted(codes: NDArray[np.float64], wide: WideColours) -> NDArray[np.float64]:
    """(N, 3) R'G'B' codes, 0..1, of ``wide`` as those of a screen of BT.709."""
    light = {"pq": _pq_light, "hlg": _hlg_light, "sdr": _sdr_light}[wide.light](codes)
    light = np.clip(light @ (np.linalg.inv(_to_xyz("bt709")) @ _to_xyz(wide.gamut)).T, 0, None)
    if wide.light != "sdr":
        brightest = np.maximum(light.max(1, keepdims=True), 1e-9)
        light *= _sdr_light(_rolled_off(_sdr_codes(brightest))) / brightest  # one factor for all three keeps the hue
    return np.clip(_sdr_codes(light), 0, 1)


def _pq_light(codes: NDArray[np.float64]) -> NDArray[np.float64]:
    """SMPTE ST 2084, relative to diffuse white."""
    power = codes ** (32 / 2523)
    light = np.clip(power - 107 / 128, 0, None) / (2413 / 128 - 2392 / 128 * power)
    return light ** (8192 / 1305) * 10_000 / _WHITE_CD_M2


def _hlg_light(codes: NDArray[np.float64]) -> NDArray[np.float64]:
    """ITU-R BT.2100 with a system gamma of 1.2 on each channel, relative to diffuse white."""
    a, b, c = 0.17883277, 0.28466892, 0.55991073
    scene = np.where(codes <= 0.5, codes**2 / 3, (np.exp((codes - c) / a) + b) / 12)
    white = (np.exp((0.75 - c) / a) + b) / 12
    return (scene / white) ** 1.2


def _sdr_light(codes: NDArray[np.float64]) -> NDArray[np.float64]:
    """As a screen shows them: sRGB's curve, which keeps the greys of an SDR picture that was put into HDR."""
    return np.where(codes <= 0.04045, codes / 12.92, ((codes + 0.055) / 1.055) ** 2.4)


def _sdr_codes(light: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.where(light <= 0.0031308, light * 12.92, 1.055 * np.maximum(light, 1e-9) ** (1 / 2.4) - 0.055)


def _rolled_off(codes: NDArray[np.float64]) -> NDArray[np.float64]:
    """Codes up to the peak's, brought below 1 by Reinhard's curve above the knee; white itself comes out as 0.98."""
    peak = (_sdr_codes(np.array(_PEAK_CD_M2 / _WHITE_CD_M2)) - _KNEE) / (1 - _KNEE)
    over = np.clip((codes - _KNEE) / (1 - _KNEE), 0, peak)
    return np.where(codes <= _KNEE, codes, _KNEE + (1 - _KNEE) * over * (1 + over / peak**2) / (1 + over))


def _to_xyz(gamut: str) -> NDArray[np.float64]:
    """(3, 3): linear R, G, B of a gamut to CIE XYZ, its white D65."""
    columns = np.array([(x / y, 1, (1 - x - y) / y) for x, y in _XY[gamut]]).T
    x, y = _D65
    return np.asarray(columns * np.linalg.solve(columns, [x / y, 1, (1 - x - y) / y]), np.float64)
