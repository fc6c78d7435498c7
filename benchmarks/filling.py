"""How right the filled pixels are, against the simulated scene without people and with a wide canvas.

    python -m benchmarks.filling FOLDER [NAME ...]        makes what is missing, writes results/filling.md

Programme frames by the paper's filler and by the default, from the analysis's EDL, as it centres them and shifted by a
tenth of the picture by hand, are held against `UnoccludedScene`: the same instant without heads and hands, seen by the
reference camera of the first pose on a larger image plane. Counted are the pixels that the chosen camera does not see,
but some camera in some pose of this perspective. Twice: with the cameras filming the empty room, which shows what a
filler does, and as recorded, where people stand in the other cameras' views as well. The default lays the other cameras
in three ways: by their planes alone, by the optical flow between medians (`compositing.parallax`), by the relief.
"""

from __future__ import annotations

import math
import platform
import sys
import time
from collections.abc import Iterator, Sequence
from datetime import date
from pathlib import Path

import attrs
import numpy as np
from attrs import frozen
from numpy.typing import NDArray

from benchmarks.recordings import RECORDINGS, make
from mcsl_core import edl
from mcsl_core.analysis.pipeline import analyse
from mcsl_core.analysis.settings import AnalysisSettings
from mcsl_core.compositing.compositor import Compositor, block_frames
from mcsl_core.compositing.parallax import Parallax
from mcsl_core.compositing.picture_source import PictureSource
from mcsl_core.compositing.placement import programme_matrix, surface_of
from mcsl_core.edl.placement import still_range
from mcsl_core.edl.resolve import resolve, shift_at
from mcsl_core.filling.footprint import FootprintFiller
from mcsl_core.filling.paper import PaperFiller
from mcsl_core.filling.protocol import Filler
from mcsl_core.hooks.registry import discover
from mcsl_core.imaging.planes import Planes, median_planes, planes_to_bgr
from mcsl_core.imaging.relief import Placement
from mcsl_core.lru_cache import LruCache
from mcsl_core.progress import Silent
from mcsl_core.recording.footage import Footage
from mcsl_core.simulation import Truth, load_truth
from mcsl_core.simulation.ground import Ground
from mcsl_core.simulation.render import CameraPictures
from mcsl_core.simulation.scene import Scene
from mcsl_core.simulation.unoccluded import UnoccludedScene
from mcsl_core.timing import FrameRange

RESULTS = Path(__file__).parent / "results"
FRAMES = 3  # judged in each pose
SHIFT = 0.1  # of the picture's width and height, to the right and down
_ROOM_BYTES = 300_000_000  # of pictures of the empty room, which take longest


@frozen
class Way:
    """One way to fill: by which filler, the other cameras laid how."""

    filler: Filler
    surface: bool = False
    flow: bool = False


WAYS = {
    "paper": Way(PaperFiller(), surface=True, flow=True),
    "planes": Way(FootprintFiller()),
    "flow": Way(FootprintFiller(), flow=True),
    "relief": Way(FootprintFiller(), surface=True, flow=True),
}


@frozen
class Row:
    """One pose of one recording, centred in one way.

    Attributes
    ----------
    name, pose, centred
        Which it is.
    share, nobody : float
        Of the picture: what the chosen camera does not show, but some camera in some pose; and what no camera ever
        shows, which all leave black.
    empty_db, people_db : tuple of float
        By each of `WAYS`: PSNR of the filled pixels, the room empty and as recorded.
    black : tuple of float
        By each of `WAYS`: share of those left black, the room empty.
    cpu_ms : tuple of float
        By each of `WAYS`: a frame, beyond the same without fill.
    """

    name: str
    pose: int
    centred: str
    share: float
    nobody: float
    empty_db: tuple[float, ...]
    black: tuple[float, ...]
    people_db: tuple[float, ...]
    cpu_ms: tuple[float, ...]


class EmptyRoom:
    """A `PictureSource` of what the cameras would have filmed without people."""

    def __init__(self, truth: Truth) -> None:
        self._kept: LruCache[Planes] = LruCache(_ROOM_BYTES)
        simulated = Scene.of(attrs.evolve(truth.scenario, heads=0, hands=0))
        ground = Ground.of(simulated.scenario, simulated.surface, simulated.rig)
        self._truth = truth
        self._pictures = {
            name: CameraPictures(simulated, ground, index, clock)
            for index, (name, clock) in enumerate(zip(truth.cameras, truth.clocks, strict=True))
        }

    def player(self, camera: str) -> _EmptyRoomPlayer:
        return _EmptyRoomPlayer(self, camera)

    def median(self, camera: str, frames: Sequence[int], within: FrameRange) -> Planes | None:
        pictures = [self.picture(camera, frame) for frame in frames]
        known = [picture for picture in pictures if picture is not None]
        return median_planes(known) if known else None

    def picture(self, camera: str, frame: int) -> Planes | None:
        own = self._truth.own_frame(camera, frame)
        return None if own is None else self._kept.get((camera, own), lambda: self._pictures[camera].frame(own)[0])


@frozen
class _EmptyRoomPlayer:
    room: EmptyRoom
    camera: str

    def at(self, frame: int) -> Planes | None:
        return self.room.picture(self.camera, frame)

    def close(self) -> None:
        """Nothing was opened."""


@frozen(eq=False)
class Recording:
    """A simulated recording: its truth, and what its cameras filmed without and with people."""

    name: str
    scene: UnoccludedScene
    room: EmptyRoom
    filmed: Footage


def measure(folder: Path, name: str) -> Iterator[Row]:
    """The rows of one recording, from its analysis, which is made when it is not there yet."""
    source = make(folder, name) if name in RECORDINGS else folder / name
    truth = load_truth(source)
    out = folder / f"{name}.ours" / "edl.json"
    if not out.exists():
        settings = AnalysisSettings()
        analyse([source], out, settings=settings, plugins=discover(), progress=Silent())
    made = edl.load(out)
    filmed = Footage(made.cameras, rate=made.rate, frames=made.frames, base=out.parent)
    recording = Recording(name, UnoccludedScene(truth.scenario), EmptyRoom(truth), filmed)
    by_hand = (0, SHIFT * made.size[0], SHIFT * made.size[1])
    for centred, keys in (("as analysed", made.centering), ("by a tenth", (by_hand,))):
        programme = attrs.evolve(made, centering=keys)
        for pose_index, pose in enumerate(programme.poses):
            frames = judged_frames(programme, still_range(programme, pose))
            if pose.perspective == made.poses[0].perspective and frames:
                yield judged(recording, programme, pose_index, centred, frames)


def judged_frames(programme: edl.Edl, still: FrameRange) -> list[int]:
    """Frames spread over ``still`` at which a filler that remembers begins anew: there it costs a handful of frames."""
    step = block_frames(programme)
    starts = list(range(-(-still.start // step) * step, still.stop, step))
    if not starts:
        return []
    return [starts[i] for i in sorted(set(np.linspace(0, len(starts) - 1, FRAMES).round().astype(int)))]


def judged(recording: Recording, programme: edl.Edl, pose_index: int, centred: str, frames: list[int]) -> Row:
    """One row, over ``frames`` of one pose."""
    ways = list(WAYS.values())
    errors, black, count, filled, nobody = np.zeros((2, len(ways))), np.zeros(len(ways)), 0, 0, 0
    flows = [(pictures, Parallax(programme, pictures)) for pictures in (recording.room, recording.filmed)]
    for frame in frames:
        decision = next(d for piece, d in resolve(programme) if frame in piece)
        offset = shift_at(programme, decision, frame)
        hole, by_some = holes(programme, pose_index, decision.camera, offset)
        count, nobody = count + hole.size, nobody + int((hole & ~by_some).sum())
        hole &= by_some
        filled += int(hole.sum())
        truth = planes_to_bgr(recording.scene.at(float(frame / programme.rate), offset))
        for j, (pictures, flow) in enumerate(flows):
            for i, way in enumerate(ways):
                with compositor_of(programme, pictures, way, flow) as compositor:
                    planes = next(iter(compositor.frames(FrameRange(frame, frame + 1))))
                picture = planes_to_bgr(planes)[hole]
                errors[j, i] += ((picture.astype(float) - truth[hole]) ** 2).mean(axis=1).sum()
                black[i] += int((picture.max(axis=1) <= 10).sum()) if pictures is recording.room else 0
    middle = frames[len(frames) // 2]
    cpu = [cost(programme, recording.filmed, way, flows[1][1], middle) for way in ways]
    psnr = [[10 * math.log10(255**2 * filled / error) for error in row] for row in errors] if filled else [[], []]
    return Row(
        recording.name,
        pose_index,
        centred,
        filled / count,
        nobody / count,
        tuple(psnr[0]),
        tuple(float(v) for v in black / max(filled, 1)),
        tuple(psnr[1]),
        tuple(cpu),
    )


def compositor_of(programme: edl.Edl, pictures: PictureSource, way: Way, flow: Parallax) -> Compositor:
    """Fills in one of the `WAYS`; ``flow`` is found once for all."""
    laid = attrs.evolve(
        programme,
        look=attrs.evolve(programme.look, surface=way.surface),
        overrides=tuple(attrs.evolve(o, surface=None) for o in programme.overrides),
    )
    return Compositor(laid, pictures, filler=way.filler, parallax=flow if way.flow else _NoFlow(programme, pictures))


class _NoFlow(Parallax):
    def of(self, pose_index: int, camera: str) -> None:
        return None


def holes(
    programme: edl.Edl, pose_index: int, camera: str, offset: tuple[float, float]
) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """(H, W), (H, W): where ``camera`` does not reach, in whatever way it is laid; where some camera does."""
    pose = programme.poses[pose_index]
    hole = np.logical_and.reduce([~inside(programme, pose, camera, offset, surface=s) for s in (False, True)])
    kin = [p for p in programme.poses if p.perspective == pose.perspective]
    by_some = [
        inside(programme, p, c.name, offset, surface=True)
        for p in kin
        for c in programme.cameras
        if c.name in p.homographies
    ]
    return hole, np.logical_or.reduce(by_some)


def inside(
    programme: edl.Edl, pose: edl.Pose, camera: str, offset: tuple[float, float], *, surface: bool
) -> NDArray[np.bool_]:
    """(H, W): where ``camera`` reaches; a pixel at its edge, half inside, does not count."""
    width, height = programme.size
    x, y = np.meshgrid(np.arange(width, dtype=np.float64), np.arange(height, dtype=np.float64))
    field = surface_of(programme, pose, camera) if surface else None
    placement = Placement(programme_matrix(programme, pose, camera), field, offset)
    seen = placement.to_camera(np.column_stack([x.ravel(), y.ravel()]))
    reach = np.array(programme.camera(camera).size) - 1
    return np.asarray(((seen >= 0) & (seen <= reach)).all(axis=1).reshape(height, width))


def cost(programme: edl.Edl, footage: Footage, way: Way, flow: Parallax, frame: int) -> float:
    """CPU in ms a frame over a second from ``frame`` on, after a first second; beyond the same without fill."""
    second = round(programme.rate)
    stop = min(frame + 2 * second, programme.frames)
    start = max(0, stop - second)
    spent = []
    for fill in (False, True):
        before = 0.0
        made = attrs.evolve(programme, look=attrs.evolve(programme.look, fill=fill))
        with compositor_of(made, footage, way, flow) as compositor:
            for index, _ in enumerate(compositor.frames(FrameRange(max(0, start - second), stop))):
                if index == second - 1:
                    before = time.process_time()
        spent.append(1000 * (time.process_time() - before) / second)
    return spent[1] - spent[0]


def table(rows: list[Row]) -> str:
    """The page: a row a pose and centering."""
    lines = [
        "# Filling against simulated truth",
        "",
        f"{date.today()}, {platform.machine()}. `python -m benchmarks.filling FOLDER`",
        "",
        "PSNR of the pixels that the chosen camera does not see, but some camera in some pose of the perspective (the",
        "rest is nobody's), against the scene without people seen by the first pose's reference camera on a wider",
        "plane: with the cameras filming the empty room, and as recorded. Each time the paper's filler (`reference`),",
        "then the default (`footprint`) with the other cameras laid by planes alone, by the flow between medians, and",
        "by the relief. Black: share of those pixels left black in the empty room. CPU: what filling costs a frame",
        "beyond the same without it, decoding the other cameras included.",
        "",
        f"In each field: {', '.join(WAYS)}.",
        "",
        "| recording | pose | centred | filled | nobody's | empty room, dB | as recorded, dB | black | CPU, ms |",
        "|---|---|---|---|---|---|---|---|---|",
    ]
    for r in rows:
        fields = (
            *(", ".join(f"{v:.1f}" for v in values) for values in (r.empty_db, r.people_db)),
            ", ".join(f"{v:.1%}" for v in r.black),
            ", ".join(f"{v:.0f}" for v in r.cpu_ms),
        )
        lines.append(f"| {r.name} | {r.pose} | {r.centred} | {r.share:.0%} | {r.nobody:.1%} | {' | '.join(fields)} |")
    names = list(WAYS)
    for what, of in (("In the empty room", "empty_db"), ("As recorded", "people_db")):
        for way, other in (("relief", "paper"), ("relief", "planes"), ("relief", "flow"), ("flow", "planes")):
            values = [getattr(r, of) for r in rows if r.empty_db]
            gains = [v[names.index(way)] - v[names.index(other)] for v in values]
            lines += [
                "",
                f"{what}, `{way}` is ahead of `{other}` in {sum(g > 0 for g in gains)} of {len(gains)} rows, by "
                f"{np.median(gains):.1f} dB in the median ({min(gains):.1f} to {max(gains):.1f}).",
            ]
    return "\n".join(lines) + "\n"


def main() -> None:
    folder = Path(sys.argv[1])
    rows = []
    for name in sys.argv[2:] or RECORDINGS:
        for row in measure(folder, name):
            print(row, flush=True)
            rows.append(row)
            (RESULTS / "filling.md").write_text(table(rows), "utf-8")


if __name__ == "__main__":
    main()
