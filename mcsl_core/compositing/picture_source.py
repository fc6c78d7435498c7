"""What the compositor needs of footage, so that pictures of another kind can be composited in the same way."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

from mcsl_core.imaging.planes import Planes
from mcsl_core.timing import FrameRange


class PicturePlayer(Protocol):
    """One camera's pictures by programme frame; for one thread."""

    def at(self, frame: int) -> Planes | None:
        """The camera's own picture, of its full size, at programme frame ``frame``; None where it has none."""
        ...

    def close(self) -> None:
        """Let go of what is open; pictures handed out stay valid."""
        ...


class PictureSource(Protocol):
    """Every camera's own pictures: `Footage`, a proxy of it, or pictures made for a purpose."""

    def player(self, camera: str) -> PicturePlayer:
        """The pictures of ``camera``, one at a time; close it when done."""
        ...

    def median(self, camera: str, frames: Sequence[int], within: FrameRange) -> Planes | None:
        """The temporal median of a camera's pictures: what stays in view.

        Parameters
        ----------
        camera : str
            The camera's name.
        frames : sequence of int
            Programme frames of one pose.
        within : FrameRange
            The range around them in which the lamp stands still; a picture near a frame may stand for it.

        Returns
        -------
        Planes or None
            Of the camera's full size; None where it has no picture at any of the frames.
        """
        ...
