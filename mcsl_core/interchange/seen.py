"""What a viewer of a sequence that came back sees of the programme: what covers what, and what is unknown."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import pairwise

from mcsl_core.progress import counted
from mcsl_core.timing import FrameRange, format_time, joined, touching

from .found import FoundClip, FoundCut
from .model import Sequence as Cut
from .model import Transform
from .painting import paint
from .placing import Placed, Placer, shown


class Seen:
    """The clips of the programme that are seen, and where something is seen that cannot be read.

    What cannot be read is of other media, nested, a title, or runs at another speed. In a shot's place, or above the
    hole that one left, it hides the cameras below. Where more than a quarter of it lies over shots it is laid over
    them, as a watermark is: what is below counts as if it were not there.

    Parameters
    ----------
    cut
        As it was exported.
    found
        As it came back.
    placer
        Of ``cut``.
    layers
        Whether the cameras lie on tracks below the shots.
    """

    def __init__(self, cut: Cut, found: FoundCut, placer: Placer, *, layers: bool) -> None:
        self._cut = cut
        placed = [(clip, None if clip.unread else placer.place(clip)) for clip in found.clips]
        self._placed = [(clip, where) for clip, where in placed if where is not None]
        self._foreign = [clip for clip, where in placed if where is None and not clip.unread]
        self.unknown = [clip for clip, where in placed if clip.enabled and (where is None or clip.retimed)]
        shots = self._lowest_of_shots() if layers else 0
        readable = [(clip, where) for clip, where in self._placed if clip.enabled and not clip.retimed]
        self.parts = self._visible(readable, shots)
        by_layer = sorted(self.parts, key=lambda part: part[0].layer)
        self.painted = paint(cut.frames, [(frames, camera) for _, _, frames, camera in by_layer])

    @property
    def known(self) -> bool:
        """Whether any clip is of the programme."""
        return bool(self._placed)

    def _lowest_of_shots(self) -> int:
        """The lowest layer that holds shots, or what would be above all: below lie the cameras, each on its own."""
        conformed = [clip.layer for clip, where in self._placed if where.conformed]
        if conformed:
            return min(conformed)
        cameras: dict[int, set[str]] = {}
        for clip, where in self._placed:
            cameras.setdefault(clip.layer, set()).add(where.camera)
        below: set[str] = set()
        for layer, found in sorted(cameras.items()):
            if len(found) > 1 or found & below or len(cameras) == 1:
                return layer
            below |= found
        return max(cameras, default=0) + 1

    def _visible(
        self, readable: list[tuple[FoundClip, Placed]], shots: int
    ) -> list[tuple[FoundClip, FrameRange, FrameRange, str]]:
        """(clip, where in the sequence, programme frames, camera) of what is seen, in the order of the sequence."""
        above = [item for item in readable if item[0].layer >= shots]
        below = [item for item in readable if item[0].layer < shots]
        taken = joined(clip.range for clip, _ in above)
        hiding = [(clip, None) for clip in self.unknown if 4 * _overlap(clip.range, taken) <= len(clip.range)]
        laid = [*sorted([*below, *hiding], key=_layer), *sorted(above, key=_layer)]
        length = max((clip.range.stop for clip, _ in laid), default=1)
        parts = []
        for piece, top in paint(length, [(item[0].range, item) for item in laid]):
            if top is None or top[1] is None:
                continue
            clip, where = top
            frames = shown(clip, where, piece)
            if frames is not None:
                parts.append((clip, piece, frames, where.camera))
        return parts

    def may_be_covered(self, gone: FrameRange) -> bool:
        """Whether something unknown lies where programme frames that are seen no more would be: it stands for them."""
        start = max((at.stop for _, at, frames, _ in self.parts if frames.stop == gone.start), default=0)
        after = [at.start for _, at, frames, _ in self.parts if frames.start == gone.stop]
        stop = min(after) if after else max((clip.range.stop for clip in self.unknown), default=0)
        return start < stop and any(clip.range.intersection(FrameRange(start, stop)) for clip in self.unknown)

    def _is_moved(self, clip: FoundClip, where: Placed) -> bool:
        """Whether a clip's picture lies elsewhere than the export laid it."""
        if clip.transform is None:
            return False
        laid = next((c.transform for c in self._cut.angle(where.camera).clips if where.start in c.range), None)
        if where.conformed:
            laid = Transform(0, 0, 1, 0)
        return laid is not None and not _alike(laid, clip.transform)

    def notes(self) -> Iterator[str]:
        """What is seen and cannot be said in an EDL."""
        for clip in self._foreign:
            yield f"{clip}: {clip.taken_from} is none of the programme's media"
        moved = [(clip, where) for clip, where in self._placed if self._is_moved(clip, where)]
        if moved:
            at = format_time(moved[0][0].range.start / self._cut.rate)
            yield f"{counted(len(moved), 'clips')} whose picture was moved, scaled or turned, the first at {at}"
        if any(frames.stop > self._cut.frames for _, _, frames, _ in self.parts):
            yield f"frames beyond the programme's end at {self._cut.frames}"
        highest = max((clip.layer for clip, _, _, _ in self.parts), default=0)
        top = [frames for clip, _, frames, _ in self.parts if clip.layer == highest]
        if any(after.start < before.start for before, after in pairwise(top)):
            yield "another order of the shots"
        twice = sum(map(len, top)) - sum(map(len, joined(top)))
        if twice:
            yield f"{twice} frames that are shown more than once"


def _layer(item: tuple[FoundClip, Placed | None]) -> int:
    return item[0].layer


def _overlap(piece: FrameRange, taken: Sequence[FrameRange]) -> int:
    """How many frames of ``piece`` lie in ``taken``, which is in order."""
    shared = (one.intersection(piece) for one in touching(taken, piece.start, piece.stop))
    return sum(len(both) for both in shared if both)


def _alike(one: Transform, other: Transform) -> bool:
    """Whether two transforms are one but for how editors round."""
    shift = max(abs(one.x - other.x), abs(one.y - other.y))
    turn = (one.rotation - other.rotation + 180) % 360 - 180
    return shift < 0.1 and abs(one.scale - other.scale) < 3e-4 and abs(turn) < 0.02
