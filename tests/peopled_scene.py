"""A field seen by five cameras around it, with things that stand at known heights over it, as pictures in memory."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from fractions import Fraction
from pathlib import Path

import attrs
import cv2
import numpy as np
from attrs import frozen
from numpy.typing import NDArray

from mcsl_core.edl import IDENTITY, Camera, Edl, Look, Media, Movement, MovementView, Pose, Relief, Shot
from mcsl_core.imaging.geometry import to_edl_matrix, to_edl_projection
from mcsl_core.imaging.planes import Planes, bgr_to_planes, median_planes
from mcsl_core.media.writing import VideoWriter
from mcsl_core.timing import FrameRange

SIZE, RATE, FRAMES = (320, 180), Fraction(10), 70
CAMERAS = ("cam1", "cam2", "cam3", "cam4", "cam5")
MOVES = FrameRange(34, 48)  # when a lamp moves that does
HAND, HEAD = 60.0, 380.0  # mm over the field
_HIGH, _AROUND, _FOCAL = 1000.0, 220.0, 1.8 * SIZE[0]  # mm, mm, pixels
_PITCH, _HALF = 1.5, 600.0  # of the field's picture, mm a pixel; of its width, mm
_GAMMA = 500.0  # about one pixel for a gamma of 1


@frozen(eq=False)
class Thing:
    """Something flat and round at a height.

    Parameters
    ----------
    height
        Over the field, mm.
    centre
        (x, y) of its middle by programme frame, mm; None where it is not there.
    radius
        In mm.
    colour
        BGR.
    """

    height: float
    centre: Callable[[int], tuple[float, float] | None]
    radius: float
    colour: tuple[int, int, int]


def lens_of(camera: str) -> NDArray[np.float64]:
    """(3,): where a camera is, mm."""
    angle = 2 * np.pi * CAMERAS.index(camera) / len(CAMERAS)
    return np.array([_AROUND * np.cos(angle), _AROUND * np.sin(angle), _HIGH])


def above(camera: str, place: tuple[float, float], height: float) -> tuple[float, float]:
    """Where something so high stands that hides a place of the field from a camera, mm."""
    x, y = np.array(place) + (lens_of(camera)[:2] - place) * height / _HIGH
    return float(x), float(y)


def pinhole_of(camera: str, by: tuple[float, float] = (0.0, 0.0)) -> NDArray[np.float64]:
    """(3, 4): world, mm -> the camera's pixel; aimed at the field's middle, each turned a little.

    by: how far the lamp has moved, mm.
    """
    lens, turn = lens_of(camera) + np.array([*by, 0.0]), 0.2 * CAMERAS.index(camera)
    ahead = -lens / np.linalg.norm(lens)
    right = np.cross(ahead, [np.sin(turn), np.cos(turn), 0.0])
    right /= np.linalg.norm(right)
    rotation = np.stack([right, np.cross(ahead, right), ahead])
    inner = np.array([[_FOCAL, 0, (SIZE[0] - 1) / 2], [0, _FOCAL, (SIZE[1] - 1) / 2], [0, 0, 1]])
    return inner @ rotation @ np.column_stack([np.eye(3), -lens])


def at_height(camera: str, height: float, by: tuple[float, float] = (0.0, 0.0)) -> NDArray[np.float64]:
    """(3, 3): x and y at a height, mm -> the camera's pixel."""
    pinhole = pinhole_of(camera, by)
    return np.column_stack([pinhole[:, 0], pinhole[:, 1], pinhole[:, 3] + height * pinhole[:, 2]])


def projection_of(camera: str, by: tuple[float, float] = (0.0, 0.0)) -> NDArray[np.float64]:
    """(3, 4): the reference camera's pixel before the lamp moved, and gamma -> the camera's pixel, as an EDL has it."""
    down = np.linalg.inv(at_height("cam1", 0.0))
    plane = np.stack([down[0], down[1], np.zeros(3), down[2]]) * _HIGH
    made = pinhole_of(camera, by) @ np.column_stack([plane, np.append(lens_of("cam1"), 1.0) / _GAMMA])
    return made / made[2, 2]


def field() -> NDArray[np.uint8]:
    """(H, W, 3) BGR: drapes, and something in their middle."""
    rng, side = np.random.default_rng(3), round(2 * _HALF / _PITCH)
    noise = cv2.GaussianBlur(rng.uniform(-1, 1, (side, side, 3)), (0, 0), 6.0)
    picture = np.clip(np.array([110, 130, 90]) + 900 * noise, 20, 230)
    cv2.circle(picture, (side // 2, side // 2), 40, (40, 40, 150), -1)
    return picture.astype(np.uint8)


def still(frame: int) -> tuple[float, float]:
    """A lamp that stands."""
    return 0.0, 0.0


def moved(frame: int) -> tuple[float, float]:
    """A lamp that moves over `MOVES`, mm."""
    part = min(max((frame - MOVES.start) / (len(MOVES) - 1), 0.0), 1.0)
    return 90 * part, -60 * part


class Filmed:
    """A `PictureSource` of the cameras' pictures, drawn when they are asked for."""

    def __init__(
        self,
        things: Sequence[Thing],
        gains: Mapping[str, float] | None = None,
        lamp: Callable[[int], tuple[float, float]] = still,
    ) -> None:
        self._lamp = lamp
        self._things, self._gains = sorted(things, key=lambda thing: thing.height), gains or {}
        self._field = field()
        self.decoded: list[tuple[str, int]] = []

    def player(self, camera: str) -> _Player:
        return _Player(self, camera)

    def median(self, camera: str, frames: Sequence[int], within: FrameRange) -> Planes | None:
        return median_planes([self.picture(camera, frame) for frame in frames])

    def picture(self, camera: str, frame: int) -> Planes:
        """What the camera shows at a programme frame."""
        by = self._lamp(frame)
        to_mm = np.array([[_PITCH, 0, -_HALF], [0, _PITCH, -_HALF], [0, 0, 1]])
        out = cv2.warpPerspective(self._field, at_height(camera, 0.0, by) @ to_mm, SIZE, flags=cv2.INTER_LINEAR)
        for thing in self._things:
            at = thing.centre(frame)
            if at is not None:
                side = 2 * thing.radius / 100
                place = np.array([[side, 0, at[0] - 64 * side], [0, side, at[1] - 64 * side], [0, 0, 1]])
                mask = cv2.circle(np.zeros((129, 129), np.uint8), (64, 64), 50, 255, -1, cv2.LINE_AA)
                share = cv2.warpPerspective(mask, at_height(camera, thing.height, by) @ place, SIZE)[..., None] / 255
                out = out * (1 - share) + np.array(thing.colour) * share
        noise = np.random.default_rng([frame, *camera.encode()]).normal(0, 1.5, out.shape)
        return bgr_to_planes(np.clip(out * self._gains.get(camera, 1.0) + noise, 0, 255).astype(np.uint8))


class _Player:
    def __init__(self, film: Filmed, camera: str) -> None:
        self._film, self._camera = film, camera

    def at(self, frame: int) -> Planes | None:
        self._film.decoded.append((self._camera, frame))
        return self._film.picture(self._camera, frame)

    def close(self) -> None:
        pass


def programme(camera: str, *, see_through: bool = True, **changes) -> Edl:
    """One pose, one shot."""
    projections = {name: to_edl_projection(projection_of(name)) for name in CAMERAS}
    homographies = {name: to_edl_matrix(np.linalg.inv(projection_of(name)[:, :3])) for name in CAMERAS}
    relief = Relief(projections, ((0.0,) * 32,) * 18, ((100,) * 32,) * 18)
    pose = Pose(FrameRange(0, FRAMES), {**homographies, "cam1": IDENTITY}, relief=relief)
    values = {
        "cameras": tuple(Camera(name, (Media(f"{name}.mp4", FRAMES),), SIZE, RATE) for name in CAMERAS),
        "poses": (pose,),
        "shots": (Shot(FrameRange(0, FRAMES), camera),),
        "look": Look(centering=False, fill=False, colour=False, see_through=see_through),
        **changes,
    }
    return Edl(rate=RATE, size=SIZE, frames=FRAMES, reference="cam1", **values)


def followed_programme(camera: str, *, see_through: bool = True) -> Edl:
    """Two poses, and a movement between them that is followed, of a lamp that has `moved`."""
    (before,) = programme(camera).poses
    views = [_as_seen(frame) for frame in range(MOVES.start - 2, MOVES.stop + 2)]
    movement, last = Movement(MOVES, views=tuple(views)), views[-1]
    anchor = np.array(last.homographies["cam1"])
    matrices = {name: np.linalg.inv(anchor) @ np.array(matrix) for name, matrix in last.homographies.items()}
    homographies = {name: to_edl_matrix(matrix) for name, matrix in matrices.items()} | {"cam1": IDENTITY}
    assert before.relief is not None
    relief = attrs.evolve(before.relief, projections=last.projections)
    after = Pose(FrameRange(movement.middle, FRAMES), homographies, anchor=to_edl_matrix(anchor), relief=relief)
    first = attrs.evolve(before, range=FrameRange(0, movement.middle))
    return programme(camera, see_through=see_through, poses=(first, after), movements=(movement,))


def _as_seen(frame: int) -> MovementView:
    projections = {name: projection_of(name, moved(frame)) for name in CAMERAS}
    homographies = {name: to_edl_matrix(np.linalg.inv(p[:, :3])) for name, p in projections.items()}
    return MovementView(frame, homographies, {name: to_edl_projection(p) for name, p in projections.items()})


def write_films(film: Filmed, folder: Path) -> Path:
    """The film as a file of every camera, as `programme` names them."""
    for name in CAMERAS:
        with VideoWriter(folder / f"{name}.mp4", size=SIZE, rate=RATE) as writer:
            for frame in range(FRAMES):
                writer.write(film.picture(name, frame))
    return folder
