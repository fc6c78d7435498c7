"""Changes to a whole EDL: decisions carried over to a new analysis, look and field changed, media paths rebased."""

from __future__ import annotations

import os
from fractions import Fraction
from pathlib import Path, PurePosixPath
from typing import Any

import attrs
from attrs import frozen

from mcsl_core.errors import DocumentError, Fault
from mcsl_core.timing import FrameRange

from .checks import NO_SOUND
from .field import DrawnField, Polygons
from .schema import Camera, Edl, Override

DECISIONS = ("overrides", "corrections", "drawn_fields", "removed", "audio_from", "look")
"""The parts of an EDL that people decide."""


@frozen
class Counted:
    """What decisions count in: frames of which programme, pixels of which perspective, whose pictures."""

    rate: Fraction
    frames: int
    size: tuple[int, int]
    reference: str
    cameras: tuple[Camera, ...]

    @classmethod
    def of(cls, edl: Edl) -> Counted:
        return cls(edl.rate, edl.frames, edl.size, edl.reference, edl.cameras)


def check_decisions(old: Edl, new: Counted) -> None:
    """DocumentError where overrides, corrections or drawn fields of ``old`` would say something else in a new analysis.

    Where the rate, the reference camera, or the size that shifts are measured in differs (the same frames and pixels
    would be others), one names a camera that is gone, or one reaches past the new end.
    """
    decided = [(f"overrides[{i}]", o.camera, o.range) for i, o in enumerate(old.overrides)]
    decided += [(f"corrections[{i}]", c.camera, c.range) for i, c in enumerate(old.corrections)]
    decided += [(f"drawn_fields[{i}]", None, f.range) for i, f in enumerate(old.drawn_fields)]
    decided += [(f"removed[{i}]", None, piece) for i, piece in enumerate(old.removed)]
    if not decided and old.audio_from is None:
        return
    if decided and old.rate != new.rate:
        raise DocumentError(
            f"the overrides count frames at {old.rate} per second, the new analysis at {new.rate}",
            remedy=f"Analyse with --rate {old.rate}, or remove the overrides from the old EDL",
        )
    check_drawn(old, new.reference)
    if decided and old.reference != new.reference:
        raise DocumentError(
            f"the overrides count from the first picture of {old.reference} and are laid in its perspective, the new "
            f"analysis has {new.reference} as its reference",
            remedy=f"Analyse with --reference {old.reference}, or into another EDL",
        )
    in_pixels = old.corrections or old.drawn_fields or any(o.offset is not None for o in old.overrides)
    if old.size != new.size and in_pixels:
        was, now = ("{}x{}".format(*size) for size in (old.size, new.size))
        raise DocumentError(
            f"what was placed by hand counts pixels of a programme of {was}, the new analysis has {now}",
            remedy="Analyse the files of that size, or into another EDL",
        )
    names = {camera.name for camera in new.cameras}
    if old.audio_from not in (None, NO_SOUND, *names):
        raise DocumentError(
            f"audio_from takes the sound of {old.audio_from!r}, which the new analysis has not",
            remedy="Name the cameras as before, or remove audio_from from the old EDL",
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


def check_drawn(old: Edl, reference: str) -> None:
    """DocumentError where the fields drawn in ``old`` are not of the perspective of the camera ``reference``."""
    if old.drawn_fields and old.reference != reference:
        raise DocumentError(
            f"drawn_fields[0] is drawn in the perspective of {old.reference!r}, the new analysis takes {reference!r}'s",
            remedy=f"Analyse with --reference {old.reference}, or take the field away: mcsl field EDL --clear",
        )


def other_media(old: Edl, new: Counted) -> str:
    """What a person should know of decisions over other files than those they were taken over; "" of the same."""
    if not (old.overrides or old.corrections or old.drawn_fields or old.removed):
        return ""
    files = {camera.name: [media.fingerprint for media in camera.media] for camera in old.cameras}
    changed = [
        camera.name
        for camera in new.cameras
        if any(_is_other(a, m.fingerprint) for a, m in zip(files.get(camera.name, ()), camera.media, strict=False))
    ]
    if not changed:
        return ""
    return f"the decisions were made when other files were {', '.join(changed)}: see whether they still hold"


def _is_other(before: str, now: str) -> bool:
    kinds = before.partition(":")[0], now.partition(":")[0]  # content keys of different kinds say nothing
    return kinds[0] == kinds[1] and before != now and ":" in before


def carry_over(old: Edl, new: Edl) -> Edl:
    """``new`` (a fresh analysis) with what people decided in ``old``.

    Raises
    ------
    DocumentError
        As `check_decisions`.
    """
    check_decisions(old, Counted.of(new))
    kept = {name: getattr(old, name) for name in DECISIONS}
    return attrs.evolve(new, **kept)


def merged(base: Edl, mine: Edl, theirs: Edl) -> Edl:
    """``mine`` and ``theirs``, each changed from ``base`` without knowing of the other, in one document.

    Raises
    ------
    DocumentError
        Where both changed the same and it cannot hold both, or frames count differently now.
    """
    counted = ("overrides", "corrections", "drawn_fields", "removed")
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
    offset: tuple[float, float] | None = None,
    piece: FrameRange | None = None,
    **aids: bool | None,
) -> Edl:
    """``edl`` with the given aids switched, everything else as it was.

    Parameters
    ----------
    edl
        The document.
    offset
        Centering by hand, (dx, dy) in programme pixels: an override, also over the whole programme.
    piece
        Where it holds, as an override; without, the whole programme's look is switched and overrides stay.
    aids
        On or off, by their names in `Look`; as they were without.
    """
    aids = {name: value for name, value in aids.items() if value is not None}
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
