"""Render presets: what a delivery is, for Blender's encoder and, equal to it, for the direct engine.

Data files in render_presets/, one a kind of delivery; a user's own file of the same form works as well.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import attrs
from attrs import field, frozen

from mcsl_core.documents import doc, make_converter, read_json, structure_document
from mcsl_core.errors import DocumentError, UsageError

SCHEMA = "mcsl.preset/1"
CONTAINERS = {"mp4": "MPEG4", "mov": "QUICKTIME", "mkv": "MKV"}  # ours -> Blender's
CODECS = ("H264", "H265", "AV1", "PRORES", "FFV1")
QUALITIES = ("LOSSLESS", "PERC_LOSSLESS", "HIGH", "MEDIUM", "LOW", "VERYLOW", "LOWEST")  # CRF 0 17 20 23 26 29 32
SPEEDS = ("BEST", "GOOD", "REALTIME")
AUDIO_CODECS = ("AAC", "FLAC", "OPUS", "PCM")
PRORES_PROFILES = ("", "422_PROXY", "422_LT", "422_STD", "422_HQ", "4444", "4444_XQ")

_FILES = {  # options of encoders, and of x264 and x265 in their own lists, that open a file
    *("stats", "passlogfile", "pass", "dump-yuv", "qpfile", "cqmfile", "tcfile-in", "tcfile-out", "log-file"),
    *("opencl-clbin", "recon", "csv", "lambda-file", "scaling-list", "zonefile", "dhdr10-info"),
    *("analysis-save", "analysis-load", "analysis-reuse-file", "dolby-vision-rpu", "film-grain"),
    *("aom-film-grain", "film-grain-table", "two-pass-stats"),
}


def _one_of(*allowed: str):
    def check(_: Any, attribute: attrs.Attribute, value: str) -> None:
        if value not in allowed:
            raise ValueError(f"{attribute.name} must be one of {', '.join(map(repr, allowed))}, got {value!r}")

    return check


def _within(low: int, high: int):
    def check(_: Any, attribute: attrs.Attribute, value: int) -> None:
        if not low <= value <= high:
            raise ValueError(f"{attribute.name} must lie in {low}..{high}, got {value}")

    return check


def _writes_no_file(_: Any, attribute: attrs.Attribute, value: Mapping[str, str]) -> None:
    """Encoders open files that options name, over whatever lies there: a preset from elsewhere could name any."""
    for name, text in value.items():
        options = [(name, text)]
        if name == "flags" or "params" in name or "opts" in name:
            options += [part.partition("=")[::2] for part in re.split("[:,+]", text)]
        for word, given in options:
            known = re.sub("[0-9]+$", "", word.strip().lower()).replace("_", "-")
            if known in _FILES and not (known == "film-grain" and given.strip().isdigit()):  # a file in x265 alone
                raise ValueError(f"{attribute.name}.{name} has an encoder open a file ({word.strip()})")


def _each_writes_no_file(_: Any, attribute: attrs.Attribute, value: Mapping[str, Mapping[str, str]]) -> None:
    for options in value.values():
        _writes_no_file(_, attribute, options)


@frozen
class BlenderOutput:
    """Blender's own names for its FFmpeg output."""

    format: str = field(validator=_one_of(*CONTAINERS.values()), metadata=doc("container"))
    codec: str = field(validator=_one_of(*CODECS), metadata=doc("video codec"))
    quality: str = field(validator=_one_of(*QUALITIES), metadata=doc("constant quality; no part in ProRes and FFV1"))
    speed: str = field(validator=_one_of(*SPEEDS), metadata=doc("encoding speed against size"))
    gop: int = field(validator=_within(1, 1000), metadata=doc("most frames from keyframe to keyframe"))
    audio_codec: str = field(validator=_one_of(*AUDIO_CODECS), metadata=doc("audio codec"))
    audio_kbps: int = field(validator=_within(32, 6144), metadata=doc("audio bit rate; no part in PCM and FLAC"))
    prores_profile: str = field(default="", validator=_one_of(*PRORES_PROFILES), metadata=doc("ProRes only"))
    depth: str = field(default="8", validator=_one_of("8", "10", "12"), metadata=doc("bits a channel"))


@frozen
class DirectOutput:
    """FFmpeg's names, for the engine that writes without Blender."""

    codec: str = field(metadata=doc("video encoder"))
    options: Mapping[str, str] = field(validator=_writes_no_file, metadata=doc("the encoder's options"))
    pixel_format: str = field(metadata=doc("pixel format"))
    gop: int = field(validator=_within(1, 1000), metadata=doc("most frames from keyframe to keyframe"))
    audio_codec: str = field(metadata=doc("audio encoder"))
    audio_options: Mapping[str, str] = field(
        factory=dict, validator=_writes_no_file, metadata=doc("the audio encoder's options")
    )
    tag: str = field(default="", metadata=doc("four-character code, where players want another than the muxer's"))
    hardware: Mapping[str, Mapping[str, str]] = field(
        factory=dict,
        validator=_each_writes_no_file,
        metadata=doc(
            "the machine's own encoders of that codec and their options, the first that works with `--hwaccel`"
        ),
    )


@frozen
class Preset:
    """One kind of delivery."""

    title: str = field(metadata=doc("for menus"))
    description: str = field(metadata=doc("what it is for"))
    container: str = field(validator=_one_of(*CONTAINERS), metadata=doc("file name extension"))
    scale_percent: int = field(validator=_within(1, 100), metadata=doc("of the programme's size"))
    blender: BlenderOutput = field(metadata=doc("for `--engine blender`"))
    direct: DirectOutput = field(metadata=doc("for `--engine direct`"))

    def __attrs_post_init__(self) -> None:
        if self.blender.format != CONTAINERS[self.container]:
            expected = CONTAINERS[self.container]
            raise ValueError(f"blender.format must be {expected!r} for container {self.container!r}")
        if (self.blender.codec == "PRORES") != bool(self.blender.prores_profile):
            raise ValueError("blender.prores_profile belongs to codec 'PRORES' and only there")

    def scaled(self, size: tuple[int, int]) -> tuple[int, int]:
        """The delivered size of a programme of ``size``, as Blender counts it: whole and even, rounded down."""
        width, height = (max(2, v * self.scale_percent // 100 // 2 * 2) for v in size)
        return width, height


_converter = make_converter()


def presets_folder() -> Path:
    """Where the presets that come with mcsl lie: in the source tree, or in mcsl_core/data where mcsl is installed."""
    package = Path(__file__).resolve().parents[1]
    beside = package.parent / "render_presets"
    return beside if beside.is_dir() else package / "data" / "render_presets"


def preset_names() -> list[str]:
    """The presets that come with mcsl."""
    return sorted(path.stem for path in presets_folder().glob("*.json"))


def load_preset(name: str | Path) -> Preset:
    """The preset of that name, or of a JSON file of one's own (a path that ends in .json).

    Raises UsageError listing the presets for an unknown name, DocumentError with the path to a wrong value.
    """
    path = Path(name)
    if path.suffix != ".json":
        if str(name) not in preset_names():
            raise UsageError(
                f"there is no preset {str(name)!r}",
                remedy=f"Take one of {', '.join(preset_names())}, or the path of a .json file of your own",
            )
        path = presets_folder() / f"{name}.json"
    value = read_json(path)
    if not isinstance(value, dict) or value.get("schema") != SCHEMA:
        found = value.get("schema") if isinstance(value, dict) else None
        raise DocumentError(
            f"schema is {found!r}, this mcsl reads {SCHEMA!r}",
            where=f"{path} at $.schema",
            remedy="Begin with a copy of one of render_presets/",
        )
    rest = {key: item for key, item in value.items() if key != "schema"}
    return structure_document(rest, Preset, _converter, where=str(path), name="a preset (presets.md)")


def preset_of(given: str | Path | Preset) -> Preset:
    """A preset as it is, or the one that `load_preset` finds under a name or path."""
    return given if isinstance(given, Preset) else load_preset(given)
