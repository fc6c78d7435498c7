"""Results of the analysis's stages kept beside the EDL, each under a key of all that it depends on.

A changed selector or detector then decodes nothing again but where its own programme is in doubt. What the keys hold
stands in `stage_keys`.
"""

from __future__ import annotations

import io
import json
from collections.abc import Callable, Mapping, Sequence
from fractions import Fraction
from functools import cached_property
from pathlib import Path
from typing import Any, Generic, TypeVar

import numpy as np
from attrs import frozen
from numpy.typing import NDArray

from mcsl_core.alignment.aligned_views import AlignedPose
from mcsl_core.alignment.observations import SolvedPose
from mcsl_core.alignment.pose_colours import PoseColours
from mcsl_core.arrays import read_arrays
from mcsl_core.documents import make_converter, write_atomic
from mcsl_core.edl import Clock, Movement, Pose
from mcsl_core.errors import McslError
from mcsl_core.imaging.masks import Mask
from mcsl_core.media.damage import Damage
from mcsl_core.movement.protocol import Curve, Detection
from mcsl_core.occlusion.score_table import ScoreTable
from mcsl_core.progress import Progress, Steps
from mcsl_core.recording.damage import DamageOf
from mcsl_core.temporary import private_folder
from mcsl_core.timing import FrameRange

T = TypeVar("T")
Arrays = Mapping[str, NDArray]

KEPT = 4  # results a stage keeps: a researcher goes back and forth between a few detectors
_MOST_BYTES = 1 << 31  # fields of ten thousand poses, unpacked
_converter = make_converter()


@frozen
class Stage(Generic[T]):
    """A stage whose results are kept: what its files are called, and how a result becomes arrays and back."""

    name: str
    pack: Callable[[T], dict[str, NDArray]]
    unpack: Callable[[Arrays], T]


class Deferred(Generic[T]):
    """``make(*given, **named)``, made when a step that runs first needs it, and then kept for the steps that follow."""

    def __init__(self, make: Callable[..., T], *given: Any, **named: Any) -> None:
        self._make, self._given, self._named = make, given, named

    @cached_property
    def value(self) -> T:
        return call(self._make, *self._given, **self._named)


def call(step: Callable[..., T], *given: Any, **named: Any) -> T:
    """``step(*given, **named)`` with the values of what is `Deferred` among the arguments."""
    plain = (each.value if isinstance(each, Deferred) else each for each in given)
    return step(*plain, **{n: each.value if isinstance(each, Deferred) else each for n, each in named.items()})


class StageCache:
    """A folder of results. Without a folder it remembers nothing. steps: told of each stage that is done anew."""

    def __init__(self, folder: Path | None, progress: Progress, steps: Steps | None = None) -> None:
        self.folder, self._progress, self._steps = folder, progress, steps

    def remember(self, stage: Stage[T], key: str, step: Callable[..., T], *given: Any, **named: Any) -> T:
        """The result of ``stage`` under ``key``: ``step(*given, **named)`` if it is not there or cannot be read.

        What is `Deferred` among the arguments is made for the step, and so not at all where the result is there.
        """
        if self.folder is None:
            return self._done(stage, step, *given, **named)
        path = self.folder / f"{stage.name}-{key}.npz"
        if path.exists():
            try:
                found = stage.unpack(read_arrays(path, wanted="a kept result", remedy="", most=_MOST_BYTES))
                path.touch()
                return found
            except Exception as fault:  # whatever is wrong with it, making it again is right
                why = fault.what if isinstance(fault, McslError) else f"{type(fault).__name__}: {fault}"
                self._progress.note(f"{path} cannot be used ({why}) and is made again")
        result = self._done(stage, step, *given, **named)
        stream = io.BytesIO()
        np.savez_compressed(stream, **stage.pack(result))  # pyright: ignore[reportArgumentType]
        private_folder(self.folder)
        write_atomic(path, stream.getvalue(), private=True)
        self.prune(stage.name, KEPT)
        return result

    def _done(self, stage: Stage[T], step: Callable[..., T], *given: Any, **named: Any) -> T:
        if self._steps is not None:
            self._steps.begin(stage.name)
        return call(step, *given, **named)

    def file(self, stage: str, key: str) -> Path | None:
        """Where a result too large for memory lies; the caller writes it."""
        return None if self.folder is None else self.folder / f"{stage}-{key}"

    def prune(self, stage: str, kept: int) -> None:
        """Deletes all but the ``kept`` results of ``stage`` that were used last."""
        if self.folder is not None:
            lying = sorted(self.folder.glob(f"{stage}-*"), key=lambda p: p.stat().st_mtime_ns, reverse=True)
            for path in lying[kept:]:
                path.unlink(missing_ok=True)


def _text(value: object) -> NDArray:
    return np.array(json.dumps(value))


def _json(arrays: Arrays, name: str) -> list:
    return json.loads(str(arrays[name][()]))


def _pack_clocks(clocks: Sequence[Clock]) -> dict[str, NDArray]:
    return {"clocks": _text(_converter.unstructure(list(clocks), list[Clock]))}


def _unpack_clocks(arrays: Arrays) -> tuple[Clock, ...]:
    return tuple(_converter.structure(_json(arrays, "clocks"), list[Clock]))


def _pack_detection(found: Detection) -> dict[str, NDArray]:
    movements = _text(_converter.unstructure(list(found.movements), list[Movement]))
    return {"movements": movements, **found.curve.arrays()}


def _unpack_detection(arrays: Arrays) -> Detection:
    movements = tuple(_converter.structure(_json(arrays, "movements"), list[Movement]))
    return Detection(movements, Curve.from_arrays(arrays))


def _pack_poses(solved: Sequence[SolvedPose]) -> dict[str, NDArray]:
    """Without the observations: they are for anchoring, which is done."""
    sizes = [[s.aligned.size, s.aligned.reference, s.aligned.camera_sizes] for s in solved]
    return {
        "poses": _text([_converter.unstructure(s.pose, Pose) for s in solved]),
        "sizes": _text(sizes),
        "samples": _text([list(map(int, s.samples)) for s in solved]),
        "field_by": _text([s.field_by for s in solved]),
        "drawn": _text([[[piece.start, piece.stop] for piece, _ in s.drawn] for s in solved]),
        "hands": _text([sorted(s.aligned.hands) for s in solved]),
        **{
            f"hands{i}_{n}": np.packbits(mask)
            for i, s in enumerate(solved)
            for n, (_, mask) in enumerate(sorted(s.aligned.hands.items()))
        },
        **{f"field{i}": np.packbits(s.aligned.field) for i, s in enumerate(solved)},
        **{f"field{i}_{n}": np.packbits(mask) for i, s in enumerate(solved) for n, (_, mask) in enumerate(s.drawn)},
    }


def _unpack_poses(arrays: Arrays) -> list[SolvedPose]:
    solved = []
    of_poses = (_json(arrays, name) for name in ("poses", "sizes", "samples", "field_by", "drawn", "hands"))
    for i, (document, (size, reference, camera_sizes), at, by, pieces, named) in enumerate(zip(*of_poses, strict=True)):
        pose = _converter.structure(document, Pose)
        field = _unpack_mask(arrays[f"field{i}"], size)
        drawn = [(FrameRange(*ends), _unpack_mask(arrays[f"field{i}_{n}"], size)) for n, ends in enumerate(pieces)]
        homographies = {name: np.array(h) for name, h in pose.homographies.items()}
        full = {name: (int(w), int(h)) for name, (w, h) in camera_sizes.items()}
        hands = {name: _unpack_mask(arrays[f"hands{i}_{n}"], size) for n, name in enumerate(named)}
        aligned = AlignedPose((size[0], size[1]), reference, homographies, full, field, hands)
        solved.append(SolvedPose(pose, aligned, tuple(at), {}, by, tuple(drawn)))
    return solved


def _unpack_mask(bits: NDArray, size: Sequence[int]) -> Mask:
    width, height = size
    return np.unpackbits(bits, count=width * height).reshape(height, width).astype(bool)


def _pack_followed(found: Sequence[Movement]) -> dict[str, NDArray]:
    return {"movements": _text(_converter.unstructure(list(found), list[Movement]))}


def _unpack_followed(arrays: Arrays) -> tuple[Movement, ...]:
    return tuple(_converter.structure(_json(arrays, "movements"), list[Movement]))


def _pack_colours(found: Sequence[PoseColours]) -> dict[str, NDArray]:
    return {"colours": _text(_converter.unstructure(list(found), list[PoseColours]))}


def _unpack_colours(arrays: Arrays) -> list[PoseColours]:
    return _converter.structure(_json(arrays, "colours"), list[PoseColours])


def _pack_damage(found: DamageOf) -> dict[str, NDArray]:
    plain = {n: [[[str(d.start_s), str(d.stop_s), d.why] for d in each] for each in of] for n, of in found.items()}
    return {"damage": _text(plain)}


def _unpack_damage(arrays: Arrays) -> DamageOf:
    plain = json.loads(str(arrays["damage"][()]))
    return {
        name: tuple(tuple(Damage(Fraction(a), Fraction(b), why) for a, b, why in each) for each in of)
        for name, of in plain.items()
    }


CLOCKS = Stage("clocks", _pack_clocks, _unpack_clocks)
DAMAGE = Stage("damage", _pack_damage, _unpack_damage)
DAMAGE_MET = Stage("decoding", _pack_damage, _unpack_damage)
MOVEMENTS = Stage("movements", _pack_detection, _unpack_detection)
POSES = Stage("poses", _pack_poses, _unpack_poses)
PLACED = Stage("placed", _pack_poses, _unpack_poses)
FOLLOWED = Stage("followed", _pack_followed, _unpack_followed)
COLOURS = Stage("colours", _pack_colours, _unpack_colours)
MERITS: Stage[dict[str, NDArray]] = Stage("merits", dict, dict)
SCORES = Stage("scores", ScoreTable.arrays, ScoreTable.from_arrays)
AROUND = Stage("around", ScoreTable.arrays, ScoreTable.from_arrays)
CLOSER = Stage("closer", ScoreTable.arrays, ScoreTable.from_arrays)
CUTS: Stage[tuple[int, ...]] = Stage(
    "cuts", lambda cuts: {"cuts": np.array(cuts, np.int64)}, lambda arrays: tuple(int(n) for n in arrays["cuts"])
)
