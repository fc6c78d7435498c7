# SPDX-License-Identifier: GPL-3.0-or-later
"""What is decided, in plain Python: no bpy."""
