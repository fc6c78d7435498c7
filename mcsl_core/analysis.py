"""From a recording to an EDL: sync, movements, poses, visible field, shots, centering. Reads like its description."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack, closing, contextmanager
from fractions import Fraction
from functools import lru_cache
from math import floor
from pathlib import Path

import attrs
import numpy as np
from attrs import field, frozen

from . import __version__, edl
from .anchoring import anchor
from .centering import FieldPlace, field_middle
from .cutting import moved_to, refine_cuts
from .decisions import carry_over, placed
from .errors import InputError, UsageError
from .evidence import SolvedPose, SolveSettings
from .footage import Footage
from .gaze import Gaze, read_gaze, resting_places
from .guards import Watch
from .media import fingerprint
from .plugins import Offer, Plugins
from .progress import Progress
from .recording import discover
from .samples import Samples
from .scene import scaling
from .scores import Detection, ScoreTable
from .scoring import Stretch, score_views, stretches
from .solving import solve_pose
from .stage_cache import CLOCKS, CUTS, DETECTION, POSES, SCORES, StageCache, code_digest, identity, key_of
from .stages import STAGES
from .sync import synchronise
from .timing import FrameRange, format_time
from .video import probe


@frozen
class AnalysisSettings:
    """What the caller may choose. reference: a camera name (the first without). rate: programme frames per second
    (the reference's without). stages: stage -> name of the plugin. sample_s: seconds between looks. gaze: files of
    where viewers looked (see `gaze`), which is centred in place of the field. cache: keep results of stages in a folder
    beside the EDL, and use those that are there."""

    reference: str | None = None
    rate: Fraction | None = None
    sync: str = "auto"
    stages: Mapping[str, str] = field(factory=dict)
    sample_s: float = 1.0
    solve: SolveSettings = field(factory=SolveSettings)
    gaze: tuple[Path, ...] = ()
    cache: bool = True


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
    reference = _reference(cameras, settings.reference)
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
    table.save(scores_path)
    edl.save(made, out)
    return made


def open_cameras(recording: Sequence[Path], base: Path, progress: Progress) -> tuple[edl.Camera, ...]:
    """The cameras of a recording, probed, clocks not yet set; media paths relative to ``base`` where possible."""
    found = discover(recording)
    if len(found) < 2:
        raise InputError(
            f"only one camera was found ({found[0][0]})",
            where=", ".join(str(p) for p in recording),
            remedy="Hand in the files of at least two cameras",
        )
    progress.stage("Opening the cameras", len(found), "cameras")
    cameras = []
    for number, (name, files) in enumerate(found):
        facts = [probe(path) for path in files]
        if len({f.size for f in facts}) > 1:
            raise InputError(
                "its files have different sizes: " + ", ".join(f"{w}x{h}" for w, h in (f.size for f in facts)),
                where=f"camera {name}",
                remedy="Hand them in as different cameras, or convert them to one size",
            )
        media = tuple(
            edl.Media(relative_path(path, base), fact.frames, fingerprint(path))
            for path, fact in zip(files, facts, strict=True)
        )
        cameras.append(edl.Camera(name, media, facts[0].size, facts[0].rate))
        progress.advance(number + 1)
    return tuple(cameras)


def relative_path(path: Path, base: Path) -> str:
    """``path`` relative to the folder ``base`` with forward slashes; absolute where there is no way (other drive)."""
    try:
        return Path(os.path.relpath(path.resolve(), base.resolve())).as_posix()
    except ValueError:
        return path.resolve().as_posix()


def programme_length(reference: edl.Camera, base: Path, rate: Fraction) -> int:
    """Frames of the programme: the reference camera's length at the programme's rate, at least 1."""
    seconds = sum(Fraction(probe(base / m.path).duration_s) for m in reference.media)
    return max(1, floor(seconds * rate + Fraction(1, 2)))


def _reference(cameras: Sequence[edl.Camera], name: str | None) -> edl.Camera:
    for camera in cameras:
        if name in (None, camera.name):
            return camera
    raise UsageError(
        f"there is no camera {name!r} to be the reference",
        remedy=f"Choose one of {', '.join(c.name for c in cameras)}",
    )


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
        def samples() -> Samples:
            return stack.enter_context(_looked(footage, cache, key, settings.sample_s, progress))

        def moved() -> Detection:
            return chosen["movement"].checked.detect(samples(), footage, progress)

        def posed() -> list[SolvedPose]:
            return _solve(samples(), footage, reference, detection.movements, chosen, settings, progress)

        def scored() -> ScoreTable:
            return score_views(samples(), solved, pieces(), detection.movements, progress)

        @lru_cache
        def pieces() -> tuple[Stretch, ...]:
            return stretches(samples(), solved, detection.movements, chosen["occlusion"])

        def refined() -> tuple[int, ...]:
            return refine_cuts(shots, footage, pieces(), detection.movements, progress)

        moves = key_of(key, identity(chosen["movement"]))
        detection = cache.remember("movements", moves, moved, DETECTION)
        poses = key_of(moves, reference, identity(chosen["matcher"]), identity(chosen["aligner"]), settings.solve)
        solved = cache.remember("poses", poses, posed, POSES)
        scores = key_of(poses, identity(chosen["occlusion"]))
        table = cache.remember("scores", scores, scored, SCORES)
        shots = chosen["selector"].checked.select(table, frames=footage.frames, rate=footage.rate)
        cuts = cache.remember("cuts", key_of(scores, [(s.range.start, s.camera) for s in shots]), refined, CUTS)
    return detection, solved, attrs.evolve(table, movement=detection.curve), moved_to(shots, cuts)


@contextmanager
def _looked(footage: Footage, cache: StageCache, key: str, step_s: float, progress: Progress) -> Iterator[Samples]:
    """The samples of ``footage``: those in the cache, or made now (into the cache, else into a temporary file)."""
    store = cache.file("samples", key)
    if store is not None and (found := Samples.load(store)) is not None:
        with closing(found):
            yield found
        return
    with tempfile.TemporaryDirectory(prefix="mcsl-samples-") as folder:
        if store is None:
            store = Path(folder) / "samples"
        else:
            store.parent.mkdir(parents=True, exist_ok=True)
        with closing(Samples.record(footage, store, progress, step_s=step_s)) as samples:
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
    samples: Samples,
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
        matrix = placed(made, made.pose_at(frame), camera)
        return None if matrix is None else np.array(matrix)

    found = resting_places(looks, place, frames=made.frames, size=made.size, rate=float(made.rate))
    return [FieldPlace(piece, middle) for piece, middle in found]


def _settings_json(settings: AnalysisSettings) -> dict[str, object]:
    """The settings as the EDL keeps them; which plugin did which stage stands beside them."""
    return {"sync": settings.sync, "sample_s": settings.sample_s, "solve": attrs.asdict(settings.solve)}


def summary(made: edl.Edl) -> dict[str, object]:
    """What was decided, for programs."""
    return {
        "frames": made.frames,
        "seconds": round(float(made.frames / made.rate), 3),
        "cameras": [c.name for c in made.cameras],
        "movements": [[m.range.start, m.range.stop] for m in made.movements],
        "shots": len(made.shots),
        "overrides": len(made.overrides),
        "weak": [{"pose": i, "camera": w.camera, "reason": w.reason} for i, p in enumerate(made.poses) for w in p.weak],
        "residual_px": [dict(p.residual_px) for p in made.poses],
    }


def describe(made: edl.Edl) -> str:
    """What was decided, in a few lines for people."""
    seconds = made.frames / made.rate
    lines = [
        f"{len(made.cameras)} cameras, {format_time(seconds)} at {float(made.rate):.6g} frames/s, "
        f"{len(made.shots)} shots, {len(made.overrides)} overrides"
    ]
    for movement in made.movements:
        start, stop = (format_time(f / made.rate) for f in (movement.range.start, movement.range.stop))
        lines.append(f"  the lamp moves from {start} to {stop} (confidence {movement.confidence:.0%})")
    for pose in made.poses:
        fits = ", ".join(f"{n} {v:.1f}" for n, v in pose.residual_px.items())
        at = format_time(pose.range.start / made.rate)
        lines.append(f"  pose from {at}, perspective {pose.perspective}: residual px {fits or 'none'}")
        lines += [f"    weak: {w.camera}: {w.reason}" for w in pose.weak]
    return "\n".join(lines)
