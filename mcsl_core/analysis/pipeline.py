"""From a recording to an EDL: sync, movements, poses, visible field, shots, centering. Reads like its description."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack, closing, contextmanager
from functools import lru_cache
from pathlib import Path

import attrs
import numpy as np

from mcsl_core import __version__, edl
from mcsl_core.alignment.anchoring import anchor
from mcsl_core.alignment.observations import SolvedPose
from mcsl_core.alignment.pose_solver import solve_pose
from mcsl_core.centering.field import field_middle
from mcsl_core.centering.gaze import Gaze, fixations, read_gaze
from mcsl_core.centering.protocol import FieldPlace
from mcsl_core.edl.edits import carry_over
from mcsl_core.edl.placement import placement_matrix
from mcsl_core.errors import UsageError
from mcsl_core.hooks.guards import Watch
from mcsl_core.hooks.registry import Offer, Plugins
from mcsl_core.hooks.stages import STAGES
from mcsl_core.imaging.geometry import scaling
from mcsl_core.movement.protocol import Detection
from mcsl_core.occlusion.score_table import ScoreTable
from mcsl_core.occlusion.scoring import ScoringSegment, score_views, scoring_segments
from mcsl_core.progress import Progress
from mcsl_core.recording.cameras import choose_reference, open_cameras, programme_length
from mcsl_core.recording.footage import Footage
from mcsl_core.recording.sample_store import SampleStore
from mcsl_core.selection.switch_refinement import refine_switches, with_switches_at
from mcsl_core.sync.synchronise import synchronise
from mcsl_core.timing import FrameRange

from .cache import CLOCKS, CUTS, DETECTION, POSES, SCORES, StageCache, code_digest, identity, key_of
from .measurements import Measurements
from .settings import AnalysisSettings


def analyse(
    recording: Sequence[Path],
    out: Path,
    *,
    settings: AnalysisSettings,
    plugins: Plugins,
    progress: Progress,
) -> edl.Edl:
    """Analyses ``recording`` (a folder, or camera files in order), writes the EDL to ``out`` and returns it.

    An EDL that lies there already keeps its overrides and look. Raises InputError where a file is refused, and
    Cancelled with nothing written.
    """
    unknown = set(settings.stages) - set(STAGES)
    if unknown:
        raise UsageError(f"there is no stage {unknown.pop()!r}", remedy=f"Stages are {', '.join(STAGES)}")
    chosen = {stage: plugins.choose(stage, settings.stages.get(stage)) for stage in STAGES}
    for offer in chosen.values():
        offer.prepare()
    before = edl.load(out) if out.exists() else None

    cameras = open_cameras(recording, out.parent, progress)
    reference = choose_reference(cameras, settings.reference)
    out.parent.mkdir(parents=True, exist_ok=True)  # media paths lead through it
    cache = StageCache(cache_folder(out) if settings.cache else None, progress)
    media = [[c.name, *(m.fingerprint for m in c.media)] for c in cameras]
    key = key_of(code_digest("mcsl_core"), media, reference.name, settings.sync)

    def clocked() -> tuple[edl.Clock, ...]:
        return synchronise(settings.sync, cameras, out.parent, progress, reference=reference.name)

    clocks = cache.remember("clocks", key, clocked, CLOCKS)
    cameras = tuple(attrs.evolve(c, clock=clock) for c, clock in zip(cameras, clocks, strict=True))
    rate = settings.rate or reference.rate
    frames = programme_length(reference, out.parent, rate)
    footage = Footage(cameras, rate=rate, frames=frames, base=out.parent)
    looks = read_gaze(settings.gaze, rate=float(rate), cameras=[c.name for c in cameras])
    watch = Watch(float(frames / rate), progress.note)
    chosen = {stage: attrs.evolve(offer, watch=watch) for stage, offer in chosen.items()}
    detection, solved, table, shots = _looked_into(
        footage, reference.name, key_of(key, rate, frames, settings.sample_s), cache, chosen, settings, progress
    )
    movements = detection.movements
    scores_path = out.with_name(f"{out.stem}.scores.npz")
    made = edl.Edl(
        rate=rate,
        size=reference.size,
        frames=frames,
        reference=reference.name,
        cameras=cameras,
        movements=movements,
        poses=tuple(s.pose for s in solved),
        shots=shots,
        scores=scores_path.name,
        made_by=edl.MadeBy(
            __version__, _settings_json(settings), {stage: str(offer) for stage, offer in chosen.items()}
        ),
    )
    if before is not None:
        made = carry_over(before, made)
    places = gaze_places(looks, made) if settings.gaze else [_field_place(s, made.size) for s in solved]
    keys = chosen["centerer"].checked.centre(places, size=made.size, rate=float(rate))
    made = attrs.evolve(made, centering=tuple(keys))
    Measurements(table, detection.curve).save(scores_path)
    edl.save(made, out)
    return made


def _looked_into(
    footage: Footage,
    reference: str,
    key: str,
    cache: StageCache,
    chosen: Mapping[str, Offer],
    settings: AnalysisSettings,
    progress: Progress,
) -> tuple[Detection, list[SolvedPose], ScoreTable, tuple[edl.Shot, ...]]:
    """What the pictures say: movements, poses, visible field, shots. ``key`` stands for all that the samples depend on.

    The samples are looked at only where a stage's result is not in the cache.
    """
    with ExitStack() as stack:

        @lru_cache
        def samples() -> SampleStore:
            return stack.enter_context(_looked(footage, cache, key, settings.sample_s, progress))

        def moved() -> Detection:
            return chosen["movement"].checked.detect(samples(), footage, progress)

        def posed() -> list[SolvedPose]:
            return _solve(samples(), footage, reference, detection.movements, chosen, settings, progress)

        def scored() -> ScoreTable:
            return score_views(samples(), solved, pieces(), detection.movements, progress)

        @lru_cache
        def pieces() -> tuple[ScoringSegment, ...]:
            return scoring_segments(samples(), solved, detection.movements, chosen["occlusion"].checked)

        def refined() -> tuple[int, ...]:
            return refine_switches(shots, footage, pieces(), detection.movements, progress)

        moves = key_of(key, identity(chosen["movement"]))
        detection = cache.remember("movements", moves, moved, DETECTION)
        poses = key_of(moves, reference, identity(chosen["matcher"]), identity(chosen["aligner"]), settings.solve)
        solved = cache.remember("poses", poses, posed, POSES)
        scores = key_of(poses, identity(chosen["occlusion"]))
        table = cache.remember("scores", scores, scored, SCORES)
        shots = chosen["selector"].checked.select(table, frames=footage.frames, rate=footage.rate)
        cuts = cache.remember("cuts", key_of(scores, [(s.range.start, s.camera) for s in shots]), refined, CUTS)
    return detection, solved, table, with_switches_at(shots, cuts)


@contextmanager
def _looked(footage: Footage, cache: StageCache, key: str, step_s: float, progress: Progress) -> Iterator[SampleStore]:
    """The samples of ``footage``: those in the cache, or made now (into the cache, else into a temporary file)."""
    store = cache.file("samples", key)
    if store is not None and (found := SampleStore.load(store)) is not None:
        with closing(found):
            yield found
        return
    with tempfile.TemporaryDirectory(prefix="mcsl-samples-") as folder:
        if store is None:
            store = Path(folder) / "samples"
        else:
            store.parent.mkdir(parents=True, exist_ok=True)
        with closing(SampleStore.record(footage, store, progress, step_s=step_s)) as samples:
            cache.prune("samples", kept=2)  # the pictures and their contents; some 20 MB a minute
            yield samples


def cache_folder(out: Path) -> Path:
    """Where the results of the stages lie: beside the EDL ``out``. It may be deleted at any time."""
    return out.with_name(f"{out.stem}.cache")


def pose_ranges(movements: Sequence[edl.Movement], frames: int) -> list[FrameRange]:
    """Stretches between the middles of the movements; they tile [0, frames)."""
    middles = [(m.range.start + m.range.stop) // 2 for m in movements]
    cuts = [0, *(m for m in middles if 0 < m < frames), frames]
    return [FrameRange(a, b) for a, b in zip(cuts, cuts[1:], strict=False)]


def _solve(
    samples: SampleStore,
    footage: Footage,
    reference: str,
    movements: Sequence[edl.Movement],
    chosen: Mapping[str, Offer],
    settings: AnalysisSettings,
    progress: Progress,
) -> list[SolvedPose]:
    """Every pose in order, each anchored to those before."""
    sizes = {c.name: c.size for c in footage.cameras}
    matcher = chosen["matcher"].checked
    solved: list[SolvedPose] = []
    pieces = pose_ranges(movements, footage.frames)
    progress.stage("Aligning the views", len(pieces), "poses")
    for piece in pieces:
        pose = solve_pose(
            piece,
            samples.standing(piece, movements) or samples.within(piece),
            samples,
            sizes,
            reference=reference,
            matcher=matcher,
            aligner=chosen["aligner"].checked,
            settings=settings.solve,
            progress=progress,
        )
        solved.append(anchor(pose, solved, samples, matcher=matcher, settings=settings.solve, progress=progress))
        progress.advance(len(solved))
    return solved


def _field_place(solved: SolvedPose, size: tuple[int, int]) -> FieldPlace:
    to_programme = np.array(solved.pose.anchor) @ scaling(solved.scene.size, size)
    return FieldPlace(solved.pose.range, field_middle(solved.scene.field, to_programme))


def gaze_places(looks: Sequence[Gaze], made: edl.Edl) -> list[FieldPlace]:
    """Where viewers looked, in the programme of ``made``: what is centred in place of the field."""

    def place(frame: int, camera: str) -> np.ndarray | None:
        matrix = placement_matrix(made, made.pose_at(frame), camera)
        return None if matrix is None else np.array(matrix)

    found = fixations(looks, place, frames=made.frames, size=made.size, rate=float(made.rate))
    return [FieldPlace(piece, middle) for piece, middle in found]


def _settings_json(settings: AnalysisSettings) -> dict[str, object]:
    """The settings as the EDL keeps them; which plugin did which stage stands beside them."""
    return {"sync": settings.sync, "sample_s": settings.sample_s, "solve": attrs.asdict(settings.solve)}
