# SPDX-License-Identifier: GPL-3.0-or-later
"""How an area is divided among cameras, so that each picture is shown as large as can be."""

from __future__ import annotations

PICTURE = 16 / 9  # width to height of most cameras


def rows_of(width: int, height: int, count: int) -> tuple[int, ...]:
    """How many cameras each row takes, the upper first, in an area of ``width`` x ``height`` pixels.

    Of all grids the one whose pictures are largest; the last row may hold fewer, and they are then wider.
    """

    def shown(columns: int) -> float:
        return min(width / columns, height / -(-count // columns) * PICTURE)

    columns = max(range(1, count + 1), key=shown)
    whole, rest = divmod(count, columns)
    return (columns,) * whole + ((rest,) if rest else ())
