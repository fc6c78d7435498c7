"""Blender as a tool of ours: found, installed, and started for a timeline, a pull or a render."""
