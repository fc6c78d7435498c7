"""EBML, which Matroska is written in: its numbers, and the elements in a piece of it.

References
----------
RFC 8794, sections 4 to 6.
"""

from __future__ import annotations

from collections.abc import Iterator


def read_number(data: bytes, *, marked: bool) -> tuple[int, int]:
    """How many bytes the number at the beginning of ``data`` takes, and the number; 0 bytes where there is none.

    The first byte says by its leading zeros how many: ``marked`` keeps that bit, as the names of elements do.
    """
    length = 9 - data[0].bit_length() if data else 0
    if not 0 < length <= min(8, len(data)):
        return 0, 0
    value = int.from_bytes(data[:length], "big")
    return length, value if marked else value & ((1 << 7 * length) - 1)


def elements(data: bytes) -> Iterator[tuple[int, bytes]]:
    """The elements of which ``data`` consists, each its name and its content, up to where something else begins."""
    at = 0
    while at < len(data):
        name_length, name = read_number(data[at : at + 8], marked=True)
        size_length, size = read_number(data[at + name_length : at + name_length + 8], marked=False)
        if not name_length or not size_length:
            return
        begin = at + name_length + size_length
        yield name, data[begin : begin + size]
        at = begin + size
