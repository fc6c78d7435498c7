"""Writes the pages that are derived from code, data and notebooks. No second source.

    python docs/generate.py            writes them
    python docs/generate.py --check    writes nothing; exit code 1 when one of them is not what it would write

Of hooks.md only the part below the marker is generated; the introduction above it is written by hand.
"""

from __future__ import annotations

import inspect
import json
import os
import sys
import types
import typing
from collections.abc import Iterator, Mapping
from fractions import Fraction
from pathlib import Path
from typing import Any, Union, get_args, get_origin

import attrs

DOCS = Path(__file__).resolve().parent
os.environ["LANGUAGE"] = "en"  # help is in the user's language, the pages are not
if __name__ == "__main__":  # the tree this file stands in, whatever else is installed
    sys.path.insert(0, str(DOCS.parent))

from cli_reference import command_line_page  # noqa: E402
from hooks_reference import hooks_page  # noqa: E402
from presets_reference import presets_page  # noqa: E402
from site_pages import decisions_page, front_door_page, notebook_page  # noqa: E402

from mcsl_core import edl  # noqa: E402
from mcsl_core.documents import Bounds, NotEmpty, make_converter  # noqa: E402
from mcsl_core.timing import RATE_PATTERN, FrameRange  # noqa: E402

# ------------------------------------------------------------------------------------------ the classes' fields


def is_optional(kind: Any) -> bool:
    return get_origin(kind) in (Union, types.UnionType) and type(None) in get_args(kind)


def inner(kind: Any) -> Any:
    """X of ``X | None``."""
    return next(k for k in get_args(kind) if k is not type(None))


def rules(attribute: attrs.Attribute[Any]) -> tuple[Bounds, bool]:
    """(bounds of the numbers in a field, whether it must hold something)."""
    given = attribute.validator
    return given if isinstance(given, Bounds) else Bounds(), isinstance(given, NotEmpty)


def fields_of(cls: Any) -> Iterator[tuple[attrs.Attribute[Any], Any]]:
    kinds = typing.get_type_hints(cls)
    for attribute in attrs.fields(cls):
        yield attribute, kinds[attribute.name]


def classes(root: Any) -> list[Any]:
    """``root`` and every attrs class its fields lead to, in the order they are met, but for `FrameRange`."""
    found: list[Any] = []

    def visit(kind: Any) -> None:
        if kind is FrameRange or kind in found:
            return
        if isinstance(kind, type) and attrs.has(kind):
            found.append(kind)
            for _, field_kind in fields_of(kind):
                visit(field_kind)
        for part in get_args(kind):
            visit(part)

    visit(root)
    return found


def default_of(attribute: attrs.Attribute[Any]) -> Any:
    """The default as a JSON value; attrs.NOTHING for a required field."""
    value = attribute.default
    if isinstance(value, attrs.Factory):  # pyright: ignore[reportArgumentType]
        value = value.factory()  # pyright: ignore[reportOptionalMemberAccess]
    return value if value is attrs.NOTHING else make_converter().unstructure(value)


# ------------------------------------------------------------------------------------------------ JSON Schema


def schema_of(kind: Any, bounds: Bounds, filled: bool) -> dict[str, Any]:
    if kind is Any:
        return {}
    if is_optional(kind):
        return {"anyOf": [schema_of(inner(kind), bounds, filled), {"type": "null"}]}
    if kind is bool:
        return {"type": "boolean"}
    if kind in (int, float):
        limits = {"minimum": bounds.low, "maximum": bounds.high}
        return {
            "type": "integer" if kind is int else "number",
            **{name: limit for name, limit in limits.items() if abs(limit) != float("inf")},
        }
    if kind is str:
        return {"type": "string", **({"minLength": 1} if filled else {})}
    if kind is Fraction:
        return {"type": "string", "pattern": f"^{RATE_PATTERN}$"}
    if kind is FrameRange or attrs.has(kind):
        return {"$ref": f"#/$defs/{kind.__name__}"}
    args = get_args(kind)
    if get_origin(kind) is tuple and args[-1] is Ellipsis:
        return {"type": "array", "items": schema_of(args[0], bounds, False), **({"minItems": 1} if filled else {})}
    if get_origin(kind) is tuple:
        items = [schema_of(k, bounds, False) for k in args]
        return {"type": "array", "prefixItems": items, "items": False, "minItems": len(args)}
    if issubclass(get_origin(kind), Mapping):
        return {"type": "object", "additionalProperties": schema_of(args[1], bounds, False)}
    raise TypeError(f"no JSON Schema for {kind}")


def schema_of_class(cls: Any) -> dict[str, Any]:
    properties: dict[str, Any] = {}
    required = []
    for attribute, kind in fields_of(cls):
        node = schema_of(kind, *rules(attribute))
        node["description"] = attribute.metadata["doc"]
        default = default_of(attribute)
        if default is attrs.NOTHING:
            required.append(attribute.name)
        elif not attribute.metadata["optional"]:
            node["default"] = default
        properties[attribute.name] = node
    return {
        "description": inspect.cleandoc(cls.__doc__),
        "type": "object",
        "properties": properties,
        "required": required,
        "additionalProperties": False,
    }


def edl_schema() -> str:
    root = schema_of_class(edl.Edl)
    frame_range = {
        "description": "Half-open frame range [start, stop): start <= frame < stop.",
        "type": "array",
        "items": {"type": "integer", "minimum": 0},
        "minItems": 2,
        "maxItems": 2,
    }
    schema = {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": edl.SCHEMA,
        "description": "The edit-decision list of mcsl. What a schema cannot say (tiling, names) stands in edl.md.",
        "type": "object",
        "properties": {"schema": {"const": edl.SCHEMA}, **root["properties"]},
        "required": ["schema", *root["required"]],
        "additionalProperties": False,
        "$defs": {
            "FrameRange": frame_range,
            **{c.__name__: schema_of_class(c) for c in classes(edl.Edl)[1:]},
        },
    }
    return json.dumps(schema, indent=2, ensure_ascii=False) + "\n"


# ----------------------------------------------------------------------------------------------------- edl.md


def words(kind: Any, bounds: Bounds, many: bool = False) -> str:
    """A type as a person would say it; ``many``: in the plural."""
    limits = "" if bounds == Bounds() else f", {bounds}"
    if kind is Any:
        return "anything"
    if is_optional(kind):
        return f"{words(inner(kind), bounds)}, or null"
    if kind is bool:
        return "true or false"
    plain = {int: ("whole number", limits), float: ("number", limits), str: ("text", ""), Fraction: ("rate", "")}
    plain[FrameRange] = ("range", "")
    if kind in plain:
        noun, rest = plain[kind]
        return f"{noun}s{rest}" if many else f"{noun}{rest}"
    if attrs.has(kind):
        return f"[{kind.__name__}](#{kind.__name__.lower()})"
    args = get_args(kind)
    if get_origin(kind) is tuple and args[-1] is Ellipsis:
        return f"list of {words(args[0], bounds, many=True)}"
    if get_origin(kind) is tuple:
        if len(set(args)) > 1:
            return "[" + ", ".join(words(k, bounds) for k in args) + "]"
        if get_origin(args[0]) is tuple:
            return f"{len(args)}x{len(get_args(args[0]))} numbers, row by row"
        return f"{len(args)} {words(args[0], bounds, many=True)}"
    return f"object: name -> {words(args[1], bounds)}"


def default_words(attribute: attrs.Attribute[Any]) -> str:
    default = default_of(attribute)
    if default is attrs.NOTHING:
        return "required"
    if attribute.metadata["optional"]:
        return "left out"
    if isinstance(default, dict) and default:
        return "its defaults"
    return f"`{json.dumps(default)}`"


def table(cls: Any) -> str:
    rows = ["| field | type | default | meaning |", "|---|---|---|---|"]
    if cls is edl.Edl:
        rows.append(f'| `schema` | text | required | `"{edl.SCHEMA}"`; an older one is upgraded, a newer one refused |')
    for attribute, kind in fields_of(cls):
        bounds, filled = rules(attribute)
        kind_words = words(kind, bounds) + (", not empty" if filled else "")
        cells = (f"`{attribute.name}`", kind_words, default_words(attribute), attribute.metadata["doc"])
        rows.append("| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |")
    return "\n".join(rows)


def example() -> edl.Edl:
    """Half a minute from three cameras with one movement of the lamp and one decision of the editor."""

    def camera(name: str, clock: edl.Clock, **more: Any) -> edl.Camera:
        media = (edl.Media(f"recording/{name}.mp4", 900, "9f1c2a"),)
        return edl.Camera(name, media, (1920, 1080), Fraction(30000, 1001), clock, **more)

    turned = ((0.309017, -0.951057, 1180.5), (0.951057, 0.309017, -539.2), (1.2e-06, -3.4e-06, 1.0))
    moved = ((0.98, -0.02, 31.0), (0.02, 0.98, -12.5), (0.0, 0.0, 1.0))
    colour = edl.Colour(((1.02, 0.0, 0.0, -1.5), (0.0, 0.97, 0.0, 3.0), (0.0, 0.0, 1.05, -6.0)))
    homographies = {"cam1": edl.IDENTITY, "cam2": turned}
    outline = ((812.0, 430.0), (1130.0, 418.0), (1166.0, 664.0), (838.0, 690.0))
    return edl.Edl(
        rate=Fraction(30000, 1001),
        size=(1920, 1080),
        frames=900,
        reference="cam1",
        cameras=(
            camera("cam1", edl.Clock(method="audio", confidence=1.0)),
            camera("cam2", edl.Clock(0.213, 12.4, "audio", 0.93)),
            camera("cam3", edl.Clock(-0.04, 0.0, "motion", 0.6), gaps=(FrameRange(410, 416),)),
        ),
        movements=(edl.Movement(FrameRange(300, 360), 0.98),),
        poses=(
            edl.Pose(
                FrameRange(0, 330),
                {**homographies, "cam3": moved},
                colour={"cam2": colour},
                solved_from=(30, 90, 150),
                residual_px={"cam2": 1.4, "cam3": 1.9},
                support={"cam2": 412, "cam3": 268},
            ),
            edl.Pose(
                FrameRange(330, 900),
                homographies,
                anchor=moved,
                solved_from=(390, 480),
                residual_px={"cam2": 1.6},
                support={"cam2": 365},
                weak=(edl.Weak("cam3", "9 matches with the other cameras, 30 needed"),),
            ),
        ),
        shots=(
            edl.Shot(FrameRange(0, 240), "cam2", 0.97, "sees the most of the field"),
            edl.Shot(FrameRange(240, 900), "cam1", 0.91, "a head covers the field in cam2"),
        ),
        overrides=(edl.Override(FrameRange(120, 200), camera="cam1", centering=False, note="show the suture"),),
        fields=(edl.FieldStretch(FrameRange(0, 330), "pictures", (outline,)),),
        drawn_fields=(edl.DrawnField(FrameRange(330, 900), (outline,), "the second wound"),),
        centering=((0, 12.5, -8.0), (330, 12.5, -8.0), (390, 4.0, 0.0)),
        scores="edl.scores.npz",
        made_by=edl.MadeBy("0.1.0", {"sample_s": 1.0}, {"selector": "shortest-path (mcsl 0.1.0)"}),
    )


INTRODUCTION = """\
# The EDL

<!-- Written by docs/generate.py from mcsl_core/edl/schema.py; change it there. -->

The edit-decision list is the one document between analysis, editor and renderer: `mcsl analyse` writes it, the
Blender timeline is built from it, the editor's changes come back into it as overrides, and every programme picture is
made from it. It is JSON in UTF-8, readable and diffable. [edl.schema.json](edl.schema.json)
is its JSON Schema.

## Conventions

- **Ranges** are half-open: `[120, 200]` holds the programme frames 120 to 199 and is never empty.
- **Time**: programme frame n stands at n / rate seconds. A camera's own time at programme time t is
  `(t - offset_s) * (1 + drift_ppm * 1e-6)`.
- **Rates** are texts that hold fractions: `"30000/1001"`, `"25"`. The usual decimals (`"29.97"`) are read as the exact
  fraction they stand for.
- **Pixels**: centres lie at integers. Sizes are width, then height.
- **Homographies** are 3x3, row by row, scaled so that the last number is 1. They act on full-size pixels:
  camera pixel -> reference camera pixel (`homographies`) -> programme pixel (`anchor`) -> shifted by `centering`.
- **Paths** are relative to the EDL's folder, or absolute, with forward slashes.
- **Poses and shots tile** [0, frames): in order, no gap, no overlap.
- **Fields**: outlines of the surgical field are in programme pixels before centering, in the first perspective those of
  the reference camera. What lies in any of them is the field.
- **Names**: every camera that is named anywhere is one of `cameras`.
- **Overrides** win over the analysis, field by field; of two that overlap, the later in the list wins. Analysing again
  keeps them.
- **The same value gives the same bytes**: fields in the order below, object keys sorted, numbers at ten digits, no
  clock times.
- **Nothing is taken on trust**: an unknown or missing field, a second value under one key, `"3"` where 3 is meant, a
  number out of bounds is refused with its path and what was expected. A newer schema is refused by name, an older one
  is upgraded.

## Fields
"""


def edl_page() -> str:
    parts = [INTRODUCTION]
    for cls in classes(edl.Edl):
        parts.append(f"### {cls.__name__}\n\n{inspect.cleandoc(cls.__doc__)}\n\n{table(cls)}\n")
    parts.append(f"## A whole example\n\n```json\n{edl.dumps(example())}```\n")
    return "\n".join(parts)


# ------------------------------------------------------------------------------------------------------- main

EXAMPLES = DOCS.parent / "examples"
PAGES = {
    "decisions/index.md": lambda: decisions_page(DOCS / "decisions"),
    "hooks.md": lambda: hooks_page(DOCS / "hooks.md"),
    "how-to/compare-detectors.md": lambda: notebook_page(EXAMPLES / "compare_detectors.ipynb"),
    "reference/command-line.md": command_line_page,
    "reference/edl.md": edl_page,
    "reference/edl.schema.json": edl_schema,
    "reference/front-door.md": front_door_page,
    "reference/presets.md": presets_page,
    "tutorials/notebook.md": lambda: notebook_page(EXAMPLES / "first_programme.ipynb"),
}


def stale() -> list[str]:
    """Pages that differ from what would be written."""
    return [
        name for name, make in PAGES.items() if not (DOCS / name).exists() or (DOCS / name).read_text("utf-8") != make()
    ]


def main(arguments: list[str]) -> int:
    if arguments not in ([], ["--check"]):
        print("usage: python docs/generate.py [--check]", file=sys.stderr)
        return 2
    old = stale()
    if not arguments:
        for name in old:
            (DOCS / name).write_text(PAGES[name](), "utf-8")
            print(f"written: docs/{name}")
        return 0
    for name in old:
        print(f"docs/{name} is stale: run python docs/generate.py", file=sys.stderr)
    return 1 if old else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
