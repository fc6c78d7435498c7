"""JSON documents: strict structuring of frozen attrs classes, canonical text, atomic saving.

Shared by the EDL and the render presets. The same value always gives the same bytes. Paths into a document are
written from its root: ``$.cameras[0].size[1]``, ``$.poses[2].homographies.cam4``.
"""

from __future__ import annotations

import json
import math
import os
import re
import stat
import sys
import tomllib
from collections.abc import Iterable, Mapping
from fractions import Fraction
from numbers import Integral, Real
from pathlib import Path
from typing import Any, TypeVar, cast, get_args, get_origin

import attrs
import cattrs
from cattrs.errors import (
    BaseValidationError,
    ClassValidationError,
    ForbiddenExtraKeysError,
    IterableValidationError,
    IterableValidationNote,
)
from cattrs.gen import make_dict_structure_fn, make_dict_unstructure_fn, override

from mcsl_core.errors import DocumentError, Fault, writing
from mcsl_core.input_files import check_target, read_text
from mcsl_core.json_text import parse_json, shallow
from mcsl_core.temporary import open_private, temporary_beside
from mcsl_core.timing import FrameRange, format_rate, parse_rate

T = TypeVar("T")
_UNKNOWN = "unknown key"

# -------------------------------------------------------------------------------------------- describing fields


def doc(text: str, *, optional: bool = False) -> dict[str, Any]:
    """attrs metadata: the field's line in the generated reference; ``optional`` fields are left out when empty."""
    return {"doc": text, "optional": optional}


@attrs.frozen
class Bounds:
    """Validator: a finite number in ``low``..``high``, both included; in a tuple or mapping, each of them."""

    low: float = -math.inf
    high: float = math.inf

    def __str__(self) -> str:
        if math.isinf(self.high):
            return "finite" if math.isinf(self.low) else f"{self.low} or more"
        return f"{self.low} to {self.high}"

    def __call__(self, _instance: Any, attribute: attrs.Attribute[Any], value: Any) -> None:
        self.check(value, f".{attribute.name}")

    def check(self, value: Any, at: str) -> None:
        """`Fault` where ``value``, or one of the numbers in it, lies outside; ``at`` is its path."""
        if isinstance(value, tuple):
            for index, item in enumerate(value):
                self.check(item, f"{at}[{index}]")
        elif isinstance(value, Mapping):
            for name, item in value.items():
                self.check(item, at + key_path(name))
        elif not (math.isfinite(value) and self.low <= value <= self.high):
            raise Fault(f"must be {self}, got {value}", at)


@attrs.frozen
class AtMost:
    """Validator: a tuple of at most so many things."""

    most: int

    def __call__(self, _instance: Any, attribute: attrs.Attribute[Any], value: Any) -> None:
        if len(value) > self.most:
            raise Fault(f"holds {len(value)}, at most {self.most} are taken", f".{attribute.name}")


@attrs.frozen
class NotEmpty:
    """Validator: a text, tuple or mapping with something in it, but no more than ``most``."""

    most: int = sys.maxsize

    def __call__(self, _instance: Any, attribute: attrs.Attribute[Any], value: Any) -> None:
        if not value:
            raise Fault("must not be empty", f".{attribute.name}")
        AtMost(self.most)(_instance, attribute, value)


def key_path(name: str) -> str:
    """One step of a path into a document: ``.name``, or ``["odd name"]`` where a dot would mislead."""
    return f".{name}" if re.fullmatch(r"[\w-]+", name) else f"[{json.dumps(name, ensure_ascii=False)}]"


# ----------------------------------------------------------------------------------------------- structuring


def make_converter() -> cattrs.Converter:
    """A converter that takes nothing on trust: no silent int("3"), no unknown keys, no missing ones."""
    converter = cattrs.Converter(forbid_extra_keys=True, detailed_validation=True)
    converter.register_structure_hook(int, lambda value, _: _whole(value))
    converter.register_structure_hook(bool, lambda value, _: _exact(value, bool, "true or false"))
    converter.register_structure_hook(str, lambda value, _: _exact(value, str, "a text"))
    converter.register_structure_hook(float, lambda value, _: _number(value))
    converter.register_structure_hook(FrameRange, lambda value, _: _frame_range(value))
    converter.register_unstructure_hook(FrameRange, lambda r: [r.start, r.stop])
    converter.register_structure_hook(Fraction, lambda value, _: parse_rate(_exact(value, str, "a text")))
    converter.register_unstructure_hook(Fraction, format_rate)

    # Mappings have no order of their own: sorted, so that equal values give equal bytes.
    def mapping_to_json(value: Mapping[str, Any]) -> dict[str, Any]:
        return {name: converter.unstructure(value[name]) for name in sorted(value)}

    def class_to_json(cls: Any):
        leave_out = {f.name: override(omit_if_default=True) for f in attrs.fields(cls) if f.metadata.get("optional")}
        return make_dict_unstructure_fn(cls, converter, **cast(Any, leave_out))

    converter.register_structure_hook_factory(_is_tuple, lambda cls: _tuple_hook(cls, converter))
    converter.register_structure_hook_factory(_is_mapping, lambda cls: _mapping_hook(cls, converter))
    converter.register_structure_hook_factory(attrs.has, lambda cls: _class_hook(cls, converter))
    converter.register_unstructure_hook_func(_is_mapping, mapping_to_json)
    converter.register_unstructure_hook_factory(attrs.has, class_to_json)
    return converter


def _exact(value: Any, kind: type, words: str) -> Any:
    if isinstance(value, bool) != (kind is bool) or not isinstance(value, kind):
        raise Fault(f"expected {words}, got {_short(value)}")
    return value


def _whole(value: Any) -> int:
    number = _exact(value, int, "a whole number")
    if abs(number) >= 1 << 63:
        raise Fault(f"expected a whole number of at most 18 digits, got {_short(value)}")
    return number


def _number(value: Any) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise Fault(f"expected a number, got {_short(value)}")
    try:
        result = float(value)
    except OverflowError:
        result = math.inf
    if not math.isfinite(result):
        raise Fault(f"expected a finite number, got {_short(value)}")
    return result


def _frame_range(value: Any) -> FrameRange:
    if not isinstance(value, list | tuple) or len(value) != 2:
        raise Fault(f"expected a range [start, stop], got {_short(value)}")
    return FrameRange(*_each(value, [int, int], lambda item, _: _whole(item), FrameRange))


def _is_tuple(cls: Any) -> bool:
    return get_origin(cls) is tuple


def _is_mapping(cls: Any) -> bool:
    kind = get_origin(cls) or cls
    return isinstance(kind, type) and issubclass(kind, Mapping)


def _tuple_hook(cls: Any, converter: cattrs.Converter):
    kinds = get_args(cls)
    homogeneous = len(kinds) == 2 and kinds[1] is Ellipsis

    def structure(value: Any, _: Any) -> Any:
        if not isinstance(value, list | tuple):
            raise Fault(f"expected a list, got {_short(value)}")
        wanted = [kinds[0]] * len(value) if homogeneous else kinds
        if len(wanted) != len(value):
            raise Fault(f"expected {len(wanted)} values, got {len(value)}")
        return tuple(_each(value, wanted, converter.structure, cls))

    return structure


def _mapping_hook(cls: Any, converter: cattrs.Converter):
    kind = (get_args(cls) or (str, Any))[1]

    def structure(value: Any, _: Any) -> Any:
        if not isinstance(value, Mapping):
            raise Fault(f"expected an object, got {_short(value)}")
        items = _each(value.values(), [kind] * len(value), converter.structure, cls, names=list(value))
        return dict(zip(value, items, strict=True))

    return structure


def _class_hook(cls: Any, converter: cattrs.Converter):
    plain = make_dict_structure_fn(cls, converter, _cattrs_forbid_extra_keys=True)
    counted = [field for field in attrs.fields(cls) if hasattr(field.validator, "most")]

    def structure(value: Any, kind: Any) -> Any:
        if not isinstance(value, Mapping):
            raise Fault(f"expected an object, got {_short(value)}")
        for field in counted:  # before any is read: a hundred thousand cameras took twenty seconds to be refused
            if isinstance(value.get(field.name), list | tuple | Mapping):
                AtMost(field.validator.most)(None, field, value[field.name])
        return plain(value, kind)

    return structure


def _short(value: Any) -> str:
    text = json.dumps(value, ensure_ascii=False, default=repr)
    return text if len(text) <= 60 else text[:57] + "..."


def _each(values: Iterable[Any], kinds: Iterable[Any], structure: Any, cls: Any, names: list[str] | None = None):
    """Structures every item; what is wrong is raised together, each with its index or key."""
    items: list[Any] = []
    faults: list[Exception] = []
    for index, (item, kind) in enumerate(zip(values, kinds, strict=True)):
        try:
            items.append(structure(item, kind))
        except (ValueError, TypeError, BaseValidationError) as fault:
            at = names[index] if names else index
            fault.add_note(IterableValidationNote(f"at {at}", at, kind))
            faults.append(fault)
    if faults:
        # pyright sees ExceptionGroup's two arguments, not those of the class's own __new__
        raise IterableValidationError(f"in {cls}", faults, cls)  # pyright: ignore[reportCallIssue]
    return items


def describe_faults(error: BaseException, path: str = "$") -> list[tuple[str, str]]:
    """(path, what is wrong there) of everything that a document was refused for."""
    if isinstance(error, ClassValidationError):
        named, plain = error.group_exceptions()
        found = [describe_faults(e, path + key_path(note.name)) for e, note in named]
    elif isinstance(error, IterableValidationError):
        noted, plain = error.group_exceptions()
        steps = [key_path(n.index) if isinstance(n.index, str) else f"[{n.index}]" for _, n in noted]
        found = [describe_faults(e, path + step) for (e, _), step in zip(noted, steps, strict=True)]
    elif isinstance(error, ForbiddenExtraKeysError):
        known = ", ".join(f.name for f in attrs.fields(cast(Any, error.cl)))
        return [(path + key_path(k), f"{_UNKNOWN}, expected one of {known}") for k in sorted(error.extra_fields)]
    elif isinstance(error, KeyError):
        return [(path, "is missing")]
    elif isinstance(error, Fault):
        return [(path + error.at, error.what)]
    else:
        return [(path, str(error))]
    return [fault for part in (*found, *(describe_faults(e, path) for e in plain)) for fault in part]


def structure_document(value: Any, kind: type[T], converter: cattrs.Converter, *, where: str, name: str) -> T:
    """``value`` as a ``kind``; DocumentError with the path to the first wrong value when it is not one.

    where: the file. name: what the page in docs/ describes, as in "the EDL (edl.md)".
    """
    try:
        return converter.structure(value, kind)
    except (cattrs.BaseValidationError, ValueError, TypeError) as error:
        # A name that is not known comes first: what it stands for is often what is missing.
        (path, what), *others = sorted(describe_faults(error), key=lambda fault: not fault[1].startswith(_UNKNOWN))
        more = f" (and {len(others)} more faults)" if len(others) > 1 else " (and 1 more fault)" if others else ""
        spot = f"{where} at {path}" if where else path
        raise DocumentError(what + more, where=spot, remedy=f"Correct the value; docs/ describes {name}") from error


# ------------------------------------------------------------------------------------------- text and files


def read_json(path: Path, *, wanted: str = "a JSON document", remedy: str = "") -> Any:
    """The JSON value of a UTF-8 file.

    InputError where there is none, DocumentError where it is not JSON; ``wanted`` and ``remedy`` as in `read_text`.
    """
    return parse_json(read_text(path, wanted=wanted, remedy=remedy), where=str(path))


def read_toml(path: Path, *, wanted: str, remedy: str) -> dict[str, Any]:
    """The values of a TOML file; ``wanted`` and ``remedy`` as in `read_text`, DocumentError where it is no TOML."""
    text = read_text(path, wanted=wanted, remedy=remedy)
    try:
        return shallow(tomllib.loads(text))
    except (ValueError, RecursionError) as error:  # a number of thousands of digits is a ValueError too
        why = "it is nested too deeply" if isinstance(error, RecursionError) else error
        raise DocumentError(f"is not TOML: {why}", where=str(path), remedy=remedy) from error


def canonical_json(value: Any) -> str:
    """Readable and diffable: short lists and objects on one line, keys in the order given, floats at 10 digits."""
    return _render(_rounded(value), "") + "\n"


def _rounded(value: Any) -> Any:
    if value is None or isinstance(value, bool | str):
        return value
    if isinstance(value, Integral):  # numpy's scalars are Integral and Real too
        return int(value)
    if isinstance(value, Real):
        number = float(value)
        if not math.isfinite(number):
            raise ValueError(f"a document holds finite numbers only, got {number}")
        short = float(f"{number:.10g}")
        return 0.0 if short == 0 else short  # no -0.0
    if isinstance(value, Mapping):
        return {str(k): _rounded(v) for k, v in value.items()}
    if isinstance(value, list | tuple):
        return [_rounded(v) for v in value]
    raise TypeError(f"a document holds JSON values only, got {type(value).__name__} {value!r}")


def _text(value: Any) -> str:
    # A file name that is not UTF-8 reaches Python as lone surrogates: written as escapes, they come back as they were.
    line = json.dumps(value, ensure_ascii=False)
    return re.sub("[\ud800-\udfff]", lambda match: f"\\u{ord(match[0]):04x}", line)


def _render(value: Any, indent: str) -> str:
    line = _text(value)
    if not isinstance(value, dict | list) or not value or len(indent) + len(line) <= 110:
        return line
    deeper = indent + "  "
    if isinstance(value, list):
        if all(isinstance(v, int | float) for v in value):  # a long row of numbers stays a row
            return line
        parts = [deeper + _render(v, deeper) for v in value]
        return "[\n" + ",\n".join(parts) + "\n" + indent + "]"
    parts = [f"{deeper}{_text(k)}: {_render(v, deeper)}" for k, v in value.items()]
    return "{\n" + ",\n".join(parts) + "\n" + indent + "}"


def write_atomic(path: Path, data: bytes, *, private: bool = False) -> None:
    """Writes beside ``path`` and renames: a reader sees the old file or the whole new one, never a part.

    What lies there and is no regular file is refused: a rename would put a file in the place of a device or a pipe.
    private: for its owner's eyes alone. Else a new file obeys the umask, and one that was there keeps its permissions.
    """
    target = Path(os.path.realpath(path))  # a link keeps pointing at what it names
    check_target(target, path)
    temporary = temporary_beside(target)
    with writing(path):
        target.parent.mkdir(parents=True, exist_ok=True)
        mode = stat.S_IMODE(target.stat().st_mode) if target.exists() and not private else None
        stream = open_private(temporary, "xb") if private else temporary.open("xb")
    try:
        with writing(path):
            with stream:
                if mode is not None:
                    temporary.chmod(mode)
                stream.write(data)
                stream.flush()
                os.fsync(stream.fileno())
            temporary.replace(target)
    except BaseException:
        temporary.unlink(missing_ok=True)
        raise
