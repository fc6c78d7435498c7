"""What the results of the analysis's stages depend on: media, settings, code, and the results they are made from.

A key holds the media's fingerprints, the settings, and the code of whatever makes the result (`code_of`), so that a
plugin that is being written is never answered from yesterday's version of itself. What a stage consumes is in its key
by that stage's own. Code that makes nothing (charts, commands, reports) is in none.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping, Sequence
from fractions import Fraction

from attrs import frozen

from mcsl_core.alignment.pose_colours import follow_drift
from mcsl_core.alignment.poses import solve_poses
from mcsl_core.alignment.tracking.followed_poses import PosePlacer
from mcsl_core.alignment.tracking.movement_views import follow_movements
from mcsl_core.code_keys import code_of
from mcsl_core.edl import Camera, DrawnField, Shot
from mcsl_core.hooks.registry import Offer
from mcsl_core.occlusion.scoring import score_views
from mcsl_core.recording.damage import damage_of
from mcsl_core.recording.sample_store import SampleStore
from mcsl_core.selection.choice import Choice
from mcsl_core.selection.close_looks import look_around_movements, look_closer
from mcsl_core.selection.merits import pose_merits
from mcsl_core.selection.switch_refinement import refine_switches
from mcsl_core.sync.synchronise import synchronise

from .settings import AnalysisSettings


@frozen
class StageKeys:
    """The keys of one analysis, each in the next."""

    clocks: str
    samples: str
    movements: str
    poses: str
    placed: str
    followed: str
    colours: str
    merits: str
    scores: str
    around: str
    closer: str

    def cuts(self, shots: Sequence[Shot], min_shot_s: float) -> str:
        """Of the switches refined, which depend on what the selector chose and promises, however it did."""
        chosen = [(shot.range.start, shot.camera) for shot in shots]
        return key_of(self.scores, code_of(refine_switches), chosen, min_shot_s)


def stage_keys(
    cameras: Sequence[Camera],
    reference: str,
    rate: Fraction,
    frames: int,
    settings: AnalysisSettings,
    chosen: Mapping[str, Offer],
    drawn: Sequence[DrawnField] = (),
) -> StageKeys:
    """The keys for a recording. cameras: with their media's fingerprints. chosen: stage -> who does it."""
    by = {stage: identity(offer) for stage, offer in chosen.items()}
    clocks = clocks_key(cameras, reference, settings)
    samples = key_of(code_of(SampleStore), clocks, damage_key(cameras), rate, frames, settings.sample_s)
    movements = key_of(samples, by["movement"])
    poses = key_of(
        code_of(solve_poses), movements, reference, by["matcher"], by["aligner"], by["relief"], settings.solve
    )
    if drawn:
        poses = key_of(poses, [(each.range.start, each.range.stop, each.polygons) for each in drawn])
    placed = key_of(code_of(PosePlacer), poses)
    followed = key_of(code_of(follow_movements), placed, by.get("tracker"))
    own, seen = (placed, followed) if settings.movement_view == "follow" else (poses, poses)
    colours = key_of(code_of(follow_drift), own)
    merits = key_of(code_of(pose_merits), own)
    scores = key_of(code_of(score_views), seen, by["occlusion"])
    around = key_of(code_of(look_around_movements), scores)
    closer = key_of(code_of(look_closer, Choice), around, merits, by["selector"])
    return StageKeys(clocks, samples, movements, poses, placed, followed, colours, merits, scores, around, closer)


def clocks_key(cameras: Sequence[Camera], reference: str, settings: AnalysisSettings) -> str:
    """Of the cameras' clocks, on which the programme's length depends, and with it all that comes after."""
    return key_of(code_of(synchronise), _media(cameras), reference, settings.sync)


def damage_key(cameras: Sequence[Camera]) -> str:
    """Of what is damaged in the files, whatever the settings are."""
    return key_of(code_of(damage_of), _media(cameras))


def _media(cameras: Sequence[Camera]) -> list[list[str]]:
    return [[camera.name, *(media.fingerprint for media in camera.media)] for camera in cameras]


def identity(offer: Offer) -> tuple[str, str, str]:
    """What an offer's results depend on: its package and version, its settings, its code.

    Settings are what its repr shows; object's own shows an address, which would be another in every process. mcsl's own
    version says nothing that the code does not.
    """
    kind = type(offer.implementation)
    settings = kind.__qualname__ if kind.__repr__ is object.__repr__ else repr(offer.implementation)
    return offer.name if offer.package == "mcsl" else str(offer), settings, code_of(kind)


def key_of(*parts: object) -> str:
    """A short key of plain values: equal parts, equal key."""
    text = json.dumps(parts, default=repr, sort_keys=True)
    return hashlib.sha256(text.encode("utf-8", "surrogatepass")).hexdigest()[:24]
