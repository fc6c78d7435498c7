"""What can go wrong, told in one sentence each: what happened, where, and what to do next."""

from __future__ import annotations


class McslError(Exception):
    """A failure that a person can act on.

    what: what happened. where: the file, camera, frame or document path it happened at. remedy: what to
    do next. ``exit_code`` is what the command line ends with.
    """

    exit_code = 4

    def __init__(self, what: str, *, where: str = "", remedy: str = "") -> None:
        self.what, self.where, self.remedy = what, where, remedy
        super().__init__(what, where, remedy)

    def __str__(self) -> str:
        text = f"{self.where}: {self.what}" if self.where else self.what
        return f"{text}. {self.remedy}" if self.remedy else text


class UsageError(McslError):
    """The call itself is wrong: an unknown name, options that contradict each other."""

    exit_code = 2


class InputError(McslError):
    """A file or document handed in is refused."""

    exit_code = 3


class DocumentError(InputError):
    """A JSON document (EDL, preset, truth) is malformed; ``where`` holds the path to the wrong value."""


class MediaError(InputError):
    """A media file cannot be opened, decoded, or ends before it should."""


class AlignmentError(McslError):
    """Views cannot be tied together."""

    exit_code = 4


class PluginError(McslError):
    """A plugin raised or returned something it may not; the message names it with package and version."""

    exit_code = 4


class BlenderError(McslError):
    """Blender is missing, cannot start, or its script failed."""

    exit_code = 4


class Cancelled(McslError):
    """Somebody asked to stop. Nothing half-written is left behind."""

    exit_code = 130

    def __init__(self) -> None:
        super().__init__("stopped", remedy="The same command carries on where it stopped")
