"""What the media of a programme are made from, whichever way they are made."""

from __future__ import annotations

from pathlib import Path

from attrs import field, frozen

from mcsl_core.edl import Edl
from mcsl_core.errors import UsageError
from mcsl_core.filling.footprint import FootprintFiller
from mcsl_core.filling.protocol import Filler


@frozen(eq=False)
class ProgrammeSource:
    """An EDL with all that its pictures and sound are made from.

    Parameters
    ----------
    edl
        What is shown when.
    base
        The folder that the EDL's media paths are relative to: its own.
    filler
        Who fills what the chosen camera does not reach.
    audio_from
        The camera whose sound the programme has; the reference's without.
    """

    edl: Edl
    base: Path
    filler: Filler = field(factory=FootprintFiller)
    audio_from: str | None = None

    @property
    def sound_camera(self) -> str:
        """The camera whose sound the programme has; UsageError where there is none of that name."""
        name = self.audio_from or self.edl.reference
        if all(camera.name != name for camera in self.edl.cameras):
            raise UsageError(
                f"there is no camera {name!r} to take the sound from",
                remedy=f"Choose one of {', '.join(c.name for c in self.edl.cameras)}",
            )
        return name
