"""Cameras whose every picture carries its number, and which number each programme frame must show.

The oracle shares no code with the reader: films are written by PyAV alone from timestamps chosen here, and which number
must be shown is worked out from those timestamps, in whole ticks.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from fractions import Fraction
from pathlib import Path

import av
import numpy as np
from attrs import field, frozen
from coded_video import SIZE, read_number, write_coded
from remuxed import remux, split

from mcsl_core.edl import IDENTITY, Camera, Clock, Edl, Look, Media, Pose, Shot
from mcsl_core.timing import FrameRange

NTSC = Fraction(30000, 1001)
OPEN = {"preset": "veryfast", "bf": "3", "x264-params": "open-gop=1:b-pyramid=2:scenecut=0"}
COUNT = 100


@frozen(kw_only=True)
class Case:
    """A camera: its files, when each picture comes on its own clock, and how that clock runs."""

    write: Callable[[Path], Sequence[Path]]
    times: Sequence[Fraction]  # of picture 0, 1, ..., seconds of the camera's own time
    ends: Fraction
    rate: Fraction = Fraction(30)  # of the programme
    clock: Clock = field(factory=Clock)

    def shown(self, frame: int) -> int | None:
        """The number at a programme frame, by the definition of the clock: the latest that has come."""
        pace = 1 + Fraction(str(self.clock.drift_ppm)) / 1_000_000
        time = (Fraction(frame) / self.rate - Fraction(str(self.clock.offset_s))) * pace
        slack = Fraction(1, 1000)  # timestamps are rounded, in Matroska to a millisecond
        if time + slack < 0 or time + slack >= self.ends:
            return None
        return max((n for n, at in enumerate(self.times) if at <= time + slack), default=None)

    def near_a_tie(self, frame: int) -> bool:
        """Whether rounding may decide which of two pictures has come."""
        pace = 1 + Fraction(str(self.clock.drift_ppm)) / 1_000_000
        time = (Fraction(frame) / self.rate - Fraction(str(self.clock.offset_s))) * pace
        edges = (*self.times, self.ends)
        return any(0 < abs(time - at) <= Fraction(2, 1000) for at in edges)


def even(rate: Fraction, count: int = COUNT) -> list[Fraction]:
    return [n / rate for n in range(count)]


def one(name: str, **settings) -> Callable[[Path], list[Path]]:
    return lambda folder: [write_coded(folder / name, range(COUNT), **settings)]


def variable() -> list[int]:
    """Milliseconds: pictures 15 to 90 ms apart, and a hole of half a second."""
    steps = np.random.default_rng(5).integers(15, 90, COUNT - 1)
    steps[40] = 500
    return [0, *np.cumsum(steps).tolist()]


def parts(suffix: str) -> Callable[[Path], list[Path]]:
    return lambda folder: split(write_coded(folder / "a.mp4", range(COUNT), gop=20), suffix=suffix, at_s=[1, 2])


def from_avi(folder: Path) -> list[Path]:
    return [remux(write_coded(folder / "a.avi", range(COUNT), options=OPEN, gop=25), folder / "b.mkv", pts_of_dts=True)]


def from_an_hour(folder: Path) -> list[Path]:
    return [remux(write_coded(folder / "a.mp4", range(COUNT)), folder / "b.mkv", later_s=3600)]


def late(folder: Path) -> list[Path]:
    return [write_coded(folder / "a.mp4", range(COUNT), stamps=[n + 15 for n in range(COUNT)])]


VARIABLE = variable()
LOST = [n for n in range(COUNT + 5) if n not in {7, 30, 31, 32, 60}]
CASES = {
    "constant": Case(write=one("a.mp4"), times=even(Fraction(30)), ends=COUNT / Fraction(30)),
    "29.97 in Matroska": Case(write=one("a.mkv", rate=NTSC), times=even(NTSC), ends=COUNT / NTSC, rate=NTSC),
    "29.97 in TS at 25": Case(write=one("a.ts", rate=NTSC), times=even(NTSC), ends=COUNT / NTSC, rate=Fraction(25)),
    "open groups": Case(write=one("a.mp4", options=OPEN), times=even(Fraction(30)), ends=COUNT / Fraction(30)),
    "B-frames in AVI": Case(write=one("a.avi", options=OPEN), times=even(Fraction(30)), ends=COUNT / Fraction(30)),
    "remuxed from AVI": Case(write=from_avi, times=even(Fraction(30)), ends=COUNT / Fraction(30)),
    "variable": Case(
        write=one("a.mp4", stamps=VARIABLE, time_base=Fraction(1, 1000)),
        times=[Fraction(ms, 1000) for ms in VARIABLE],
        ends=Fraction(VARIABLE[-1], 1000) + Fraction(1, 100),
    ),
    "lost pictures": Case(
        write=one("a.mp4", stamps=LOST), times=[Fraction(n, 30) for n in LOST], ends=Fraction(LOST[-1] + 1, 30)
    ),
    "late": Case(write=late, times=[Fraction(n + 15, 30) for n in range(COUNT)], ends=Fraction(COUNT + 15, 30)),
    "from an hour": Case(write=from_an_hour, times=even(Fraction(30)), ends=COUNT / Fraction(30)),
    "offset": Case(
        write=one("a.mp4"), times=even(Fraction(30)), ends=COUNT / Fraction(30), clock=Clock(offset_s=0.213)
    ),
    "early": Case(write=one("a.mp4"), times=even(Fraction(30)), ends=COUNT / Fraction(30), clock=Clock(offset_s=-1.5)),
    "drift": Case(
        write=one("a.mp4"),
        times=even(Fraction(30)),
        ends=COUNT / Fraction(30),
        clock=Clock(offset_s=0.2, drift_ppm=-20000.0),
    ),
    "parts in Matroska": Case(write=parts(".mkv"), times=even(Fraction(30)), ends=COUNT / Fraction(30)),
    "parts in TS": Case(write=parts(".ts"), times=even(Fraction(30)), ends=COUNT / Fraction(30)),
    "60 at 30": Case(write=one("a.mp4", rate=Fraction(60)), times=even(Fraction(60)), ends=COUNT / Fraction(60)),
}
DELIVERED = ("constant", "29.97 in Matroska", "B-frames in AVI", "variable", "late", "drift", "parts in TS")
FRAMES = 110


def edl_of(case: Case, folder: Path) -> Edl:
    camera = Camera("a", tuple(Media(p.name, 1) for p in case.write(folder)), SIZE, case.rate, clock=case.clock)
    return Edl(
        rate=case.rate,
        size=SIZE,
        frames=FRAMES,
        reference="a",
        cameras=(camera,),
        poses=(Pose(FrameRange(0, FRAMES), {"a": IDENTITY}),),
        shots=(Shot(FrameRange(0, FRAMES), "a"),),
        look=Look(centering=False, fill=False, colour=False),
    )


def wrong(case: Case, got: Sequence[int | None], frames: Sequence[int]) -> dict[int, tuple[int | None, int | None]]:
    """Programme frame -> what was shown and what should have been, but for ties that rounding decides."""
    pairs = {frame: (number, case.shown(frame)) for frame, number in zip(frames, got, strict=True)}
    return {frame: pair for frame, pair in pairs.items() if pair[0] != pair[1] and not case.near_a_tie(frame)}


def delivered(path: Path) -> list[int | None]:
    with av.open(str(path)) as container:
        pictures = [frame.to_ndarray(format="gray") for frame in container.decode(video=0)]
    return [None if picture.mean() < 20 else read_number(picture) for picture in pictures]
