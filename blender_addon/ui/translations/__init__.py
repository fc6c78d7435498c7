# SPDX-License-Identifier: GPL-3.0-or-later
"""The extension in the user's language: the tables, and looking a text up through Blender's own mechanism."""
