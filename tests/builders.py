"""Small EDLs, and what an untouched sequencer looks like after a plan was built."""

from __future__ import annotations

from fractions import Fraction

import attrs

from blender_addon.core.corrections import FoundCamera
from blender_addon.core.read_overrides import FoundStrip, SequencerState
from blender_addon.core.strip_plan import StripPlan
from mcsl_core.edl import IDENTITY, Camera, Edl, Media, Pose, Shot
from mcsl_core.timing import FrameRange

R = FrameRange
CAMERAS = ("cam1", "cam2", "cam3")


def small_edl(frames: int = 300, **fields) -> Edl:
    """Three cameras, reference cam1, one pose; shots cam1 [0,100), cam2 [100,200), cam3 [200,300)."""
    given = {
        "rate": Fraction(30),
        "size": (320, 180),
        "frames": frames,
        "reference": "cam1",
        "cameras": tuple(
            Camera(name, (Media(f"{name}.mp4", frames),), size=(320, 180), rate=Fraction(30)) for name in CAMERAS
        ),
        "poses": (Pose(R(0, frames), dict.fromkeys(CAMERAS, IDENTITY)),),
    }
    if "shots" not in fields:
        ends = (0, frames // 3, 2 * frames // 3, frames)
        given["shots"] = tuple(Shot(R(a, b), name) for a, b, name in zip(ends, ends[1:], CAMERAS, strict=False))
    return Edl(**{**given, **fields})


def state_of(plan: StripPlan) -> SequencerState:
    """The sequencer just after building ``plan``, as reading it back must find it."""
    return SequencerState(
        strips=tuple(
            FoundStrip(s.id, plan.programme_channel, s.range.start, s.range.stop, s.source) for s in plan.programme
        ),
        cameras=tuple(
            FoundCamera(
                camera=track.camera,
                channel=track.channel,
                start=piece.range.start,
                stop=piece.range.stop,
                name=f"{track.camera}.{piece.range.start}",
                transform=piece.transform,
                planned=piece.planned,
            )
            for track in plan.cameras
            for file in track.files
            for piece in file.pieces
        ),
        automatic=plan.automatic,
    )


def small(frames: int = 100, **fields) -> Edl:
    """Two cameras, reference cam1, one pose; shots cam1 [0,40), cam2 [40,100)."""
    cameras = tuple(Camera(n, (Media(f"{n}.mp4", frames),), (320, 180), Fraction(25)) for n in ("cam1", "cam2"))
    return attrs.evolve(
        Edl(
            rate=Fraction(25),
            size=(320, 180),
            frames=frames,
            reference="cam1",
            cameras=cameras,
            poses=(Pose(R(0, frames), {"cam1": IDENTITY, "cam2": IDENTITY}),),
            shots=(Shot(R(0, 40), "cam1"), Shot(R(40, frames), "cam2")),
        ),
        **fields,
    )
