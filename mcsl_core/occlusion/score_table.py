"""How much of the surgical field each camera sees over time: the table that selectors choose from."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from attrs import Factory, field, frozen
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
    shown : (S, C) int array, optional
        The programme frame that each camera's picture really belongs to, whose score stands in ``visible``: a sample
        takes the keyframe nearest to it. The samples' own frames without.

    Raises
    ------
    ValueError
        Where a shape does not fit, the frames do not rise or a share lies outside of 0..1.

    Notes
    -----
    Samples need not be evenly spaced: where the programme was in doubt there are more of them.
    """

    frames: NDArray[np.int64]
    cameras: tuple[str, ...]
    visible: NDArray[np.float64]
    usable: NDArray[np.bool_]
    merits: Mapping[str, NDArray[np.float64]] = field(factory=dict)
    shown: NDArray[np.int64] = field(
        default=Factory(lambda self: np.repeat(self.frames[:, None], len(self.cameras), axis=1), takes_self=True)
    )

    def __attrs_post_init__(self) -> None:
        shape = (len(self.frames), len(self.cameras))
        if not self.visible.shape == self.usable.shape == self.shown.shape == shape:
            given = f"{self.visible.shape}, {self.usable.shape} and {self.shown.shape}"
            raise ValueError(f"visible, usable and shown must be {shape}, got {given}")
        if len(self.frames) and (self.frames[0] < 0 or (np.diff(self.frames) <= 0).any()):
            raise ValueError("frames of the samples must rise from 0 or later")
        known = self.visible[~np.isnan(self.visible)]
        if known.size and (known.min() < 0 or known.max() > 1):
            raise ValueError(f"visible must lie in 0..1, got {known.min():.3g}..{known.max():.3g}")
        for name, merit in self.merits.items():
            if merit.shape != shape or not ((merit >= 0) & (merit <= 1)).all():
                raise ValueError(f"the merit {name} must be {shape} in 0..1")

    def seen_at(self, frames: NDArray[np.int64]) -> NDArray[np.float64]:
        """What the cameras see at some frames, by the frames that their pictures really belong to.

        Parameters
        ----------
        frames : (N,) int array
            Programme frames.

        Returns
        -------
        (N, C) float array
            Visible share of the field, on the line between what a camera's pictures before and after show; also where
            there is no data, as while the lamp moves (a head is likely to be still there). 0 for a camera without any.
        """
        seen = np.zeros((len(frames), len(self.cameras)))
        for column, (shown, visible) in enumerate(zip(self.shown.T, self.visible.T, strict=True)):
            known = ~np.isnan(visible)
            if known.any():
                at, first = np.unique(shown[known], return_index=True)  # two samples may take one picture
                seen[:, column] = np.interp(frames, at, visible[known][first])
        return seen

    @property
    def seen(self) -> NDArray[np.float64]:
        """(S, C): `seen_at` the samples' frames; NaN where a sample has no data."""
        return np.where(np.isnan(self.visible), np.nan, self.seen_at(self.frames))

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
            "shown": self.shown,
            **{_MERIT + name: merit for name, merit in self.merits.items()},
        }

    @classmethod
    def from_arrays(cls, arrays: Mapping[str, NDArray]) -> ScoreTable:
        """The table that `arrays` was made from.

        Parameters
        ----------
        arrays : mapping of str to array
            Others in it are left alone; ``shown`` may be missing, as from versions before it.

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
            **({"shown": arrays["shown"].astype(np.int64)} if "shown" in arrays else {}),
        )
