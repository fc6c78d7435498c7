"""What was measured along the recording, in a file beside the EDL: for reports, and to select again."""

from __future__ import annotations

import io
from pathlib import Path

import numpy as np
from attrs import field, frozen

from mcsl_core.arrays import read_arrays
from mcsl_core.documents import write_atomic
from mcsl_core.errors import DocumentError
from mcsl_core.movement.protocol import NO_CURVE, Curve
from mcsl_core.occlusion.score_table import ScoreTable


@frozen(eq=False)
class Measurements:
    """The visible field over time, and the curve that movements were judged by.

    Parameters
    ----------
    scores
        How much of the field each camera sees at every sample.
    movement
        What the movement detector measured, and its bound; empty without.
    """

    scores: ScoreTable
    movement: Curve = field(default=NO_CURVE)

    def save(self, path: Path) -> None:
        """Writes a compressed .npz atomically, in single precision; the same values give the same bytes."""
        arrays = {**self.scores.arrays(), **self.movement.arrays()}
        single = {name: a.astype(np.float32) if a.dtype == np.float64 else a for name, a in arrays.items()}
        stream = io.BytesIO()
        np.savez_compressed(stream, **single)  # pyright: ignore[reportArgumentType]
        write_atomic(path, stream.getvalue())


def load_measurements(path: Path) -> Measurements:
    """Reads what `Measurements.save` wrote.

    Raises
    ------
    InputError, DocumentError
        Where the file is missing or something else.
    """
    wanted, remedy = "a table of scores", "Run `mcsl analyse` again"
    data = read_arrays(path, wanted=wanted, remedy=remedy)
    try:
        return Measurements(ScoreTable.from_arrays(data), Curve.from_arrays(data))
    except (LookupError, ValueError, TypeError, OverflowError) as error:
        raise DocumentError(f"is not {wanted} ({error})", where=str(path), remedy=remedy) from error
