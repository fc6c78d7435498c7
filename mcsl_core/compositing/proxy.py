"""Proxies: a programme at a smaller size, made at that size, for what needs many pictures of it but not every pixel."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import attrs
import numpy as np

from mcsl_core.edl import IDENTITY, Edl, Matrix34, Movement, MovementView, Pose, Relief
from mcsl_core.edl.field import at_size
from mcsl_core.filling.footprint import FootprintFiller
from mcsl_core.filling.protocol import Filler
from mcsl_core.hooks.registry import filler_offer
from mcsl_core.imaging.geometry import Homography, scaling, to_edl_matrix, to_edl_projection
from mcsl_core.imaging.planes import Planes
from mcsl_core.recording.footage import Footage, Player
from mcsl_core.timing import FrameRange


def proxy_size(size: tuple[int, int], width: int) -> tuple[int, int]:
    """The size of a proxy.

    Parameters
    ----------
    size : (int, int)
        Width and height of the original.
    width : int
        Columns wanted.

    Returns
    -------
    (int, int)
        Width and height, both even, aspect kept; never enlarged.
    """
    factor = min(1.0, width / size[0])
    return max(2, 2 * round(size[0] * factor / 2)), max(2, 2 * round(size[1] * factor / 2))


def proxy_edl(edl: Edl, size: tuple[int, int]) -> Edl:
    """The same programme at another size, its cameras reduced as much, so that pictures of it are made at that size.

    Parameters
    ----------
    edl : Edl
        The programme.
    size : (int, int)
        Width and height; see `proxy_size`.

    Returns
    -------
    Edl
        Of the same shots; poses, corrections, overrides and centering act on the smaller pictures.
    """
    factor = size[0] / edl.size[0]
    cameras = tuple(attrs.evolve(c, size=proxy_size(c.size, round(c.size[0] * factor))) for c in edl.cameras)
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
            relief=pose.relief and _relief_at_size(pose.relief, shrink, programme),
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
        fields=at_size(edl.fields, x, y),
        drawn_fields=at_size(edl.drawn_fields, x, y),
        cameras=cameras,
        movements=tuple(_movement_at_size(m, shrink, programme) for m in edl.movements),
        poses=tuple(pose_at_size(p) for p in edl.poses),
        corrections=corrections,
        overrides=overrides,
        centering=tuple((frame, dx * x, dy * y) for frame, dx, dy in edl.centering),
    )


def _relief_at_size(relief: Relief, cameras: Mapping[str, Homography], programme: Homography) -> Relief:
    """Seen in smaller pictures; matrices from full-size pixels to theirs. The grid's corners move by half a pixel."""
    return attrs.evolve(relief, projections=_projections_at_size(relief.projections, cameras, programme))


def _projections_at_size(
    projections: Mapping[str, Matrix34], cameras: Mapping[str, Homography], programme: Homography
) -> dict[str, Matrix34]:
    back = np.eye(4)
    back[np.ix_([0, 1, 2], [0, 1, 2])] = np.linalg.inv(programme)
    return {name: to_edl_projection(cameras[name] @ np.array(p) @ back) for name, p in projections.items()}


def _movement_at_size(movement: Movement, cameras: Mapping[str, Homography], programme: Homography) -> Movement:
    views = (
        MovementView(
            view.frame,
            {
                n: to_edl_matrix(programme @ np.array(h) @ np.linalg.inv(cameras[n]))
                for n, h in view.homographies.items()
            },
            _projections_at_size(view.projections, cameras, programme),
        )
        for view in movement.views
    )
    return attrs.evolve(movement, views=tuple(views))


def proxy_filler(edl: Edl, size: tuple[int, int]) -> Filler:
    """The filler that an EDL was made with, for its proxy; a new one, since a filler may keep what it worked out.

    Parameters
    ----------
    edl : Edl
        The programme at its full size.
    size : (int, int)
        Width and height of the proxy.

    Returns
    -------
    Filler

    Raises
    ------
    PluginError
        Names the package to install where the filler is not here.
    """
    offer = filler_offer(edl)
    if isinstance(offer.implementation, FootprintFiller):
        return FootprintFiller(offer.implementation.feather_px * size[0] / edl.size[0])
    return offer.checked


class ProxyFootage:
    """A `PictureSource` of proxies, of which every camera is decoded once, whoever asks: all read the same frames.

    Parameters
    ----------
    edl : Edl
        The programme at its full size.
    base : Path
        The folder that media paths are relative to.
    size : (int, int)
        Width and height of the proxy programme; see `proxy_size`.

    Attributes
    ----------
    footage : Footage
        The proxies' own footage, each call of which opens decoders of its own.
    """

    def __init__(self, edl: Edl, base: Path, size: tuple[int, int]) -> None:
        self.footage = Footage(proxy_edl(edl, size).cameras, rate=edl.rate, frames=edl.frames, base=base)
        self._players: dict[str, _SharedPlayer] = {}

    def player(self, camera: str) -> _SharedPlayer:
        """The pictures of ``camera``, the same player for all."""
        if camera not in self._players:
            self._players[camera] = _SharedPlayer(self.footage.player(camera))
        return self._players[camera]

    def median(self, camera: str, frames: Sequence[int], within: FrameRange) -> Planes | None:
        """See `PictureSource`."""
        return self.footage.median(camera, frames, within)

    def close(self) -> None:
        """Close the decoders."""
        for player in self._players.values():
            player.end()


class _SharedPlayer:
    def __init__(self, player: Player) -> None:
        self._player = player

    def at(self, frame: int) -> Planes | None:
        return self._player.at(frame)

    def close(self) -> None:
        """A compositor is done with it; the others are not."""

    def end(self) -> None:
        self._player.close()
