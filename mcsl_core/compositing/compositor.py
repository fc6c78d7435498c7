"""Programme frames: one single resampling from camera pixel to programme pixel, colour, fill.

Everything that makes programme pictures comes through here. Pictures are `Planes` (4:2:0, BT.709 limited). Matrices map
camera pixel to programme pixel: translate(centering offset) @ anchor @ homography, composed in float64; a pose's relief
adds to them what its cameras see from their own side.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Iterator, Mapping
from itertools import chain

import attrs
from attrs import frozen

from mcsl_core.edl import Edl, Look
from mcsl_core.edl.dependencies import sees_through
from mcsl_core.edl.resolve import Decision, resolve_by_pose, shift_at
from mcsl_core.errors import DocumentError
from mcsl_core.filling.footprint import FootprintFiller
from mcsl_core.filling.protocol import Filler
from mcsl_core.filling.provenance import ShowProvenance
from mcsl_core.filling.visual_hull import Cells
from mcsl_core.imaging.planes import Planes, black
from mcsl_core.imaging.warp import Resampling
from mcsl_core.timing import FrameRange

from .camera_warper import CameraWarper
from .frame_context import FrameContext
from .parallax import Parallax
from .picture_source import PictureSource
from .read_ahead import ReadAhead
from .see_through import SeeThrough
from .stand_ins import StandIns

BLOCK_S = 10  # conformed chunks, and what a filler that remembers begins anew, lie on one grid


class Compositor:
    """Makes programme frames from an EDL and its footage. For one thread; close it, or use it as a context manager.

    Parameters
    ----------
    edl : Edl
        The programme.
    pictures : PictureSource
        The cameras' pictures, as a rule `Footage`.
    filler : Filler, optional
        Fills the pixels outside the chosen camera's picture; `FootprintFiller` by default.
    look : Look, optional
        In place of the EDL's look and of the overrides' looks, for a comparison with or without the aids.
    resampling : {"linear", "lanczos"}
        How a camera's picture is resampled.
    parallax : Parallax, optional
        Shared by the compositors of one EDL; its own without.

    Raises
    ------
    DocumentError
        Where the programme's size is odd: pictures are 4:2:0.

    Attributes
    ----------
    stand_ins : StandIns
        Which camera was shown where the chosen one has no picture, in what was made so far.

    Notes
    -----
    A frame depends on its frame number and the EDL alone, not on the range it is made in.
    """

    def __init__(
        self,
        edl: Edl,
        pictures: PictureSource,
        *,
        filler: Filler | None = None,
        look: Look | None = None,
        resampling: Resampling = "linear",
        parallax: Parallax | None = None,
    ) -> None:
        if edl.size[0] % 2 or edl.size[1] % 2:
            what = f"is {edl.size[0]}x{edl.size[1]}; a programme's size is even"
            raise DocumentError(what, where="$.size of the EDL", remedy="Correct it, or analyse again")
        self.edl, self.filler = edl, filler or FootprintFiller()
        self._segments = tuple(
            (part, _with_look(decision, look), pose_index) for part, decision, pose_index in resolve_by_pose(edl)
        )
        self._see_through: SeeThrough | None = None
        if any(sees_through(edl.poses[pose_index], decision) for _, decision, pose_index in self._segments):
            parallax, pictures = parallax or Parallax(edl, pictures), ReadAhead(pictures)
            self._warper = CameraWarper(edl, pictures, resampling, parallax)
            self._see_through = SeeThrough(self._warper, pictures)
        else:
            self._warper = CameraWarper(edl, pictures, resampling, parallax)
        self.stand_ins = StandIns()

    def __enter__(self) -> Compositor:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Close the decoders and let go of what was kept; frames handed out stay valid."""
        self._warper.close()
        if self._see_through is not None:
            self._see_through.forget()

    def picture(self, camera: str, frame: int) -> Planes | None:
        """The camera's own picture at programme frame ``frame``, decoded once; None where it has none."""
        return self._warper.own_picture(camera, frame)

    def frames(self, piece: FrameRange) -> Iterator[Planes]:
        """Make programme pictures.

        Parameters
        ----------
        piece : FrameRange
            The programme frames to make.

        Yields
        ------
        Planes
            One picture a frame, of the programme's size. Treat as read-only: they may be the decoder's memory.
        """
        made: _Composited | None = None
        block = block_frames(self.edl)
        try:
            for frame in piece:
                if self.filler.remembers and (frame == piece.start or frame % block == 0):
                    made = None
                    start = frame - frame % block
                    for before in chain(remembered(start), range(start, frame)):
                        made = self._composited(before, made)
                made = self._composited(frame, made if self.filler.remembers else None)
                yield made.planes
        finally:
            self.close()

    def seen_through(self, frame: int) -> Mapping[str, Cells]:
        """What other cameras show under heads in a frame.

        Parameters
        ----------
        frame : int
            The programme frame.

        Returns
        -------
        mapping of str to (rows, columns) float32
            By other camera the weight of its picture, 0..1, by cell of the programme before centering; empty where
            nothing is seen through.
        """
        _, decision, pose_index = self._segment(frame)
        if self._see_through is None or not sees_through(self.edl.poses[pose_index], decision):
            return {}
        camera = self._camera_with_picture(frame, decision, self._warper.pose_at(frame))
        return {} if camera is None else self._see_through.weights(self._context(frame, camera, decision, pose_index))

    def _segment(self, frame: int) -> tuple[FrameRange, Decision, int]:
        return self._segments[bisect_right(self._segments, frame, key=lambda segment: segment[0].start) - 1]

    def _context(
        self, frame: int, camera: str, decision: Decision, pose_index: int, previous: Planes | None = None
    ) -> FrameContext:
        offset = shift_at(self.edl, decision, frame)
        still = all(shift_at(self.edl, decision, n) == offset for n in (frame - 1, frame + 1))
        steady = still and self._warper.pose_at(frame) == pose_index
        return FrameContext(
            self._warper, frame, camera, pose_index, offset, decision.colour, decision.surface, steady, previous
        )

    def _composited(self, frame: int, before: _Composited | None) -> _Composited:
        _, decision, pose_index = self._segment(frame)
        perspective = self.edl.poses[pose_index].perspective
        # In another perspective the frame before lies elsewhere: nothing in it belongs here.
        known = before.planes if before is not None and before.perspective == perspective else None
        return _Composited(perspective, self._frame(frame, decision, pose_index, known))

    def _frame(self, frame: int, decision: Decision, pose_index: int, previous: Planes | None) -> Planes:
        edl, laid_by = self.edl, self._warper.pose_at(frame)
        camera = self._camera_with_picture(frame, decision, laid_by)
        if camera is None:
            return black(edl.size)
        context = self._context(frame, camera, decision, pose_index, previous)
        planes = self._filled(context, fill=decision.fill and self._warper.is_placed(laid_by, camera))
        if self._see_through is None or not sees_through(edl.poses[pose_index], decision):
            return planes
        if not isinstance(self.filler, ShowProvenance):
            return self._see_through.through(context, context, planes)
        return self.filler.with_legend(self._see_through.through(context, self.filler.tinted(context), planes))

    def _filled(self, context: FrameContext, *, fill: bool) -> Planes:
        if fill:
            return self.filler.fill(context)
        return self.filler.unfilled(context) if isinstance(self.filler, ShowProvenance) else context.front

    def _camera_with_picture(self, frame: int, decision: Decision, pose_index: int) -> str | None:
        """The decision's camera, or who stands in for it where it has no picture.

        That is the reference, else the nearest viewpoint, else a camera whose place is not known: a picture that jumps
        tells a viewer more than black. None where no camera has one.
        """
        chosen = decision.camera
        others = (self.edl.reference, *self._warper.others(pose_index, chosen), *(c.name for c in self.edl.cameras))
        having = (c for c in dict.fromkeys((chosen, *others)) if self._warper.own_picture(c, frame) is not None)
        shown = next(having, None)
        if shown != chosen:
            self.stand_ins.add(chosen, shown, frame)
        return shown


@frozen(eq=False)
class _Composited:
    """A finished frame, and the perspective it is made in."""

    perspective: int
    planes: Planes


def _with_look(decision: Decision, look: Look | None) -> Decision:
    if look is None:
        return decision
    return attrs.evolve(decision, **attrs.asdict(look))


def remembered(start: int) -> tuple[int, ...]:
    """The frames from which a filler's memory is made for a block: 1, 2, 4, 8, ... before it, in order.

    What was in the picture long ago stays, at the cost of a handful of frames, and wherever one begins the memory is
    the same.

    Parameters
    ----------
    start : int
        The block's first programme frame.

    Returns
    -------
    tuple of int
        Rising, at most about log2 of ``start`` of them.
    """
    return tuple(start - (1 << k) for k in reversed(range(start.bit_length())))


def block_frames(edl: Edl) -> int:
    """Frames in a block of the programme: a conformed chunk, or what a filler that remembers makes in one go."""
    return max(1, round(BLOCK_S * edl.rate))
