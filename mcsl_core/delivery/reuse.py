"""Programme pictures taken from conformed chunks where these are there, and composed where they are not."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import closing
from fractions import Fraction
from pathlib import Path

from mcsl_core.compositing.compositor import Compositor
from mcsl_core.imaging.planes import Planes
from mcsl_core.media.frames import to_planes
from mcsl_core.media.probing import probe
from mcsl_core.media.reading import VideoReader
from mcsl_core.timing import FrameRange

from .chunk_keys import Chunk, plan_chunks
from .quality import Quality
from .source import ProgrammeSource


def chunks_there(source: ProgrammeSource, folder: Path, quality: Quality) -> tuple[Chunk, ...]:
    """The chunks of this programme and quality that lie in ``folder``, in order; none without such a folder."""
    if not folder.is_dir():
        return ()
    there = {path.name for path in folder.iterdir()}
    chunks = plan_chunks(source.edl, source.base, filler=source.filler, quality=quality)
    return tuple(chunk for chunk in chunks if chunk.name in there)


def pictures(compositor: Compositor, piece: FrameRange, chunks: Sequence[Chunk], folder: Path) -> Iterator[Planes]:
    """The programme's pictures.

    Parameters
    ----------
    compositor : Compositor
        Makes those that no chunk has.
    piece : FrameRange
        The programme frames wanted.
    chunks : sequence of Chunk
        Of the same programme, in order.
    folder : Path
        Where they lie.

    Yields
    ------
    Planes
        One picture a frame.

    Raises
    ------
    MediaError
        Where a chunk cannot be read.
    """
    at = piece.start
    for chunk in chunks:
        both = chunk.range.intersection(piece)
        if both is None:
            continue
        yield from _composed(compositor, at, both.start)
        at = both.start
        for planes in _read(folder / chunk.name, both.start - chunk.range.start, len(both)):
            yield planes
            at += 1
        yield from _composed(compositor, at, both.stop)  # of a file that was cut short since
        at = both.stop
    yield from _composed(compositor, at, piece.stop)


def _composed(compositor: Compositor, start: int, stop: int) -> Iterator[Planes]:
    if start < stop:
        yield from compositor.frames(FrameRange(start, stop))


def _read(path: Path, first: int, count: int) -> Iterator[Planes]:
    facts = probe(path)
    with closing(VideoReader(facts)) as reader:
        for n, (_, frame) in enumerate(reader.read(Fraction(0))):
            if n == first + count or frame is None:
                return
            if n >= first:
                yield to_planes(frame, facts)
