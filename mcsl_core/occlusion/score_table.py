"""How much of the surgical field each camera sees over time: the table that selectors choose from."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from attrs import frozen
from numpy.typing import NDArray


@frozen(eq=False)
class ScoreTable:
    """Visible field over time.

    frames: (S,) rising programme frames of the samples. cameras: C names. visible: (S, C) float in 0..1, NaN where
    there is no data. usable: (S, C) bool, False where no automatic shot may use the camera (weak, or no picture).
    """

    frames: NDArray[np.int64]
    cameras: tuple[str, ...]
    visible: NDArray[np.float64]
    usable: NDArray[np.bool_]

    def __attrs_post_init__(self) -> None:
        shape = (len(self.frames), len(self.cameras))
        if self.visible.shape != shape or self.usable.shape != shape:
            raise ValueError(f"visible and usable must be {shape}, got {self.visible.shape} and {self.usable.shape}")
        if len(self.frames) and (self.frames[0] < 0 or (np.diff(self.frames) <= 0).any()):
            raise ValueError("frames of the samples must rise from 0 or later")
        known = self.visible[~np.isnan(self.visible)]
        if known.size and (known.min() < 0 or known.max() > 1):
            raise ValueError(f"visible must lie in 0..1, got {known.min():.3g}..{known.max():.3g}")

    def arrays(self) -> dict[str, NDArray]:
        """Everything in it, as arrays that .npz files take; `from_arrays` is the way back."""
        return {
            "frames": self.frames,
            "cameras": np.array(self.cameras),
            "visible": self.visible,
            "usable": self.usable,
        }

    @classmethod
    def from_arrays(cls, arrays: Mapping[str, NDArray]) -> ScoreTable:
        """KeyError where an array is missing, ValueError where one does not fit."""
        return cls(
            arrays["frames"].astype(np.int64),
            tuple(str(name) for name in arrays["cameras"]),
            arrays["visible"].astype(np.float64),
            arrays["usable"].astype(bool),
        )
