"""Where the field's true points come to lie in a programme, and the programme that the truth's own geometry would make.

Shares no geometry with what it judges but the map from programme pixel to camera pixel that the compositor uses; what
leads back is worked out here.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import lru_cache
from itertools import pairwise

import attrs
import cv2
import numpy as np
from attrs import frozen
from numpy.typing import NDArray

from mcsl_core import edl
from mcsl_core.alignment.colour_match import apply_colour
from mcsl_core.compositing.placement import has_relief, programme_matrix, surface_of
from mcsl_core.edl.following import placed_pose
from mcsl_core.edl.placement import first_of_perspective, placement_matrix
from mcsl_core.edl.resolve import Decision, resolve
from mcsl_core.imaging.planes import Planes
from mcsl_core.imaging.relief import Placement
from mcsl_core.imaging.warp import RemapTables, remap_planes
from mcsl_core.simulation import PoseTruth, Scenario, Truth
from mcsl_core.simulation.rig import PinholeCamera, Rig
from mcsl_core.simulation.schedule import LampPath, lamp_path
from mcsl_core.simulation.surface import Surface
from mcsl_core.simulation.truth import fit_homography, transfer
from mcsl_core.timing import FrameRange

RAISED_MM = 40.0  # where hands and instruments are, above the field
DRILL_S, SEEN = 1.5, 0.9  # from one drilled switch to the next, and how much of the field its camera sees past heads
AROUND = 3  # frames on either side of a switch
JUMP_WIDTH, SHIFT_WIDTH = 640, 960  # of the pictures whose pixels are counted
Points = NDArray[np.float64]
Map = Callable[[Points], Points]


# ---------------------------------------------------------------------------------------------------------- the maps


def to_programme(programme: edl.Edl, pose: edl.Pose, camera: str, *, surface: bool) -> Map:
    """From camera pixels, (N, 2), to programme pixels before centering, as the programme lays that camera's picture.

    Parameters
    ----------
    programme, pose, camera
        Of what; see `placed_pose`.
    surface
        By the pose's relief, where it has one; else by the plane.
    """
    matrix = programme_matrix(programme, pose, camera)
    back = surface_map(programme, pose, camera) if surface else None
    if back is None:
        return lambda px: transfer(matrix, px)
    return lambda px: inverse(back, px, transfer(matrix, px))


def surface_map(programme: edl.Edl, pose: edl.Pose, camera: str) -> Map | None:
    """From programme pixels before centering to the camera's pixels by the relief; None where there is none."""
    if not has_relief(programme, pose, camera):
        return None
    return Placement(programme_matrix(programme, pose, camera), surface_of(programme, pose, camera)).to_camera


def inverse(there: Map, px: Points, start: Points) -> Points:
    """The points that ``there`` leads to ``px``, by Newton's method from ``start``; its slopes over half a pixel."""
    at = np.array(start, np.float64)
    step = 0.5
    for _ in range(12):
        off = there(at) - px
        along = [(there(at + d) - there(at - d)) / (2 * step) for d in (np.array([step, 0]), np.array([0, step]))]
        slopes = np.stack(along, -1)
        flat = np.abs(np.linalg.det(slopes)) < 1e-3  # a fold: nothing leads there
        slopes[flat] = np.eye(2)
        at -= np.clip(np.linalg.solve(slopes, off[..., None])[..., 0], -8, 8)
    return at


# ------------------------------------------------------------------------------------------------- the field's points


def true_pose(truth: Truth, pose: edl.Pose) -> PoseTruth:
    """The true pose that lies at the middle of a solved one."""
    middle = (pose.range.start + pose.range.stop) // 2
    return min(truth.poses, key=lambda p: max(p.range[0] - middle, middle - p.range[1]))


def displacements(programme: edl.Edl, truth: Truth, *, surface: bool) -> dict[tuple[int, str], NDArray[np.float64]]:
    """By (pose, camera): how far from their place each of the field's points lies, pixels at `SHIFT_WIDTH`.

    Their place is where the reference camera showed them when the perspective began. Left out: that camera in that
    pose, which is the identity, and cameras that the pose has no place for.
    """
    found = {}
    for index, camera, seen, home in views(programme, truth):
        at = to_programme(programme, programme.poses[index], camera, surface=surface)(seen)
        found[index, camera] = _length(at - home, SHIFT_WIDTH / programme.size[0])
    return found


def best_planes(programme: edl.Edl, truth: Truth) -> dict[tuple[int, str], NDArray[np.float64]]:
    """As `displacements`, of the single planes that fit the truth best."""
    scale = SHIFT_WIDTH / programme.size[0]
    return {
        (index, camera): _length(transfer(fit_homography(seen, home), seen) - home, scale)
        for index, camera, seen, home in views(programme, truth)
    }


def views(programme: edl.Edl, truth: Truth) -> Iterator[tuple[int, str, Points, Points]]:
    """(pose, camera, the field's points in its picture, their place in the programme before centering)."""
    reference = truth.camera_index(truth.reference)
    for index, pose in enumerate(programme.poses):
        first = first_of_perspective(programme, index)
        home = true_pose(truth, programme.poses[first]).field_points_px[reference]
        for number, camera in enumerate(truth.cameras):
            itself = (index, camera) == (first, truth.reference)
            if not itself and placement_matrix(programme, pose, camera) is not None:
                yield index, camera, true_pose(truth, pose).field_points_px[number], home


def spread(values: NDArray[np.float64]) -> list[float]:
    """Median, rms and 95th percentile."""
    found = np.median(values), np.sqrt((values**2).mean()), np.percentile(values, 95)
    return [round(float(v), 3) for v in found]


def _length(shift: Points, scale: float) -> NDArray[np.float64]:
    return scale * np.hypot(*shift.T)


def in_movements(programme: edl.Edl, truth: Truth, *, surface: bool) -> NDArray[np.float64]:
    """As `displacements`, of what the programme shows in every third frame of movements; empty without any."""
    reference, lamp = truth.camera_index(truth.reference), Lamp(programme, truth)
    shown, found = decisions(programme), [np.zeros(0)]
    for movement in truth.in_movements:
        for frame in (int(f) for f in movement.frames if f < programme.frames):
            index, camera = programme.poses.index(programme.pose_at(frame)), shown[frame].camera
            first, pinhole = programme.poses[first_of_perspective(programme, index)], lamp.pinhole(camera, frame)
            if pinhole is None:
                continue
            seen = pinhole.project(truth.field_points_mm)
            at = to_programme(programme, placed_pose(programme, frame), camera, surface=surface)(seen)
            home = true_pose(truth, first).field_points_px[reference]
            found.append(_length(at - home, SHIFT_WIDTH / programme.size[0]))
    return np.concatenate(found)


# ------------------------------------------------------------------------------------------------------- at switches


@frozen
class Cut:
    """A switch while the lamp stands: the first frame of the camera ``after``."""

    frame: int
    before: str
    after: str


def switches(programme: edl.Edl, truth: Truth) -> list[Cut]:
    """Those between two frames in which the lamp truly stands."""
    found = []
    for (_, one), (piece, other) in pairwise(resolve(programme)):
        moves = any(start <= f < stop for start, stop in truth.movements for f in (piece.start - 1, piece.start))
        if one.camera != other.camera and not moves:
            found.append(Cut(piece.start, one.camera, other.camera))
    return found


def drilled(programme: edl.Edl, truth: Truth) -> edl.Edl:
    """The programme with a switch every `DRILL_S` while the lamp stands, to the next camera that sees the field.

    Analysed recordings of this length have one switch or none; where they lie, depends on the selection.
    """
    step, cuts = round(DRILL_S * programme.rate), [(0, programme.reference)]
    still = [range(a + step, b - AROUND) for a, b in (pose.range for pose in truth.poses)]
    for frame in (f for piece in still for f in piece[::step]):
        turn = truth.cameras.index(cuts[-1][1])
        others = [*truth.cameras[turn + 1 :], *truth.cameras[:turn]]
        pose = programme.pose_at(frame)
        seen = truth.visible_field_without_hands[frame - AROUND : frame + AROUND].min(0)
        free = [
            c
            for c in others
            if placement_matrix(programme, pose, c) is not None and seen[truth.cameras.index(c)] > SEEN
        ]
        if free:
            cuts.append((frame, free[0]))
    ends = [*(frame for frame, _ in cuts[1:]), programme.frames]
    shots = [edl.Shot(FrameRange(a, b), camera) for (a, camera), b in zip(cuts, ends, strict=True)]
    return attrs.evolve(programme, shots=tuple(shots), overrides=())


def jumps(programme: edl.Edl, truth: Truth, cut: Cut, *, surface: bool) -> tuple[float, float] | None:
    """How far the field's points, and others above them, jump at a switch: medians, pixels at `JUMP_WIDTH`.

    None where a camera has no picture then.
    """
    lamp, found = Lamp(programme, truth), []
    for lift in (0.0, RAISED_MM):
        points, places, inside = truth.field_points_mm + np.array([0, 0, lift]), [], []
        for frame, camera in ((cut.frame - 1, cut.before), (cut.frame, cut.after)):
            pinhole = lamp.pinhole(camera, frame)
            if pinhole is None:
                return None
            seen = pinhole.project(points)
            inside.append(((seen >= 0) & (seen < programme.size)).all(1))
            pose = placed_pose(programme, frame)
            places.append(to_programme(programme, pose, camera, surface=surface)(seen))
        both = inside[0] & inside[1]
        found.append(_length((places[1] - places[0])[both], JUMP_WIDTH / programme.size[0]))
    return float(np.median(found[0])), float(np.median(found[1]))


# ------------------------------------------------------------------------------------------------------- the floor


def shown_frame(programme: edl.Edl, truth: Truth, camera: str, frame: int) -> int | None:
    """The camera's own frame that the programme shows at ``frame``, by the clock it was given; None without one."""
    rate = float(truth.rate)
    own = int(np.floor(programme.camera(camera).clock.camera_time(frame / float(programme.rate)) * rate + 1e-6))
    return own if 0 <= own < truth.camera_frames[truth.camera_index(camera)] else None


class Lamp:
    """The true cameras at every programme frame, while the lamp moves, too: when they took what is shown then."""

    def __init__(self, programme: edl.Edl, truth: Truth) -> None:
        self._edl, self._truth = programme, truth
        self._rig, self._path = _rig(truth.scenario)

    def pinhole(self, camera: str, frame: int) -> PinholeCamera | None:
        """The camera at what it shows at ``frame``; None where it has no picture then."""
        own, index = shown_frame(self._edl, self._truth, camera, frame), self._truth.camera_index(camera)
        if own is None:
            return None
        at = self._truth.clocks[index].programme(own / float(self._truth.rate))
        return self._rig.camera(index, self._path.pose(at)[0])


@lru_cache(maxsize=4)
def _rig(scenario: Scenario) -> tuple[Rig, LampPath]:
    return Rig.of(scenario), lamp_path(scenario)


class TrueGeometry:
    """Lays the cameras' pictures where the truth has the surface, by the same single resampling.

    What is left between that and the ideal programme no alignment of what lies on the surface takes away: resampling,
    what is seen otherwise from another side, and hands above the surface.
    """

    def __init__(self, programme: edl.Edl, truth: Truth) -> None:
        self._edl, self._lamp = programme, Lamp(programme, truth)
        home = truth.poses[0].pinhole(truth.camera_index(truth.reference))
        x, y = np.meshgrid(*(np.arange(n, dtype=np.float64) for n in programme.size))
        gx, gy = (g.astype(np.float64) for g in _surface(truth.scenario).intersect(home, np.stack([x, y], -1)))
        gz = _surface(truth.scenario).height_at(gx, gy)
        self._points = np.stack([gx, gy, gz], -1).reshape(-1, 3)
        self._kept: tuple[object, RemapTables, NDArray[np.bool_]] | None = None

    def picture(self, planes: Planes, camera: str, frame: int, colour: bool) -> tuple[Planes, NDArray[np.bool_]] | None:
        """The camera's own picture at ``frame`` as it belongs, and which pixels (H, W) lie inside it."""
        pinhole = self._lamp.pinhole(camera, frame)
        if pinhole is None:
            return None
        tables, inside = self._tables((camera, pinhole.t.tobytes(), pinhole.R.tobytes()), pinhole)
        made = remap_planes(planes, tables)
        match = self._edl.pose_at(frame).colour.get(camera) if colour else None
        return (made if match is None else apply_colour(made, match)), inside

    def mask(self, mask: NDArray[np.bool_], camera: str, frame: int) -> NDArray[np.bool_]:
        """Where a mask of the camera's picture comes to lie, and what lies outside of that."""
        pinhole = self._lamp.pinhole(camera, frame)
        assert pinhole is not None
        tables, inside = self._tables((camera, pinhole.t.tobytes(), pinhole.R.tobytes()), pinhole)
        return (cv2.remap(mask.astype(np.uint8), *tables.luma, cv2.INTER_NEAREST) > 0) | ~inside  # pyright: ignore

    def _tables(self, key: object, pinhole: PinholeCamera) -> tuple[RemapTables, NDArray[np.bool_]]:
        if self._kept is None or self._kept[0] != key:
            width, height = self._edl.size
            at = pinhole.project(self._points).reshape(height, width, 2)
            inside = np.asarray(((at >= 0) & (at <= (width - 1, height - 1))).all(-1))
            # A chroma sample lies half a pixel below its cell's first luma sample, in both pictures.
            between = (at[0::2, 0::2] + at[1::2, 0::2]) / 2
            chroma = (between - (0, 0.5)) / 2
            tables = RemapTables(_table(at), _table(chroma))
            self._kept = key, tables, inside
        return self._kept[1], self._kept[2]


def _table(at: Points) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    x, y = np.ascontiguousarray(at.transpose(2, 0, 1), np.float32)
    return x, y


@lru_cache(maxsize=2)
def _surface(scenario: Scenario) -> Surface:
    return Surface.of(scenario)


def decisions(programme: edl.Edl) -> list[Decision]:
    """By frame."""
    return [decision for piece, decision in resolve(programme) for _ in piece]
