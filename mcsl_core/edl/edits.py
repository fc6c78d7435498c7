"""Changes to a whole EDL: decisions carried over to a new analysis, look and field changed, media paths rebased."""

from __future__ import annotations

import os
from pathlib import Path, PurePosixPath
from typing import Any

import attrs

from mcsl_core.errors import DocumentError, Fault
from mcsl_core.timing import FrameRange

from .field import DrawnField, Polygons
from .schema import Edl, Override


def carry_over(old: Edl, new: Edl) -> Edl:
    """``new`` (a fresh analysis) with the editor's decisions of ``old``: overrides, corrections, drawn fields and look.

    Raises
    ------
    DocumentError
        Where the rate differs (the same frame numbers would be other times), an override names a camera that is gone,
        one reaches past the new end, or a field was drawn in another camera's perspective.
    """
    check_drawn(old, new.reference)
    names = {c.name for c in new.cameras}
    decided = [(f"overrides[{i}]", o.camera, o.range) for i, o in enumerate(old.overrides)]
    decided += [(f"corrections[{i}]", c.camera, c.range) for i, c in enumerate(old.corrections)]
    decided += [(f"drawn_fields[{i}]", None, f.range) for i, f in enumerate(old.drawn_fields)]
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
    kept = {name: getattr(old, name) for name in ("overrides", "corrections", "drawn_fields", "look")}
    return attrs.evolve(new, **kept)


def check_drawn(old: Edl, reference: str) -> None:
    """DocumentError where the fields drawn in ``old`` are not of the perspective of the camera ``reference``."""
    if old.drawn_fields and old.reference != reference:
        raise DocumentError(
            f"drawn_fields[0] is drawn in the perspective of {old.reference!r}, the new analysis takes {reference!r}'s",
            remedy=f"Analyse with --reference {old.reference}, or take the field away: mcsl field EDL --clear",
        )


def merged(base: Edl, mine: Edl, theirs: Edl) -> Edl:
    """``mine`` and ``theirs``, each changed from ``base`` without knowing of the other, in one document.

    Raises
    ------
    DocumentError
        Where both changed the same and it cannot hold both, or frames count differently now.
    """
    counted = ("overrides", "corrections", "drawn_fields")
    if theirs.rate != base.rate and any(getattr(mine, name) != getattr(base, name) for name in counted):
        raise _conflict("rate")
    names = [field.name for field in attrs.fields(Edl)]
    try:
        return Edl(**{name: _one_of(name, *(getattr(edl, name) for edl in (base, mine, theirs))) for name in names})
    except Fault as fault:
        raise DocumentError(
            f"what was changed here does not fit what was written into the file meanwhile ({fault})",
            remedy="Open the file again and make the change there",
        ) from fault


def _one_of(name: str, base: Any, mine: Any, theirs: Any) -> Any:
    """A part of the document that holds both changes."""
    if mine in (base, theirs):
        return theirs
    if theirs == base:
        return mine
    if name == "look":
        parts = [field.name for field in attrs.fields(type(base))]
        return type(base)(**{n: _one_of(n, *(getattr(look, n) for look in (base, mine, theirs))) for n in parts})
    if name in ("overrides", "corrections", "drawn_fields") and mine[: len(base)] == base:
        return (*theirs, *mine[len(base) :])
    raise _conflict(name)


def _conflict(name: str) -> DocumentError:
    return DocumentError(
        f"{name} was changed here, and in the file as well since it was opened",
        remedy="Open the file again and make the change there, or save under another name",
    )


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


def draw_field(edl: Edl, polygons: Polygons, piece: FrameRange | None = None, note: str = "") -> Edl:
    """``edl`` with the field drawn as ``polygons`` over ``piece`` (everything, without), in place of what was there.

    Raises
    ------
    Fault
        Where a polygon is none, or nothing of them lies in the programme's picture.
    """
    drawn = DrawnField(piece or FrameRange(0, edl.frames), polygons, note)
    width, height = edl.size
    for index, polygon in enumerate(polygons):
        x, y = zip(*polygon, strict=True)
        if max(x) < 0 or max(y) < 0 or min(x) > width - 1 or min(y) > height - 1:
            raise Fault(f"lies outside of the programme's {width}x{height} pixels", f".polygons[{index}]")
    return attrs.evolve(edl, drawn_fields=(*clear_field(edl, drawn.range).drawn_fields, drawn))


def clear_field(edl: Edl, piece: FrameRange | None = None) -> Edl:
    """``edl`` with nothing drawn over ``piece`` (anywhere, without): there the field is found again."""
    if piece is None:
        return attrs.evolve(edl, drawn_fields=())
    left = []
    for drawn in edl.drawn_fields:
        ends = [
            (drawn.range.start, min(drawn.range.stop, piece.start)),
            (max(drawn.range.start, piece.stop), drawn.range.stop),
        ]
        left += [attrs.evolve(drawn, range=FrameRange(start, stop)) for start, stop in ends if start < stop]
    return attrs.evolve(edl, drawn_fields=tuple(left))


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
