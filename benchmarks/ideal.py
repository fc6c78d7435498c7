"""How far programmes are from the ideal one, on simulated recordings whose truth is known.

    python -m benchmarks.ideal FOLDER [--tuning] [--again] [NAME ...]    makes what is missing, writes results/ideal.md

NAME is a seed of the plain scene, such as 701, or a family with its seed, such as suturing:601 (see families.py).
FOLDER keeps recordings, analyses and figures: what is there is used; --again measures and analyses anew. The page has
the rows that FOLDER has figures of; seeds to tune on are kept out of it, and with --tuning the others.

The ideal programme is what a camera would show that hung still where the reference camera stands in the first pose
(`mcsl simulate --ideal`). Every variant is made by the compositor, without centering and fill, with colours matched;
the floor by the truth's own geometry.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Mapping, Sequence
from fractions import Fraction
from pathlib import Path
from typing import Any

import attrs
import cv2
import numpy as np
from attrs import frozen
from numpy.typing import NDArray

from benchmarks.accuracy import by_hand, by_truth
from benchmarks.families import KINDS
from benchmarks.ideal_distance import Distance, distance, means, occasions
from benchmarks.ideal_geometry import (
    AROUND,
    TrueGeometry,
    best_planes,
    decisions,
    displacements,
    drilled,
    in_movements,
    jumps,
    spread,
    switches,
)
from benchmarks.ideal_hands import Hands, Mask
from benchmarks.ideal_page import markdown
from mcsl_core import edl
from mcsl_core.analysis.pipeline import analyse
from mcsl_core.analysis.settings import AnalysisSettings
from mcsl_core.compositing.compositor import Compositor
from mcsl_core.evaluation.evaluate import without_alignment
from mcsl_core.evaluation.manual_alignment import aligned_by_hand
from mcsl_core.hooks.registry import discover
from mcsl_core.imaging.planes import Planes
from mcsl_core.media.frames import to_planes
from mcsl_core.media.probing import probe
from mcsl_core.media.reading import VideoReader
from mcsl_core.progress import Silent
from mcsl_core.recording.footage import Footage
from mcsl_core.simulation import Scenario, Truth, load_truth, simulate
from mcsl_core.simulation.ideal import FIELD, FILM, FOLDER
from mcsl_core.simulation.scenario import DRAPES, GLOVES, SKINS
from mcsl_core.timing import FrameRange

RESULTS = Path(__file__).parent / "results"
TUNING, FINAL = (
    (*range(501, 507), 702, 703, 705, 706, 709, 713, 714, 715, 717, 720, 721, 724, 728),
    (719, 722, 723, 725, 726, 727, 729, 730),
)
AIDS = ("surface", "see_through")
"""Looks that lay pictures otherwise than planes do, each a variant with those before it, where the programme has it."""


def scenario(name: str) -> Scenario:
    """The scene of that name."""
    kind, _, few = name.rpartition(":")
    seed = int(few)
    if kind:
        return KINDS[kind].scenario(seed)
    n, poses_s = seed % 100, 12  # in less the reference camera may be hidden all through the first pose
    moves = (1, 2, 1, 1, 3, 1)[n % 6]
    return Scenario(
        seed=seed, duration_s=poses_s * (moves + 1), size=(640, 360), rate=10, heads=3 + n % 2,
        movements=tuple((poses_s * (i + 1) - 1.0, 1.2 + 0.3 * (n % 5)) for i in range(moves)),
        relief_mm=(10, 20, 30, 40, 50, 60)[n % 6], drape=DRAPES[n % len(DRAPES)], skin=SKINS[n % len(SKINS)],
        gloves=GLOVES[(n + 2) % len(GLOVES)],
    )  # fmt: skip


@frozen
class Variant:
    """A programme that is held against the ideal one.

    Attributes
    ----------
    name
        In figures and tables.
    edl, look
        What the compositor makes it of.
    surface
        Whether the reliefs lay its pictures.
    """

    name: str
    edl: edl.Edl
    look: edl.Look
    surface: bool = False


def variants(made: edl.Edl, truth: Truth) -> list[Variant]:
    """Those that this programme has."""
    here = [name for name in AIDS if name in attrs.fields_dict(edl.Look)]
    # Filled or not, the field is the same but for what little of it the chosen camera misses, at twenty times the cost.
    plane = edl.Look(centering=False, fill=False, colour=True, **dict.fromkeys(here, False))
    found = [
        Variant("no", without_alignment(made), plane),
        Variant("manual", aligned_by_hand(made, by_hand(made, truth, truth.scenario.seed)), plane),
        Variant("best plane", aligned_by_hand(made, by_truth(made, truth)), plane),
        Variant("plane", made, plane),
    ]
    if any(pose.relief for pose in made.poses):
        for n, name in enumerate(here):
            found.append(Variant(name, made, attrs.evolve(plane, **dict.fromkeys(here[: n + 1], True)), surface=True))
    return found


# ------------------------------------------------------------------------------------------------------- a recording


def measure(folder: Path, name: str, *, again: bool = False) -> dict[str, Any]:
    """Everything about one recording; kept as JSON beside it."""
    word = name.replace(":", "-")
    source, out, kept = folder / word, folder / f"{word}.edl" / "edl.json", folder / f"{word}.ideal.json"
    if kept.exists() and not again:
        return json.loads(kept.read_text("utf-8"))
    if not (source / FOLDER / FILM).exists():
        simulate(scenario(name), source, Silent(), ideal=True)
    truth = load_truth(source)
    if again or not out.exists():
        analyse([source], out, settings=AnalysisSettings(), plugins=discover(), progress=Silent())
    made = edl.load(out)
    figures = {"name": name, "scene": scene_of(truth), **of_geometry(made, truth)}
    figures["distance"] = of_pictures(made, truth, source, out.parent)
    kept.write_text(json.dumps(figures, indent=1) + "\n", "utf-8")
    return figures


def scene_of(truth: Truth) -> str:
    """What a recording shows, in words."""
    s = truth.scenario
    words = [*s.families, f"{s.relief_mm:.0f} mm", f"{s.drape} drape", f"{s.skin} skin"]
    return ", ".join([*words, f"{len(truth.movements)} movements"])


def of_geometry(made: edl.Edl, truth: Truth) -> dict[str, Any]:
    """Displacements of the field's points by view, and their jumps at switches."""
    own = {v.name: v for v in variants(made, truth)}
    ways = {name: displacements(v.edl, truth, surface=v.surface) for name, v in own.items() if name in ("plane", *AIDS)}
    ways["best plane"] = best_planes(made, truth)
    views = [
        {"pose": pose, "camera": camera, **{name: spread(way[pose, camera]) for name, way in ways.items()}}
        for pose, camera in ways["plane"]
    ]
    pooled = {name: spread(np.concatenate(list(way.values()))) for name, way in ways.items() if way}
    drill = drilled(made, truth)
    leaps = {
        v.name: [jump for cut in switches(drill, truth) if (jump := jumps(v.edl, truth, cut, surface=v.surface))]
        for v in variants(drill, truth)
    }
    moving = {name: in_movements(v.edl, truth, surface=v.surface) for name, v in own.items()}
    moved = {name: spread(values) for name, values in moving.items() if len(values)}
    weak = sum(len(pose.weak) for pose in made.poses)
    perspectives = len({pose.perspective for pose in made.poses})
    return {
        "views": views,
        "pooled": pooled,
        "jumps": leaps,
        "moving": moved,
        "weak": weak,
        "perspectives": perspectives,
    }


def of_pictures(made: edl.Edl, truth: Truth, source: Path, base: Path) -> dict[str, Any]:
    """By place, variant and occasion: means of PSNR and structure; and how many frames there are."""
    cut, drill = Watched(made, truth, source, base), Watched(drilled(made, truth), truth, source, base)
    whole = FrameRange(0, min(made.frames, truth.frames))
    which = occasions(truth, cut.shown)
    found = cut.distances([whole])
    around = drill.distances([FrameRange(c.frame - AROUND, c.frame + AROUND) for c in switches(drill.edl, truth)])
    figures: dict[str, Any] = {}
    for place, rows in found.items():
        figures[place] = {name: {o: means(row, chosen) for o, chosen in which.items()} for name, row in rows.items()}
        for name, row in around[place].items():
            figures[place][name]["switches"] = means(row, np.ones(len(row), bool))
    counts = {occasion: int(chosen.sum()) for occasion, chosen in which.items()}
    return figures | {"frames": counts | {"switches": len(next(iter(around["field"].values()), []))}}


class Watched:
    """A programme whose variants are held against the ideal one.

    Parameters
    ----------
    programme, truth
        Which, and of what.
    source, base
        The recording's folder, and the one that the programme's media are relative to.
    """

    def __init__(self, programme: edl.Edl, truth: Truth, source: Path, base: Path) -> None:
        self.edl, self._truth, self._field = programme, truth, field_of(source)
        self.shown = [decision.camera for decision in decisions(programme)][: truth.frames]
        self._ideal = [planes.y for planes in pictures(source / FOLDER / FILM)]
        self._footage = Footage(programme.cameras, rate=programme.rate, frames=programme.frames, base=base)
        self._geometry = TrueGeometry(programme, truth)

    def distances(self, pieces: Sequence[FrameRange]) -> dict[str, dict[str, list[Distance | None]]]:
        """By place and variant, the distances of these frames."""
        places = places_of(self._field, Hands(self.edl, self._truth), self._geometry, self.shown, pieces)
        found: dict[str, dict[str, list[Distance | None]]] = {place: {} for place in places}

        def note(name: str, frame: int, luma: NDArray[np.uint8]) -> None:
            for place, masks in places.items():
                found[place].setdefault(name, []).append(distance(luma, self._ideal[frame], masks[frame]))

        for variant in variants(self.edl, self._truth):
            for piece in pieces:
                with Compositor(variant.edl, self._footage, look=variant.look) as compositor:
                    for frame, planes in zip(piece, compositor.frames(piece), strict=True):
                        note(variant.name, frame, planes.y)
                        if variant.name == "plane":
                            note("floor", frame, self._floor(compositor, frame, planes))
        return found

    def _floor(self, compositor: Compositor, frame: int, plane: Planes) -> NDArray[np.uint8]:
        """Luma by the true geometry; where the chosen camera does not see, as the planes lay it."""
        camera = self.shown[frame]
        own = compositor.picture(camera, frame)
        laid = None if own is None else self._geometry.picture(own, camera, frame, colour=True)
        return plane.y if laid is None else np.where(laid[1], laid[0].y, plane.y)


def field_of(source: Path) -> Mask:
    """The field in the ideal programme."""
    mask = cv2.imdecode(np.frombuffer((source / FOLDER / FIELD).read_bytes(), np.uint8), cv2.IMREAD_GRAYSCALE)
    assert mask is not None
    return np.asarray(mask) > 0


def places_of(
    field: Mask, people: Hands, geometry: TrueGeometry, shown: Sequence[str], pieces: Sequence[FrameRange]
) -> dict[str, dict[int, Mask]]:
    """By frame, what of the field is judged: all of it; without hands; and without heads and arms as well.

    Hands are those of the ideal programme and of the chosen camera, heads the chosen camera's.
    """
    wanted = {frame for piece in pieces for frame in piece}
    places: dict[str, dict[int, Mask]] = {"surface": {}, "bare": {}, "field": dict.fromkeys(wanted, field)}
    in_ideal = people.in_ideal(sorted(wanted))
    for camera in sorted(set(shown)):
        for frame in sorted(f for f in wanted if shown[f] == camera):
            here, bare = people.in_camera(camera, frame), field & ~in_ideal[frame]
            for place in ("surface", "bare"):
                hidden = here and (here.hands if place == "bare" else here.all)
                places[place][frame] = bare if hidden is None else bare & ~geometry.mask(hidden, camera, frame)
    return places


def pictures(file: Path) -> list[Planes]:
    """All of a film's pictures."""
    facts = probe(file)
    reader = VideoReader(facts)
    try:
        return [to_planes(frame, facts) for _, frame in reader.read(Fraction(0))]
    finally:
        reader.close()


# --------------------------------------------------------------------------------------------------------- the run


def main(arguments: Sequence[str]) -> None:
    folder = Path(arguments[0])
    folder.mkdir(parents=True, exist_ok=True)
    flags = {a for a in arguments[1:] if a.startswith("--")}
    tuning = "--tuning" in flags
    names = [a for a in arguments[1:] if a not in flags] or [str(s) for s in (TUNING if tuning else FINAL)]
    cv2.setNumThreads(1)
    for name in names:
        print(json.dumps(measure(folder, name, again="--again" in flags)["distance"]), flush=True)
    found = [json.loads(file.read_text("utf-8")) for file in sorted(folder.glob("*.ideal.json"))]
    page = markdown([f for f in found if is_tuning(f) == tuning])
    if not tuning:
        (RESULTS / "ideal.md").write_text(page, "utf-8")
    print(page)


def is_tuning(figures: Mapping[str, Any]) -> bool:
    """Whether a recording's seed is one to tune on."""
    return int(figures["name"].rpartition(":")[2]) in TUNING


if __name__ == "__main__":
    main(sys.argv[1:])
