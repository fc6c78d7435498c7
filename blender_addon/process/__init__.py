# SPDX-License-Identifier: GPL-3.0-or-later
"""mcsl started from Blender, as a child process. No bpy."""
