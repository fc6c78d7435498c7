"""`mcsl report`: one page that a surgeon or an editor reads in a minute, self-contained, the same bytes for one input.

What is missing (media, scores) is told in its place; the page comes all the same.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import jinja2
from attrs import field, frozen

from mcsl_core import __version__
from mcsl_core.analysis.measurements import Measurements, load_measurements
from mcsl_core.edl import Edl, load
from mcsl_core.errors import Cancelled, McslError
from mcsl_core.evaluation.evaluate import evaluate
from mcsl_core.evaluation.results import Evaluation, load_evaluation
from mcsl_core.occlusion.score_table import ScoreTable
from mcsl_core.outputs.claim import claim
from mcsl_core.outputs.inputs import inputs_of
from mcsl_core.outputs.manifest import Manifest
from mcsl_core.progress import Progress, Silent

from .anonymous import FILE, fileless, nameless, untold
from .charts import Bar, short_time
from .facts import colour_bar, gather
from .pictures import PosePictures, pose_pictures
from .relief_picture import ReliefPicture, relief_picture
from .residuals import Residuals, residuals
from .steady import SteadyFacts, steady_facts

QUICK_SWITCHES = 40  # half a second of CPU each; their mean is known to a tenth then


@frozen
class _PoseSection:
    """A pose's pictures with the words and bars that go with them."""

    pictures: PosePictures
    time: str
    bars: tuple[Bar, ...]
    words: str
    left_out: str


@frozen
class ReliefSection:
    """A pose's relief, where it has one: its picture, if pictures are shown, and what it leaves, if measured."""

    picture: ReliefPicture | None = None
    left: Mapping[str, Residuals] = field(factory=dict)


@frozen
class Lacking:
    """The words that stand in place of what is not there; empty where it is."""

    scores: str = ""
    pictures: str = ""
    figures: str = ""


def write_report(
    edl_path: Path,
    out: Path,
    *,
    figures_path: Path | None = None,
    anonymous: bool = False,
    with_pictures: bool = True,
    force: bool = False,
    progress: Progress | None = None,
) -> None:
    """Write the page about an EDL.

    Parameters
    ----------
    edl_path : Path
        The EDL.
    out : Path
        The page, HTML.
    figures_path : Path, optional
        What `mcsl evaluate --json` wrote; without it the steadiness is measured at up to `QUICK_SWITCHES` switches.
    anonymous : bool
        Without names of cameras, files and folders, without remarks and plugins; pictures show what they show.
    with_pictures : bool
        Whether pictures are taken.
    force : bool
        Replace a page that mcsl did not write, or that was changed since.
    progress : Progress, optional
        Where it is told how far it has come.

    Raises
    ------
    InputError
        Where the EDL or the results cannot be read, or ``out`` may not be written over; missing media or scores
        are told on the page.
    """
    progress = progress or Silent()
    edl = load(edl_path)
    base = edl_path.parent
    read = [*inputs_of(edl, edl_path), *([figures_path] if figures_path else [])]
    output = claim(out, inputs=read, manifest=Manifest.beside(edl_path), force=force)
    evaluation = None if figures_path is None else load_evaluation(figures_path)
    measured, no_scores = _measured(edl, base, progress)
    if anonymous:
        edl, measured = nameless(edl, measured)
    pictures: list[PosePictures | None] = [None] * len(edl.poses)
    no_pictures = "The pictures were left out."
    if with_pictures:
        pictures, no_pictures = _pictures(edl, base, None if measured is None else measured.scores, progress)
    reliefs = _reliefs(edl, base, with_pictures, progress)
    no_figures = ""
    if evaluation is None:
        evaluation, no_figures = _evaluated(edl, base, progress)
    steady = None if evaluation is None else steady_facts(evaluation, edl.rate)
    name, lacking = edl_path.name, Lacking(no_scores, no_pictures, no_figures)
    if anonymous:
        edl, name, lacking = fileless(edl), FILE, Lacking(untold(no_scores), untold(no_pictures), untold(no_figures))
    text = page(edl, name, measured, pictures, steady, lacking, reliefs)
    output.write(text.encode("utf-8", "backslashreplace"))  # names of files need not be text


def _measured(edl: Edl, base: Path, progress: Progress) -> tuple[Measurements | None, str]:
    if edl.scores is None:
        return None, "The EDL names no scores, so what each camera sees over time is not known."
    if not (base / edl.scores).is_file():
        return None, _noted(f"What each camera sees over time is not known: {edl.scores} is missing.", progress)
    try:
        measured = load_measurements(base / edl.scores)
        lacking = {c.name for c in edl.cameras} - set(measured.scores.cameras)
        if not lacking:
            return measured, ""
        why = f"{edl.scores}: it lacks {', '.join(sorted(lacking))}"
    except McslError as error:
        why = _short(error, base)
    return None, _noted(f"What each camera sees over time is not known: {why}.", progress)


def _pictures(
    edl: Edl, base: Path, scores: ScoreTable | None, progress: Progress
) -> tuple[list[PosePictures | None], str]:
    try:
        return pose_pictures(edl, base, scores, progress), ""
    except Cancelled:
        raise
    except McslError as error:
        return [None] * len(edl.poses), _noted(f"The pictures cannot be shown: {_short(error, base)}.", progress)


def _reliefs(edl: Edl, base: Path, with_pictures: bool, progress: Progress) -> list[ReliefSection]:
    """One a pose. The form of a patient's body is a picture of it; what the relief leaves is none."""
    shown = [relief_picture(edl, pose) if with_pictures else None for pose in edl.poses]
    try:
        left = residuals(edl, base, progress)
    except Cancelled:
        raise
    except McslError:  # told where pictures and steadiness are missing: these are the same media
        left = [{} for _ in edl.poses]
    return [ReliefSection(*each) for each in zip(shown, left, strict=True)]


def _evaluated(edl: Edl, base: Path, progress: Progress) -> tuple[Evaluation | None, str]:
    try:
        return evaluate(edl, base, every=0, most_switches=QUICK_SWITCHES, progress=progress), ""
    except Cancelled:
        raise
    except McslError as error:
        return None, _noted(f"The steadiness cannot be measured: {_short(error, base)}.", progress)


def _short(error: McslError, base: Path) -> str:
    """What is wrong, with the path as the EDL has it: the page must not tell of the machine it was made on."""
    text = f"{error.where}: {error.what}" if error.where else error.what
    return text.replace(f"{base}/", "").rstrip(".")


def _noted(text: str, progress: Progress) -> str:
    progress.note(text)
    return text


def page(
    edl: Edl,
    file: str,
    measured: Measurements | None,
    pictures: list[PosePictures | None],
    steady: SteadyFacts | None,
    lacking: Lacking,
    reliefs: Sequence[ReliefSection] = (),
) -> str:
    """The page as HTML. file: the EDL's name. pictures, reliefs: one entry a pose; without reliefs none is shown."""
    facts = gather(edl, measured)
    colours = dict(facts.cameras)
    shown = []
    for pose, taken in zip(edl.poses, pictures, strict=True):
        if taken is None:
            shown.append(None)
            continue
        bars, words = colour_bar(taken.shares, colours)
        left_out = ", ".join(w.camera for w in pose.weak if w.camera not in pose.homographies)
        shown.append(_PoseSection(taken, short_time(float(taken.frame / edl.rate)), bars, words, left_out))
    environment = jinja2.Environment(
        loader=jinja2.PackageLoader("mcsl_core.report", "."),
        autoescape=True,
        trim_blocks=True,
        lstrip_blocks=True,
        undefined=jinja2.StrictUndefined,
    )
    return environment.get_template("page.html").render(
        name=title(edl, file),
        file=file,
        version=__version__,
        edl=edl,
        facts=facts,
        shown=shown,
        reliefs=reliefs or [ReliefSection() for _ in edl.poses],
        steady=steady,
        no_scores=lacking.scores,
        no_pictures=lacking.pictures,
        no_figures=lacking.figures,
    )


def title(edl: Edl, file: str) -> str:
    """What the recording is called: the folder of the reference camera's files, where the EDL tells it."""
    folders = edl.camera(edl.reference).media[0].path.split("/")[:-1]
    return folders[-1] if folders and folders[-1] not in ("", ".", "..") else file.rpartition(".")[0] or file
