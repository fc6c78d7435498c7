"""The edit-decision list: the one document between analysis, editor and renderer. Written out in docs/edl.md.

Conventions: ranges are half-open frame ranges on the programme clock; pixel centres lie at integers;
homographies are 3x3 row-major, scaled so that the last element is 1, and act on full-size pixels.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from fractions import Fraction
from itertools import pairwise
from pathlib import Path
from typing import Any

import attrs
from attrs import field, frozen

from .documents import canonical_json, doc, make_converter, read_json, structure_document, write_atomic
from .errors import DocumentError
from .timing import FrameRange, check_tiles, cut_points, merge_equal

SCHEMA = "mcsl.edl/1"

Matrix = tuple[tuple[float, float, float], tuple[float, float, float], tuple[float, float, float]]
Matrix34 = tuple[
    tuple[float, float, float, float], tuple[float, float, float, float], tuple[float, float, float, float]
]
IDENTITY: Matrix = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


def _require(condition: bool, message: str) -> None:
    if not condition:
        raise ValueError(message)


def _positive_size(_: Any, attribute: attrs.Attribute, value: tuple[int, int]) -> None:
    _require(min(value) > 0, f"{attribute.name} must be positive, got {list(value)}")


def _unit(_: Any, attribute: attrs.Attribute, value: float) -> None:
    _require(0 <= value <= 1, f"{attribute.name} must lie in 0..1, got {value}")


def _invertible(matrix: Matrix, name: str) -> None:
    (a, b, c), (d, e, f), (g, h, i) = matrix
    determinant = a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g)
    _require(abs(determinant) > 1e-12, f"{name} is singular")


@frozen
class Media:
    """One file of a camera; a camera's files are played one after another."""

    path: str = field(metadata=doc("relative to the EDL's folder, or absolute; forward slashes"))
    frames: int = field(metadata=doc("pictures in the file"))
    fingerprint: str = field(default="", metadata=doc("content key: changes when the file does"))

    def __attrs_post_init__(self) -> None:
        _require(bool(self.path), "path is empty")
        _require(self.frames > 0, f"frames must be positive, got {self.frames}")


@frozen
class Clock:
    """A camera's own time is ``(t - offset_s) * (1 + drift_ppm * 1e-6)`` at programme time t seconds."""

    offset_s: float = field(default=0.0, metadata=doc("programme time in seconds at which the camera's time is 0"))
    drift_ppm: float = field(default=0.0, metadata=doc("how much faster the camera's clock runs, parts per million"))
    method: str = field(default="none", metadata=doc("which sync found it: timecode, audio, motion, none, hand"))
    confidence: float = field(default=0.0, validator=_unit, metadata=doc("0 (a guess) to 1 (certain)"))

    def camera_time(self, programme_s: float | Fraction) -> float:
        """The camera's own time in seconds at programme time ``programme_s``."""
        return (float(programme_s) - self.offset_s) * (1 + self.drift_ppm * 1e-6)

    def programme_time(self, camera_s: float | Fraction) -> float:
        """The programme time in seconds at the camera's own time ``camera_s``; the inverse of `camera_time`."""
        return float(camera_s) / (1 + self.drift_ppm * 1e-6) + self.offset_s


@frozen
class Camera:
    """One view: its files, their size and rate, and how its clock stands to the programme's."""

    name: str = field(metadata=doc("unique; used everywhere else in this document"))
    media: tuple[Media, ...] = field(metadata=doc("played one after another"))
    size: tuple[int, int] = field(validator=_positive_size, metadata=doc("displayed width and height in pixels"))
    rate: Fraction = field(metadata=doc("nominal frames per second"))
    clock: Clock = field(factory=Clock, metadata=doc("relation to the programme clock"))
    gaps: tuple[FrameRange, ...] = field(default=(), metadata=doc("programme ranges with no picture"))

    def __attrs_post_init__(self) -> None:
        _require(bool(self.name), "name is empty")
        _require(bool(self.media), f"camera {self.name} has no media")


@frozen
class Movement:
    """A stretch in which the lamp moves."""

    range: FrameRange = field(metadata=doc("first moving frame to first frame standing still again"))
    confidence: float = field(default=1.0, validator=_unit, metadata=doc("0..1"))


@frozen
class Weak:
    """A camera that cannot be tied to the others in a pose; no automatic shot uses it there."""

    camera: str = field(metadata=doc("camera name"))
    reason: str = field(metadata=doc("why, in words for a person"))


@frozen
class Colour:
    """Matches a camera's colours to the reference camera's."""

    matrix: Matrix34 = field(
        metadata=doc("[Y', Cb, Cr, 1] of the camera, BT.709 limited range, 8-bit codes -> of the reference camera")
    )


@frozen
class Pose:
    """A stretch in which the lamp stands still, and how every camera then sees the programme's perspective."""

    range: FrameRange = field(metadata=doc("poses tile [0, frames)"))
    homographies: Mapping[str, Matrix] = field(
        metadata=doc("camera pixel -> reference camera pixel; the reference's own is the identity; weak ones may lack")
    )
    anchor: Matrix = field(default=IDENTITY, metadata=doc("reference camera pixel of this pose -> programme pixel"))
    perspective: int = field(default=0, metadata=doc("poses of one number share the programme's perspective"))
    colour: Mapping[str, Colour] = field(factory=dict, metadata=doc("camera -> match to the reference camera"))
    solved_from: tuple[int, ...] = field(default=(), metadata=doc("programme frames the homographies were solved from"))
    residual_px: Mapping[str, float] = field(
        factory=dict, metadata=doc("camera -> rms transfer error of the matches kept, reference pixels")
    )
    support: Mapping[str, int] = field(
        factory=dict, metadata=doc("camera -> distinct places (4-pixel cells) its matches come from")
    )
    weak: tuple[Weak, ...] = field(default=(), metadata=doc("cameras that could not be tied in, and why"))

    def __attrs_post_init__(self) -> None:
        for name, matrix in self.homographies.items():
            _invertible(matrix, f"homographies.{name}")
        _invertible(self.anchor, "anchor")
        _require(self.perspective >= 0, "perspective must be 0 or more")

    @property
    def weak_cameras(self) -> frozenset[str]:
        return frozenset(w.camera for w in self.weak)


@frozen
class Shot:
    """A stretch of the programme taken from one camera, as the analysis chose it."""

    range: FrameRange = field(metadata=doc("shots tile [0, frames)"))
    camera: str = field(metadata=doc("camera name"))
    score: float = field(default=0.0, validator=_unit, metadata=doc("mean visible field over the shot, 0..1"))
    why: str = field(default="", metadata=doc("the reason, in words for a person"))


@frozen
class Override:
    """An editor's decision over a stretch: each field given wins over the analysis; of two, the later in the list."""

    range: FrameRange = field(metadata=doc("where it holds"))
    camera: str | None = field(default=None, metadata=doc("take this camera", optional=True))
    centering: bool | None = field(default=None, metadata=doc("centering on or off", optional=True))
    fill: bool | None = field(default=None, metadata=doc("fill on or off", optional=True))
    colour: bool | None = field(default=None, metadata=doc("colour matching on or off", optional=True))
    note: str = field(default="", metadata=doc("the editor's remark", optional=True))


@frozen
class Look:
    """The visual aids, each on or off for the whole programme."""

    centering: bool = field(default=True, metadata=doc("shift the surgical field to the middle"))
    fill: bool = field(default=True, metadata=doc("fill pixels the warp leaves empty from other views"))
    colour: bool = field(default=True, metadata=doc("match each camera's colours to the reference camera"))


@frozen
class MadeBy:
    """What made the analysis, so that it can be made again."""

    mcsl: str = field(metadata=doc("version of mcsl"))
    settings: Mapping[str, Any] = field(factory=dict, metadata=doc("settings of the analysis"))
    plugins: Mapping[str, str] = field(factory=dict, metadata=doc("stage -> name, package and version that did it"))


CenteringKey = tuple[int, float, float]


@frozen(kw_only=True)
class Edl:
    """The whole document."""

    rate: Fraction = field(metadata=doc("programme frames per second; frame n stands at n / rate seconds"))
    size: tuple[int, int] = field(validator=_positive_size, metadata=doc("programme width and height in pixels"))
    frames: int = field(metadata=doc("length of the programme"))
    reference: str = field(metadata=doc("the camera whose perspective the programme keeps"))
    cameras: tuple[Camera, ...] = field(metadata=doc("every view"))
    movements: tuple[Movement, ...] = field(default=(), metadata=doc("when the lamp moves, in order"))
    poses: tuple[Pose, ...] = field(
        metadata=doc(
            "stretches in which the lamp stands still; a movement's first half "
            "belongs to the pose before it, its second to the pose after"
        )
    )
    shots: tuple[Shot, ...] = field(metadata=doc("the automatic decisions"))
    overrides: tuple[Override, ...] = field(default=(), metadata=doc("the editor's decisions; analysis keeps them"))
    look: Look = field(factory=Look, metadata=doc("visual aids for the whole programme"))
    centering: tuple[CenteringKey, ...] = field(
        default=(),
        metadata=doc("[frame, dx, dy]: shift in programme pixels, linear between keys, held outside"),
    )
    scores: str | None = field(default=None, metadata=doc("path of the per-sample visible-field scores (.npz)"))
    made_by: MadeBy | None = field(default=None, metadata=doc("what made the analysis"))

    def __attrs_post_init__(self) -> None:
        _require(self.frames > 0, f"frames must be positive, got {self.frames}")
        names = [c.name for c in self.cameras]
        _require(bool(names), "cameras is empty")
        _require(len(set(names)) == len(names), f"cameras must have different names, got {names}")
        known = set(names)
        self._check_names([("reference", self.reference)], known)
        check_tiles((p.range for p in self.poses), self.frames, "poses")
        check_tiles((s.range for s in self.shots), self.frames, "shots")
        self._check_names(((f"shots[{i}].camera", s.camera) for i, s in enumerate(self.shots)), known)
        for i, override in enumerate(self.overrides):
            if override.camera is not None:
                self._check_names([(f"overrides[{i}].camera", override.camera)], known)
            self._check_inside(f"overrides[{i}].range", override.range)
        last = 0
        for i, movement in enumerate(self.movements):
            self._check_inside(f"movements[{i}].range", movement.range)
            _require(movement.range.start >= last, f"movements[{i}] begins before the one before it ends")
            last = movement.range.stop
        for i, pose in enumerate(self.poses):
            used = [*pose.homographies, *pose.colour, *pose.residual_px, *pose.support, *pose.weak_cameras]
            self._check_names(((f"poses[{i}]", name) for name in used), known)
            missing = sorted(known - set(pose.homographies) - pose.weak_cameras)
            _require(not missing, f"poses[{i}].homographies lacks {', '.join(missing)}, which is not weak either")
        for before, after in pairwise(self.centering):
            _require(before[0] < after[0], f"centering keys must rise, got frames {before[0]} then {after[0]}")

    def _check_names(self, uses: Iterable[tuple[str, str]], known: set[str]) -> None:
        for place, name in uses:
            _require(name in known, f"{place} names {name!r}, which is not a camera ({', '.join(sorted(known))})")

    def _check_inside(self, place: str, piece: FrameRange) -> None:
        _require(piece.stop <= self.frames, f"{place} {piece} ends after the programme's {self.frames} frames")

    def camera(self, name: str) -> Camera:
        """The camera of that name; KeyError when there is none."""
        for camera in self.cameras:
            if camera.name == name:
                return camera
        raise KeyError(name)

    def pose_at(self, frame: int) -> Pose:
        """The pose that programme frame ``frame`` lies in."""
        for pose in self.poses:
            if frame in pose.range:
                return pose
        raise IndexError(f"frame {frame} is outside [0, {self.frames})")


@frozen
class Decision:
    """What the viewer gets over a stretch, after the overrides."""

    camera: str
    centering: bool
    fill: bool
    colour: bool
    overridden: bool


def resolve(edl: Edl) -> tuple[tuple[FrameRange, Decision], ...]:
    """The effective shots and looks: the analysis below, overrides on top. The ranges tile [0, frames).

    Neighbours with the same decision are one stretch. Cost grows with shots plus overrides squared at worst.
    """
    points = cut_points(edl.frames, [s.range for s in edl.shots] + [o.range for o in edl.overrides])
    pieces: list[tuple[FrameRange, Decision]] = []
    shots = iter(edl.shots)
    shot = next(shots)
    for start, stop in pairwise(points):
        while start not in shot.range:
            shot = next(shots)
        decision = Decision(shot.camera, edl.look.centering, edl.look.fill, edl.look.colour, overridden=False)
        for override in edl.overrides:
            if start in override.range:
                given = {
                    name: value
                    for name in ("camera", "centering", "fill", "colour")
                    if (value := getattr(override, name)) is not None
                }
                decision = attrs.evolve(decision, **given, overridden=decision.overridden or bool(given))
        pieces.append((FrameRange(start, stop), decision))
    return tuple(merge_equal(pieces))


def offset_at(keys: tuple[CenteringKey, ...], frame: float) -> tuple[float, float]:
    """Centering offset (dx, dy) in programme pixels at ``frame``: linear between keys, held outside, 0 without keys."""
    if not keys:
        return 0.0, 0.0
    if frame <= keys[0][0]:
        return keys[0][1], keys[0][2]
    for (f0, x0, y0), (f1, x1, y1) in pairwise(keys):
        if frame <= f1:
            part = (frame - f0) / (f1 - f0)
            return x0 + part * (x1 - x0), y0 + part * (y1 - y0)
    return keys[-1][1], keys[-1][2]


def carry_over(old: Edl, new: Edl) -> Edl:
    """``new`` (a fresh analysis) with the editor's decisions of ``old``: overrides and look. Nothing is lost.

    Raises DocumentError where an override names a camera that is gone or reaches past the new end.
    """
    names = {c.name for c in new.cameras}
    for index, override in enumerate(old.overrides):
        if override.camera is not None and override.camera not in names:
            raise DocumentError(
                f"overrides[{index}] takes camera {override.camera!r}, which the new analysis has not",
                remedy="Name the cameras as before, or remove the override from the old EDL",
            )
        if override.range.stop > new.frames:
            raise DocumentError(
                f"overrides[{index}] ends at frame {override.range.stop}, after the new end {new.frames}",
                remedy="Analyse the whole recording, or shorten the override in the old EDL",
            )
    return attrs.evolve(new, overrides=old.overrides, look=old.look)


# ------------------------------------------------------------------------------------------ reading and writing

_converter = make_converter()
_UPGRADES: dict[str, Any] = {}  # schema -> function from its JSON value to the next schema's


def from_json(value: Any, *, where: str = "") -> Edl:
    """An EDL from its JSON value; DocumentError with the path to the wrong value and what was expected."""
    if not isinstance(value, dict):
        raise DocumentError("an EDL is a JSON object", where=where, remedy="Hand in the file that `mcsl analyse` wrote")
    value = dict(value)
    schema = value.get("schema")
    while schema in _UPGRADES:
        value = _UPGRADES[schema](value)
        schema = value["schema"]
    if schema != SCHEMA:
        family, _, version = str(schema).partition("/")
        newer = family == "mcsl.edl" and version.isdigit() and int(version) > int(SCHEMA.split("/")[1])
        raise DocumentError(
            f"schema is {schema!r}, this mcsl reads {SCHEMA!r}",
            where=f"{where} at $.schema" if where else "$.schema",
            remedy="Install a newer mcsl" if newer else "Hand in the file that `mcsl analyse` wrote",
        )
    del value["schema"]
    return structure_document(value, Edl, _converter, where=where, name="the EDL (edl.md)")


def to_json(edl: Edl) -> dict[str, Any]:
    """The JSON value of an EDL, keys in the document's order."""
    return {"schema": SCHEMA, **_converter.unstructure(edl, Edl)}


def dumps(edl: Edl) -> str:
    """Canonical text: the same EDL gives the same bytes."""
    return canonical_json(to_json(edl))


def load(path: str | Path) -> Edl:
    """Reads, upgrades and checks an EDL; InputError or DocumentError say what is wrong and where."""
    return from_json(read_json(Path(path)), where=str(path))


def save(edl: Edl, path: str | Path) -> None:
    """Writes the canonical text atomically."""
    write_atomic(Path(path), dumps(edl).encode())
