# SPDX-License-Identifier: GPL-3.0-or-later
"""The conformed pictures in the sequencer: put in place, muted where they no longer hold, back when they do again.

`outstanding` decides; this does. A strip that holds in part is split there. Muted, not removed: when the editor takes
the decision back, the exact picture returns at once. What an editor mutes stays muted.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import bpy  # pyright: ignore[reportMissingImports]
from attrs import frozen

from mcsl_core.edl import Edl
from mcsl_core.timing import FrameRange

from ..core import stale as outstanding
from ..core import strip_plan as plans
from ..core.strip_plan import ConformedPiece
from .build import add_conformed_strip, replace_sound
from .compat import ends
from .edit import split_at
from .scene_properties import ROLE

BASIS = "mcsl_conformed_for"  # of the scene: what its conformed pictures were made from
FALLEN = "mcsl_fallen"  # of a conformed strip: muted because its pictures no longer hold


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
    scene[BASIS] = outstanding.to_text(outstanding.basis_of(edl))


def found(scene: Any) -> list[tuple[Any, FrameRange]]:
    """Every conformed strip and the programme frames it shows, in order."""
    pairs = []
    for strip in scene.sequence_editor.strips:
        if strip.get(ROLE) == "conformed":
            start, stop = ends(strip)
            pairs.append((strip, FrameRange(start, stop)))
    return sorted(pairs, key=lambda pair: pair[1])


def any_there(scene: Any) -> bool:
    return any(strip.get(ROLE) == "conformed" for strip in scene.sequence_editor.strips)


def keep_true(scene: Any, now: Edl) -> Held:
    """Mutes what no longer shows what ``now`` decides, unmutes what does again."""
    there = found(scene)
    then = outstanding.from_text(scene.get(BASIS, ""))
    gone = outstanding.changed(outstanding.basis_of(now), then) if there else ()
    lost, changed = [], False
    for strip, span in there:
        parts = outstanding.parts(span, gone)
        pieces = split_at(strip, [part.range.stop for part in parts[:-1]])
        for piece, part in zip(pieces, parts, strict=True):
            changed |= _set_holds(piece, part.holds)
            if not part.holds:
                lost.append(part.range)
    covered = [span for strip, span in found(scene) if not strip.mute]
    return Held(outstanding.outstanding(now.frames, covered), outstanding.without(lost, ()), changed)


def _set_holds(strip: Any, holds: bool) -> bool:
    """Touches the strip only where something changes, which handlers hear of; whether it did."""
    if not holds and not strip.mute:
        strip.mute, strip[FALLEN] = True, 1
        return True
    if holds and strip.get(FALLEN):
        strip.mute = False
        del strip[FALLEN]
        return True
    return False


def place(scene: Any, edl: Edl, pieces: Sequence[ConformedPiece], sound: str | None, base: Path) -> Iterator[float]:
    """Puts the conformed files of ``edl`` in place, one a step (0.15 s each); yields what part is done.

    Files that are in place and whole stay. base: what the paths are relative to.
    """
    channel = plans.FIRST_CAMERA_CHANNEL + len(edl.cameras) + 2
    wanted = {str((base / piece.path).resolve()): piece for piece in pieces}
    whole = {}
    for strip, span in found(scene):
        path = str(Path(bpy.path.abspath(strip.filepath)).resolve())
        if path in wanted and wanted[path].range == span:
            whole[path] = strip
            strip.mute = False
            strip.pop(FALLEN, None)
        else:
            scene.sequence_editor.strips.remove(strip)
    missing = [piece for path, piece in wanted.items() if path not in whole]
    # Until all are in place those that are hold for this basis, and the others are not there.
    note_basis(scene, edl)
    for index, piece in enumerate(missing):
        add_conformed_strip(scene, piece, channel, base)
        yield (index + 1) / len(missing)
    if sound is not None:
        replace_sound(scene, plans.make_plan(edl, (), sound), base)
    yield 1.0
