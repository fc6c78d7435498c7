"""Stands where Blender puts its UILayout, which exists only while a window is drawn: notes what a panel asks for.

Every operator and property that is asked for must be there, as the real layout demands; texts are kept by kind, so that
a test can ask for the Japanese of each.
"""

from __future__ import annotations

import bpy  # pyright: ignore[reportMissingImports]


class Recorder:
    def __init__(self, notes=None):
        self.notes = notes if notes is not None else []

    def _nested(self, *_, **__):
        return Recorder(self.notes)

    row = column = box = split = column_flow = grid_flow = _nested

    def label(self, *, text="", icon="NONE", translate=True, **_):
        check_icon(icon)
        self.notes.append(("label", text, translate))

    def separator(self, **_):
        pass

    def progress(self, *, factor, text):
        assert 0 <= factor <= 1
        self.notes.append(("label", text, False))

    def prop(self, data, name, *, text=None, **_):
        found = data.bl_rna.properties[name]
        if found.type == "ENUM":
            getattr(data, name)
        self.notes.append(("prop", found.name if text is None else text, True))

    def template_list(self, kind, _id, data, name, active_data, active_name, **_):
        row = getattr(bpy.types, kind)
        for item in getattr(data, name):
            row.draw_item(None, bpy.context, Recorder(self.notes), data, item, 0, active_data, active_name)

    def operator(self, name, *, text=None, icon="NONE", translate=True, **_):
        check_icon(icon)
        module, _, short = name.partition(".")
        assert short in dir(getattr(bpy.ops, module)), f"no operator {name}"
        kind = getattr(getattr(bpy.ops, module), short).get_rna_type()
        self.notes.append(("operator", kind.name if text is None else text, translate))
        return Properties(kind.properties, name)

    def operator_menu_enum(self, name, property, *, text=None, icon="NONE", translate=True, **_):
        self.operator(name, text=text, icon=icon, translate=translate)
        module, _, short = name.partition(".")
        assert property in getattr(getattr(bpy.ops, module), short).get_rna_type().properties, property

    def __setattr__(self, name, value):
        object.__setattr__(self, name, value)


class Properties:
    """The settings of a button: only those that the operator has can be set."""

    def __init__(self, properties, name):
        object.__setattr__(self, "_known", (set(properties.keys()), name))

    def __setattr__(self, name, value):
        known, operator = self._known
        assert name in known, f"{operator} has no {name}"


def check_icon(icon):
    icons = bpy.types.UILayout.bl_rna.functions["prop"].parameters["icon"].enum_items
    assert icon in icons, f"no icon {icon}"


def draw(names=None):
    """What the panels of these names (all of ours) show now, in order: [kind, text, translated by Blender]."""
    kinds = [getattr(bpy.types, name) for name in dir(bpy.types) if name.startswith("MCSL_PT_")]
    recorder = Recorder()
    for kind in sorted(kinds, key=lambda k: (getattr(k, "bl_order", 9), k.__name__)):
        if names is not None and kind.__name__ not in names:
            continue
        if hasattr(kind, "poll") and not kind.poll(bpy.context):
            continue
        panel = type("Drawn", (), {"layout": recorder, "draw": kind.draw})()
        panel.draw(bpy.context)
    return recorder.notes
