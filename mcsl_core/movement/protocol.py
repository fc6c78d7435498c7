"""What a movement detector is given and gives: the movements, and the curve they were judged by."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Protocol

import numpy as np
from attrs import field, frozen
from numpy.typing import NDArray

from mcsl_core.edl import Movement
from mcsl_core.progress import Progress
from mcsl_core.recording.footage import Footage
from mcsl_core.recording.sample_store import SampleStore


class MovementDetector(Protocol):
    """Finds the stretches in which the lamp moves."""

    @property
    def name(self) -> str: ...

    def detect(self, samples: SampleStore, footage: Footage, progress: Progress) -> Detection:
        """Movements in order, not overlapping, inside [0, footage.frames), and the curve they were judged by.

        samples: the recording about once a second, reduced; iterate it. footage: for a closer look at full rate.
        """
        ...


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

    def arrays(self) -> dict[str, NDArray]:
        """Everything in it, as arrays that .npz files take; `from_arrays` is the way back."""
        return {
            "movement_label": np.array([self.label, self.unit]),
            "movement_frames": self.frames,
            "movement_values": self.values,
            "movement_threshold": self.threshold,
        }

    @classmethod
    def from_arrays(cls, arrays: Mapping[str, NDArray]) -> Curve:
        """KeyError where an array is missing, ValueError where one does not fit."""
        label, unit = (str(word) for word in arrays["movement_label"])
        return cls(
            label,
            unit,
            arrays["movement_frames"].astype(np.int64),
            arrays["movement_values"].astype(np.float64),
            arrays["movement_threshold"].astype(np.float64),
        )


NO_CURVE = Curve("", "", np.zeros(0, np.int64), np.zeros(0), np.zeros(0))


@frozen(eq=False)
class Detection:
    """What a movement detector found, and the curve it judged by."""

    movements: tuple[Movement, ...]
    curve: Curve = field(default=NO_CURVE)
