"""A programme as a person in Python holds it: the EDL, and everything that can be seen, decided and made with it."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cached_property
from os import PathLike
from pathlib import Path
from typing import Any, Unpack

import attrs
import numpy as np
from numpy.typing import ArrayLike, NDArray

from mcsl_core import edl as edls
from mcsl_core.analysis.measurements import load_measurements
from mcsl_core.blender import installation as blenders
from mcsl_core.blender import render as rendering
from mcsl_core.blender.messages import BuiltTimeline
from mcsl_core.blender.render import RenderSettings
from mcsl_core.blender.timeline import build_timeline
from mcsl_core.delivery import conform as conforming
from mcsl_core.delivery.conform import Conformed, default_folder
from mcsl_core.delivery.parts import WHOLE, Part
from mcsl_core.delivery.quality import quality_named
from mcsl_core.delivery.source import ProgrammeSource
from mcsl_core.edl import Edl, Override
from mcsl_core.errors import Fault, InputError, UsageError
from mcsl_core.hooks.registry import filler_of
from mcsl_core.imaging.planes import U8
from mcsl_core.occlusion.score_table import ScoreTable
from mcsl_core.progress import Progress, Silent, counted
from mcsl_core.recording.footage import Footage, footage_of
from mcsl_core.report.page import write_report
from mcsl_core.timing import FrameRange, format_time

from .fields import Fields
from .removal import Removal
from .saving import write_edl
from .views import Aids, Views, moved


class Programme(Fields, Removal):
    """A programme: its EDL, the folder that lies in, its footage and its scores.

    Pictures are (H, W, 3) uint8 arrays, RGB; frames count from 0 at the programme's rate; points are (x, y) with pixel
    centres at integers. Changes are made here and written by `save`, nowhere before. Footage and scores are opened when
    they are first asked for. For one thread; closed by `close` or as a context manager, and usable again afterwards.

    Parameters
    ----------
    edl : Edl
        The document.
    path : str or Path
        Its file: relative media paths count from its folder, and `save` writes it.
    """

    def __init__(self, edl: Edl, path: str | Path) -> None:
        self.path = Path(path)
        self._edl = edl
        self._written: Edl | None = None
        self.hwaccel = "none"  # what decodes for `conform`: "auto", or hardware as FFmpeg names it

    @classmethod
    def open(cls, path: str | Path, *, allow_outside: bool = False) -> Programme:
        """The programme of the EDL at ``path``; see `mcsl_core.open`."""
        if not isinstance(path, str | PathLike):
            raise UsageError(f"an EDL is opened by its path, got {path!r}", remedy='Give it as mcsl.open("edl.json")')
        programme = cls(edls.load(path, allow_outside=allow_outside), path)
        programme._written = programme.edl
        return programme

    def __repr__(self) -> str:
        edl = self._edl
        length = f"{format_time(edl.frames / edl.rate)} at {float(edl.rate):.6g} frames/s"
        length = f"{counted(len(edl.cameras), 'cameras')}, {length}"
        decided = f"{counted(len(edl.shots), 'shots')}, {counted(len(edl.overrides), 'overrides')}"
        return f"<Programme {self.path}: {length}, {decided}{'' if self.is_saved else ', not saved'}>"

    def __enter__(self) -> Programme:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Lets go of decoders, footage and scores; what was handed out stays valid."""
        self._forget("_views", "footage", "scores")

    # ---------------------------------------------------------------------------------------------- the document

    @property
    def edl(self) -> Edl:
        """The document as it is now: a frozen value. Assign another, such as one made by ``attrs.evolve``."""
        return self._edl

    @edl.setter
    def edl(self, edl: Edl) -> None:
        before, self._edl = self._edl, edl
        self._forget("_views")
        if (edl.cameras, edl.rate, edl.frames) != (before.cameras, before.rate, before.frames):
            self._forget("footage")
        if edl.scores != before.scores:
            self._forget("scores")

    @property
    def folder(self) -> Path:
        """The folder that the EDL lies in, which relative media paths count from."""
        return self.path.parent

    @property
    def is_saved(self) -> bool:
        """Whether the document is what was read from the file or written to it last."""
        return self._edl == self._written

    @cached_property
    def footage(self) -> Footage:
        """Pictures (BGR) and sound of every camera by programme time."""
        return footage_of(self._edl, self.folder, threads=0)

    @cached_property
    def scores(self) -> ScoreTable:
        """How much of the surgical field each camera saw over time; InputError where no scores were kept.

        Examples
        --------
        >>> dict(zip(p.scores.cameras, np.nanmean(p.scores.visible, axis=0)))
        """
        if self._edl.scores is None:
            raise InputError("keeps no scores", where=str(self.path), remedy="Run `mcsl analyse` again")
        return load_measurements(self.folder / self._edl.scores).scores

    def override(
        self,
        frames: FrameRange | tuple[int, int],
        *,
        camera: str | None = None,
        offset: tuple[float, float] | None = None,
        note: str = "",
        **look: Unpack[Aids],
    ) -> None:
        """Decides over a range of frames, above the analysis and above earlier overrides. `save` writes it.

        Parameters
        ----------
        frames : FrameRange or (int, int)
            First frame, and the first one after it.
        camera : str, optional
            The camera shown.
        centering, fill, colour, surface, see_through : bool, optional
            The visual aids, on or off.
        offset : (float, float), optional
            Centering by hand, in programme pixels, right and down.
        note : str
            The editor's remark.

        Raises
        ------
        UsageError
            Where nothing is decided, a value is none for its name, or the range is not inside the programme.

        Examples
        --------
        >>> p.override((900, 1100), camera="cam2")
        >>> p.save()
        """
        unknown = sorted(look.keys() - Aids.__annotations__.keys())
        if unknown:
            raise TypeError(f"override() got an unexpected keyword argument {unknown[0]!r}")
        decided: dict[str, Any] = {"camera": camera, **{name: look.get(name) for name in Aids.__annotations__}}
        decided["offset"] = offset
        if all(value is None for value in decided.values()):
            remedy = f"Give one of {', '.join(decided)}"
            raise UsageError("the override decides nothing", where=str(self.path), remedy=remedy)
        try:
            override = Override(self._views.piece_of(frames), note=note, **decided)
        except Fault as fault:
            raise UsageError(str(fault), where=str(self.path), remedy="See help(Programme.override)") from None
        if camera is not None:
            self._views.check_camera(camera)
        self.edl = attrs.evolve(self._edl, overrides=(*self._edl.overrides, override))

    def save(self, path: str | Path | None = None, *, force: bool = False) -> Path:
        """Writes the EDL, whole or not at all, and returns where. What others wrote into the file meanwhile stays, and
        `edl` has it afterwards; DocumentError where both changed the same.

        path: another file than the one it was opened from, which then stays as it is. From then on the programme is the
        new file's, and its media paths count from the new folder. force: write it over whatever is there.
        """
        target = self.path if path is None else Path(path)
        made = write_edl(self._edl, self._written, self.path, target, force=force)
        if made != self._edl:
            self.close()  # they know the media by the paths of before
        self.path, self._edl, self._written = target, made, made
        return target

    # ------------------------------------------------------------------------------------------------- pictures

    def frame(self, frame: int) -> U8:
        """The finished programme picture: (height, width, 3) uint8, RGB, as `conform` makes it before it is encoded.

        Notes
        -----
        The first picture of a pose takes some seconds where the fill is on: what lies still is looked at over the whole
        pose. For many frames in a row use `frames`, which decodes on instead of seeking.

        Examples
        --------
        >>> plt.imshow(p.frame(900))
        """
        at = self._views.check_frame(frame)
        return next(self._views.frames(FrameRange(at, at + 1)))

    def frames(self, frames: FrameRange | tuple[int, int]) -> Iterator[U8]:
        """The finished pictures of a range one after another, in flat memory; each as `frame` gives it."""
        return self._views.frames(self._views.piece_of(frames))

    def camera_at(self, frame: int) -> str:
        """The camera chosen at a frame, overrides on top; where it has no picture the reference camera is shown."""
        return self._views.decision_at(frame)[0].camera

    def camera_frame(self, camera: str, frame: int, *, aligned: bool = False) -> U8:
        """What one camera shows at a programme frame, RGB.

        Parameters
        ----------
        camera : str
            Its name.
        frame : int
            The programme frame; the camera's clock is accounted for.
        aligned : bool
            Laid where the programme would show it, in the colours it would have there, black where it does not reach;
            else as the camera sees it, in its own size.

        Raises
        ------
        MediaError
            Where the camera has no picture then: it started late, ended early, or has a gap.
        """
        return (self._views.aligned_frame if aligned else self._views.camera_frame)(camera, frame)

    # --------------------------------------------------------------------------------------------------- places

    def to_programme(self, points: ArrayLike, camera: str, frame: int) -> NDArray[np.float64]:
        """Where pixels of a camera lie in the programme at a frame, as its picture would be laid there.

        Homography, the pose's anchor and relief, a correction by hand and the centering at that frame are all in it.

        Parameters
        ----------
        points : array-like, (N, 2) or (2,)
            (x, y) in pixels of the camera's full-size picture.
        camera : str
            Its name.
        frame : int
            The programme frame.

        Returns
        -------
        (N, 2) or (2,) float array
            (x, y) in programme pixels; they may lie outside the picture.

        Notes
        -----
        Without a relief, or with ``surface`` off, the plane of the field is aligned: what lies off it moves along with
        it, and the fill bends the picture by some pixels towards its edge, which is not in it. With a relief, hands
        that stand above it go along with it. A weak camera fills the frame as it is.

        Examples
        --------
        >>> p.to_programme([[640, 360]], "cam3", 900)
        """
        return moved(self._views.placement(camera, frame).to_programme, points)

    def to_camera(self, points: ArrayLike, camera: str, frame: int) -> NDArray[np.float64]:
        """Where programme pixels lie in a camera's full-size picture; the inverse of `to_programme`, shapes alike."""
        return moved(self._views.placement(camera, frame).to_camera, points)

    # ------------------------------------------------------------------------------------------------- delivery

    def conform(
        self,
        *,
        folder: str | Path | None = None,
        quality: str = "standard",
        jobs: int | None = None,
        prune: bool = False,
        audio: str | None = None,
        part: Part = WHOLE,
        progress: Progress | None = None,
    ) -> Conformed:
        """Makes the exact programme pictures as media, only what is missing or changed; changes need not be saved.

        Parameters
        ----------
        folder : str or Path, optional
            Where they lie; beside the EDL without (``edl.conformed``).
        quality : {"standard", "draft", "fine"}
            Of the pictures.
        jobs, prune : int, optional, and bool
            Chunks made at the same time, one a core without; whether those that the EDL does not need are deleted.
        audio : str, optional
            The camera whose sound is taken, or "none"; as the EDL has it without.
        part : Part, optional
            Which of the chunks are made; all without.

        Returns
        -------
        Conformed
            ``chunks`` that tile the programme, or its part, ``audio``, and how many were ``made`` now.
        """
        out = default_folder(self.path) if folder is None else Path(folder)
        progress = progress or Silent()
        how: dict[str, Any] = {"jobs": jobs, "prune": prune, "quality": quality_named(quality), "part": part}
        source = ProgrammeSource(self._edl, self.folder, filler_of(self._edl, progress), audio, self.hwaccel)
        return conforming.conform(source, out, **how, progress=progress)

    def render(
        self,
        out: str | Path,
        *,
        settings: RenderSettings | None = None,
        progress: Progress | None = None,
        **changes: Any,
    ) -> Path:
        """Renders the programme to a video and returns where it lies.

        Parameters
        ----------
        out : str or Path
            The video; its suffix is the preset's.
        settings : RenderSettings, optional
            Preset, engine, quality, sound and the like; the defaults without.
        progress : Progress, optional
            Where the work reports to.
        **changes
            Fields of `RenderSettings`, in place of those of ``settings``.

        Raises
        ------
        UsageError, InputError
            Also where changes are not saved (Blender reads the EDL's file), or ``out`` may not be written over.

        Examples
        --------
        >>> p.render("programme.mp4", engine="direct", audio="none")
        """
        self._check_saved()
        return rendering.render(self.path, Path(out), settings=settings, progress=progress, **changes)

    def timeline(
        self,
        out: str | Path,
        *,
        preset: str | Path = "h264",
        conformed: str | Path | None = None,
        audio: str | None = None,
        blender: str | None = None,
        force: bool = False,
        progress: Progress | None = None,
    ) -> BuiltTimeline:
        """Builds the Blender timeline ``out`` (.blend) of the saved EDL; see `blender.timeline.build_timeline`."""
        self._check_saved()
        how: dict[str, Any] = {"preset": preset, "conformed": conformed, "audio": audio, "force": force}
        return build_timeline(self.path, Path(out), blender=blenders.find(blender), **how, progress=progress)

    def report(
        self,
        out: str | Path,
        *,
        figures: str | Path | None = None,
        anonymous: bool = False,
        with_pictures: bool = True,
        force: bool = False,
        progress: Progress | None = None,
    ) -> Path:
        """Writes the page (.html) about the saved EDL; see `report.page.write_report`.

        figures: from `mcsl evaluate --json`, else measured quickly.
        """
        self._check_saved()
        how: dict[str, Any] = {"anonymous": anonymous, "with_pictures": with_pictures, "force": force}
        write_report(self.path, Path(out), figures_path=Path(figures) if figures else None, progress=progress, **how)
        return Path(out)

    @cached_property
    def _views(self) -> Views:
        return Views(self._edl, self.footage, str(self.path))

    def _forget(self, *names: str) -> None:
        """Drops what was worked out under these names; it is worked out again when it is asked for."""
        for name in names:
            dropped = self.__dict__.pop(name, None)
            if isinstance(dropped, Views):
                dropped.close()

    def _check_saved(self) -> None:
        remedy = "Call save(), or save(another path) to leave the file as it is"
        if not self.is_saved:
            raise UsageError("has changes that are not saved", where=str(self.path), remedy=remedy)
