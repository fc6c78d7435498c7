# SPDX-License-Identifier: GPL-3.0-or-later
"""Decisions that others wrote into the EDL and that an older timeline takes back, told by frame. No bpy.

A timeline says which camera is shown in every frame, so that what another timeline or a program decided since it was
last brought in line looks like a decision of its editor against it. His choice is taken, but not without a word.
"""

from __future__ import annotations

from collections.abc import Iterator

from mcsl_core.edl import Edl
from mcsl_core.edl.resolve import resolve
from mcsl_core.timing import FrameRange

_SHOWN = 3  # stretches that are named


def overruled(edl: Edl, new: Edl, known: object) -> tuple[str, ...]:
    """What there is to say of overrides of a camera that ``new`` no longer follows.

    Parameters
    ----------
    edl
        The EDL as it lies there.
    new
        The same with what the timeline shows.
    known
        How many overrides the EDL had when the timeline was last brought in line; what is no count says nothing.
    """
    if not isinstance(known, int) or new.overrides == edl.overrides:
        return ()
    since = [o for o in edl.overrides[max(known, 0) :] if o.camera is not None]
    if not since:
        return ()
    lost = sorted({found for override in since for found in _lost(edl, new, override.range, override.camera)})
    notes = [
        f"programme frames {piece.start + 1} to {piece.stop}: {theirs}, decided elsewhere since this timeline was last "
        f"pulled or built, gives way to {ours}, which it shows"
        for piece, theirs, ours in lost[:_SHOWN]
    ]
    if len(lost) > _SHOWN:
        notes.append(f"and {len(lost) - _SHOWN} more stretches that were decided elsewhere")
    return tuple(notes)


def _lost(edl: Edl, new: Edl, where: FrameRange, camera: str | None) -> Iterator[tuple[FrameRange, str, str]]:
    """Where ``edl`` shows ``camera`` and ``new`` another: the frames, the camera, the other."""
    held = [p for s, decision in resolve(edl) if decision.camera == camera and (p := s.intersection(where))]
    for stretch, decision in resolve(new):
        for piece in held if decision.camera != camera else ():
            if part := piece.intersection(stretch):
                yield part, str(camera), decision.camera
