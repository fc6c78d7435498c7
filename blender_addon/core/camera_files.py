# SPDX-License-Identifier: GPL-3.0-or-later
"""The camera files an editor picked -> cameras, named as `mcsl analyse` names them; and that command. No bpy."""

from __future__ import annotations

import re
import zlib
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

from attrs import frozen

# option of `mcsl analyse` -> label; a test holds it against mcsl's own stages
STAGES = {
    "movement": "Movement",
    "matcher": "Matching",
    "aligner": "Alignment",
    "relief": "Relief",
    "tracker": "Tracking",
    "occlusion": "Occlusion",
    "selector": "Selection",
    "centerer": "Centering",
    "filler": "Fill",
}

_PART = re.compile(r"(.+)[_-]\d{3}", re.DOTALL)


@frozen
class PickedCamera:
    """A camera and its files, played one after another."""

    name: str
    files: tuple[str, ...]


def cameras_of(paths: Iterable[str]) -> tuple[PickedCamera, ...]:
    """Files by camera in the order picked: cam1_000.mp4 and cam1_001.mp4 of one folder are parts of cam1."""
    groups: dict[tuple[str, str], list[str]] = {}
    for path in paths:
        file = Path(path)
        match = _PART.fullmatch(file.stem)
        groups.setdefault((str(file.parent), match[1] if match else file.name), []).append(path)
    return tuple(
        PickedCamera(name if len(files) > 1 else Path(files[0]).stem, tuple(sorted(files, key=_natural)))
        for (_, name), files in groups.items()
    )


def plugin_number(name: str) -> int:
    """A number for a plugin, of any name, that does not change when others come and go: below 2**31."""
    return zlib.crc32(name.encode("utf-8", "surrogatepass")) & 0x7FFFFFFF


def as_text(name: str) -> str:
    """A name as Blender can show it: what is no valid text in it stands as its escape."""
    return name.encode("utf-8", "backslashreplace").decode()


def _natural(text: str) -> list[tuple[int, int, str]]:
    """A sort key that puts part 2 before part 10."""
    return [(0, int(t), "") if t.isdigit() else (1, 0, t.casefold()) for t in re.split(r"(\d+)", text) if t]


def analyse_command(
    mcsl: str, files: Sequence[str], edl: str, *, reference: str = "", stages: Mapping[str, str] | None = None
) -> list[str]:
    """The words of `mcsl analyse` for a job.

    Parameters
    ----------
    mcsl
        The program.
    files, edl
        The cameras' files, and the EDL to write.
    reference
        The reference camera's name; '' leaves it to mcsl.
    stages
        Option -> plugin's name; '' leaves the default.
    """
    command = [mcsl, "--progress", "json", "analyse", "-o", edl]
    if reference:
        command += ["--reference", reference]
    for stage, name in (stages or {}).items():
        if name:
            command += [f"--{stage}", name]
    return [*command, "--", *files]


def conform_command(mcsl: str, edl: str) -> list[str]:
    """`mcsl conform` for a job."""
    return [mcsl, "--progress", "json", "conform", edl]


def export_command(mcsl: str, edl: str, out: str, *, exact: bool) -> list[str]:
    """`mcsl export` for a job; ``out`` is a document for another editor."""
    return [mcsl, "--progress", "json", "export", edl, "-o", out, "--exact" if exact else "--angles"]


def plugins_command(mcsl: str) -> list[str]:
    """`mcsl plugins --json` for a job."""
    return [mcsl, "plugins", "--json"]
