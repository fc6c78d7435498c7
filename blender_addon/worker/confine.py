# SPDX-License-Identifier: GPL-3.0-or-later
"""A .blend from elsewhere renders to its output and writes nothing else. The .blend itself is not saved after this."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import bpy  # pyright: ignore[reportMissingImports]

_WRITES = "CompositorNodeOutputFile"


def confine(scene: Any) -> list[str]:
    """Switches off whatever in the open file would write beside the output when ``scene`` is rendered.

    Returns
    -------
    list of str
        What was switched off, for a person.
    """
    notes = [f"a File Output node in {where} is switched off: a render writes its video alone" for where in _nodes()]
    for other in bpy.data.scenes:
        render = other.render
        for name, value in (("use_render_cache", False), ("use_placeholder", False), ("use_overwrite", True)):
            if hasattr(render, name):
                setattr(render, name, value)
        if other.sequence_editor is not None:
            for strip in other.sequence_editor.strips_all:
                if getattr(strip, "use_proxy", False):
                    strip.use_proxy = False
    if scene.render.use_multiview:
        scene.render.use_multiview = False
        notes.append("Stereoscopy is switched off: a render writes one video")
    notes.extend(f"{what} is switched off: it keeps files of its own" for what in _caches())
    return notes


def _nodes() -> Iterator[str]:
    """Takes File Output nodes out of every node tree; yields where they were."""
    trees = [(f"the nodes {group.name!r}", group) for group in bpy.data.node_groups]
    trees += [(f"the scene {s.name!r}", tree) for s in bpy.data.scenes if (tree := _tree_of(s)) is not None]
    for where, tree in trees:
        for node in [node for node in tree.nodes if node.bl_idname == _WRITES]:
            tree.nodes.remove(node)
            yield where


def _tree_of(scene: Any) -> Any:
    """The compositing nodes that a scene has to itself; from 5.0 they are node groups like others."""
    return None if hasattr(scene, "compositing_node_group") else scene.node_tree


def _caches() -> Iterator[str]:
    """Switches off simulations that write to disk as time goes on; yields them."""
    for body in bpy.data.objects:
        for modifier in body.modifiers:
            if modifier.type == "FLUID" and modifier.fluid_type == "DOMAIN":
                modifier.show_viewport = modifier.show_render = False
                yield f"the fluid of {body.name!r}"
            if _keeps_on_disk(getattr(modifier, "point_cache", None)):
                yield f"the disk cache of {body.name!r}"
        for system in body.particle_systems:
            if _keeps_on_disk(system.point_cache):
                yield f"the disk cache of {body.name!r}"
    for scene in bpy.data.scenes:
        if scene.rigidbody_world is not None and _keeps_on_disk(scene.rigidbody_world.point_cache):
            yield f"the disk cache of the scene {scene.name!r}"


def _keeps_on_disk(cache: Any) -> bool:
    if cache is None or not cache.use_disk_cache:
        return False
    cache.use_disk_cache = False
    return True
