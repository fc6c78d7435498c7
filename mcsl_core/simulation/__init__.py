"""Makes the recording of a multi-camera surgical lamp with known truth: for tests, benchmarks and demonstrations.

World: mm, z up, the table about z = 0. Pixels: full-size, centres at integers. Times and frames in the truth are the
programme's, which are the reference camera's (the first's).
"""

from typing import TYPE_CHECKING

from mcsl_core.lazy import lazy_names

if TYPE_CHECKING:
    from .families import FAMILIES
    from .field_truth import true_field
    from .recorder import Recorder
    from .recording import simulate
    from .scenario import Scenario
    from .truth import PoseTruth, Truth, alignment_error, best_plane, best_plane_error, load_truth

__all__ = [
    "FAMILIES",
    "PoseTruth",
    "Recorder",
    "Scenario",
    "Truth",
    "alignment_error",
    "best_plane",
    "best_plane_error",
    "load_truth",
    "simulate",
    "true_field",
]

__getattr__, __dir__ = lazy_names(
    __name__,
    {
        f"{__name__}.families": ["FAMILIES"],
        f"{__name__}.field_truth": ["true_field"],
        f"{__name__}.recorder": ["Recorder"],
        f"{__name__}.recording": ["simulate"],
        f"{__name__}.scenario": ["Scenario"],
        f"{__name__}.truth": [
            "PoseTruth",
            "Truth",
            "alignment_error",
            "best_plane",
            "best_plane_error",
            "load_truth",
        ],
    },
)
