# SPDX-License-Identifier: GPL-3.0-or-later
"""The sequencer's strips: built, read, edited. The only user of Blender's strip API."""
