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
    from mcsl_core.blender.render import RenderSettings
    from mcsl_core.cli.output import Session
    from mcsl_core.errors import McslError
    from mcsl_core.timing import FrameRange

__version__ = "0.2.0"

__all__ = [
    "Alignment",
    "AnalysisSettings",
    "FrameRange",
    "McslError",
    "Programme",
    "RenderSettings",
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
        "mcsl_core.alignment.protocol": ("Alignment",),
        "mcsl_core.analysis.settings": ("AnalysisSettings",),
        "mcsl_core.api.entry": ("analyse", "evaluate", "open"),
        "mcsl_core.api.programme": ("Programme",),
        "mcsl_core.api.stills": ("align",),
        "mcsl_core.blender.render": ("RenderSettings",),
        "mcsl_core.cli.output": ("Session",),
        "mcsl_core.errors": ("McslError",),
        "mcsl_core.timing": ("FrameRange",),
    },
)
