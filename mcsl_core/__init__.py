"""mcsl: one steady, unoccluded video from the cameras of a surgical lamp.

The pipeline that turns a recording into an edit-decision list (EDL) and the EDL into programme pictures. From Python::

    import mcsl_core as mcsl

    p = mcsl.analyse("recording/", "edl.json")  # or mcsl.open("edl.json")
    p.frame(900)  # (H, W, 3) RGB
    p.override((900, 1200), camera="cam2")
    p.save()

Nothing in this package imports Blender. Importing the package itself imports nothing but the standard library: each
name below is imported when it is first used.
"""

from typing import TYPE_CHECKING

from mcsl_core.lazy import lazy_names

if TYPE_CHECKING:
    from mcsl_core.alignment.protocol import Alignment
    from mcsl_core.analysis.settings import AnalysisSettings
    from mcsl_core.api.entry import analyse, evaluate, open
    from mcsl_core.api.programme import Programme
    from mcsl_core.api.stills import align
    from mcsl_core.cli.output import Session
    from mcsl_core.errors import McslError
    from mcsl_core.timing import FrameRange

__version__ = "0.1.0"

__all__ = [
    "Alignment",
    "AnalysisSettings",
    "FrameRange",
    "McslError",
    "Programme",
    "Session",
    "__version__",
    "align",
    "analyse",
    "evaluate",
    "open",
]

__getattr__, __dir__ = lazy_names(
    __name__,
    {
        "Alignment": "mcsl_core.alignment.protocol",
        "AnalysisSettings": "mcsl_core.analysis.settings",
        "FrameRange": "mcsl_core.timing",
        "McslError": "mcsl_core.errors",
        "Programme": "mcsl_core.api.programme",
        "Session": "mcsl_core.cli.output",
        "align": "mcsl_core.api.stills",
        "analyse": "mcsl_core.api.entry",
        "evaluate": "mcsl_core.api.entry",
        "open": "mcsl_core.api.entry",
    },
)
