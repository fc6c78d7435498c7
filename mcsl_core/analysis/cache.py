"""Results of the analysis's stages kept beside the EDL, each under a key of all that it depends on.

A changed selector then costs a moment, and a changed detector decodes nothing again. A key holds the media's
fingerprints, the settings, and the code of whatever made the result, so that a plugin that is being written is never
answered from yesterday's version of itself.
"""

from __future__ import annotations

import hashlib
import importlib
import io
import json
from collections.abc import Callable, Mapping, Sequence
from functools import lru_cache
from pathlib import Path
from typing import Generic, TypeVar

import numpy as np
from attrs import frozen
from numpy.typing import NDArray

from mcsl_core.alignment.aligned_views import AlignedPose
from mcsl_core.alignment.observations import SolvedPose
from mcsl_core.documents import make_converter, write_atomic
from mcsl_core.edl import Clock, Movement, Pose
from mcsl_core.hooks.registry import Offer
from mcsl_core.movement.protocol import Curve, Detection
from mcsl_core.occlusion.score_table import ScoreTable
from mcsl_core.progress import Progress

T = TypeVar("T")
Arrays = Mapping[str, NDArray]

KEPT = 4  # results a stage keeps: a researcher goes back and forth between a few detectors
_converter = make_converter()


@frozen
class Form(Generic[T]):
    """How one kind of result becomes arrays and back."""

    pack: Callable[[T], dict[str, NDArray]]
    unpack: Callable[[Arrays], T]


class StageCache:
    """A folder of results. Without a folder it remembers nothing."""

    def __init__(self, folder: Path | None, progress: Progress) -> None:
        self.folder, self._progress = folder, progress

    def remember(self, stage: str, key: str, make: Callable[[], T], form: Form[T]) -> T:
        """The result of ``stage`` under ``key``, made now if it is not there or cannot be read."""
        if self.folder is None:
            return make()
        path = self.folder / f"{stage}-{key}.npz"
        if path.exists():
            try:
                with np.load(path, allow_pickle=False) as stored:
                    found = form.unpack(dict(stored))
                path.touch()
                return found
            except Exception as fault:  # whatever is wrong with it, making it again is right
                self._progress.note(f"{path} cannot be used ({type(fault).__name__}: {fault}) and is made again")
        made = form.pack(result := make())
        stream = io.BytesIO()
        np.savez_compressed(stream, **made)  # pyright: ignore[reportArgumentType]
        write_atomic(path, stream.getvalue())
        self.prune(stage, KEPT)
        return result

    def file(self, stage: str, key: str) -> Path | None:
        """Where a result too large for memory lies; the caller writes it."""
        return None if self.folder is None else self.folder / f"{stage}-{key}"

    def prune(self, stage: str, kept: int) -> None:
        """Deletes all but the ``kept`` results of ``stage`` that were used last."""
        if self.folder is not None:
            lying = sorted(self.folder.glob(f"{stage}-*"), key=lambda p: p.stat().st_mtime_ns, reverse=True)
            for path in lying[kept:]:
                path.unlink(missing_ok=True)


def key_of(*parts: object) -> str:
    """A short key of plain values: equal parts, equal key."""
    text = json.dumps(parts, default=repr, sort_keys=True)
    return hashlib.sha256(text.encode("utf-8", "surrogatepass")).hexdigest()[:24]


def identity(offer: Offer) -> tuple[str, str, str]:
    """What an offer's results depend on: its package and version, its settings, its code.

    Settings are what its repr shows; object's own shows an address, which would be another in every process.
    """
    kind = type(offer.implementation)
    settings = kind.__qualname__ if kind.__repr__ is object.__repr__ else repr(offer.implementation)
    return str(offer), settings, code_digest(kind.__module__.split(".")[0])


@lru_cache
def code_digest(package: str) -> str:
    """A hash of the Python source of a top-level package or module; empty where there is no source."""
    module = importlib.import_module(package)
    folders = [Path(p) for p in getattr(module, "__path__", ())]
    files = sorted(f for folder in folders for f in folder.rglob("*.py")) or [Path(getattr(module, "__file__", ""))]
    digest = hashlib.sha256()
    for file in files:
        if file.is_file():
            digest.update(file.name.encode() + b"\0" + file.read_bytes())
    return digest.hexdigest()[:24]


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
    scenes = [[s.aligned.size, s.aligned.reference, s.aligned.camera_sizes] for s in solved]
    return {
        "poses": _text([_converter.unstructure(s.pose, Pose) for s in solved]),
        "scenes": _text(scenes),
        "moments": _text([list(map(int, s.samples)) for s in solved]),
        **{f"field{i}": np.packbits(s.aligned.field) for i, s in enumerate(solved)},
    }


def _unpack_poses(arrays: Arrays) -> list[SolvedPose]:
    solved = []
    poses, scenes, moments = (_json(arrays, name) for name in ("poses", "scenes", "moments"))
    for i, (document, (size, reference, sizes), at) in enumerate(zip(poses, scenes, moments, strict=True)):
        pose = _converter.structure(document, Pose)
        width, height = size
        field = np.unpackbits(arrays[f"field{i}"], count=width * height).reshape(height, width).astype(bool)
        homographies = {name: np.array(h) for name, h in pose.homographies.items()}
        camera_sizes = {name: (int(w), int(h)) for name, (w, h) in sizes.items()}
        scene = AlignedPose((width, height), reference, homographies, camera_sizes, field)
        solved.append(SolvedPose(pose, scene, tuple(at), {}))
    return solved


CLOCKS = Form(_pack_clocks, _unpack_clocks)
DETECTION = Form(_pack_detection, _unpack_detection)
POSES = Form(_pack_poses, _unpack_poses)
SCORES = Form(ScoreTable.arrays, ScoreTable.from_arrays)
CUTS: Form[tuple[int, ...]] = Form(
    lambda cuts: {"cuts": np.array(cuts, np.int64)}, lambda arrays: tuple(int(n) for n in arrays["cuts"])
)
