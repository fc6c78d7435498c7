"""Changes to a whole EDL: decisions carried over to a new analysis, the look switched, media paths rebased."""

from __future__ import annotations

import os
from pathlib import Path, PurePosixPath

import attrs

from mcsl_core.errors import DocumentError
from mcsl_core.timing import FrameRange

from .schema import Edl, Override


def carry_over(old: Edl, new: Edl) -> Edl:
    """``new`` (a fresh analysis) with the editor's decisions of ``old``: overrides, corrections and look.

    Raises
    ------
    DocumentError
        Where the rate differs (the same frame numbers would be other times), an override names a camera that is gone,
        or one reaches past the new end.
    """
    names = {c.name for c in new.cameras}
    decided = [(f"overrides[{i}]", o.camera, o.range) for i, o in enumerate(old.overrides)]
    decided += [(f"corrections[{i}]", c.camera, c.range) for i, c in enumerate(old.corrections)]
    if decided and old.rate != new.rate:
        raise DocumentError(
            f"the overrides count frames at {old.rate} per second, the new analysis at {new.rate}",
            remedy=f"Analyse with --rate {old.rate}, or remove the overrides from the old EDL",
        )
    for at, camera, piece in decided:
        if camera is not None and camera not in names:
            raise DocumentError(
                f"{at} takes camera {camera!r}, which the new analysis has not",
                remedy=f"Name the cameras as before, or remove {at} from the old EDL",
            )
        if piece.stop > new.frames:
            raise DocumentError(
                f"{at} ends at frame {piece.stop}, after the new end {new.frames}",
                remedy=f"Analyse the whole recording, or shorten {at} in the old EDL",
            )
    return attrs.evolve(new, overrides=old.overrides, corrections=old.corrections, look=old.look)


def change_look(
    edl: Edl,
    *,
    centering: bool | None = None,
    fill: bool | None = None,
    colour: bool | None = None,
    offset: tuple[float, float] | None = None,
    piece: FrameRange | None = None,
) -> Edl:
    """``edl`` with the given aids switched, everything else as it was.

    Parameters
    ----------
    edl
        The document.
    centering, fill, colour
        On or off; as it was without.
    offset
        Centering by hand, (dx, dy) in programme pixels: an override, also over the whole programme.
    piece
        Where it holds, as an override; without, the whole programme's look is switched and overrides stay.
    """
    aids = {n: v for n, v in (("centering", centering), ("fill", fill), ("colour", colour)) if v is not None}
    if not aids and offset is None:
        return edl
    if piece is None and aids:
        edl = attrs.evolve(edl, look=attrs.evolve(edl.look, **aids))
    if piece is None and offset is None:
        return edl
    override = attrs.evolve(Override(piece or FrameRange(0, edl.frames), offset=offset), **(aids if piece else {}))
    return attrs.evolve(edl, overrides=(*edl.overrides, override))


def rebased(edl: Edl, old: Path, new: Path) -> Edl:
    """``edl`` with its relative paths, which counted from the folder ``old``, counting from the folder ``new``."""
    old, new = old.resolve(), new.resolve()
    if old == new:
        return edl

    def moved(path: str) -> str:
        if PurePosixPath(path).is_absolute() or Path(path).is_absolute():
            return path
        try:
            return Path(os.path.relpath(old / path, new)).as_posix()
        except ValueError:  # another drive: there is no relative way
            return (old / path).as_posix()

    cameras = tuple(
        attrs.evolve(camera, media=tuple(attrs.evolve(media, path=moved(media.path)) for media in camera.media))
        for camera in edl.cameras
    )
    return attrs.evolve(edl, cameras=cameras, scores=None if edl.scores is None else moved(edl.scores))
