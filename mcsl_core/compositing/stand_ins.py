"""Who was shown in place of a chosen camera that has no picture."""

from __future__ import annotations

from fractions import Fraction

from attrs import field, frozen

from mcsl_core.progress import Progress
from mcsl_core.timing import format_time, ranges_of

_MOST_NOTES = 12


@frozen(eq=False)
class StandIns:
    """Which camera stood in for a chosen one without a picture, and at which programme frames."""

    _frames: dict[tuple[str, str | None], set[int]] = field(factory=dict, init=False)

    def add(self, chosen: str, shown: str | None, frame: int) -> None:
        """``shown``: None where no camera has a picture."""
        self._frames.setdefault((chosen, shown), set()).add(frame)

    def update(self, other: StandIns) -> None:
        """Adds those of ``other``."""
        for key, frames in other._frames.items():
            self._frames.setdefault(key, set()).update(frames)

    def tell(self, rate: Fraction, progress: Progress) -> None:
        """Notes each stretch, the first dozen one by one; ``rate``: programme frames per second."""
        stretches = [(piece, *key) for key, frames in self._frames.items() for piece in ranges_of(frames)]
        for piece, chosen, shown in sorted(stretches, key=lambda one: one[0])[:_MOST_NOTES]:
            start, stop = (format_time(frame / rate) for frame in (piece.start, piece.stop))
            instead = "and no other camera has one: black" if shown is None else f"{shown} is shown in its place"
            progress.note(f"{chosen} has no picture from {start} to {stop} (frames {piece}), {instead}")
        if len(stretches) > _MOST_NOTES:
            progress.note(f"{len(stretches) - _MOST_NOTES} more stretches in which another camera is shown")
