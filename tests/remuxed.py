"""Test films cut, shifted and joined packet by packet, as splitters, recorders and `cat` do it; without mcsl."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from pathlib import Path
from typing import Any

import av

SHIFT_S = 1.0  # muxers without negative timestamps would shift the first part alone


def split(
    film: Path, *, suffix: str, at_s: Sequence[float], later_s: Sequence[float] = (), anew: bool = False, **kept
) -> list[Path]:
    """Cuts ``film`` before the first keyframe from each of ``at_s`` on.

    later_s: how much later than it was each part's clock stands. anew: each part's clock begins with it, or else goes
    on. kept: as `remux` takes them.
    """
    keys = _keyframes(film)
    cuts = [next(k for k in keys if k[0] >= at)[1] for at in at_s]
    paths = []
    for number, (start, stop) in enumerate(zip([None, *cuts], [*cuts, None], strict=True)):
        path = film.with_name(f"{film.stem}_{number:03}{suffix}")
        later = SHIFT_S + (later_s[number] if later_s else 0)
        if anew:
            later = 0.2 - float(start or 0)
        paths.append(remux(film, path, later_s=later, start_s=start, stop_s=stop, **kept))
    return paths


def _keyframes(film: Path) -> list[tuple[Fraction, Fraction]]:
    """(presentation, decoding time) of each keyframe."""
    with av.open(str(film)) as source:
        packets: list[Any] = [p for p in source.demux(video=0) if p.dts is not None and p.is_keyframe]
        return [(p.pts * p.time_base, p.dts * p.time_base) for p in packets]


def remux(
    film: Path,
    path: Path,
    *,
    later_s: float = 0.0,
    start_s: Fraction | None = None,
    stop_s: Fraction | None = None,
    sound_later_s: float = 0.0,
    pts_of_dts: bool = False,
) -> Path:
    """The packets of ``film`` whose decoding time lies in [start_s, stop_s), with later timestamps, in ``path``.

    sound_later_s: of the sound alone, before it is cut. pts_of_dts: timestamps are those of decoding, as from AVI.
    """
    with av.open(str(film)) as source, av.open(str(path), "w") as out:
        streams = [*source.streams.video, *source.streams.audio]
        copies = {s.index: out.add_stream_from_template(s) for s in streams}
        packets: list[Any] = [p for p in source.demux(streams) if p.dts is not None]
        for packet in sorted(packets, key=lambda p: p.dts * p.time_base):
            later = round(Fraction(sound_later_s) / packet.time_base) if packet.stream.type == "audio" else 0
            time = (packet.dts + later) * packet.time_base
            if (start_s is not None and time < start_s) or (stop_s is not None and time >= stop_s):
                continue
            later += round(Fraction(later_s) / packet.time_base)
            packet.pts, packet.dts = packet.pts + later, packet.dts + later
            if pts_of_dts:
                packet.pts = packet.dts
            packet.stream = copies[packet.stream.index]
            out.mux(packet)
    return path
