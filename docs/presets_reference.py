"""reference/presets.md: every preset that comes with mcsl, and what a file of one's own may say; see generate.py."""

from __future__ import annotations

from typing import Any

import attrs

INTRODUCTION = """\
# Render presets

<!-- Written by docs/generate.py from render_presets/*.json and mcsl_core/delivery/presets.py; change it there. -->

A preset says what a delivery is: `mcsl render edl.json -o out.mov --preset prores`. Each names Blender's encoder and,
equal to it, the one of `--engine direct`, which writes the same programme without Blender and without what lies above
the channel Conformed. Blender itself writes ProRes and FFV1 without colour tags (the pictures are BT.709; FFV1 is
full-range RGB there and BT.709 4:2:0 from the direct engine).
"""

OWN = """\
## A preset of your own

Copy one of the files, change it and name it: `mcsl render edl.json -o out.mp4 --preset mine.json`. A wrong value is
refused with its place and what was expected.
"""


def row(attribute: attrs.Attribute[Any], before: str = "") -> str:
    return f"| `{before}{attribute.name}` | {attribute.metadata['doc']} |"


def words(value: object) -> str:
    """A value as it stands in the file, for a cell of a table."""
    if isinstance(value, dict):
        return ", ".join(f"`{name}`{options(item)}" for name, item in value.items())
    return f"`{value}`" if value != "" else ""


def options(value: object) -> str:
    """What stands behind a name: one value, or an encoder's own options."""
    if isinstance(value, dict):
        return f" ({', '.join(f'{name} {item}' for name, item in value.items())})"
    return f" {value}"


def section(name: str, preset: Any) -> str:
    both = {"Blender": attrs.asdict(preset.blender), "direct": attrs.asdict(preset.direct)}
    names = [n for n in dict.fromkeys(n for f in both.values() for n in f) if any(f.get(n) for f in both.values())]
    size = "full size" if preset.scale_percent == 100 else f"{preset.scale_percent} % of the programme's size"
    lines = [f"## {name}", "", f"**{preset.title}.** {preset.description} File: `.{preset.container}`, {size}.", ""]
    lines += ["| | Blender | direct |", "|---|---|---|"]
    for field in names:
        cells = (words(fields[field]) if field in fields else "" for fields in both.values())
        lines.append(f"| `{field}` | " + " | ".join(cells) + " |")
    return "\n".join(lines) + "\n"


def presets_page() -> str:
    from mcsl_core.delivery import presets

    found = {name: presets.load_preset(name) for name in presets.preset_names()}
    summary = ["| name | what for |", "|---|---|"]
    summary += [f"| [{name}](#{name}) | {preset.description} |" for name, preset in found.items()]
    fields = ["| field | meaning |", "|---|---|", f"| `schema` | `{presets.SCHEMA}` |"]
    for attribute in attrs.fields(presets.Preset):
        fields.append(row(attribute))
        if attribute.name in ("blender", "direct"):
            kind = presets.BlenderOutput if attribute.name == "blender" else presets.DirectOutput
            fields += [row(inner, f"{attribute.name}.") for inner in attrs.fields(kind)]
    parts = [INTRODUCTION, "\n".join(summary) + "\n", *(section(*pair) for pair in found.items()), OWN]
    return "\n".join([*parts, "\n".join(fields)]) + "\n"
