"""Discovery of the cameras: a recording is a folder, or the camera files in order."""

from __future__ import annotations

import os
import re
import unicodedata
from collections.abc import Collection, Iterable, Sequence
from pathlib import Path

from mcsl_core.errors import InputError, MediaError
from mcsl_core.media.probing import probe

SUFFIXES = frozenset(
    {".mp4", ".mov", ".m4v", ".mkv", ".avi", ".mts", ".m2ts", ".ts", ".mpg", ".mpeg", ".mxf", ".webm", ".wmv"}
    | {".flv", ".3gp", ".vob", ".dv", ".ogv"}
    | {
        ".h264",
        ".264",
        ".avc",
        ".h265",
        ".265",
        ".hevc",
        ".m2v",
        ".m1v",
        ".mjpeg",
        ".obu",
    }  # refused by name, not passed over
)
_PART = re.compile(r"(.+)[_-]\d{3}", re.DOTALL)  # four digits and more are names: GOPR_0001, a date
# GoPro: GH010123 is chapter 1 of recording 0123; older ones wrote GOPR0123, then GP010123, GP020123.
_GOPRO = re.compile(
    r"G[HXLS](?P<chapter>\d{2})(?P<recording>\d{4})|GP(?P<later>\d{2})(?P<old>\d{4})|GOPR(?P<first>\d{4})", re.I
)
_NUMBERED = re.compile(r"(.+?)(?:[ _-]+\(?\d+\)?|\(\d+\))", re.DOTALL)  # cam1-2, cam1 (2), cam1(2); not cam12


def discover(
    paths: Sequence[str | Path], leave_out: Collection[Path] = frozenset()
) -> list[tuple[str, tuple[Path, ...]]]:
    """The cameras of a recording and their files.

    Parameters
    ----------
    paths
        Folders or video files. A folder has one camera for each video file in it, in natural order, named by the
        file's stem; files such as cam1_000.mp4, cam1_001.mp4 (one stem, then _ or - and three digits) are parts of one
        camera, and so are the chapters of one GoPro recording (GH010123.MP4, GH020123.MP4).
        A folder in it that holds video files is one camera, but a simulation's ideal programme is none. Files handed
        in singly are cameras in that order.
    leave_out
        Real paths of files in folders that are no cameras.

    Returns
    -------
    list
        (camera name, its files in order of time).

    Raises
    ------
    InputError
        Where nothing is found, two cameras have one name, or a file is no video.
    """
    if not paths:
        raise InputError("no recording was named", remedy="Name a folder, or the camera files in order")
    cameras: list[tuple[str, tuple[Path, ...]]] = []
    loose: list[Path] = []
    for path in map(Path, paths):
        if path.is_dir():
            cameras += _grouped(loose)
            loose = []
            cameras += _in_folder(path, leave_out, alone=len(paths) == 1)
        elif path.exists():
            loose.append(path)
        else:
            raise InputError("does not exist", where=str(path), remedy="Check the path")
    cameras += _grouped(loose)
    names = [name for name, _ in cameras]
    folded = [_folded(name) for name in names]
    twice = sorted({n for n, f in zip(names, folded, strict=True) if folded.count(f) > 1})
    if twice:
        raise InputError(
            f"two cameras are named {twice[0]!r}",
            where=", ".join(str(files[0]) for name, files in cameras if _folded(name) == _folded(twice[0])),
            remedy="Rename one of the files",
        )
    for _, files in cameras:
        for file in files:
            _check(file)
    return cameras


def _folded(name: str) -> str:
    """cam1 and CAM1, and ä in one character or two, are one name for people, and one file's on many machines."""
    return unicodedata.normalize("NFC", unicodedata.normalize("NFC", name).casefold())


def _check(file: Path) -> None:
    try:
        probe(file)
    except MediaError as error:
        raise InputError(error.what, where=error.where, remedy=error.remedy) from error


def _in_folder(folder: Path, leave_out: Collection[Path], *, alone: bool) -> list[tuple[str, tuple[Path, ...]]]:
    entries = sorted((p for p in folder.iterdir() if _real(p) not in leave_out), key=_in_order)
    files = [p for p in entries if _is_video(p)]
    if not alone and files:  # one of several folders on the command line is one camera, as a folder in a folder is
        return [(folder.name, tuple(files))]
    cameras = _grouped(files)
    for sub in entries:
        if sub.is_dir() and not sub.name.startswith(".") and not _is_ideal(sub):
            inside = (p for p in sub.iterdir() if _is_video(p) and _real(p) not in leave_out)
            inside = sorted(inside, key=_in_order)
            if inside:
                cameras.append((sub.name, tuple(inside)))
    if not cameras:
        raise InputError(
            "holds no video files",
            where=str(folder),
            remedy=f"Name the folder the camera files lie in ({', '.join(sorted(SUFFIXES)[:6])}, ...)",
        )
    return cameras


def _grouped(files: Iterable[Path]) -> list[tuple[str, tuple[Path, ...]]]:
    """Files by camera, cameras in the order of their first file, parts in natural order."""
    groups: dict[tuple[Path, str], list[Path]] = {}
    for file in files:
        part, chapter = _PART.fullmatch(file.stem), _chapter(file.stem)
        camera = chapter[0] if chapter else part[1] if part else file.name
        groups.setdefault((file.parent, camera), []).append(file)
    cameras = []
    for (_, name), members in groups.items():
        # One numbered file by itself is not a part of anything and keeps its name.
        label = name if len(members) > 1 else members[0].stem
        cameras.append((label, tuple(sorted(members, key=_in_order))))
    return cameras


def _chapter(stem: str) -> tuple[str, int] | None:
    """(recording, chapter) of a GoPro file's name; None of another."""
    match = _GOPRO.fullmatch(stem)
    if match is None:
        return None
    if match["recording"]:
        return f"{stem[:2].upper()}{match['recording']}", int(match["chapter"])
    return f"GOPR{match['old'] or match['first']}", int(match["later"] or 0)


def _in_order(path: Path) -> tuple[list[tuple[int, int, str]], int, str]:
    """A sort key: cam2 before cam10, cam1 before cam1-2, a recording's chapters before the next recording."""
    recording, chapter = _chapter(path.stem) or (path.stem, 0)
    return _natural(recording), chapter, path.suffix


def look_like_parts(names: Sequence[str]) -> list[tuple[str, str]]:
    """(camera, further camera) where one's name is another's and a number, as cam1 and cam1-2: parts, or not."""
    found = []
    for name in names:
        match = _NUMBERED.fullmatch(name)
        if match and match[1] in names and match[1] != name:
            found.append((match[1], name))
    return found


def _natural(text: str) -> list[tuple[int, int, str]]:
    """A sort key that puts cam2 before cam10."""
    return [(0, int(t), "") if t.isdigit() else (1, 0, t.casefold()) for t in re.split(r"(\d+)", text) if t]


def _real(path: Path) -> Path:
    return Path(os.path.realpath(path))  # takes a link to itself, too


def _is_ideal(folder: Path) -> bool:
    """Whether a folder holds the ideal programme that `simulate` films beside the cameras (simulation/ideal.py)."""
    return all((folder / name).is_file() for name in ("ideal.mp4", "field.png"))


def _is_video(path: Path) -> bool:
    return path.is_file() and path.suffix.lower() in SUFFIXES and not path.name.startswith(".")
