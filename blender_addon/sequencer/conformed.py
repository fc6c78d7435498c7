# SPDX-License-Identifier: GPL-3.0-or-later
"""The conformed pictures in the sequencer: put in place, muted where they no longer hold, back when they do again.

core/stale.py decides; this does. A strip that holds in part is split there. Muted, not removed: when the editor takes
the decision back, the exact picture returns at once. What an editor mutes stays muted.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import bpy  # pyright: ignore[reportMissingImports]
from attrs import frozen

from mcsl_core.blender.messages import ConformedPiece
from mcsl_core.edl import Edl
from mcsl_core.edl.resolve import DecisionsByPose
from mcsl_core.timing import FrameRange, without

from ..core import stale
from ..core.carry_over import Place, main_part, parts_of, uncovered
from ..core.strip_plan import FIRST_CAMERA_CHANNEL, make_plan
from .build import add_conformed_strip, cut_out, deselect
from .compat import ends, strips_of
from .edit import effect_inputs, split_at
from .films import link_film
from .scene_properties import AWAITS_PICTURES, CONFORMED_BASIS, FALLEN, NO_LONGER_HOLDS, role_of
from .sound import renew_sound
from .touched import Work


@frozen
class Held:
    """What `keep_true` found. outstanding: stretches without an exact picture; lost: those whose picture fell away.

    changed: whether strips were muted or came back.
    """

    outstanding: tuple[FrameRange, ...]
    lost: tuple[FrameRange, ...]
    changed: bool


def note_basis(scene: Any, edl: Edl) -> None:
    """The conformed pictures in place were made for ``edl``."""
    scene[CONFORMED_BASIS] = stale.to_text(stale.basis_of(edl))


def conformed_strips(scene: Any) -> list[tuple[Any, FrameRange]]:
    """Every conformed strip and the programme frames it shows, in order."""
    pairs = []
    for strip in strips_of(scene, "MOVIE"):
        if role_of(strip) == "conformed":
            start, stop = ends(strip)
            pairs.append((strip, FrameRange(start, stop)))
    return sorted(pairs, key=lambda pair: pair[1])


def any_there(scene: Any) -> bool:
    return any(role_of(strip) == "conformed" for strip in strips_of(scene, "MOVIE"))


def all_hold(scene: Any, edl: Edl) -> bool:
    """Whether the conformed pictures in place are, all over the programme, what ``edl`` decides."""
    then = stale.from_text(scene.get(CONFORMED_BASIS, ""))
    return any_there(scene) and not stale.changed(stale.basis_of(edl), then)


def keep_true(scene: Any, now: Edl, by_pose: DecisionsByPose | None = None) -> Held:
    """Mutes what no longer shows what ``now`` decides, unmutes what does again.

    by_pose: what `resolve_by_pose` says of ``now``, where that is known.
    """
    there = conformed_strips(scene)
    then = stale.from_text(scene.get(CONFORMED_BASIS, ""))
    gone = stale.changed(stale.basis_of(now, by_pose), then) if there else ()
    lost, changed, whole = [], False, effect_inputs(scene) if gone else set()
    for strip, span in there:
        parts = stale.parts(span, gone)
        if strip.name in whole and len(parts) > 1:
            parts = (stale.Part(span, holds=False),)
        pieces = split_at(strip, [part.range.stop for part in parts[:-1]])
        for piece, part in zip(pieces, parts, strict=True):
            changed |= _set_holds(piece, part.holds)
            if not part.holds:
                lost.append(part.range)
    covered = [span for strip, span in conformed_strips(scene) if not strip.mute] if there else []
    return Held(stale.outstanding(now.frames, covered), without(lost, ()), changed)


def _set_holds(strip: Any, holds: bool) -> bool:
    """Touches the strip only where something changes, which handlers hear of; whether it did."""
    if not holds and not strip.mute:
        strip.mute, strip[FALLEN] = True, NO_LONGER_HOLDS
        return True
    if holds and strip.get(FALLEN) == NO_LONGER_HOLDS:
        _awake(strip)
        return True
    return False


def insert(scene: Any, edl: Edl, pieces: Sequence[ConformedPiece], sound: Path | None, base: Path) -> Iterator[float]:
    """Puts the conformed files of ``edl`` in place, one a step (0.15 s each); yields what part is done.

    base: what the paths are relative to.
    """
    channel = FIRST_CAMERA_CHANNEL + len(edl.cameras) + 2
    # Until all are in place those that are hold for this basis, and the others are not there.
    note_basis(scene, edl)
    yield from renew(scene, pieces, channel, base)
    if sound is not None:
        renew_sound(scene, make_plan(edl, (), sound), base)
    deselect(scene)
    yield 1.0


def renew(scene: Any, pieces: Sequence[ConformedPiece], channel: int, base: Path) -> Iterator[float]:
    """The conformed strips are those of ``pieces``; yields what part is done.

    Files that are in place and whole stay. So do strips that bear an editor's work: they show the new pictures over the
    same frames; where there are none (yet), they stay hidden and wait.
    """
    wanted = {str((base / piece.path).resolve()): piece for piece in pieces}
    places = [Place(piece.range, path, piece.range.start) for path, piece in wanted.items()]
    work, kept = Work(scene), []
    for strip, span in conformed_strips(scene):
        path = str(Path(bpy.path.abspath(strip.filepath)).resolve())
        if path in wanted and wanted[path].range == span:
            kept.append((span.start, span.stop))
            _awake(strip)
        elif work.on(strip):
            kept.append((span.start, span.stop))
            _renew(scene, strip, span, places)
        else:
            scene.sequence_editor.strips.remove(strip)
    missing: dict[str, list[FrameRange]] = {}
    for span, place in uncovered(places, kept):
        missing.setdefault(place.path, []).append(span)
    for index, (path, spans) in enumerate(missing.items()):
        cut_out(scene, add_conformed_strip(scene, wanted[path], channel, base), spans)
        yield (index + 1) / len(missing)


def _renew(scene: Any, strip: Any, span: FrameRange, places: Sequence[Place]) -> None:
    whole = strip.name in effect_inputs(scene)
    parts = (main_part if whole else parts_of)(span.start, span.stop, places)
    for piece, part in zip(split_at(strip, [part.stop for part in parts[:-1]]), parts, strict=True):
        if part.place is not None and link_film(scene, piece, Path(part.place.path), part.place.start):
            _awake(piece)
        elif not piece.mute:
            piece.mute, piece[FALLEN] = True, AWAITS_PICTURES


def _awake(strip: Any) -> None:
    """Its pictures hold: it is shown, unless the editor muted it."""
    if strip.get(FALLEN):
        strip.mute = False
        del strip[FALLEN]
