# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender started from mcsl: the child process and what it can do."""
