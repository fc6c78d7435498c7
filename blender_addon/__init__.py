# SPDX-License-Identifier: GPL-3.0-or-later
"""mcsl in Blender's sequencer: the timeline of an EDL, and the editor's decisions back into it.

`plan`, `similarity` and `readback` hold the decisions and import no bpy; `strips` is the only user of the strip API;
`background` runs in a child process. Of mcsl_core only timing, errors, progress, documents and edl are used here.
"""
