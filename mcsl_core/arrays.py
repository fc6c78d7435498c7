"""Arrays kept in .npz files, read without trust: no pickles, and nothing larger than was said beforehand."""

from __future__ import annotations

import math
import zipfile
from pathlib import Path

import numpy as np
from numpy.lib import format as npy
from numpy.typing import NDArray

from mcsl_core.errors import DocumentError
from mcsl_core.input_files import check_file

MOST_BYTES = 1 << 28  # unpacked; the scores of nine cameras over two days take some 15 MB


def read_arrays(path: Path, *, wanted: str, remedy: str, most: int = MOST_BYTES) -> dict[str, NDArray]:
    """The arrays of an .npz file by name.

    Parameters
    ----------
    path : Path
        The file.
    wanted : str
        What it should be, for messages.
    remedy : str
        How to get one.
    most : int
        Bytes that all of them may take together.

    Raises
    ------
    InputError
        Where there is no such file.
    DocumentError
        Where it is damaged, something else, holds objects, or is larger.
    """
    check_file(path, wanted=wanted, remedy=remedy)
    try:
        with zipfile.ZipFile(path) as packed:
            said = sum(entry.file_size for entry in packed.infolist())
            if said > most:
                raise ValueError(f"{said >> 20} MB unpacked, at most {most >> 20} MB are read")
            for entry in packed.infolist():
                _check_entry(packed, entry)
        with np.load(path, allow_pickle=False) as stored:
            return dict(stored)
    except Exception as error:  # zipfile, zlib and numpy have a dozen kinds of their own for a damaged file
        why = str(error) or type(error).__name__
        raise DocumentError(f"is not {wanted} ({why})", where=str(path), remedy=remedy) from error


def _check_entry(packed: zipfile.ZipFile, entry: zipfile.ZipInfo) -> None:
    """ValueError where an array says it is larger than what lies there: numpy makes room for it before it reads."""
    with packed.open(entry) as stream:
        version = npy.read_magic(stream)
        read = npy.read_array_header_1_0 if version == (1, 0) else npy.read_array_header_2_0
        shape, _, kind = read(stream)
    if kind.hasobject:
        raise ValueError(f"{entry.filename} holds objects, which could run a program")
    if min(shape, default=0) < 0 or math.prod(shape) * kind.itemsize > entry.file_size:
        raise ValueError(f"{entry.filename} is cut short")
