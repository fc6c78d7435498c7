# SPDX-License-Identifier: GPL-3.0-or-later
"""The sequencer's strips: built, read, edited. The only user of Blender's strip API.

Programme frame n is Blender's frame n + 1. Every strip made here says its role (camera, programme, centering,
conformed, sound); what has none belongs to the editor and is never touched, only moved up when it lies where our
channels are. All names of custom properties stand in scene_properties.py, what differs between versions of Blender in
compat.py.
"""
