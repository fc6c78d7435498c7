"""Valid documents made slightly wrong: by their structure where they are JSON, by lines, cells and bytes else."""

from __future__ import annotations

import json
from random import Random
from typing import Any

ODD_VALUES: tuple[Any, ...] = (
    None, True, -1, 0, 1, 2.5, 10**6, 10**9, 10**20, -(10**400), 1e300, -1e-300, "", "cam9", "\0", "\ud800", "\udcff",
    "x" * 300, "[/]", "../../etc/passwd", "http://a/b", [], {}, [[]], [1, 2], [0, 10**9], {"a": 1}, "1/999999999",
)  # fmt: skip
ODD_TEXTS = (
    b"1e999", b"NaN", b"-inf", b"nan", b'"', b"\0", b"\xff\xfe", b"\xef\xbb\xbf", b",,,,", b";", b"\t", b"\r", b"[/]",
    b"-1", b"1_000", "٣".encode(), b"9" * 400, b"9" * 5000, b"[" * 3000, b"{", b"}", b"0x10", b"1,5", b"time_ms", b"'",
    b"\\ud800", b"\xed\xa0\x80", b"x" * 140_000, b"inf", b"1979-05-27", b"sep=;\n",
)  # fmt: skip


def mutated(data: bytes, random: Random) -> bytes:
    """``data`` with one to four changes."""
    for _ in range(random.choice((1, 1, 1, 2, 4))):
        way = random.choice((_structure, _structure, _token, _token, _lines, _bytes, _cut))
        data = way(data, random)
    return data


def _structure(data: bytes, random: Random) -> bytes:
    try:
        value = json.loads(data)
    except (ValueError, RecursionError):
        return _cells(data, random)
    places: list[tuple[Any, Any]] = []
    waiting = [value]
    while waiting:
        part = waiting.pop()
        keys = list(part) if isinstance(part, dict) else range(len(part)) if isinstance(part, list) else ()
        places += [(part, key) for key in keys]
        waiting += [part[key] for key in keys]
    if not places:
        return data
    part, key = random.choice(places)
    match random.randrange(4):
        case 0:
            del part[key]
        case 1 if isinstance(part, list):
            part *= random.choice((2, 30))
        case 2:
            other, name = random.choice(places)
            part[key] = other[name] if name in other or (isinstance(other, list) and name < len(other)) else None
        case _:
            part[key] = random.choice(ODD_VALUES)
    try:
        return json.dumps(value).encode()
    except (ValueError, RecursionError):  # a value inside itself
        return data


def _cells(data: bytes, random: Random) -> bytes:
    lines = data.split(b"\n")
    at = random.randrange(len(lines))
    separator = max((b",", b";", b"\t", b"="), key=lines[at].count)
    cells = lines[at].split(separator)
    cells[random.randrange(len(cells))] = random.choice(ODD_TEXTS)
    lines[at] = separator.join(cells)
    return b"\n".join(lines)


def _token(data: bytes, random: Random) -> bytes:
    at = random.randrange(len(data) + 1)
    return data[:at] + random.choice(ODD_TEXTS) + data[at + random.choice((0, 0, 1, 5)) :]


def _lines(data: bytes, random: Random) -> bytes:
    lines = data.split(b"\n")
    a, b = random.randrange(len(lines)), random.randrange(len(lines))
    match random.randrange(3):
        case 0:
            lines[a], lines[b] = lines[b], lines[a]
        case 1:
            lines.insert(a, lines[b])
        case _:
            del lines[a]
    return b"\n".join(lines)


def _bytes(data: bytes, random: Random) -> bytes:
    changed = bytearray(data)
    for _ in range(random.choice((1, 2, 8))):
        if changed:
            changed[random.randrange(len(changed))] = random.randrange(256)
    return bytes(changed)


def _cut(data: bytes, random: Random) -> bytes:
    a, b = sorted((random.randrange(len(data) + 1), random.randrange(len(data) + 1)))
    return random.choice((data[:a], data[a:], data[:a] + data[b:]))
