"""What is to be done for one operation: a document in its folder of results, changed only when the work is.

Engines compare times of files: whatever was made before this document last changed is made again.
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from fractions import Fraction
from hashlib import sha256
from math import ceil
from pathlib import Path

from attrs import frozen

from mcsl_core.delivery.presets import preset_of
from mcsl_core.delivery.quality import quality_named
from mcsl_core.documents import canonical_json, make_converter, read_json, structure_document, write_atomic
from mcsl_core.errors import McslError, writing
from mcsl_core.media.probing import probe
from mcsl_core.outputs.deliveries import own_videos
from mcsl_core.recording.discovery import SUFFIXES, discover

from .operations import ANALYSIS, Operation

SCHEMA = "mcsl.archive-job/1"
PART_S = 1200  # seconds of programme a job conforms: an hour of work or two, which is what queues like
_converter = make_converter()


@frozen
class Facts:
    """What the headers of a recording's files tell; of none, where ``fault`` says why it cannot be taken.

    Attributes
    ----------
    cameras, files : int
        How many.
    seconds, rate : float
        Length of the longest camera, and pictures a second of the first.
    size : (int, int)
        Width and height of the first camera's pictures.
    bytes : int
        Of all files together.
    fault : str
        Why it is no recording that can be analysed; empty where it is one.
    """

    cameras: int = 0
    files: int = 0
    seconds: float = 0.0
    rate: float = 0.0
    size: tuple[int, int] = (0, 0)
    bytes: int = 0
    fault: str = ""


@frozen
class Job:
    """The work on one operation.

    Attributes
    ----------
    schema : str
        `SCHEMA`.
    operation, recording : str
        Its folder relative to the archive, and where that is.
    state : str
        Of its files: changes when one of them does.
    facts : Facts
        What their headers tell.
    analyse, conform, render : tuple of str
        Options of the commands.
    parts : int
        How many jobs conform it.
    video : str
        What the finished video is called.
    """

    schema: str
    operation: str
    recording: str
    state: str
    facts: Facts
    analyse: tuple[str, ...]
    conform: tuple[str, ...]
    render: tuple[str, ...]
    parts: int
    video: str

    @property
    def frames(self) -> int:
        return round(self.facts.seconds * self.facts.rate)


def load_job(path: Path) -> Job:
    """Reads a job; InputError or DocumentError where there is none."""
    return structure_document(read_json(path), Job, _converter, where=str(path), name="archives")


def planned(operation: Operation, archive: Path, folder: Path, *, write: bool = True, anonymous: bool = False) -> Job:
    """The job of an operation, written to ``folder``/job.json where it is not what stands there.

    Files that are as they were are not opened again, but for those that could not be read. What is wrong with them, or
    with the options, is in the facts.

    Parameters
    ----------
    operation : Operation
        What is worked on.
    archive, folder : Path
        Where its recording's folder lies, and its results.
    write : bool
        Else nothing is written: a look at what would be done.
    anonymous : bool
        Nobody but the owner may look into ``folder``, whose job names the recording.
    """
    recording, path = archive / operation.folder, folder / "job.json"
    before = _read(path)
    state = _state(recording)
    known = before is not None and before.state == state and not before.facts.fault
    facts = before.facts if before is not None and known else facts_of(recording)
    options = dict(operation.options)
    fault, video = _fault(options)
    if Path(options.get("preset", "")).suffix:  # a file: jobs run in another folder
        options["preset"] = str(Path(options["preset"]).resolve())
    if write:
        fault = _made(folder, recording, anonymous) or fault
    shared = ("--audio", options["audio"]) if options.get("audio") else ()
    quality = ("--quality", options.get("quality", "standard"))
    job = Job(
        SCHEMA,
        operation.folder,
        recording.resolve().as_posix(),
        state,
        facts if not fault else Facts(fault=fault),
        tuple(word for name in ANALYSIS if options.get(name) for word in (f"--{name}", options[name])),
        (*quality, *shared),
        ("--preset", options.get("preset", "h264"), *quality, *shared),
        int(options.get("parts") or max(1, ceil(facts.seconds / PART_S))),
        video,
    )
    if write and job != before:
        text = canonical_json(_converter.unstructure(job))
        write_atomic(path, text.encode("utf-8", "backslashreplace"), private=anonymous)
    return job


def facts_of(recording: Path) -> Facts:
    """What the headers of a recording's files tell, or why it is none."""
    dead = next((path for path in _files(recording) if path.is_symlink() and not path.exists()), None)
    if dead is not None:
        return Facts(fault=f"{dead.name}: is a link to a file that is not there. Bring the file back, or leave it out")
    try:
        cameras = discover([recording], own_videos([recording]))
        probed = [[probe(path) for path in files] for _, files in cameras]
    except (McslError, OSError) as error:
        return Facts(fault=told(error, recording))
    if len(cameras) < 2:
        return Facts(fault="only one camera was found. Put the files of all cameras into the folder")
    paths = [path for _, files in cameras for path in files]
    first = probed[0][0]
    seconds = max(sum((fact.usable_s for fact in camera), Fraction(0)) for camera in probed)
    size_in_bytes = sum(path.stat().st_size for path in paths)
    return Facts(len(cameras), len(paths), float(seconds), float(first.rate), first.size, size_in_bytes)


def told(error: Exception, recording: Path) -> str:
    """An error in words that name files as the recording has them, not where it lies."""
    text = str(error)
    for base in (str(recording.resolve()), str(recording)):
        text = text.replace(f"{base}{os.sep}", "").replace(base, "the recording")
    return text


def _fault(options: Mapping[str, str]) -> tuple[str, str]:
    """What is wrong with the options that can be seen at once, and the video's name."""
    try:
        quality_named(options.get("quality", "standard"))
        return "", f"programme.{preset_of(options.get('preset', 'h264')).container}"
    except McslError as error:
        return str(error), "programme.mp4"


def _read(path: Path) -> Job | None:
    try:
        return load_job(path)
    except McslError:  # none yet, or of another version
        return None


def _state(recording: Path) -> str:
    """Names, sizes and times of what may be a camera's file: no file is opened."""
    found = []
    for path in _files(recording):
        try:
            stat = path.stat()
            how = f"{stat.st_size} {stat.st_mtime_ns}"
        except OSError:  # why, `facts_of` tells
            how = "missing"
        found.append(f"{path.relative_to(recording).as_posix()} {how}")
    return sha256("\n".join(found).encode("utf-8", "surrogateescape")).hexdigest()[:20]


def _files(recording: Path) -> list[Path]:
    """What may be a camera's file by its name."""
    found = sorted((*recording.glob("*"), *recording.glob("*/*")))
    return [path for path in found if path.suffix.lower() in SUFFIXES and not path.name.startswith(".")]


def _made(folder: Path, recording: Path, anonymous: bool) -> str:
    """Makes the folder of results, with a link to the recording in it; what is in the way, or nothing.

    By the link commands, and the engine's messages about them, name an operation as its folder of results does.
    """
    with writing(folder):
        folder.mkdir(parents=True, exist_ok=True, mode=0o700 if anonymous else 0o777)
    link, target = folder / "recording", recording.resolve()
    if link.is_symlink() and Path(os.path.realpath(link)) == target:
        return ""
    if link.exists() and not link.is_symlink():
        return f"{link.name}: is no link to the recording. Move it out of the folder of results"
    try:
        link.unlink(missing_ok=True)
        link.symlink_to(target, target_is_directory=True)
    except OSError as error:
        return f"{link.name}: a link to the recording cannot be made ({error.strerror}). Choose another file system"
    return ""
