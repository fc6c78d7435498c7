# SPDX-License-Identifier: GPL-3.0-or-later
"""Panels, operators and what they need of Blender: a thin skin over `core`."""
