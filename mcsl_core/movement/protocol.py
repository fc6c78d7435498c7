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


@frozen(eq=False)
class Curve:
    """A measure over time and the threshold it was judged by, for reports.

    Attributes
    ----------
    label
        What is measured, in words: "degree of misalignment".
    unit
        "px", or "" for a share.
    frames
        (N,) programme frames, rising.
    values
        (N,), NaN without data.
    threshold
        (N,), NaN where none applies.
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
        """Everything in it, as arrays that .npz files take; `from_arrays` is the inverse."""
        return {
            "movement_label": np.array([self.label, self.unit]),
            "movement_frames": self.frames,
            "movement_values": self.values,
            "movement_threshold": self.threshold,
        }

    @classmethod
    def from_arrays(cls, arrays: Mapping[str, NDArray]) -> Curve:
        """The curve that `arrays` wrote.

        Raises
        ------
        KeyError
            Where an array is missing.
        ValueError
            Where the lengths differ.
        """
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
    """What a movement detector found, and the curve it judged by.

    Attributes
    ----------
    movements
        In order, not overlapping.
    curve
        Empty where the detector has none.
    """

    movements: tuple[Movement, ...]
    curve: Curve = field(default=NO_CURVE)


class MovementDetector(Protocol):
    """Finds when the lamp moves."""

    @property
    def name(self) -> str:
        """The name it is chosen by."""
        ...

    def detect(self, samples: SampleStore, footage: Footage, progress: Progress) -> Detection:
        """Movements in order, not overlapping, inside [0, footage.frames), and the curve they were judged by.

        Parameters
        ----------
        samples
            The recording about once a second, downscaled; iterate it.
        footage
            All pictures, for sampling at full rate.
        progress
            To be told of stages.
        """
        ...
