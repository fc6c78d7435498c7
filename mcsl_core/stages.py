"""The stages that plugins may do: stage -> (hook, methods its objects must have, name of the default)."""

from __future__ import annotations

from collections.abc import Mapping

STAGES: Mapping[str, tuple[str, tuple[str, ...], str]] = {
    "movement": ("register_movement_detectors", ("detect",), "stillness"),
    "matcher": ("register_matchers", ("features", "match"), "rootsift"),
    "occlusion": ("register_occlusion_detectors", ("scorer",), "hue-area"),
    "selector": ("register_selectors", ("select",), "shortest-path"),
    "centerer": ("register_centerers", ("centre",), "field"),
    "filler": ("register_fillers", ("fill",), "footprint"),
}
