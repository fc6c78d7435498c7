"""All that a plugin imports: the marker, the protocols, the values they are handed and give, errors, and helpers.

Everything comes from here (``from mcsl_core.hooks import hookimpl, AlignedView``): where in mcsl a name lives may
change, its name here does not. Each is imported when it is first used, so that nothing heavy comes with the rest.
"""

from typing import TYPE_CHECKING

from mcsl_core.lazy import lazy_names

if TYPE_CHECKING:
    from mcsl_core.alignment.aligned_views import AlignedPose, AlignedView
    from mcsl_core.alignment.correspondences import Correspondences
    from mcsl_core.alignment.protocol import Aligner, Alignment, Features, Matcher
    from mcsl_core.alignment.relief.protocol import (
        ReliefCamera,
        ReliefEstimator,
        ReliefScene,
        ReliefSurface,
        ReliefView,
    )
    from mcsl_core.alignment.tracking.fitting import Sighting, fit_view
    from mcsl_core.alignment.tracking.lamp import Lamp, LampView
    from mcsl_core.alignment.tracking.protocol import End, Instant, Tracker
    from mcsl_core.alignment.tracking.templates import Ground, Template
    from mcsl_core.arrays import read_arrays
    from mcsl_core.centering.protocol import Centerer, FieldPosition
    from mcsl_core.documents import make_converter, read_toml, structure_document, write_atomic
    from mcsl_core.edl import CenteringKey, Movement, Shot, Weak
    from mcsl_core.errors import Cancelled, DocumentError, Fault, InputError, McslError, PluginError, UsageError
    from mcsl_core.filling.protocol import FillContext, Filler
    from mcsl_core.hooks.registry import discover
    from mcsl_core.hooks.specs import hookimpl
    from mcsl_core.imaging.geometry import project, scaling, size_at_columns, transform_points
    from mcsl_core.imaging.masks import Mask, main_region
    from mcsl_core.imaging.planes import U8, Planes
    from mcsl_core.imaging.rect import Rect
    from mcsl_core.movement.protocol import Curve, Detection, MovementDetector
    from mcsl_core.occlusion.consensus import Consensus, Cut
    from mcsl_core.occlusion.protocol import OcclusionDetector, OcclusionScorer
    from mcsl_core.occlusion.score_table import ScoreTable
    from mcsl_core.outputs.claim import claim, claim_folder
    from mcsl_core.outputs.manifest import Manifest
    from mcsl_core.progress import Progress, Silent
    from mcsl_core.recording.footage import Footage
    from mcsl_core.recording.sample_store import Sample, SampleStore
    from mcsl_core.selection.protocol import Selector
    from mcsl_core.selection.selectors import sample_borders, shots_from, worth
    from mcsl_core.timing import FrameRange

__all__ = [
    "U8",
    "AlignedPose",
    "AlignedView",
    "Aligner",
    "Alignment",
    "Cancelled",
    "Centerer",
    "CenteringKey",
    "Consensus",
    "Correspondences",
    "Curve",
    "Cut",
    "Detection",
    "DocumentError",
    "End",
    "Fault",
    "Features",
    "FieldPosition",
    "FillContext",
    "Filler",
    "Footage",
    "FrameRange",
    "Ground",
    "InputError",
    "Instant",
    "Lamp",
    "LampView",
    "Manifest",
    "Mask",
    "Matcher",
    "McslError",
    "Movement",
    "MovementDetector",
    "OcclusionDetector",
    "OcclusionScorer",
    "Planes",
    "PluginError",
    "Progress",
    "Rect",
    "ReliefCamera",
    "ReliefEstimator",
    "ReliefScene",
    "ReliefSurface",
    "ReliefView",
    "Sample",
    "SampleStore",
    "ScoreTable",
    "Selector",
    "Shot",
    "Sighting",
    "Silent",
    "Template",
    "Tracker",
    "UsageError",
    "Weak",
    "claim",
    "claim_folder",
    "discover",
    "fit_view",
    "hookimpl",
    "main_region",
    "make_converter",
    "project",
    "read_arrays",
    "read_toml",
    "sample_borders",
    "scaling",
    "shots_from",
    "size_at_columns",
    "structure_document",
    "transform_points",
    "worth",
    "write_atomic",
]

__getattr__, __dir__ = lazy_names(
    __name__,
    {
        "mcsl_core.alignment.aligned_views": ("AlignedPose", "AlignedView"),
        "mcsl_core.alignment.correspondences": ("Correspondences",),
        "mcsl_core.alignment.protocol": ("Aligner", "Alignment", "Features", "Matcher"),
        "mcsl_core.alignment.relief.protocol": (
            "ReliefCamera",
            "ReliefEstimator",
            "ReliefScene",
            "ReliefSurface",
            "ReliefView",
        ),
        "mcsl_core.alignment.tracking.fitting": ("Sighting", "fit_view"),
        "mcsl_core.alignment.tracking.following": ("End", "Instant"),
        "mcsl_core.alignment.tracking.lamp": ("Lamp", "LampView"),
        "mcsl_core.alignment.tracking.protocol": ("Tracker",),
        "mcsl_core.alignment.tracking.templates": ("Ground", "Template"),
        "mcsl_core.arrays": ("read_arrays",),
        "mcsl_core.centering.protocol": ("Centerer", "FieldPosition"),
        "mcsl_core.documents": ("make_converter", "read_toml", "structure_document", "write_atomic"),
        "mcsl_core.edl": ("CenteringKey", "Movement", "Shot", "Weak"),
        "mcsl_core.errors": (
            "Cancelled",
            "DocumentError",
            "Fault",
            "InputError",
            "McslError",
            "PluginError",
            "UsageError",
        ),
        "mcsl_core.filling.protocol": ("FillContext", "Filler"),
        "mcsl_core.hooks.registry": ("discover",),
        "mcsl_core.hooks.specs": ("hookimpl",),
        "mcsl_core.imaging.geometry": ("project", "scaling", "size_at_columns", "transform_points"),
        "mcsl_core.imaging.masks": ("Mask", "main_region"),
        "mcsl_core.imaging.planes": ("U8", "Planes"),
        "mcsl_core.imaging.rect": ("Rect",),
        "mcsl_core.movement.protocol": ("Curve", "Detection", "MovementDetector"),
        "mcsl_core.occlusion.consensus": ("Consensus", "Cut"),
        "mcsl_core.occlusion.protocol": ("OcclusionDetector", "OcclusionScorer"),
        "mcsl_core.occlusion.score_table": ("ScoreTable",),
        "mcsl_core.outputs.claim": ("claim", "claim_folder"),
        "mcsl_core.outputs.manifest": ("Manifest",),
        "mcsl_core.progress": ("Progress", "Silent"),
        "mcsl_core.recording.footage": ("Footage",),
        "mcsl_core.recording.sample_store": ("Sample", "SampleStore"),
        "mcsl_core.selection.protocol": ("Selector",),
        "mcsl_core.selection.selectors": ("sample_borders", "shots_from", "worth"),
        "mcsl_core.timing": ("FrameRange",),
    },
)
