# SPDX-License-Identifier: GPL-3.0-or-later
"""Back to the automatic choice: what is to be set in which strip. No bpy."""

from __future__ import annotations

from attrs import frozen

from mcsl_core.edl import Edl
from mcsl_core.timing import FrameRange

from .read_overrides import FIELDS, SequencerState
from .strip_plan import automatic_cameras


@frozen
class Setting:
    """The part ``range`` of a strip shows channel ``source``; None leaves the part as it is.

    said: the fields that the EDL's own overrides give there. Against those the strip has to speak; of all others it
    need only be silent.
    """

    range: FrameRange
    source: int | None
    said: frozenset[str] = frozenset()


def revert(edl: Edl, state: SequencerState, piece: FrameRange) -> dict[str, tuple[Setting, ...]]:
    """The strips that decide in ``piece`` and what their parts are to show: by name, parts in order, tiling the strip.

    A camera without a strip leaves its part as it is: nothing could be shown there.
    """
    automatic = state.automatic or automatic_cameras(edl)
    channel = {camera.camera: camera.channel for camera in state.cameras}
    result = {}
    for strip in state.strips:
        if strip.muted or strip.start >= piece.stop or strip.stop <= piece.start:
            continue
        points = {strip.start, strip.stop, piece.start, piece.stop}
        points |= {point for span, _ in automatic for point in (span.start, span.stop)}
        inside = sorted(p for p in points if strip.start <= p <= strip.stop)
        settings: list[Setting] = []
        for start, stop in zip(inside, inside[1:], strict=False):
            part = FrameRange(max(start, 0), stop) if stop > 0 else None
            chosen = next((camera for span, camera in automatic if part and start in span), None)
            source = channel.get(chosen or "") if start in piece else None
            if part is None:
                continue
            said = _said(edl, part) if source is not None else frozenset()
            if settings and settings[-1].source == source:
                part, said = FrameRange(settings[-1].range.start, stop), said | settings.pop().said
            settings.append(Setting(part, source, said))
        result[strip.name] = tuple(settings)
    return result


def _said(edl: Edl, part: FrameRange) -> frozenset[str]:
    """The fields of the overrides that hold somewhere in ``part``."""
    holding = [o for o in edl.overrides if o.range.intersection(part) is not None]
    return frozenset(name for name in FIELDS for o in holding if getattr(o, name) is not None)
