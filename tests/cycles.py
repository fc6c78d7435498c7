"""What a run leaves in reference cycles, which only Python's garbage collector ends, and that seldom."""

from __future__ import annotations

import gc
from collections.abc import Callable


def left_in_cycles(run: Callable[[], object]) -> set[str]:
    """The classes of this project and of PyAV of which ``run`` leaves objects that are in no use, but not freed."""
    gc.collect()
    gc.disable()
    gc.set_debug(gc.DEBUG_SAVEALL)
    try:
        run()
        gc.collect()
        kinds = {f"{type(found).__module__}.{type(found).__qualname__}" for found in gc.garbage}
    finally:
        gc.set_debug(0)
        gc.garbage.clear()
        gc.enable()
    return {kind for kind in kinds if kind.startswith(("mcsl_core", "av."))}
