"""Where the pictures come from that stand behind the chosen camera's."""

from __future__ import annotations

from collections.abc import Iterator

from attrs import frozen

from mcsl_core.imaging.rect import Rect

from .median_grid import first_grid_frames, grid_frames, grid_step
from .protocol import FillContext

_FADE_S = 1.0  # from one median to the next


@frozen
class Source:
    """Pictures of a camera: as it is now, or (``moment``) as it was last looked at, or at one frame of another pose."""

    camera: str
    moment: bool = False
    frame: int | None = None
    plain: bool = False  # warped alone, where a bent picture does not reach

    @property
    def live(self) -> bool:
        return not self.moment and self.frame is None


def candidates(context: FillContext) -> Iterator[Source]:
    """Who may stand behind, the best first."""
    for camera in context.others:
        yield Source(camera, moment=True)
    for still in context.elsewhere:
        frame = still.stop - 1 if still.start < context.still.start else still.start  # the nearest in time
        for camera in (context.camera, *context.others):
            yield Source(camera, frame=frame)


def sets_of(context: FillContext, source: Source) -> tuple[tuple[int, ...], ...]:
    """The sets of median_of at which a source is looked at, the latest first; an empty set is now."""
    if source.frame is not None:
        still = next(piece for piece in context.elsewhere if source.frame in piece)
        step = grid_step(still, context.rate)
        return (
            grid_frames(still, step, source.frame // step)
            if source.frame > still.start
            else first_grid_frames(still, step),
        )
    if not source.moment:
        return ((),)
    step = grid_step(context.still, context.rate)
    now, before = (grid_frames(context.still, step, context.frame // step - ago) for ago in (0, 1))
    return (now,) if now == before or faded(context) >= 1 else (now, before)


def faded(context: FillContext) -> float:
    """How much of the latest looks has come, 0..1."""
    step = grid_step(context.still, context.rate)
    return min(1.0, (context.frame % step + 1) / max(1.0, min(_FADE_S * context.rate, step)))


def missing(context: FillContext, source: Source) -> bool:
    speck = Rect(0, 0, 2, 2)
    return any(context.picture(source.camera, speck, median_of) is None for median_of in sets_of(context, source))
