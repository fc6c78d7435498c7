"""Files that somebody hands in: regular ones alone, read within a bound; what is in the way is told with its remedy.

A pipe or a device would hang whoever opens it, a file of many gigabytes would fill the memory: both are refused before.
"""

from __future__ import annotations

import os
import stat
from pathlib import Path

from mcsl_core.errors import DocumentError, InputError

MOST_BYTES = 64 << 20  # of a document; the EDL of twelve hours with a decision each second takes some 10 MB

_LONGEST_NAME, _LONGEST_PATH = 255, 4000  # bytes
_SIGNATURES = (  # what people hand in by mistake: the place of some bytes, the bytes, what it is
    (4, b"ftyp", "a video"),
    (4, b"moov", "a video"),
    (4, b"mdat", "a video"),
    (0, b"\x1aE\xdf\xa3", "a video"),
    (8, b"AVI ", "a video"),
    (0, b"G@", "a video"),
    (0, b"\x00\x00\x01\xba", "a video"),
    (8, b"WAVE", "a sound file"),
    (0, b"ID3", "a sound file"),
    (0, b"fLaC", "a sound file"),
    (0, b"BLENDER", "a Blender file"),
    (0, b"\x28\xb5\x2f\xfd", "a compressed file, perhaps Blender's"),
    (0, b"\x89PNG", "a picture"),
    (0, b"\xff\xd8\xff", "a picture"),
    (0, b"PK\x03\x04", "a zip file, such as a spreadsheet or a table of scores"),
    (0, b"\x1f\x8b", "a compressed file"),
    (0, b"%PDF", "a PDF"),
    (0, b"\x7fELF", "a program"),
)
_MARKS = ((b"\xef\xbb\xbf", "utf-8-sig"), (b"\xff\xfe", "utf-16"), (b"\xfe\xff", "utf-16"))
_KINDS = (
    (stat.S_ISFIFO, "a pipe"),
    (stat.S_ISSOCK, "a socket"),
    (stat.S_ISCHR, "a device"),
    (stat.S_ISBLK, "a device"),
)


def check_file(path: Path, *, wanted: str = "a file", remedy: str = "") -> None:
    """InputError unless ``path`` is a regular file; nothing is opened, so that a pipe cannot hang it.

    Parameters
    ----------
    path : Path
        As the user or a document names it.
    wanted : str
        What was hoped for, with its article: "an EDL".
    remedy : str
        What to hand in where something else lies there.
    """
    try:
        mode = path.stat().st_mode
    except (OSError, ValueError) as error:
        raise unreadable(path, error) from error
    if stat.S_ISDIR(mode):
        raise InputError(f"is a folder, not {wanted}", where=str(path), remedy=remedy or "Name the file itself")
    if not stat.S_ISREG(mode):
        raise InputError(
            f"is {_kind_of(mode)}, not {wanted}", where=str(path), remedy="Save it as a file, and name that"
        )


def read_bytes(path: Path, *, wanted: str = "a file", remedy: str = "", most: int = MOST_BYTES) -> bytes:
    """The content of a regular file of at most ``most`` bytes; InputError else. As `check_file` otherwise."""
    check_file(path, wanted=wanted, remedy=remedy)
    try:
        with open(path, "rb", opener=_without_waiting) as stream:
            if os.fstat(stream.fileno()).st_size <= most and len(data := stream.read(most + 1)) <= most:
                return data
    except (OSError, ValueError) as error:
        raise unreadable(path, error) from error
    raise InputError(
        f"is larger than {most >> 20} MB: not {wanted}", where=str(path), remedy=remedy or "Check the path"
    )


def read_text(path: Path, *, wanted: str = "a text", remedy: str = "", most: int = MOST_BYTES) -> str:
    """The text of a file in UTF-8, or in what its byte order mark says; DocumentError names the first wrong line."""
    data = read_bytes(path, wanted=wanted, remedy=remedy, most=most)
    encoding = next((name for mark, name in _MARKS if data.startswith(mark)), "utf-8")
    try:
        text = data.decode(encoding)
    except UnicodeDecodeError as error:
        if found := _signature(data):
            raise DocumentError(f"is {found}, not {wanted}", where=str(path), remedy=remedy) from error
        line = data.count(b"\n", 0, error.start) + 1
        raise DocumentError(
            f"is not {encoding.upper().removesuffix('-SIG')} text",
            where=f"{path}, line {line}",
            remedy=f"Save it as UTF-8{f', or check that it is {wanted}' if wanted else ''}",
        ) from error
    if "\0" in text:
        what = f"is {_signature(data) or 'no text'}, not {wanted}"
        raise DocumentError(what, where=str(path), remedy=remedy or "Save it as UTF-8 text")
    return text


def check_target(target: Path, named: Path) -> None:
    """InputError where something lies at ``target`` that is no regular file; ``named``: as the user names it."""
    try:
        mode = target.stat().st_mode
    except (OSError, ValueError):
        return  # there is nothing: writing tells whether there can be
    if not stat.S_ISREG(mode):
        kind = "a folder" if stat.S_ISDIR(mode) else _kind_of(mode)
        what = f"cannot be written: it is {kind}, no file"
        raise InputError(what, where=str(named), remedy="Choose another name")


def unreadable(path: Path | str, error: OSError | ValueError) -> InputError:
    """What to say where a file cannot be opened: an OSError, or the ValueError of a name that no file can have."""
    where = str(path).replace("\0", "\\0")
    where = where if len(where) <= 300 else f"{where[:120]}...{where[-60:]}"
    if isinstance(error, FileNotFoundError | NotADirectoryError):
        return InputError("does not exist", where=where, remedy="Check the path")
    if isinstance(error, OSError):
        return InputError(
            f"cannot be read ({error.strerror or error})", where=where, remedy="Check the path and its permissions"
        )
    return InputError("is no name that a file can have", where=where, remedy="Check the path")


def name_fault(path: str) -> str:
    """Why no file can have that path; "" where one can."""
    try:
        parts = os.fsencode(path).split(os.fsencode(os.sep))
    except UnicodeEncodeError:
        return "holds characters that no file name has"
    if "\0" in path:
        return "holds a null character"
    if max(map(len, parts)) > _LONGEST_NAME or sum(map(len, parts)) > _LONGEST_PATH:
        return f"is too long: names have at most {_LONGEST_NAME} bytes, paths {_LONGEST_PATH}"
    return ""


def _kind_of(mode: int) -> str:
    return next((name for test, name in _KINDS if test(mode)), "something else")


def _without_waiting(path: str, flags: int) -> int:
    return os.open(path, flags | getattr(os, "O_NONBLOCK", 0))  # should a pipe have taken the file's place


def _signature(data: bytes) -> str:
    return next((name for at, mark, name in _SIGNATURES if data[at : at + len(mark)] == mark), "")
