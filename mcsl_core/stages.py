"""The stages that plugins may do, by the name of their option on the command line."""

from __future__ import annotations

from collections.abc import Mapping

from attrs import frozen


@frozen
class Stage:
    """hook: the function a plugin registers by. methods: what its objects must have. default: the built-in's name."""

    hook: str
    methods: tuple[str, ...]
    default: str
    purpose: str


STAGES: Mapping[str, Stage] = {
    "movement": Stage("register_movement_detectors", ("detect",), "stillness", "finds when the lamp moves"),
    "matcher": Stage("register_matchers", ("features", "match"), "rootsift", "finds the same places in two views"),
    "aligner": Stage("register_aligners", ("align",), "joint-plane", "ties the views of a pose together"),
    "occlusion": Stage("register_occlusion_detectors", ("scorer",), "consensus", "says how much of the field shows"),
    "selector": Stage("register_selectors", ("select",), "shortest-path", "chooses the camera of every moment"),
    "centerer": Stage("register_centerers", ("centre",), "field", "puts the surgical field in the middle"),
    "filler": Stage("register_fillers", ("fill",), "footprint", "fills what the warp leaves empty"),
}
