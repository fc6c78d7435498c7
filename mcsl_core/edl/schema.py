"""The EDL's classes, frozen and checked when they are made. Written out in docs/reference/edl.md.

Conventions: ranges are half-open frame ranges on the programme clock; pixel centres lie at integers;
homographies are 3x3 row-major, scaled so that the last element is 1, and act on full-size pixels.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from copy import copy
from fractions import Fraction
from numbers import Real
from typing import Any

import attrs
from attrs import field, frozen
from attrs.validators import optional

from mcsl_core.documents import AtMost, NotEmpty, doc, key_path
from mcsl_core.timing import FrameRange, check_tiles

from .camera import Camera, check_rate_field
from .checks import (
    FRAMES,
    IDENTITY,
    LONGEST_S,
    MOST_CAMERAS,
    MOST_DECISIONS,
    MOST_DRAWN,
    MOST_POSES,
    NO_SOUND,
    NOT_NEGATIVE,
    NUMBERS,
    SIDES,
    UNIT,
    FileName,
    Matrix,
    check_matrix,
    require,
)
from .colour import Colour, ColourKey, check_keys
from .field import DrawnField, FieldStretch
from .look import Look
from .movement import Movement
from .relief import Relief


def _pair(_: Any, attribute: attrs.Attribute[Any], value: Any) -> None:
    numbers = isinstance(value, tuple) and len(value) == 2 and all(isinstance(each, Real) for each in value)
    require(numbers, f"expected two numbers, got {value!r}", f".{attribute.name}")


@frozen
class Weak:
    """A camera that cannot be tied to the others in a pose; no automatic shot uses it there."""

    camera: str = field(metadata=doc("camera name"))
    reason: str = field(metadata=doc("why, in words for a person"))


@frozen
class Pose:
    """A stretch in which the lamp stands still, and how every camera then sees the programme's perspective."""

    range: FrameRange = field(metadata=doc("poses tile [0, frames)"))
    homographies: Mapping[str, Matrix] = field(
        metadata=doc("camera pixel -> reference camera pixel; the reference's own is the identity; weak ones may lack")
    )
    anchor: Matrix = field(default=IDENTITY, metadata=doc("reference camera pixel of this pose -> programme pixel"))
    perspective: int = field(
        default=0, validator=NOT_NEGATIVE, metadata=doc("poses of one number share the programme's perspective")
    )
    colour: Mapping[str, Colour] = field(factory=dict, metadata=doc("camera -> match to the reference camera"))
    colour_keys: Mapping[str, tuple[ColourKey, ...]] = field(
        factory=dict,
        metadata=doc(
            "camera -> [frame, r, g, b]: what its R', G' and B' are multiplied with before the match, linear between "
            "keys, held outside; without, it does not drift",
            optional=True,
        ),
    )
    solved_from: tuple[int, ...] = field(
        default=(), validator=NOT_NEGATIVE, metadata=doc("programme frames the homographies were solved from")
    )
    residual_px: Mapping[str, float] = field(
        factory=dict,
        validator=NOT_NEGATIVE,
        metadata=doc("camera -> rms distance from its plane of what laid it, matches or the surface, reference pixels"),
    )
    support: Mapping[str, int] = field(
        factory=dict,
        validator=NOT_NEGATIVE,
        metadata=doc("camera -> distinct 4-pixel cells its matches come from"),
    )
    weak: tuple[Weak, ...] = field(default=(), metadata=doc("cameras that could not be tied in, and why"))
    relief: Relief | None = field(
        default=None, metadata=doc("the scene's relief over the plane; without, it is taken as plane", optional=True)
    )

    def __attrs_post_init__(self) -> None:
        for name, matrix in self.homographies.items():
            check_matrix(matrix, f".homographies{key_path(name)}")
        check_matrix(self.anchor, ".anchor")
        for name, keys in self.colour_keys.items():
            check_keys(keys, self.range, f".colour_keys{key_path(name)}")

    @property
    def weak_cameras(self) -> frozenset[str]:
        """Names of the cameras that could not be tied in."""
        return frozenset(w.camera for w in self.weak)


@frozen
class Shot:
    """A stretch of the programme taken from one camera, as the analysis chose it."""

    range: FrameRange = field(metadata=doc("shots tile [0, frames)"))
    camera: str = field(metadata=doc("camera name"))
    score: float = field(default=0.0, validator=UNIT, metadata=doc("mean visible field over the shot"))
    why: str = field(default="", metadata=doc("the reason, in words for a person"))


@frozen
class Override:
    """An editor's decision over a stretch: each field given wins over the analysis; of two, the later in the list."""

    range: FrameRange = field(metadata=doc("where it holds"))
    camera: str | None = field(default=None, metadata=doc("take this camera", optional=True))
    centering: bool | None = field(default=None, metadata=doc("centering on or off", optional=True))
    fill: bool | None = field(default=None, metadata=doc("fill on or off", optional=True))
    colour: bool | None = field(default=None, metadata=doc("colour matching on or off", optional=True))
    offset: tuple[float, float] | None = field(
        default=None,
        validator=optional([_pair, NUMBERS]),
        metadata=doc("[dx, dy] in programme pixels, by hand, in place of the automatic centering", optional=True),
    )
    note: str = field(default="", metadata=doc("the editor's remark", optional=True))
    surface: bool | None = field(default=None, metadata=doc("alignment by the relief on or off", optional=True))
    see_through: bool | None = field(default=None, metadata=doc("seeing through heads on or off", optional=True))

    def __attrs_post_init__(self) -> None:
        for name in ("centering", "fill", "colour", "surface", "see_through"):
            value = getattr(self, name)
            require(value is None or isinstance(value, bool), f"expected true or false, got {value!r}", f".{name}")


@frozen
class Correction:
    """An editor's correction of where a camera's picture lies; it holds in the poses most of whose frames it spans."""

    range: FrameRange = field(metadata=doc("where it holds"))
    camera: str = field(metadata=doc("camera name"))
    matrix: Matrix = field(metadata=doc("programme pixel -> programme pixel, after homography and anchor"))
    note: str = field(default="", metadata=doc("the editor's remark", optional=True))

    def __attrs_post_init__(self) -> None:
        check_matrix(self.matrix, ".matrix")


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

    rate: Fraction = field(
        validator=check_rate_field, metadata=doc("programme frames per second; frame n stands at n / rate seconds")
    )
    size: tuple[int, int] = field(validator=SIDES, metadata=doc("programme width and height in pixels"))
    frames: int = field(validator=FRAMES, metadata=doc("length of the programme"))
    reference: str = field(metadata=doc("the camera whose perspective the programme keeps"))
    cameras: tuple[Camera, ...] = field(validator=NotEmpty(MOST_CAMERAS), metadata=doc("every camera"))
    movements: tuple[Movement, ...] = field(
        default=(), validator=AtMost(MOST_POSES), metadata=doc("when the lamp moves, in order")
    )
    poses: tuple[Pose, ...] = field(
        validator=AtMost(MOST_POSES),
        metadata=doc(
            "stretches in which the lamp stands still; a movement's first half "
            "belongs to the pose before it, its second to the pose after"
        ),
    )
    shots: tuple[Shot, ...] = field(validator=AtMost(MOST_DECISIONS), metadata=doc("the automatic decisions"))
    overrides: tuple[Override, ...] = field(
        default=(),
        validator=AtMost(MOST_DECISIONS),
        metadata=doc("the editor's decisions; analysis keeps them"),
    )
    corrections: tuple[Correction, ...] = field(
        default=(),
        validator=AtMost(MOST_POSES),
        metadata=doc("alignment corrected by hand; analysis keeps it; of two, the later in the list", optional=True),
    )
    fields: tuple[FieldStretch, ...] = field(
        default=(),
        validator=AtMost(MOST_POSES),
        metadata=doc("where the analysis took the surgical field to lie, in order", optional=True),
    )
    drawn_fields: tuple[DrawnField, ...] = field(
        default=(),
        validator=AtMost(MOST_DRAWN),
        metadata=doc(
            "the field drawn by hand; analysis keeps and uses it; of two, the later in the list", optional=True
        ),
    )
    removed: tuple[FrameRange, ...] = field(
        default=(),
        validator=AtMost(MOST_DECISIONS),
        metadata=doc(
            "programme frames left out of what is delivered, picture and sound, in order; analysis keeps them; "
            "all frame numbers in this document count the whole programme",
            optional=True,
        ),
    )
    audio_from: str | None = field(
        default=None,
        metadata=doc(
            'the camera whose sound the programme has, or "none"; the reference\'s without; analysis keeps it',
            optional=True,
        ),
    )
    look: Look = field(factory=Look, metadata=doc("visual aids for the whole programme"))
    centering: tuple[CenteringKey, ...] = field(
        default=(),
        metadata=doc("[frame, dx, dy]: shift in programme pixels, linear between keys, held outside"),
    )
    scores: str | None = field(
        default=None, validator=optional(FileName()), metadata=doc("path of the per-sample visible-field scores (.npz)")
    )
    made_by: MadeBy | None = field(default=None, metadata=doc("what made the analysis"))

    def __attrs_post_init__(self) -> None:
        lasts_s = self.frames / self.rate
        require(lasts_s <= LONGEST_S, f"{float(lasts_s):.6g} s are longer than two days", ".frames")
        self._check_cameras()
        self._check_movements()
        self._check_poses()
        self._check_decisions()
        last = -1
        for index, (frame, dx, dy) in enumerate(self.centering):
            at = f".centering[{index}]"
            require(0 <= frame < self.frames, f"frame {frame} is outside [0, {self.frames})", f"{at}[0]")
            require(frame > last, f"keys must rise, got frame {frame} after {last}", f"{at}[0]")
            NUMBERS.check(dx, f"{at}[1]")
            NUMBERS.check(dy, f"{at}[2]")
            last = frame

    def _check_cameras(self) -> None:
        seen: set[str] = set()
        for index, camera in enumerate(self.cameras):
            at = f".cameras[{index}]"
            require(camera.name not in seen, f"a camera before it is also called {camera.name!r}", f"{at}.name")
            seen.add(camera.name)
            self._check_ordered(camera.gaps, lambda i, at=at: f"{at}.gaps[{i}]")
        self._check_names([(".reference", self.reference)])

    def _check_movements(self) -> None:
        self._check_ordered([m.range for m in self.movements], lambda i: f".movements[{i}].range")
        last = -1
        for index, movement in enumerate(self.movements):
            for n, view in enumerate(movement.views):
                at = f".movements[{index}].views[{n}]"
                require(last < view.frame < self.frames, f"frame {view.frame} does not rise, or ends after all", at)
                last = view.frame
                self._check_names((f"{at}.{part}{key_path(name)}", name) for part, name in view.names())

    def _check_poses(self) -> None:
        check_tiles((p.range for p in self.poses), self.frames, "poses")
        names = [c.name for c in self.cameras]
        for index, pose in enumerate(self.poses):
            at = f".poses[{index}]"
            for part in ("homographies", "colour", "colour_keys", "residual_px", "support"):
                self._check_names((f"{at}.{part}{key_path(name)}", name) for name in getattr(pose, part))
            reliefs = () if pose.relief is None else pose.relief.projections
            self._check_names((f"{at}.relief.projections{key_path(name)}", name) for name in reliefs)
            self._check_names((f"{at}.weak[{i}].camera", w.camera) for i, w in enumerate(pose.weak))
            missing = [n for n in names if n not in pose.homographies and n not in pose.weak_cameras]
            require(not missing, f"lacks {', '.join(missing)}, not weak either", f"{at}.homographies")
            own = pose.homographies.get(self.reference)
            own_path = f"{at}.homographies{key_path(self.reference)}"
            require(own is not None, "the reference camera has no homography; it is the identity", own_path)
            require(own == IDENTITY, "the reference camera's own homography must be the identity", own_path)

    def _check_decisions(self, *, of_people_alone: bool = False) -> None:
        if not of_people_alone:
            check_tiles((s.range for s in self.shots), self.frames, "shots")
            self._check_names((f".shots[{i}].camera", s.camera) for i, s in enumerate(self.shots))
        for index, override in enumerate(self.overrides):
            at = f".overrides[{index}]"
            if override.camera is not None:
                self._check_names([(f"{at}.camera", override.camera)])
            self._check_inside(override.range, f"{at}.range")
        self._check_ordered([f.range for f in self.fields], lambda i: f".fields[{i}].range")
        for index, drawn in enumerate(self.drawn_fields):
            self._check_inside(drawn.range, f".drawn_fields[{index}].range")
        self._check_ordered(self.removed, lambda i: f".removed[{i}]")
        everything = sum(map(len, self.removed)) == self.frames
        require(not everything, "everything is removed, nothing would be delivered", ".removed")
        if self.audio_from not in (None, NO_SOUND):
            self._check_names([(".audio_from", self.audio_from)])
        for index, correction in enumerate(self.corrections):
            at = f".corrections[{index}]"
            self._check_names([(f"{at}.camera", correction.camera)])
            self._check_inside(correction.range, f"{at}.range")

    def _check_names(self, uses: Iterable[tuple[str, str]]) -> None:
        names = [c.name for c in self.cameras]
        for at, name in uses:
            require(name in names, f"{name!r} is not a camera, expected one of {', '.join(names)}", at)

    def _check_inside(self, piece: FrameRange, at: str) -> None:
        require(piece.stop <= self.frames, f"{piece} ends after the programme's {self.frames} frames", at)

    def _check_ordered(self, pieces: Iterable[FrameRange], at: Callable[[int], str]) -> None:
        last = 0
        for index, piece in enumerate(pieces):
            self._check_inside(piece, at(index))
            require(piece.start >= last, f"{piece} begins before the one before it ends at {last}", at(index))
            last = piece.stop

    def redecided(self, **decisions: Any) -> Edl:
        """With other decisions of people, which are checked; what the analysis found was, when it was made."""
        new = copy(self)
        for name, value in decisions.items():
            object.__setattr__(new, name, value)
        attrs.validate(new)
        new._check_decisions(of_people_alone=True)
        return new

    def camera(self, name: str) -> Camera:
        """The camera of that name.

        Raises
        ------
        KeyError
            Where there is none.
        """
        for camera in self.cameras:
            if camera.name == name:
                return camera
        raise KeyError(name)

    def pose_at(self, frame: int) -> Pose:
        """The pose that programme frame ``frame`` lies in.

        Raises
        ------
        IndexError
            Where it lies outside the programme.
        """
        for pose in self.poses:
            if frame in pose.range:
                return pose
        raise IndexError(f"frame {frame} is outside [0, {self.frames})")
