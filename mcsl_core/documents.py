"""JSON documents: strict structuring of frozen attrs classes, canonical text, atomic saving.

Shared by the EDL and the render presets. The same value always gives the same bytes.
"""

from __future__ import annotations

import json
import math
import os
import tempfile
import types
from collections.abc import Mapping
from fractions import Fraction
from pathlib import Path
from typing import Any, TypeVar, Union

import attrs
import cattrs
from cattrs import transform_error
from cattrs.errors import ForbiddenExtraKeysError, IterableValidationError, IterableValidationNote
from cattrs.gen import make_dict_structure_fn, make_dict_unstructure_fn, override

from .errors import DocumentError, InputError
from .timing import FrameRange, format_rate, parse_rate

T = TypeVar("T")


def doc(text: str, *, optional: bool = False) -> dict[str, Any]:
    """attrs metadata: the field's line in the generated reference; ``optional`` fields are left out when empty."""
    return {"doc": text, "optional": optional}


def make_converter() -> cattrs.Converter:
    """A converter that takes nothing on trust: no silent int("3"), no unknown keys, no missing ones."""
    converter = cattrs.Converter(forbid_extra_keys=True, detailed_validation=True)

    def exact(kind: type, name: str):
        def structure(value: Any, _: Any) -> Any:
            if isinstance(value, bool) != (kind is bool) or not isinstance(value, kind):
                raise ValueError(f"expected {name}, got {json.dumps(value, ensure_ascii=False)[:60]}")
            return value

        return structure

    def number(value: Any, _: Any) -> float:
        if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
            raise ValueError(f"expected a finite number, got {json.dumps(value)[:60]}")
        return float(value)

    def frame_range(value: Any, _: Any) -> FrameRange:
        if not isinstance(value, list | tuple) or len(value) != 2:
            raise ValueError(f"expected a range [start, stop], got {json.dumps(value)[:60]}")
        start, stop = (exact(int, "a whole number")(v, int) for v in value)
        return FrameRange(start, stop)

    def rate(value: Any, _: Any) -> Fraction:
        return parse_rate(exact(str, "a rate such as '30000/1001'")(value, str))

    converter.register_structure_hook(int, exact(int, "a whole number"))
    converter.register_structure_hook(bool, exact(bool, "true or false"))
    converter.register_structure_hook(str, exact(str, "a text"))
    converter.register_structure_hook(float, number)
    converter.register_structure_hook(FrameRange, frame_range)
    converter.register_unstructure_hook(FrameRange, lambda r: [r.start, r.stop])
    converter.register_structure_hook(Fraction, rate)
    converter.register_unstructure_hook(Fraction, format_rate)

    def is_tuple(cls: Any) -> bool:
        return getattr(cls, "__origin__", None) is tuple

    converter.register_structure_hook_factory(is_tuple, lambda cls: _tuple_hook(cls, converter))

    def structure_class(cls: Any):
        plain = make_dict_structure_fn(cls, converter, _cattrs_forbid_extra_keys=True)

        def structure(value: Any, kind: Any) -> Any:
            if not isinstance(value, Mapping):
                raise ValueError(f"expected an object, got {json.dumps(value, ensure_ascii=False)[:60]}")
            return plain(value, kind)

        return structure

    def unstructure_class(cls: Any):
        leave_out = {f.name: override(omit_if_default=True) for f in attrs.fields(cls) if f.metadata.get("optional")}
        return make_dict_unstructure_fn(cls, converter, **leave_out)  # pyright: ignore[reportArgumentType]

    converter.register_structure_hook_factory(attrs.has, structure_class)
    converter.register_unstructure_hook_factory(attrs.has, unstructure_class)
    return converter


def _tuple_hook(cls: Any, converter: cattrs.Converter):
    """Structures tuple[X, ...] and tuple[X, Y, Z] from a JSON list, naming the index of what is wrong."""
    args = cls.__args__
    homogeneous = len(args) == 2 and args[1] is Ellipsis

    def structure(value: Any, _: Any) -> Any:
        if not isinstance(value, list | tuple):
            raise ValueError(f"expected a list, got {json.dumps(value, ensure_ascii=False)[:60]}")
        kinds = [args[0]] * len(value) if homogeneous else list(args)
        if len(kinds) != len(value):
            raise ValueError(f"expected {len(kinds)} values, got {len(value)}")
        items, faults = [], []
        for index, (kind, item) in enumerate(zip(kinds, value, strict=True)):
            try:
                items.append(converter.structure(item, kind))
            except Exception as fault:  # collected and raised together, with the index, below
                fault.add_note(IterableValidationNote(f"Structuring {cls} @ index {index}", index, kind))
                faults.append(fault)
        if faults:
            raise IterableValidationError(f"While structuring {cls}", faults, cls)
        return tuple(items)

    return structure


def describe_faults(error: BaseException) -> list[tuple[str, str]]:
    """(path, what was expected) of everything wrong in a document, in document order."""

    def words(fault: BaseException, _kind: Any) -> str:
        if isinstance(fault, ForbiddenExtraKeysError):
            return "unknown key " + ", ".join(repr(k) for k in sorted(fault.extra_fields))
        if isinstance(fault, KeyError):
            return f"missing key {fault.args[0]!r}"
        return str(fault)

    faults = []
    for line in transform_error(error, format_exception=words):  # pyright: ignore[reportArgumentType]
        what, _, path = line.rpartition(" @ ")
        faults.append((path, what))
    return faults


def structure_document(value: Any, kind: type[T], converter: cattrs.Converter, *, where: str, name: str) -> T:
    """``value`` as a ``kind``; DocumentError with the path to the first wrong value when it is not one."""
    try:
        return converter.structure(value, kind)
    except (cattrs.BaseValidationError, ValueError, TypeError) as error:
        path, what = describe_faults(error)[0]
        spot = f"{where} at {path}" if where else path
        raise DocumentError(what, where=spot, remedy=f"Correct the value; {name} is described in docs/") from error


def read_json(path: Path) -> Any:
    """The JSON value of a UTF-8 file; InputError where it is missing, DocumentError where it is not JSON."""
    try:
        text = path.read_text("utf-8")
    except OSError as error:
        raise InputError(
            f"cannot be read ({error.strerror})", where=str(path), remedy="Check the path and its permissions"
        ) from error
    except UnicodeDecodeError as error:
        raise DocumentError("is not UTF-8 text", where=str(path), remedy="Save it as UTF-8") from error
    try:
        return json.loads(text)
    except json.JSONDecodeError as error:
        raise DocumentError(
            f"is not JSON: {error.msg}",
            where=f"{path}, line {error.lineno}, column {error.colno}",
            remedy="The file may be cut short; restore it or make it again",
        ) from error


def canonical_json(value: Any) -> str:
    """Readable and diffable: short lists and objects on one line, keys in the order given, floats at 10 digits."""
    return _render(_rounded(value), "") + "\n"


def _rounded(value: Any) -> Any:
    if isinstance(value, float):
        if not math.isfinite(value):
            raise ValueError(f"a document holds finite numbers only, got {value}")
        short = float(f"{value:.10g}")
        return 0.0 if short == 0 else short  # no -0.0
    if isinstance(value, Mapping):
        return {str(k): _rounded(v) for k, v in value.items()}
    if isinstance(value, list | tuple):
        return [_rounded(v) for v in value]
    return value


def _render(value: Any, indent: str) -> str:
    line = json.dumps(value, ensure_ascii=False)
    if not isinstance(value, dict | list) or not value or len(indent) + len(line) <= 110:
        return line
    deeper = indent + "  "
    if isinstance(value, list):
        if all(isinstance(v, int | float | str) for v in value):  # a long row of numbers stays a row
            return line
        parts = [deeper + _render(v, deeper) for v in value]
        return "[\n" + ",\n".join(parts) + "\n" + indent + "]"
    parts = [f"{deeper}{json.dumps(k, ensure_ascii=False)}: {_render(v, deeper)}" for k, v in value.items()]
    return "{\n" + ",\n".join(parts) + "\n" + indent + "}"


def write_atomic(path: Path, data: bytes) -> None:
    """Writes beside ``path`` and renames: a reader sees the old file or the whole new one, never a part."""
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        handle, name = tempfile.mkstemp(prefix=f".{path.name}.", dir=path.parent)
    except OSError as error:
        raise InputError(
            f"cannot be written ({error.strerror})",
            where=str(path),
            remedy="Choose a folder you may write to",
        ) from error
    temporary = Path(name)
    try:
        with os.fdopen(handle, "wb") as stream:
            stream.write(data)
            stream.flush()
            os.fsync(stream.fileno())
        umask = os.umask(0)
        os.umask(umask)
        temporary.chmod(0o666 & ~umask)
        temporary.replace(path)
    except BaseException:
        temporary.unlink(missing_ok=True)
        raise


def is_union(kind: Any) -> bool:
    """X | None and Union[X, None]."""
    return getattr(kind, "__origin__", None) is Union or isinstance(kind, types.UnionType)
