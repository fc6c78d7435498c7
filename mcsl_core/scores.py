"""What was measured along the recording: how much of the field each camera sees, and what movements were judged by."""

from __future__ import annotations

import io
from pathlib import Path

import numpy as np
from attrs import field, frozen
from numpy.typing import NDArray

from .documents import write_atomic
from .edl import Movement
from .errors import DocumentError


@frozen(eq=False)
class Curve:
    """A measure over time and the bound it was judged by, for reports.

    label: what is measured, in words, e.g. "degree of misalignment". unit: "px", or "" for a share. frames: (N,)
    rising programme frames. values: (N,), NaN without data. threshold: (N,), NaN where none applies.
    """

    label: str
    unit: str
    frames: NDArray[np.int64]
    values: NDArray[np.float64]
    threshold: NDArray[np.float64]

    def __attrs_post_init__(self) -> None:
        if not len(self.frames) == len(self.values) == len(self.threshold):
            raise ValueError("frames, values and threshold of a curve must be equally many")


NO_CURVE = Curve("", "", np.zeros(0, np.int64), np.zeros(0), np.zeros(0))


@frozen(eq=False)
class Detection:
    """What a movement detector found, and the curve it judged by."""

    movements: tuple[Movement, ...]
    curve: Curve = field(default=NO_CURVE)


@frozen(eq=False)
class ScoreTable:
    """Visible field over time.

    frames: (S,) rising programme frames of the samples. cameras: C names. visible: (S, C) float in 0..1, NaN where
    there is no data. usable: (S, C) bool, False where no automatic shot may use the camera (weak, or no picture).
    movement: what movements were judged by.
    """

    frames: NDArray[np.int64]
    cameras: tuple[str, ...]
    visible: NDArray[np.float64]
    usable: NDArray[np.bool_]
    movement: Curve = field(default=NO_CURVE)

    def __attrs_post_init__(self) -> None:
        shape = (len(self.frames), len(self.cameras))
        if self.visible.shape != shape or self.usable.shape != shape:
            raise ValueError(f"visible and usable must be {shape}, got {self.visible.shape} and {self.usable.shape}")
        if len(self.frames) and (self.frames[0] < 0 or (np.diff(self.frames) <= 0).any()):
            raise ValueError("frames of the samples must rise from 0 or later")
        known = self.visible[~np.isnan(self.visible)]
        if known.size and (known.min() < 0 or known.max() > 1):
            raise ValueError(f"visible must lie in 0..1, got {known.min():.3g}..{known.max():.3g}")

    def save(self, path: Path) -> None:
        """Writes a compressed .npz atomically; the same table gives the same bytes."""
        stream = io.BytesIO()
        np.savez_compressed(
            stream,
            frames=self.frames,
            cameras=np.array(self.cameras),
            visible=self.visible.astype(np.float32),
            usable=self.usable,
            movement_label=np.array([self.movement.label, self.movement.unit]),
            movement_frames=self.movement.frames,
            movement_values=self.movement.values.astype(np.float32),
            movement_threshold=self.movement.threshold.astype(np.float32),
        )
        write_atomic(path, stream.getvalue())


def load_scores(path: Path) -> ScoreTable:
    """Reads what `ScoreTable.save` wrote; DocumentError when it is something else."""
    try:
        with np.load(path, allow_pickle=False) as data:
            return ScoreTable(
                data["frames"].astype(np.int64),
                tuple(str(name) for name in data["cameras"]),
                data["visible"].astype(np.float64),
                data["usable"].astype(bool),
                Curve(
                    str(data["movement_label"][0]),
                    str(data["movement_label"][1]),
                    data["movement_frames"].astype(np.int64),
                    data["movement_values"].astype(np.float64),
                    data["movement_threshold"].astype(np.float64),
                ),
            )
    except (OSError, KeyError, ValueError) as error:
        raise DocumentError(
            f"is not a table of scores ({error})", where=str(path), remedy="Run `mcsl analyse` again"
        ) from error
