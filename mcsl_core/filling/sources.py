"""Where the pictures come from that stand behind the chosen camera's."""

from __future__ import annotations

from collections.abc import Iterator

from attrs import frozen

from .moments import first_looks, grid_step, looks
from .view import Rect, View

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


def candidates(view: View) -> Iterator[Source]:
    """Who may stand behind, the best first."""
    for camera in view.others:
        yield Source(camera, moment=True)
    for still in view.elsewhere:
        frame = still.stop - 1 if still.start < view.still.start else still.start  # the nearest in time
        for camera in (view.camera, *view.others):
            yield Source(camera, frame=frame)


def sets_of(view: View, source: Source) -> tuple[tuple[int, ...], ...]:
    """The sets of moments at which a source is looked at, the latest first; an empty set is now."""
    if source.frame is not None:
        still = next(piece for piece in view.elsewhere if source.frame in piece)
        step = grid_step(still, view.rate)
        return (looks(still, step, source.frame // step) if source.frame > still.start else first_looks(still, step),)
    if not source.moment:
        return ((),)
    step = grid_step(view.still, view.rate)
    now, before = (looks(view.still, step, view.frame // step - ago) for ago in (0, 1))
    return (now,) if now == before or faded(view) >= 1 else (now, before)


def faded(view: View) -> float:
    """How much of the latest looks has come, 0..1."""
    step = grid_step(view.still, view.rate)
    return min(1.0, (view.frame % step + 1) / max(1.0, min(_FADE_S * view.rate, step)))


def missing(view: View, source: Source) -> bool:
    speck = Rect(0, 0, 2, 2)
    return any(view.look(source.camera, speck, moments) is None for moments in sets_of(view, source))
