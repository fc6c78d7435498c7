"""Cuts for tests of interchange: cameras made up as values, and what stands where by the footage's own rules."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fractions import Fraction
from math import floor
from pathlib import Path

import attrs
from hypothesis import strategies as st

from mcsl_core.edl import IDENTITY, Camera, Clock, Edl, Media, Override, Pose, Shot, Weak
from mcsl_core.interchange.model import Medium
from mcsl_core.interchange.model import Sequence as Cut
from mcsl_core.interchange.sequence import Wanted, sequence_of
from mcsl_core.media.facts import MediaFacts
from mcsl_core.media.tracks import AudioTrack
from mcsl_core.recording.decoder import Part, exact_camera_time, part_at
from mcsl_core.recording.joining import joined
from mcsl_core.timing import FrameRange

R = FrameRange
BASE = Path("/films")
SIZE = (1920, 1080)
NTSC = [Fraction(n * 1000, 1001) for n in (24, 30, 60)]
RATES = [*NTSC, *map(Fraction, (24, 25, 30, 50, 60))]
ODD_NAMES = [
    "cam1",
    "a b",
    "Kamera ü",
    "手術 カメラ",
    "100% & <x>",
    "C:\\films\\a",
    "it's #1?",
    "x;y,z",
    "cam1.programme",
]


def facts_of(name: str, rate: Fraction, frames: int, *, timecode: str | None = None, channels: int = 1) -> MediaFacts:
    """A file of whole pictures at an even rate, as `probe` would describe it."""
    tracks = (AudioTrack(0, "aac", 48000, channels, "mono" if channels == 1 else "5.1", ""),) if channels else ()
    end_s = frames / rate
    return MediaFacts(
        path=BASE / name,
        size=SIZE,
        coded_size=SIZE,
        rotation=0,
        sample_aspect=Fraction(1),
        rate=rate,
        frames=frames,
        zero_s=Fraction(0),
        start_s=Fraction(0),
        end_s=end_s,
        usable_s=end_s,
        tick_s=Fraction(1, 90_000),
        variable_rate=False,
        keyframe_interval_s=1.0,
        codec="h264",
        pixel_format="yuv420p",
        audio_tracks=tracks,
        timecode=timecode,
        truncated=False,
    )


@attrs.frozen
class Film:
    """An EDL and the files of its cameras."""

    edl: Edl
    parts: Mapping[str, Sequence[Part]]

    def cut(self, *, exact: bool = False, start: str = "01:00:00:00", sound: str | None = "") -> Cut:
        """Its cut; the programme's file is made up too. sound: "" for the reference camera's."""
        edl = self.edl
        programme = Medium(BASE / "cut.programme.mp4", edl.rate, edl.frames, size=edl.size) if exact else None
        wav = Medium(BASE / "cut.programme.wav", edl.rate, edl.frames, channels=1, audio_rate=48000) if exact else None
        heard = edl.reference if sound == "" else sound
        wanted = Wanted(name="cut", start=start, sound_camera=None if exact else heard, programme=programme, sound=wav)
        return sequence_of(edl, self.parts, wanted)

    def camera_at(self, frame: int) -> str:
        """Whom the EDL shows at a frame: the last override that says so, else the shot."""
        said = [o.camera for o in self.edl.overrides if o.camera is not None and frame in o.range]
        return said[-1] if said else next(s.camera for s in self.edl.shots if frame in s.range)

    def picture_at(self, camera: str, frame: int) -> tuple[str, int] | None:
        """(file, picture from its first) that ``camera`` shows at a programme frame, as `Footage` finds it."""
        one = self.edl.camera(camera)
        if any(frame in gap for gap in one.gaps):
            return None
        camera_s = exact_camera_time(one, frame / self.edl.rate)
        part = part_at(self.parts[camera], camera_s)
        file_s = None if part is None else part.file_time(camera_s)
        if part is None or file_s is None:
            return None
        since = file_s - part.facts.start_s + part.facts.tolerance_s
        picture = floor(since * part.facts.rate)
        return (str(part.facts.path), picture) if 0 <= picture < part.facts.frames else None


def film(
    rate: Fraction = Fraction(25),
    frames: int = 100,
    *,
    names: Sequence[str] = ("cam1", "cam2", "cam3"),
    files: Mapping[str, Sequence[MediaFacts]] | None = None,
    cameras: Mapping[str, dict] | None = None,
    **fields,
) -> Film:
    """Cameras of one file each unless ``files`` says more; shots in turn. cameras: clock and gaps of some."""
    plain = {name: [facts_of(f"{n}/{name}.mp4", rate, frames)] for n, name in enumerate(names)}
    made = plain | dict(files or {})
    ends = [frames * n // len(names) for n in range(len(names) + 1)]
    given = {
        "rate": rate,
        "size": SIZE,
        "frames": frames,
        "reference": names[0],
        "cameras": tuple(
            Camera(
                name,
                tuple(Media(str(f.path.relative_to(BASE)), f.frames) for f in made[name]),
                size=SIZE,
                rate=made[name][0].rate,
                **(cameras or {}).get(name, {}),
            )
            for name in names
        ),
        "poses": (Pose(R(0, frames), dict.fromkeys(names, IDENTITY)),),
        "shots": tuple(Shot(R(a, b), name) for a, b, name in zip(ends, ends[1:], names, strict=False) if a < b),
        **fields,
    }
    return Film(Edl(**given), {name: joined(own) for name, own in made.items()})


@st.composite
def films(draw: st.DrawFn, *, mixed_rates: bool = False) -> Film:
    """Any rate, names, files, timecodes, clocks, gaps, shots down to one frame, poses and overrides."""
    rate = draw(st.sampled_from(RATES))
    frames = draw(st.integers(1, 400))
    names = draw(st.lists(st.sampled_from(ODD_NAMES), min_size=2, max_size=4, unique=True))
    files, cameras = {}, {}
    for n, name in enumerate(names):
        own = draw(st.sampled_from(RATES)) if mixed_rates else rate
        lengths = draw(st.lists(st.integers(1, 300), min_size=1, max_size=3))
        code = draw(st.sampled_from([None, "00:00:00:00", "10:11:12:13", "23:59:58:00", "01:02:03;04"]))
        channels = draw(st.sampled_from([0, 1, 2, 6]))
        odd = name.replace("/", "_")
        files[name] = [
            facts_of(f"{n} {odd}/{i} ü%20.mp4", own, length, timecode=code if i == 0 else None, channels=channels)
            for i, length in enumerate(lengths)
        ]
        clock = Clock(
            offset_s=draw(st.integers(-9000, 9000)) / 1000,
            drift_ppm=draw(st.sampled_from([0, 0, 12.4, -30, 5000, -20000, 90000])),
        )
        cameras[name] = {"clock": clock, "gaps": tuple(draw(_some(frames)))}
    pose_ends = sorted({frames, *draw(st.lists(st.integers(1, frames), max_size=2))})
    poses, at = [], 0
    for number, end in enumerate(pose_ends):
        turned = ((0.8, -0.6, 300.0 + number), (0.6, 0.8, -20.0), (1e-5, 0.0, 1.0))
        others = {name: turned for name in names[1:-1]}
        weak = (Weak(names[-1], "too few matches"),)
        poses.append(Pose(R(at, end), {names[0]: IDENTITY, **others}, weak=weak, perspective=number // 2))
        at = end
    shots = tuple(Shot(piece, draw(st.sampled_from(names)), why="it sees the field") for piece in draw(_tiles(frames)))
    overrides = tuple(Override(piece, camera=draw(st.sampled_from(names)), note="so") for piece in draw(_some(frames)))
    return film(
        rate, frames, names=names, files=files, cameras=cameras, poses=tuple(poses), shots=shots, overrides=overrides
    )


@st.composite
def _tiles(draw: st.DrawFn, frames: int) -> list[FrameRange]:
    points = sorted({0, frames, *draw(st.lists(st.integers(0, frames), max_size=6))})
    return [R(a, b) for a, b in zip(points, points[1:], strict=False)]


@st.composite
def _some(draw: st.DrawFn, frames: int) -> list[FrameRange]:
    return [piece for piece in draw(_tiles(frames)) if draw(st.booleans())][:2]
