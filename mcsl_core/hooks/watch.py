"""How long plugins take, for a person who waits."""

from __future__ import annotations

import threading
from collections.abc import Callable


class Watch:
    """Notes a plugin that has taken longer than the recording lasts, and again each time that has doubled.

    Not mcsl's own: of those nobody can choose a better one, and on a busy machine newcomers took the note for a fault.

    Parameters
    ----------
    lasts_s : float
        The recording's length in seconds.
    note : callable
        Takes the note: no judgement, but what a person who waits wants to know.
    """

    def __init__(self, lasts_s: float, note: Callable[[str], None]) -> None:
        self.lasts_s, self._note = lasts_s, note
        self._spent: dict[str, float] = {}
        self._bounds_s: dict[str, float] = {}
        self._lock = threading.Lock()

    def spent(self, who: str, seconds: float) -> None:
        """``who`` was busy for so long, just now. Safe from several threads."""
        with self._lock:
            total = self._spent.get(who, 0.0) + seconds
            self._spent[who] = total
            bound = self._bounds_s.get(who, self.lasts_s)
            if total <= bound:
                return
            self._bounds_s[who] = 2 * total
        self._note(f"{who} has taken {total:.0f} s, for a recording of {self.lasts_s:.0f} s")
