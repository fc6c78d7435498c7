"""The look of the whole programme: its visual aids, each on or off."""

from __future__ import annotations

from attrs import field, frozen

from mcsl_core.documents import doc


@frozen
class Look:
    """The visual aids, each on or off for the whole programme."""

    centering: bool = field(default=True, metadata=doc("shift the surgical field to the middle"))
    fill: bool = field(default=True, metadata=doc("fill pixels the warp leaves empty from other cameras"))
    colour: bool = field(default=True, metadata=doc("match each camera's colours to the reference camera"))
    surface: bool = field(default=True, metadata=doc("align by the pose's relief, where it has one"))
    see_through: bool = field(
        default=False,
        metadata=doc(
            "show what another camera sees under heads and arms, where pictures lie by a relief", optional=True
        ),
    )
