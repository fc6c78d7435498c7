"""The stages that plugins may do, by the name of their option on the command line."""

from __future__ import annotations

from collections.abc import Mapping

from attrs import frozen


@frozen
class Stage:
    """hook: the function a plugin registers by. methods: what its objects must have. default: the built-in's name.

    noun: what such a plugin is called. numbers: what else its objects must have, as whole numbers or yes and no.
    """

    hook: str
    methods: tuple[str, ...]
    default: str
    purpose: str
    noun: str
    numbers: tuple[str, ...] = ()


STAGES: Mapping[str, Stage] = {
    "movement": Stage(
        "register_movement_detectors", ("detect",), "stillness", "finds when the lamp moves", "movement detector"
    ),
    "matcher": Stage(
        "register_matchers", ("features", "match"), "rootsift", "finds the same places in two views", "matcher"
    ),
    "aligner": Stage("register_aligners", ("align",), "joint-plane", "ties the views of a pose together", "aligner"),
    "relief": Stage(
        "register_reliefs", ("estimate",), "plane-sweep", "finds the relief that the views share", "relief estimator"
    ),
    "tracker": Stage("register_trackers", ("follow",), "background", "follows the lamp while it moves", "lamp tracker"),
    "occlusion": Stage(
        "register_occlusion_detectors",
        ("scorer",),
        "consensus",
        "says how much of the field shows",
        "occlusion detector",
    ),
    "selector": Stage(
        "register_selectors", ("select",), "shortest-path", "chooses the camera of every moment", "selector"
    ),
    "centerer": Stage("register_centerers", ("centre",), "field", "puts the surgical field in the middle", "centerer"),
    "filler": Stage(
        "register_fillers",
        ("fill",),
        "footprint",
        "fills what the warp leaves empty",
        "filler",
        numbers=("version", "remembers"),
    ),
}
