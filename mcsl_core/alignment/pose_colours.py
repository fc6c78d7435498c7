"""The colours of a pose: each camera's match to the reference camera, and keys where a camera drifts.

Every camera is brought to its own usual exposure and white balance, the reference camera as well, and from there to the
reference camera's usual colours: the programme does not pump, whichever camera it shows.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import attrs
import numpy as np
from attrs import field, frozen

from mcsl_core.edl import Colour, ColourKey, Movement, Pose
from mcsl_core.edl.colour import gains_at
from mcsl_core.edl.placement import still_part
from mcsl_core.imaging.exposure import Float, levelled
from mcsl_core.progress import Progress
from mcsl_core.recording.footage import Footage
from mcsl_core.recording.sample_store import SampleStore

from .agreed_colours import HARDLY, agreed_colours, steady_colours
from .aligned_views import Picture
from .drift import drift_keys
from .observations import SolvedPose


@frozen
class PoseColours:
    """What a pose says of colours; see `Pose`."""

    colour: Mapping[str, Colour] = field(factory=dict)
    colour_keys: Mapping[str, tuple[ColourKey, ...]] = field(factory=dict)

    def of(self, pose: Pose) -> Pose:
        """The pose with these colours."""
        return attrs.evolve(pose, colour=self.colour, colour_keys=self.colour_keys)


def follow_drift(
    samples: SampleStore,
    solved: Sequence[SolvedPose],
    footage: Footage,
    movements: Sequence[Movement],
    progress: Progress,
) -> list[PoseColours]:
    """The colours of every pose, matched anew where a camera drifts.

    Parameters
    ----------
    samples : SampleStore
        The recording's samples.
    solved : sequence of SolvedPose
        In order of time.
    footage : Footage
        Where pictures between the samples are read from, where colours change fast.
    movements : sequence of Movement
        Pictures in them say nothing.
    progress : Progress
        Told of every pose.

    Returns
    -------
    list of PoseColours
        One a pose. Without any drift the pose keeps the match it has; what it lacks another pose lends, or else what
        both cameras show steadily tells.
    """
    progress.stage("Following the cameras' colours", len(solved), "poses")
    found = []
    for pose in solved:
        still = still_part(pose.pose.range, movements)
        standing = samples.standing(still, movements)
        keys = {name: drift_keys(name, still, standing, samples, footage) for name in pose.aligned.homographies}
        keys = {name: own for name, own in keys.items() if own}
        colour = agreed_colours(pose.aligned, _levels(samples, pose, keys)) if keys else {}
        found.append(PoseColours(colour or pose.pose.colour, keys))
        progress.advance(len(found))
    cameras = [set(pose.aligned.homographies) - {pose.aligned.reference} for pose in solved]
    made = []
    for own, pose, names in zip(_lent(found, cameras), solved, cameras, strict=True):
        if lacking := names - own.colour.keys():
            shown = _levels(samples, pose, own.colour_keys)
            hardly = agreed_colours(pose.aligned, shown, HARDLY)
            known = {**own.colour, **{name: hardly[name] for name in lacking & hardly.keys()}}
            steady = steady_colours(pose.aligned, shown, names - known.keys())
            own = attrs.evolve(own, colour={**known, **steady})
        made.append(own)
    return made


def _lent(found: Sequence[PoseColours], cameras: Sequence[set[str]]) -> list[PoseColours]:
    """Cameras that a pose has no match of, as a head hides the field from them, have that of the nearest pose."""
    made = []
    for i, own in enumerate(found):
        lent = {}
        for name in sorted(cameras[i] - own.colour.keys()):
            others = [n for n, other in enumerate(found) if name in other.colour]
            if others:
                lent[name] = found[min(others, key=lambda n, i=i: abs(n - i))].colour[name]
        made.append(attrs.evolve(own, colour={**own.colour, **lent}) if lent else own)
    return made


def _levels(
    samples: SampleStore, pose: SolvedPose, keys: Mapping[str, Sequence[ColourKey]]
) -> list[dict[str, Picture | None]]:
    """The samples that the pose was solved from, each brought to its camera's usual exposure."""

    def level(position: int, name: str) -> Picture | None:
        picture = samples.picture(position, name)
        if picture is None or name not in keys:
            return picture
        gains: Float = np.array(gains_at(keys[name], samples.shown_frame(position, name))[::-1], np.float32)
        return levelled(picture, gains)

    return [{name: level(at, name) for name in samples.cameras} for at in pose.samples]
