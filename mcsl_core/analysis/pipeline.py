"""From a recording to an EDL: sync, movements, poses, visible field, shots, centering. Reads like its description."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack, closing, contextmanager
from fractions import Fraction
from functools import partial
from pathlib import Path
from typing import Any

import attrs
from threadpoolctl import threadpool_limits

from mcsl_core import __version__, edl
from mcsl_core.alignment.observations import SolvedPose
from mcsl_core.alignment.pose_colours import follow_drift
from mcsl_core.alignment.pose_solver import PoseSolver
from mcsl_core.alignment.poses import solve_poses
from mcsl_core.alignment.tracking.followed_poses import PosePlacer
from mcsl_core.alignment.tracking.movement_views import follow_movements
from mcsl_core.centering.gaze_files import GazeFile, Shown, read_gaze
from mcsl_core.centering.positions import field_positions, gaze_positions, looks_unplaced
from mcsl_core.centering.protocol import Centerer, FieldPosition
from mcsl_core.edl import edits
from mcsl_core.errors import UsageError
from mcsl_core.hooks.registry import Offer, Plugins
from mcsl_core.hooks.stages import STAGES
from mcsl_core.hooks.watch import Watch
from mcsl_core.occlusion.scoring import score_views, scoring_segments
from mcsl_core.progress import Progress, Steps
from mcsl_core.recording.cameras import choose_reference, open_cameras, programme_length
from mcsl_core.recording.damage import DamageOf, damage_met, damage_of, with_gaps
from mcsl_core.recording.footage import Footage
from mcsl_core.recording.sample_store import SampleStore
from mcsl_core.selection.choice import Choice
from mcsl_core.selection.close_looks import look_around_movements, look_closer
from mcsl_core.selection.merits import pose_merits
from mcsl_core.selection.switch_refinement import refine_switches, with_switches_at
from mcsl_core.sync.synchronise import synchronise
from mcsl_core.temporary import temporary_folder

from .cache import (
    AROUND,
    CLOCKS,
    CLOSER,
    COLOURS,
    CUTS,
    DAMAGE,
    DAMAGE_MET,
    FOLLOWED,
    MERITS,
    MOVEMENTS,
    PLACED,
    POSES,
    SCORES,
    Deferred,
    StageCache,
)
from .fields import drawn_before, field_stretches, tell_of_fields, without_claims
from .measurements import Measurements
from .place import EdlPlace, cache_folder
from .settings import AnalysisSettings
from .stage_keys import clocks_key, damage_key, stage_keys

_BLAS_THREADS = 1  # for small matrices: threads that wait for each other on a busy machine took 200 times as long


def analyse(
    recording: Sequence[Path],
    out: Path,
    *,
    settings: AnalysisSettings,
    plugins: Plugins,
    force: bool = False,
    progress: Progress,
) -> edl.Edl:
    """Analyses ``recording`` (a folder, or camera files in order), writes the EDL to ``out`` and returns it.

    An EDL that lies there already keeps its overrides, corrections, drawn fields and look, those as well that are
    written while the analysis is at work. Anything else that lies there is replaced where ``force`` says so; the
    recording never. Raises InputError where a file is refused or another analysis is at work on ``out``, and Cancelled
    with nothing written.
    """
    chosen = _chosen(settings, plugins)
    place = EdlPlace.claimed(out, recording, settings.gaze, force=force)
    with place.held(), threadpool_limits(_BLAS_THREADS, user_api="blas"):
        made = _analysed(recording, place, settings, chosen, progress)
        remembered = edl.remember(made, out)  # before anything is told: a note may stop the work
        tell_of_fields(made, progress)
        if not remembered:
            progress.note("that this EDL was made here cannot be remembered: other commands will want --allow-outside")
    return made


def _analysed(
    recording: Sequence[Path],
    place: EdlPlace,
    settings: AnalysisSettings,
    chosen: Mapping[str, Offer],
    progress: Progress,
) -> edl.Edl:
    steps = Steps(progress, _steps(settings))
    cameras = open_cameras(recording, place.path.parent, progress)
    reference = choose_reference(cameras, settings.reference)
    rate = settings.rate or reference.rate
    cache = StageCache(cache_folder(place.path) if settings.cache else None, progress, steps)
    footage = _on_one_clock(cameras, reference.name, place.path.parent, rate, settings, cache, progress)
    footage = _with_gaps(footage, cache.remember(DAMAGE, damage_key(cameras), damage_of, footage, progress), progress)
    cameras, frames, sizes = footage.cameras, footage.frames, {camera.name: camera.size for camera in footage.cameras}
    drawn = _kept_decisions(place.before, reference, footage, progress)
    gaze = _read_gaze(settings.gaze, Shown(float(rate), frames, reference.size, sizes), progress)
    keys = stage_keys(cameras, reference.name, rate, frames, settings, chosen, drawn)
    by = _by(chosen, Watch(float(frames / rate), progress.note))
    with ExitStack() as opened:
        samples = Deferred(opened.enter_context, _samples(footage, cache, keys.samples, settings.sample_s, progress))
        met = cache.remember(DAMAGE_MET, keys.samples, damage_met, footage, samples, progress)
        footage = _with_gaps(footage, met, progress)
        detection = cache.remember(MOVEMENTS, keys.movements, by["movement"].detect, samples, footage, progress)
        solver = PoseSolver(sizes, reference.name, by["matcher"], by["aligner"], settings.solve, by["relief"])
        movements = detection.movements
        solved = cache.remember(POSES, keys.poses, solve_poses, solver, samples, movements, frames, progress, drawn)
        if settings.movement_view == "follow":
            placer = Deferred(PosePlacer, samples, footage, movements, reference.name)
            solved = cache.remember(PLACED, keys.placed, PosePlacer.place, placer, solved, progress)
            follow = partial(follow_movements, reference=reference.name, tracker=by["tracker"])
            movements = cache.remember(FOLLOWED, keys.followed, follow, samples, solved, movements, footage, progress)
        colours = cache.remember(COLOURS, keys.colours, follow_drift, samples, solved, footage, movements, progress)
        segments = Deferred(scoring_segments, samples, solved, movements, by["occlusion"])
        table = cache.remember(SCORES, keys.scores, score_views, samples, solved, segments, movements, progress)
        where = footage, segments, movements
        table = cache.remember(AROUND, keys.around, look_around_movements, table, *where, progress)
        merits = cache.remember(MERITS, keys.merits, pose_merits, samples, solved, movements, progress)
        ranges, spans = [s.pose.range for s in solved], {c.name: footage.span_s(c.name) for c in footage.cameras}
        choice = Choice(by["selector"], ranges, merits, footage.cameras, spans, frames, rate)
        look = partial(look_closer, choose=choice.shots, progress=progress)
        table = cache.remember(CLOSER, keys.closer, look, table, *where)
        shots, table = choice.shots(table), choice.measured(table)
        refine = partial(refine_switches, min_shot_s=by["selector"].min_shot_s)
        cuts = cache.remember(CUTS, keys.cuts(shots, by["selector"].min_shot_s), refine, shots, *where, progress)
    fields = field_stretches(solved, drawn)
    made = edl.Edl(
        rate=rate,
        size=reference.size,
        frames=frames,
        reference=reference.name,
        cameras=footage.cameras,
        movements=movements,
        poses=tuple(own.of(pose.pose) for own, pose in zip(colours, solved, strict=True)),
        shots=without_claims(with_switches_at(shots, cuts), fields),
        fields=fields,
        scores=place.scores.name,
        made_by=_made_by(settings, chosen, gaze),
    )
    return _saved(made, place, Measurements(table, detection.curve), solved, gaze, by["centerer"], progress)


def _steps(settings: AnalysisSettings) -> list[str]:
    """All that `_analysed` does which takes its time, in order."""
    following = (PLACED, FOLLOWED) if settings.movement_view == "follow" else ()
    before, after = (CLOCKS, DAMAGE, DAMAGE_MET, MOVEMENTS, POSES), (COLOURS, SCORES, AROUND, MERITS, CLOSER, CUTS)
    return ["cameras", *(stage.name for stage in (*before, *following, *after))]


def _saved(
    made: edl.Edl,
    place: EdlPlace,
    measured: Measurements,
    solved: Sequence[SolvedPose],
    gaze: Sequence[GazeFile],
    centerer: Centerer,
    progress: Progress,
) -> edl.Edl:
    """The EDL, centered and with what was decided in the one that lies there, as it lies there now."""
    with place.changing() as there:
        made = made if there is None else edits.carry_over(there, made)
        positions = _gazed_at(gaze, made, progress) if gaze else field_positions(solved, made.size)
        made = attrs.evolve(made, centering=centerer.centre(positions, size=made.size, rate=float(made.rate)))
        measured.save(place.scores)
        edl.save(made, place.path)
    return made


def _by(chosen: Mapping[str, Offer], watch: Watch) -> dict[str, Any]:
    """Stage -> who does it, behind checks."""
    return {stage: attrs.evolve(offer, watch=watch).checked for stage, offer in chosen.items()}


def _kept_decisions(
    before: edl.Edl | None, reference: edl.Camera, footage: Footage, progress: Progress
) -> tuple[edl.DrawnField, ...]:
    """Before the long work, whether what was decided can be kept; the fields that were drawn."""
    if before is not None:
        now = edits.Counted(footage.rate, footage.frames, reference.size, reference.name, footage.cameras)
        edits.check_decisions(before, now)
        if told := edits.other_media(before, now):
            progress.note(told)
    return drawn_before(before, reference.name, footage.frames)


def _with_gaps(footage: Footage, damage: DamageOf, progress: Progress) -> Footage:
    """``footage`` whose cameras know where their files are damaged."""
    cameras = with_gaps(footage, damage, progress)
    if cameras == footage.cameras:
        return footage
    return Footage(cameras, rate=footage.rate, frames=footage.frames, base=footage.base)


def _on_one_clock(
    cameras: Sequence[edl.Camera],
    reference: str,
    base: Path,
    rate: Fraction,
    settings: AnalysisSettings,
    cache: StageCache,
    progress: Progress,
) -> Footage:
    """The cameras with their clocks, over the length of the programme."""
    key = clocks_key(cameras, reference, settings)
    clocks = cache.remember(CLOCKS, key, synchronise, settings.sync, cameras, base, progress, reference=reference)
    timed = [attrs.evolve(camera, clock=clock) for camera, clock in zip(cameras, clocks, strict=True)]
    frames = programme_length(Footage(timed, rate=rate, frames=1, base=base), reference, progress)
    return Footage(timed, rate=rate, frames=frames, base=base)


def _chosen(settings: AnalysisSettings, plugins: Plugins) -> dict[str, Offer]:
    """Who does each stage, ready to work."""
    unknown = set(settings.stages) - set(STAGES)
    if unknown:
        raise UsageError(f"there is no stage {unknown.pop()!r}", remedy=f"Stages are {', '.join(STAGES)}")
    chosen = {stage: plugins.choose(stage, settings.stages.get(stage)) for stage in STAGES}
    if settings.movement_view == "hold":  # nobody follows: nothing is prepared for it, and the EDL names nobody
        del chosen["tracker"]
    for offer in chosen.values():
        offer.prepare()
    return chosen


@contextmanager
def _samples(footage: Footage, cache: StageCache, key: str, step_s: float, progress: Progress) -> Iterator[SampleStore]:
    """The samples of ``footage``: those in the cache, or made now (into the cache, else into a temporary file)."""
    store = cache.file("samples", key)
    if store is not None and (found := SampleStore.load(store)) is not None:
        with closing(found):
            yield found
        return
    with ExitStack() as opened:
        if store is None:  # else nothing temporary: a killed run would leave it, and the next has its samples
            store = opened.enter_context(temporary_folder("samples")) / "samples"
        with closing(SampleStore.record(footage, store, progress, step_s=step_s)) as samples:
            cache.prune("samples", kept=2)  # the pictures and their contents; some 20 MB a minute
            yield samples


def _read_gaze(paths: Sequence[Path], shown: Shown, progress: Progress) -> list[GazeFile]:
    """The files of gaze; how many looks of how many are used is told of each."""
    files = []
    for path in paths:
        files.append(read_gaze(path, shown))
        progress.note(f"{path}: {files[-1]}")
    return files


def _gazed_at(files: Sequence[GazeFile], made: edl.Edl, progress: Progress) -> list[FieldPosition]:
    """What viewers looked at."""
    looks = [look for file in files for look in file.looks]
    if unplaced := looks_unplaced(looks, made):
        progress.note(f"{unplaced} of {len(looks)} looks are at cameras whose place in the programme is not known then")
    return gaze_positions(looks, made)


def _made_by(settings: AnalysisSettings, chosen: Mapping[str, Offer], gaze: Sequence[GazeFile]) -> edl.MadeBy:
    """The settings as the EDL keeps them; which plugin did which stage stands beside them."""
    kept: dict[str, Any] = {
        "sync": settings.sync,
        "sample_s": settings.sample_s,
        "solve": attrs.asdict(settings.solve),
    }
    if gaze:
        kept["gaze"] = [{"file": f.path.name, "samples": f.samples, "used": len(f.looks)} for f in gaze]
    return edl.MadeBy(__version__, kept, {stage: str(offer) for stage, offer in chosen.items()})
