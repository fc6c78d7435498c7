"""A programme at a smaller size, made at that size: for what needs many pictures of it but not every pixel."""

from __future__ import annotations

from pathlib import Path

import attrs
import numpy as np

from mcsl_core.edl import IDENTITY, Edl, Pose
from mcsl_core.filling.footprint import FootprintFiller
from mcsl_core.filling.protocol import Filler
from mcsl_core.hooks.registry import filler_offer
from mcsl_core.imaging.geometry import scaling, to_edl_matrix
from mcsl_core.imaging.planes import Planes
from mcsl_core.recording.footage import Footage, Player


def reduced_size(size: tuple[int, int], width: int) -> tuple[int, int]:
    """``size`` at ``width`` columns, aspect kept, both even, never enlarged."""
    factor = min(1.0, width / size[0])
    x, y = (max(2, 2 * round(v * factor / 2)) for v in size)
    return x, y


def reduced(edl: Edl, size: tuple[int, int]) -> Edl:
    """The same programme at ``size``, its cameras reduced as much, so that pictures of it are made at that size."""
    factor = size[0] / edl.size[0]
    cameras = tuple(attrs.evolve(c, size=reduced_size(c.size, round(c.size[0] * factor))) for c in edl.cameras)
    shrink = {c.name: scaling(c.size, r.size) for c, r in zip(edl.cameras, cameras, strict=True)}
    ground, programme = shrink[edl.reference], scaling(edl.size, size)

    def pose_at_size(pose: Pose) -> Pose:
        return attrs.evolve(
            pose,
            homographies={
                name: IDENTITY
                if name == edl.reference
                else to_edl_matrix(ground @ np.array(h) @ np.linalg.inv(shrink[name]))
                for name, h in pose.homographies.items()
            },
            anchor=to_edl_matrix(programme @ np.array(pose.anchor) @ np.linalg.inv(ground)),
        )

    x, y = size[0] / edl.size[0], size[1] / edl.size[1]
    corrections = tuple(
        attrs.evolve(c, matrix=to_edl_matrix(programme @ np.array(c.matrix) @ np.linalg.inv(programme)))
        for c in edl.corrections
    )
    overrides = tuple(
        o if o.offset is None else attrs.evolve(o, offset=(o.offset[0] * x, o.offset[1] * y)) for o in edl.overrides
    )
    return attrs.evolve(
        edl,
        size=size,
        cameras=cameras,
        poses=tuple(pose_at_size(p) for p in edl.poses),
        corrections=corrections,
        overrides=overrides,
        centering=tuple((frame, dx * x, dy * y) for frame, dx, dy in edl.centering),
    )


def reduced_filler(edl: Edl, size: tuple[int, int]) -> Filler:
    """The EDL's filler for pictures of ``size``: a new one, since a filler may keep what it worked out."""
    offer = filler_offer(edl)
    if isinstance(offer.implementation, FootprintFiller):
        return FootprintFiller(offer.implementation.feather_px * size[0] / edl.size[0])
    return offer.checked


class SharedFootage(Footage):
    """Reduced pictures of which every camera is decoded once, whoever asks: all go through the same frames together."""

    def __init__(self, edl: Edl, base: Path, size: tuple[int, int]) -> None:
        small = reduced(edl, size)
        super().__init__(small.cameras, rate=edl.rate, frames=edl.frames, base=base)
        self._players: dict[str, _SharedPlayer] = {}

    def player(self, camera: str) -> _SharedPlayer:  # pyright: ignore[reportIncompatibleMethodOverride]
        if camera not in self._players:
            self._players[camera] = _SharedPlayer(super().player(camera))
        return self._players[camera]

    def close(self) -> None:
        for player in self._players.values():
            player.end()


class _SharedPlayer:
    def __init__(self, player: Player) -> None:
        self._player = player

    def at(self, frame: int) -> Planes | None:
        return self._player.at(frame)

    def close(self) -> None:
        """A compositor has done with it; the others have not."""

    def end(self) -> None:
        self._player.close()
