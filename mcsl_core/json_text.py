"""JSON as texts from elsewhere hold it, read strictly: what could not be worked with or written again is refused."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Iterable
from typing import Any

from mcsl_core.errors import DocumentError

DEEPEST = 64  # lists and objects inside each other; the EDL has some ten
_NO_TEXT = re.compile("[\ud800-\udc7f\udd00-\udfff]")  # \udc80 to \udcff: bytes of a file name that is not UTF-8


def parse_json(text: str, *, where: str) -> Any:
    """The JSON value of a text.

    DocumentError where it is none, or one with two values under one key, a number that is none (NaN, 1e999), a text
    that is no Unicode, or more than `DEEPEST` lists and objects inside each other.
    """
    remedy = "The file may be cut short; restore it or make it again"
    try:
        value = json.loads(text, object_pairs_hook=_once, parse_constant=_no_constant, parse_float=_finite)
        return shallow(value)
    except json.JSONDecodeError as error:
        spot = f"line {error.lineno}, column {error.colno}"
        raise DocumentError(
            f"is not JSON: {error.msg}", where=f"{where}, {spot}" if where else spot, remedy=remedy
        ) from error
    except (ValueError, RecursionError) as error:
        what = f"is refused: {error}"
        if isinstance(error, RecursionError):
            what = "is nested too deeply"
        elif "integer string" in str(error):  # Python's own words speak of its settings
            what = "is refused: a number has thousands of digits"
        raise DocumentError(what, where=where, remedy="Correct the file or make it again") from error


def _once(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    value = dict(pairs)
    if len(value) != len(pairs):
        names = [name for name, _ in pairs]
        twice = next(name for name in names if names.count(name) > 1)
        raise ValueError(f"the key {twice[:60]!r} stands twice in one object")
    return value


def _no_constant(name: str) -> Any:
    raise ValueError(f"{name} is not a number")


def _finite(digits: str) -> float:
    if math.isinf(number := float(digits)):
        raise ValueError(f"{digits[:40]} is too large a number")
    return number


def shallow(value: Any) -> Any:
    """``value``, unless it is nested deeper than a recursion may go or holds text that cannot be written."""
    level = [value]
    for _ in range(DEEPEST):
        level = [item for part in level for item in _items(part)]
        if any(isinstance(item, str) and _NO_TEXT.search(item) for item in level):
            raise ValueError("a text in it is no Unicode")
        if not level:
            return value
    raise RecursionError


def _items(part: Any) -> Iterable[Any]:
    return part if isinstance(part, list) else (*part, *part.values()) if isinstance(part, dict) else ()
