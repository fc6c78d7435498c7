"""The ways in: analyse a recording, open its EDL, measure its programme."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import attrs

from mcsl_core.analysis import pipeline
from mcsl_core.analysis.settings import AnalysisSettings
from mcsl_core.errors import UsageError
from mcsl_core.evaluation import evaluate as evaluating
from mcsl_core.evaluation.manual_alignment import load_manual
from mcsl_core.evaluation.results import Evaluation
from mcsl_core.hooks.registry import Plugins, discover
from mcsl_core.progress import Progress, Silent

from .programme import Programme


def analyse(
    recording: str | Path | Sequence[str | Path],
    edl_path: str | Path,
    *,
    reference: str | None = None,
    settings: AnalysisSettings | None = None,
    plugins: Plugins | None = None,
    force: bool = False,
    progress: Progress | None = None,
    **stages: str,
) -> Programme:
    """Decides everything: a recording becomes an EDL, written to ``edl_path``; stages' results are kept beside it.

    Parameters
    ----------
    recording : str, Path or sequence of them
        A folder with one file per camera, or the camera files in order.
    edl_path : str or Path
        Where the EDL is written. One that lies there already keeps its overrides, corrections, fields drawn by
        hand and look.
    reference : str, optional
        Whose perspective the programme keeps; the first camera without.
    settings : AnalysisSettings, optional
        Rate, sync, gaze and the like; the defaults without.
    plugins : Plugins, optional
        What is on offer for each stage; all that is installed, without.
    force : bool
        Replace something else than an EDL at ``edl_path``; a camera's file never.
    progress : Progress, optional
        Where long work reports to, such as ``with mcsl.Session("bar").progress() as progress``; nowhere without.
    **stages : str
        Stage -> name of the plugin that does it, such as ``occlusion="hue-area"``; see ``mcsl plugins``.

    Returns
    -------
    Programme
        As `open` gives it: it reads what was written.

    Raises
    ------
    UsageError, InputError, Cancelled
        Where a name is unknown, a file is refused, or ``progress`` was told to stop; nothing is written then.

    Examples
    --------
    >>> mcsl.analyse("recording/", "edl.json", selector="least-occluded").edl.movements
    """
    _check_settings(settings, stages)
    settings = settings or AnalysisSettings()
    settings = attrs.evolve(settings, stages={**settings.stages, **stages}, reference=reference or settings.reference)
    files = [recording] if isinstance(recording, (str, Path)) else recording
    pipeline.analyse(
        [Path(file) for file in files],
        Path(edl_path),
        settings=settings,
        plugins=plugins or discover(),
        force=force,
        progress=progress or Silent(),
    )
    return open(edl_path, allow_outside=True)  # it was made here, even where that cannot be remembered


def _check_settings(settings: object, stages: Mapping[str, str]) -> None:
    wrong = sorted(set(stages) & {f.name for f in attrs.fields(AnalysisSettings)})
    if wrong:
        raise UsageError(
            f"{wrong[0]} is a setting, no stage",
            remedy=f"Give settings=mcsl.AnalysisSettings({wrong[0]}={stages[wrong[0]]!r})",
        )
    if not isinstance(settings, AnalysisSettings | None):
        raise UsageError(
            f"settings are an AnalysisSettings, got {type(settings).__name__}",
            remedy='Give settings=mcsl.AnalysisSettings(sync="none")',
        )


def open(path: str | Path, *, allow_outside: bool = False) -> Programme:
    """The programme of the EDL at ``path``; InputError where it is none. Media are opened when needed.

    Parameters
    ----------
    path : str or Path
        The EDL.
    allow_outside : bool
        Its media may lie outside of its folder, though it was not made here by `analyse`: you trust who wrote it. It is
        remembered for this EDL.

    Examples
    --------
    >>> with mcsl.open("edl.json") as p:
    ...     plt.imshow(p.frame(900))
    """
    return Programme.open(path, allow_outside=allow_outside)


def evaluate(
    programme: Programme,
    *,
    manual: str | Path | None = None,
    manual_fit: str = "similarity",
    width: int = evaluating.WIDTH,
    every: int = 1,
    colour: bool = False,
    progress: Progress | None = None,
) -> Evaluation:
    """Measures how steady a programme is (ITF, AvSpeed), without alignment, aligned by hand, and as mcsl makes it.

    Parameters
    ----------
    programme : Programme
        As it is now: changes need not be saved.
    manual : str or Path, optional
        A file of alignments by hand (JSON or CSV): measures Manual-alignment too.
    manual_fit : {"similarity", "homography"}
        What point pairs set by hand become.
    width : int
        Columns of the pictures measured.
    every : int
        One in so many pairs of neighbouring frames within shots is measured; 0: those at switches alone.
    colour : bool
        Whether the cameras' colours are matched in all variants.

    Returns
    -------
    Evaluation
        ``measured``: one row for each variant, over the whole and over the switches.

    Notes
    -----
    It decodes the whole recording: some minutes for ten minutes of five cameras. ``every=10`` takes a fraction.

    Examples
    --------
    >>> {row.name: row.whole.itf_db for row in mcsl.evaluate(p, every=10).measured}
    """
    if not isinstance(programme, Programme):
        remedy = 'Give what mcsl.open("edl.json") returns'
        raise UsageError(f"a Programme is measured, got {programme!r}", remedy=remedy)
    if manual is None and manual_fit != "similarity":
        raise UsageError("manual_fit says what manual becomes, which is not given", remedy="Give both or none")
    edl = programme.edl
    by_hand = None if manual is None else load_manual(Path(manual), edl, fit=manual_fit)
    variants = evaluating.standard_variants(edl, manual=by_hand, colour=colour)
    return evaluating.evaluate(edl, programme.folder, variants, width=width, every=every, progress=progress)
