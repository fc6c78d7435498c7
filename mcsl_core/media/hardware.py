"""The machine's own hardware for coding, by FFmpeg's names of its kinds; the processor does what it does not."""

from __future__ import annotations

from collections.abc import Iterator

from av.codec.hwaccel import HWAccel, HWDeviceType, hwdevices_available

from mcsl_core.errors import UsageError

NONE, AUTO = "none", "auto"
ENCODERS = {  # how FFmpeg's encoders on such hardware end
    "cuda": "_nvenc",
    "qsv": "_qsv",
    "videotoolbox": "_videotoolbox",
    "d3d11va": "_amf",
    "dxva2": "_amf",
}


def check_hwaccel(name: str) -> str:
    """``name``, where it is a kind of hardware, `AUTO` or `NONE`; UsageError otherwise."""
    known = {kind.name for kind in HWDeviceType} | {*hwdevices_available(), AUTO, NONE}
    if name not in known:
        built = ", ".join((AUTO, NONE, *hwdevices_available()))
        raise UsageError(f"there is no decoding hardware called {name!r}", remedy=f"This machine's FFmpeg has {built}")
    return name


def accelerations(name: str) -> Iterator[HWAccel]:
    """What to try in turn: the kind of that name, every kind that FFmpeg was built for, or none.

    Kinds that FFmpeg was built for need not be there; opening a file with one tells.
    """
    kinds = {NONE: [], AUTO: hwdevices_available()}.get(name, [name])
    for kind in kinds:
        if kind in hwdevices_available():
            yield HWAccel(kind, allow_software_fallback=True)
