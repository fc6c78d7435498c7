"""Makes the recording of a multi-camera surgical lamp with known truth: for tests, benchmarks and demonstrations.

World: mm, z up, the table about z = 0. Pixels: full-size, centres at integers. Times and frames in the truth are the
programme's, which are the reference camera's (the first's).
"""

from .recorder import Recorder
from .recording import simulate
from .scenario import Scenario
from .truth import PoseTruth, Truth, alignment_error, best_plane, best_plane_error, load_truth

__all__ = [
    "PoseTruth",
    "Recorder",
    "Scenario",
    "Truth",
    "alignment_error",
    "best_plane",
    "best_plane_error",
    "load_truth",
    "simulate",
]
