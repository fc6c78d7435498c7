"""What a tracker is given and gives: where the lamp stands at the instants of one movement."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

from .following import End, Instant
from .lamp import Lamp, LampView


class Tracker(Protocol):
    """Follows the lamp while it moves."""

    @property
    def name(self) -> str: ...

    def follow(self, lamp: Lamp, before: End, after: End, instants: Sequence[Instant]) -> Sequence[LampView | None]:
        """Finds where the lamp stands in a movement.

        Parameters
        ----------
        lamp : Lamp
            Its rig.
        before, after : End
            The poses at the movement's ends.
        instants : sequence of Instant
            In order of time, some twelve a second, the first and last about at rest.

        Returns
        -------
        sequence of LampView or None
            One for every instant: where the lamp stands then, against the pose that views count from; None where it
            is lost. Over gaps of up to a second the lamp is taken to go on evenly; where a longer one is, the programme
            holds its camera.
        """
        ...
