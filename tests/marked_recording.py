"""A simulated recording with a mark in all that can bear one: names, tags, chapters, attachments, messages (SEI)."""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path
from typing import Any

import av
from av.bitstream import BitStreamFilterContext
from traces import MARK

from mcsl_core.progress import Silent
from mcsl_core.simulation import Scenario, simulate

UUID = "086f3693-b7b3-4f2c-9653-21492feee5b8"
MADE = "2019-02-03T04:05:06Z"
PLACES = ("title", "artist", "album", "comment", "copyright", "description", "location", "make", "model", "synopsis")


def marked_recording(folder: Path) -> Path:
    """Three cameras as MP4, MOV and MKV in a folder of ``folder``; returns it."""
    recording = folder / f"{MARK} 2019-02-03"
    scenario = Scenario(seed=5, duration_s=6, movements=0, size=(320, 180), cameras=3, clock_offset_s=0.2)
    simulate(scenario, recording, Silent())
    for number, suffix in enumerate((".mp4", ".mov", ".mkv"), start=1):
        plain = recording / f"cam{number}.mp4"
        _marked(plain, recording / f"{MARK}-{number}{suffix}.part")
        plain.unlink()
        (recording / f"{MARK}-{number}{suffix}.part").rename(recording / f"{MARK}-{number}{suffix}")
    for other in recording.iterdir():
        if MARK not in other.name:
            other.unlink()
    return recording


def _marked(plain: Path, path: Path) -> None:
    kind = {".mp4": "mp4", ".mov": "mov", ".mkv": "matroska"}[Path(path.stem).suffix]
    with av.open(str(plain)) as source, av.open(str(path), "w", format=kind, container_options=_options(kind)) as out:
        out.metadata.update({place: f"{MARK}-{place}" for place in PLACES}, creation_time=MADE, encoder=f"{MARK}-tool")
        video: Any = out.add_stream_from_template(source.streams.video[0])
        streams: dict[int, Any] = {source.streams.video[0].index: video}
        for sound in source.streams.audio:
            streams[sound.index] = out.add_stream_from_template(sound)
        for stream in streams.values():
            stream.metadata.update(title=f"{MARK}-track", handler_name=f"{MARK}-handler", encoder=f"{MARK}-encoder")
        video.metadata["timecode"] = "04:05:06:07"
        if kind == "matroska":
            out.add_attachment(f"{MARK}.txt", "text/plain", f"{MARK}-attached".encode())
        chapter = {"id": 1, "start": 0, "end": 900, "time_base": Fraction(1, 1000), "metadata": {"title": f"{MARK}-ch"}}
        out.set_chapters([chapter])  # pyright: ignore[reportArgumentType]
        message = BitStreamFilterContext(f"h264_metadata=sei_user_data={UUID}+{MARK}-message", source.streams.video[0])
        for packet in source.demux(*source.streams.video, *source.streams.audio):
            if packet.dts is None:
                continue
            copies = message.filter(packet) if packet.stream.type == "video" else [packet]
            index = packet.stream.index
            for copy in copies:
                copy.stream = streams[index]
                out.mux(copy)


def _options(kind: str) -> dict[str, str]:
    return {} if kind == "matroska" else {"movflags": "use_metadata_tags"}


def marks_in(path: Path) -> set[str]:
    """The marks that stand in a file, each with what is planted with it."""
    data = path.read_bytes()
    found = set()
    for code in ("utf-8", "utf-16-le", "utf-16-be"):
        word, at = MARK.encode(code), -1
        while (at := data.find(word, at + 1)) >= 0:
            found.add(data[at : at + 3 * len(word)].decode(code, "replace"))
    return found
