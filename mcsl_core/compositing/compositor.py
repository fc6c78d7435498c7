"""Programme frames: one single resampling from camera pixel to programme pixel, colour, fill.

Everything that makes programme pictures comes through here. Pictures are `Planes` (4:2:0, BT.709 limited). Matrices map
camera pixel to programme pixel: translate(centering offset) @ anchor @ homography, composed in float64.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Iterator
from itertools import chain

import attrs
from attrs import frozen

from mcsl_core.edl import Edl, Look
from mcsl_core.edl.resolve import Decision, resolve_by_pose, shift_at
from mcsl_core.filling.footprint import FootprintFiller
from mcsl_core.filling.protocol import Filler
from mcsl_core.filling.provenance import ShowProvenance
from mcsl_core.imaging.planes import Planes, black
from mcsl_core.imaging.warp import Resampling
from mcsl_core.recording.footage import Footage
from mcsl_core.timing import FrameRange

from .camera_warper import CameraWarper
from .frame_context import FrameContext
from .parallax import Parallax

BLOCK_S = 10  # conformed chunks, and what a filler that remembers begins anew, lie on one grid


def remembered(start: int) -> tuple[int, ...]:
    """The frames by which the memory of a block from ``start`` on is made: 1, 2, 4, 8, ... before it, in order.

    What was seen long ago stays, at the cost of a handful of frames, and wherever one begins the memory is the same.
    """
    return tuple(start - (1 << k) for k in reversed(range(start.bit_length())))


def block_frames(edl: Edl) -> int:
    """Frames in a block of the programme: a conformed chunk, or what a filler that remembers makes in one go."""
    return max(1, round(BLOCK_S * edl.rate))


@frozen(eq=False)
class _Made:
    """A finished frame, and the perspective it is laid for."""

    perspective: int
    planes: Planes


class Compositor:
    """Makes programme frames from an EDL and its footage. For one thread; close it, or use it as a context manager.

    A frame depends on its pose_index and the EDL alone, not on the stretch it is made in. filler: fills what the chosen
    camera does not reach (`FootprintFiller` by default). look: in place of the EDL's look and of the overrides' looks,
    for a comparison with or without the aids. parallax: shared by the compositors of one EDL; its own without.
    """

    def __init__(
        self,
        edl: Edl,
        footage: Footage,
        *,
        filler: Filler | None = None,
        look: Look | None = None,
        resampling: Resampling = "linear",
        parallax: Parallax | None = None,
    ) -> None:
        self.edl, self.filler = edl, filler or FootprintFiller()
        self._stretches = tuple(
            (part, _looked(decision, look), pose_index) for part, decision, pose_index in resolve_by_pose(edl)
        )
        self._warper = CameraWarper(edl, footage, resampling, parallax)

    def __enter__(self) -> Compositor:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Closes the decoders and forgets what was looked at; frames handed out stay valid."""
        self._warper.close()

    def picture(self, camera: str, frame: int) -> Planes | None:
        """The camera's own picture at programme frame ``frame``, decoded once."""
        return self._warper.own_picture(camera, frame)

    def frames(self, piece: FrameRange) -> Iterator[Planes]:
        """The programme's pictures over ``piece``, of the programme's size. Treat as read-only."""
        made: _Made | None = None
        block = block_frames(self.edl)
        try:
            for frame in piece:
                if self.filler.remembers and (frame == piece.start or frame % block == 0):
                    made = None
                    start = frame - frame % block
                    for before in chain(remembered(start), range(start, frame)):
                        made = self._at(before, made)
                made = self._at(frame, made if self.filler.remembers else None)
                yield made.planes
        finally:
            self.close()

    def _at(self, frame: int, before: _Made | None) -> _Made:
        _, decision, pose_index = self._stretches[bisect_right(self._stretches, frame, key=lambda s: s[0].start) - 1]
        perspective = self.edl.poses[pose_index].perspective
        # In another perspective the frame before lies elsewhere: nothing in it belongs here.
        known = before.planes if before is not None and before.perspective == perspective else None
        return _Made(perspective, self._frame(frame, decision, pose_index, known))

    def _frame(self, frame: int, decision: Decision, pose_index: int, previous: Planes | None) -> Planes:
        edl, camera = self.edl, decision.camera
        planes = self._warper.own_picture(camera, frame)
        if planes is None and camera != edl.reference:
            camera = edl.reference
            planes = self._warper.own_picture(camera, frame)
        if planes is None:
            return black(edl.size)
        offset = shift_at(edl, decision, frame)
        steady = all(shift_at(edl, decision, near) == offset for near in (frame - 1, frame + 1))
        view = FrameContext(self._warper, frame, camera, pose_index, offset, decision.colour, steady, previous)
        if decision.fill and self._warper.knows(pose_index, camera):
            return self.filler.fill(view)
        return self.filler.bare(view) if isinstance(self.filler, ShowProvenance) else view.front


def _looked(decision: Decision, look: Look | None) -> Decision:
    if look is None:
        return decision
    return attrs.evolve(decision, centering=look.centering, fill=look.fill, colour=look.colour)
