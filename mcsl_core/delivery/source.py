"""What the media of a programme are made from, whichever way they are made."""

from __future__ import annotations

from pathlib import Path

from attrs import field, frozen

from mcsl_core.edl import NO_SOUND, Edl
from mcsl_core.edl.resolve import sound_camera
from mcsl_core.errors import UsageError
from mcsl_core.filling.footprint import FootprintFiller
from mcsl_core.filling.protocol import Filler
from mcsl_core.media.hardware import NONE, check_hwaccel
from mcsl_core.recording.footage import Footage, footage_of


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
        The camera whose sound the programme has, and none at all for `NO_SOUND`; without, as the EDL has it.
    hwaccel
        Which hardware decodes the cameras' files, as `media.hardware` names it.

    Raises
    ------
    UsageError
        Where there is no camera or hardware of that name.
    """

    edl: Edl
    base: Path
    filler: Filler = field(factory=FootprintFiller)
    audio_from: str | None = None
    hwaccel: str = field(default=NONE, converter=check_hwaccel)

    def __attrs_post_init__(self) -> None:
        name = self.sound_camera
        if name is not None and all(camera.name != name for camera in self.edl.cameras):
            raise UsageError(
                f"there is no camera {name!r} to take the sound from",
                remedy=f"Choose one of {', '.join(c.name for c in self.edl.cameras)}, or {NO_SOUND}",
            )

    def footage(self, threads: int = 0) -> Footage:
        """Its cameras' pictures and sound; ``threads`` as `Footage` takes them."""
        return footage_of(self.edl, self.base, threads, self.hwaccel)

    @property
    def sound_camera(self) -> str | None:
        """The camera whose sound the programme has, if any."""
        return sound_camera(self.edl, self.audio_from)
