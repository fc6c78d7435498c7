"""What a tracker is given and gives: where the lamp stands at the instants of one movement."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Protocol

from attrs import frozen

from mcsl_core.imaging.geometry import Homography

from .lamp import Lamp, LampView
from .templates import Grey, Ground, Template


@frozen(eq=False)
class Instant:
    """What the cameras show at a programme frame.

    Attributes
    ----------
    frame : int
        The programme frame.
    pictures : mapping of str to (h, w) uint8
        Camera -> its picture, of any size.
    late : mapping of str to float
        Camera -> by how many frames its picture was taken before that.
    """

    frame: int
    pictures: Mapping[str, Grey]
    late: Mapping[str, float]


@frozen(eq=False)
class End:
    """A pose at one end of a movement.

    Attributes
    ----------
    view : LampView
        Where the lamp stands.
    ground : Ground
        Its relief.
    templates : mapping of str to Template
        What its cameras show.
    bends : mapping of str to (3, 3) array
        Camera -> its pixel by the rigid lamp -> by the pose's own projection.
    """

    view: LampView
    ground: Ground
    templates: Mapping[str, Template]
    bends: Mapping[str, Homography]


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
