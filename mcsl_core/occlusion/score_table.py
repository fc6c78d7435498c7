"""How much of the surgical field each camera sees over time: the table that selectors choose from."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from attrs import field, frozen
from numpy.typing import NDArray

_MERIT = "merit_"  # before the names of arrays that hold merits


@frozen(eq=False)
class ScoreTable:
    """Visible field over time, of S samples and C cameras.

    Attributes
    ----------
    frames : (S,) int array
        Programme frames of the samples, rising.
    cameras : tuple of str
        Names of the cameras.
    visible : (S, C) float array
        Visible share of the surgical field, 0..1; NaN where there is no data.
    usable : (S, C) bool array
        False where no automatic shot may use the camera: it is weak, or has no picture.
    merits : mapping of str to (S, C) float array, optional
        How well each camera shows the field, whatever is in its way: name of the merit (``sharpness``, ``resolution``,
        ``viewpoint``; there may be others, or none) -> 0 (not at all) to 1 (as well as any).

    Raises
    ------
    ValueError
        Where a shape does not fit, the frames do not rise or a share lies outside of 0..1.

    Notes
    -----
    Samples need not be evenly spaced: where occlusion changes fast there are more of them.
    """

    frames: NDArray[np.int64]
    cameras: tuple[str, ...]
    visible: NDArray[np.float64]
    usable: NDArray[np.bool_]
    merits: Mapping[str, NDArray[np.float64]] = field(factory=dict)

    def __attrs_post_init__(self) -> None:
        shape = (len(self.frames), len(self.cameras))
        if self.visible.shape != shape or self.usable.shape != shape:
            raise ValueError(f"visible and usable must be {shape}, got {self.visible.shape} and {self.usable.shape}")
        if len(self.frames) and (self.frames[0] < 0 or (np.diff(self.frames) <= 0).any()):
            raise ValueError("frames of the samples must rise from 0 or later")
        known = self.visible[~np.isnan(self.visible)]
        if known.size and (known.min() < 0 or known.max() > 1):
            raise ValueError(f"visible must lie in 0..1, got {known.min():.3g}..{known.max():.3g}")
        for name, merit in self.merits.items():
            if merit.shape != shape or not ((merit >= 0) & (merit <= 1)).all():
                raise ValueError(f"the merit {name} must be {shape} in 0..1")

    def arrays(self) -> dict[str, NDArray]:
        """The table as named arrays.

        Returns
        -------
        dict of str to array
            As .npz files take them; `from_arrays` is the way back.
        """
        return {
            "frames": self.frames,
            "cameras": np.array(self.cameras),
            "visible": self.visible,
            "usable": self.usable,
            **{_MERIT + name: merit for name, merit in self.merits.items()},
        }

    @classmethod
    def from_arrays(cls, arrays: Mapping[str, NDArray]) -> ScoreTable:
        """The table that `arrays` was made from.

        Parameters
        ----------
        arrays : mapping of str to array
            Others in it are left alone.

        Returns
        -------
        ScoreTable

        Raises
        ------
        KeyError
            Where an array is missing.
        ValueError
            Where one does not fit.
        """
        return cls(
            arrays["frames"].astype(np.int64),
            tuple(str(name) for name in arrays["cameras"]),
            arrays["visible"].astype(np.float64),
            arrays["usable"].astype(bool),
            {n.removeprefix(_MERIT): arrays[n].astype(np.float64) for n in arrays if n.startswith(_MERIT)},
        )
