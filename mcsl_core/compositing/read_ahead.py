"""Pictures that are looked at before they are shown, decoded once."""

from __future__ import annotations

from collections.abc import Sequence

from mcsl_core.imaging.planes import Planes
from mcsl_core.timing import FrameRange

from .picture_source import PicturePlayer, PictureSource

_MOST_AHEAD = 64  # frames; what lies further on is left from before a jump


class ReadAhead:
    """A `PictureSource` whose players can look at frames to come, and keep them until they are shown."""

    def __init__(self, pictures: PictureSource) -> None:
        self._pictures = pictures
        self._players: dict[str, _AheadPlayer] = {}

    def player(self, camera: str) -> PicturePlayer:
        """See `PictureSource`; the latest one is who looks ahead."""
        self._players[camera] = _AheadPlayer(self._pictures.player(camera))
        return self._players[camera]

    def median(self, camera: str, frames: Sequence[int], within: FrameRange) -> Planes | None:
        """See `PictureSource`."""
        return self._pictures.median(camera, frames, within)

    def look(self, camera: str, frame: int) -> Planes | None:
        """The picture of ``camera`` at a frame near the one that is shown now, before it or after."""
        return self._players[camera].look(frame)


class _AheadPlayer:
    def __init__(self, player: PicturePlayer) -> None:
        self._player = player
        self._kept: dict[int, Planes | None] = {}
        self._now = 0

    def at(self, frame: int) -> Planes | None:
        self._now = frame
        self._kept = {f: planes for f, planes in self._kept.items() if frame <= f <= frame + _MOST_AHEAD}
        return self.look(frame)

    def look(self, frame: int) -> Planes | None:
        for between in range(self._now, frame):  # they are shown later
            self._read(between)
        return self._read(frame)

    def _read(self, frame: int) -> Planes | None:
        if frame not in self._kept:
            self._kept[frame] = self._player.at(frame)
        return self._kept[frame]

    def close(self) -> None:
        self._player.close()
        self._kept.clear()
