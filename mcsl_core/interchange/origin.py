"""What a document says of the decisions that it was exported with, so that it can be compared with just those.

A digest of the automatic choice; one of what was shown; the stretches in which overrides showed another camera, as
``start-stop:camera`` with the camera's number in the EDL; and those that were removed, as ``xstart-stop``. The second
digest tells whether they came back whole. Last stands what was heard: ``a`` with the angle's number, ``ax`` what is
conformed, ``a-`` nothing.
"""

from __future__ import annotations

import hashlib
import json
import re
from collections.abc import Iterable, Sequence

import attrs
from attrs import frozen

from mcsl_core.edl import Edl, Override
from mcsl_core.edl.resolve import resolve
from mcsl_core.timing import FrameRange, merge_equal

from .model import Shot
from .painting import beside

_MOST_LETTERS = 40_000  # no editor says how much a note holds
_DIGEST = "[0-9a-f]{16}"
ORIGIN = re.compile(rf"mcsl cut ({_DIGEST}(?:\s+{_DIGEST}(?:\s+(?:\d+-\d+:\d+|x\d+-\d+|a(?:\d+|x|-)))*)?)")
_STRETCH = re.compile(r"(\d{1,15})-(\d{1,15}):(\d{1,9})")
_SOUND = re.compile(r"a(\d{1,9}|x|-)")
CONFORMED = " "  # in the place of a camera: no camera is called so
_REMOVED = re.compile(r"x(\d{1,15})-(\d{1,15})")


@frozen
class Exported:
    """What a document held when it was exported: its shots, and what of the programme was removed."""

    shots: tuple[Shot, ...]
    removed: tuple[FrameRange, ...]


def shots_of(edl: Edl) -> tuple[Shot, ...]:
    """The shots with the overrides in them; neighbours of one camera are one."""
    cameras = merge_equal([(piece, decision.camera) for piece, decision in resolve(edl)])
    return tuple(Shot(piece, camera) for piece, camera in cameras)


def automatic_of(edl: Edl) -> tuple[Shot, ...]:
    """The shots without overrides; neighbours of one camera are one."""
    return tuple(Shot(piece, camera) for piece, camera in merge_equal([(s.range, s.camera) for s in edl.shots]))


def pairs(shots: Iterable[Shot]) -> list[tuple[FrameRange, str]]:
    """(frames, camera) of each."""
    return [(shot.range, shot.camera) for shot in shots]


def basis_of(edl: Edl) -> str:
    """A digest of the automatic choice: a document of another analysis must not be compared with this."""
    return _digest(edl, automatic_of(edl))


def origin_of(edl: Edl) -> str:
    """What an export says of the decisions that it shows; without the stretches where they are too many."""
    shown, number = shots_of(edl), {camera.name: n for n, camera in enumerate(edl.cameras)}
    both = beside(edl.frames, pairs(shown), pairs(automatic_of(edl)))
    decided = merge_equal([(piece, camera) for piece, (camera, automatic) in both if camera != automatic])
    said = [basis_of(edl), _digest(edl, shown, edl.removed)]
    words = [*said, *(f"{piece.start}-{piece.stop}:{number[camera]}" for piece, camera in decided)]
    whole = " ".join([*words, *(f"x{piece.start}-{piece.stop}" for piece in edl.removed)])
    return whole if len(whole) <= _MOST_LETTERS else " ".join(said)


def with_sound(origin: str, heard: str | None, cameras: Sequence[str]) -> str:
    """``origin`` with what is heard: of the camera, in the order of the angles, `CONFORMED`, or nothing."""
    word = "-" if heard is None else "x" if heard == CONFORMED else cameras.index(heard)
    return f"{origin} a{word}"


def sound_in(origin: str, cameras: Sequence[str]) -> str | None:
    """What was heard, as `with_sound` says it; empty where nothing was, None where it does not say so."""
    said = next((match[1] for word in origin.split() if (match := _SOUND.fullmatch(word))), None)
    if said is None or said in "x-":
        return None if said is None else CONFORMED if said == "x" else ""
    return cameras[int(said)] if int(said) < len(cameras) else None


def exported(origin: str, edl: Edl) -> Exported | None:
    """What a document held when it was exported; None where it does not say so, or not whole."""
    words = origin.split()
    if len(words) < 2:
        return None
    decided = [override for word in words[2:] if (override := _override(word, edl)) is not None]
    gone = [match for word in words[2:] if (match := _REMOVED.fullmatch(word))]
    said = tuple(FrameRange(int(m[1]), int(m[2])) for m in gone if int(m[1]) < int(m[2]))
    shown = shots_of(edl), shots_of(attrs.evolve(edl, overrides=tuple(decided)))
    found = (Exported(shots, removed) for shots in shown for removed in (said, edl.removed))
    return next((one for one in found if _digest(edl, one.shots, one.removed) == words[1]), None)


def _override(word: str, edl: Edl) -> Override | None:
    match = _STRETCH.fullmatch(word)
    if match is None:
        return None
    start, stop, camera = map(int, match.groups())
    there = start < stop <= edl.frames and camera < len(edl.cameras)
    return Override(FrameRange(start, stop), camera=edl.cameras[camera].name) if there else None


def _digest(edl: Edl, shots: Sequence[Shot], removed: Sequence[FrameRange] = ()) -> str:
    facts = [str(edl.rate), *([shot.range.stop, shot.camera] for shot in shots)]
    facts += [["x", piece.start, piece.stop] for piece in removed]
    return hashlib.sha256(json.dumps(facts).encode()).hexdigest()[:16]
