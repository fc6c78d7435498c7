"""Bringing the cameras' clocks onto the reference camera's."""
