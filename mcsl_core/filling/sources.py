"""The pictures that may stand behind the chosen camera's."""

from __future__ import annotations

from collections.abc import Iterator

from attrs import frozen

from mcsl_core.imaging.rect import Rect

from .median_grid import first_grid_frames, grid_frames, grid_step
from .protocol import FillContext

_CROSSFADE_S = 1.0  # from one median to the next


@frozen
class Source:
    """Pictures of one camera: as it is now, its latest median, or its median in another pose.

    Parameters
    ----------
    camera : str
        The camera's name.
    median : bool
        The median of this pose's latest grid frames, in place of the picture now.
    frame : int, optional
        A programme frame of another pose: the median near it.
    plane_only : bool
        Warped by the homography alone, for pixels that the parallax-corrected picture leaves empty.
    """

    camera: str
    median: bool = False
    frame: int | None = None
    plane_only: bool = False

    @property
    def live(self) -> bool:
        """Whether it is the picture now, for which the camera is decoded all along."""
        return not self.median and self.frame is None


def candidates(context: FillContext) -> Iterator[Source]:
    """The sources that may stand behind the chosen camera, the best first."""
    for camera in context.others:
        yield Source(camera, median=True)
    for still in context.elsewhere:
        before = (still.start + still.stop) // 2 < context.frame
        frame = still.stop - 1 if before else still.start  # the nearest in time
        for camera in (context.camera, *context.others):
            yield Source(camera, frame=frame)


def median_frames(context: FillContext, source: Source) -> tuple[tuple[int, ...], ...]:
    """The frames of each median that a source is made of now.

    Parameters
    ----------
    context : FillContext
        The programme frame.
    source : Source
        One of `candidates`.

    Returns
    -------
    tuple of tuples of int
        One entry for each picture, the latest first; two while one median goes over into the next (`crossfade`). An
        empty entry is the picture now.
    """
    if source.frame is not None:
        still = next(piece for piece in context.elsewhere if source.frame in piece)
        step = grid_step(still, context.rate)
        if source.frame > still.start:
            return (grid_frames(still, step, source.frame // step),)
        return (first_grid_frames(still, step),)
    if not source.median:
        return ((),)
    step = grid_step(context.still, context.rate)
    latest = context.frame // step
    now, before = grid_frames(context.still, step, latest), grid_frames(context.still, step, latest - 1)
    return (now,) if now == before or crossfade(context) >= 1 else (now, before)


def crossfade(context: FillContext) -> float:
    """Weight of the latest median against the one before it, 0..1."""
    step = grid_step(context.still, context.rate)
    return min(1.0, (context.frame % step + 1) / max(1.0, min(_CROSSFADE_S * context.rate, step)))


def missing(context: FillContext, source: Source) -> bool:
    """Whether a source has no picture at this frame: a gap in the camera's recording."""
    speck = Rect(0, 0, 2, 2)
    return any(context.picture(source.camera, speck, frames) is None for frames in median_frames(context, source))
