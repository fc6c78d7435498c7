"""How sound falls silent and comes back where frames are removed: a cut in the middle of a tone clicks."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

FADE_FRAMES = 2  # on each side


def gain(first: int, length: int, of: int, fade: int, *, rises: bool, falls: bool) -> NDArray[np.float32]:
    """What samples of a piece of sound are multiplied by.

    Parameters
    ----------
    first, length
        Which samples of the piece.
    of
        How many the piece has.
    fade
        How many a fade lasts; at most half of the piece is taken.
    rises, falls
        Whether the piece begins, and ends, at removed frames.

    Returns
    -------
    NDArray
        (length,) 0 to 1, linear over a fade.
    """
    fade = max(1, min(fade, of // 2))
    at = np.arange(first, first + length) + 0.5
    gains = np.minimum(1, at / fade) if rises else np.ones(length)
    return (np.minimum(gains, (of - at) / fade) if falls else gains).astype(np.float32)
