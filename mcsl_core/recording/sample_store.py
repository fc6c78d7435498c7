"""Samples of the recording about once a second, decoded once and kept on disk small enough to be read again and again.

Every stage of the analysis iterates the same samples; pictures are BGR, downscaled to `SAMPLE_HEIGHT` rows.
"""

from __future__ import annotations

import json
import threading
from collections.abc import Iterator, Mapping, Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any, BinaryIO

import cv2
import numpy as np
from attrs import define, field, frozen
from numpy.typing import NDArray

from mcsl_core.documents import make_converter, read_json, structure_document, write_atomic
from mcsl_core.edl import Movement
from mcsl_core.errors import Fault, InputError, writing
from mcsl_core.input_files import check_file
from mcsl_core.progress import Progress
from mcsl_core.temporary import open_private, private_folder
from mcsl_core.timing import FrameRange

from .disk_space import tell_of_space
from .footage import Footage
from .keyframe_sampling import sample_cameras

SAMPLE_HEIGHT = 360
_converter = make_converter()
_BYTES_A_PIXEL = 0.26  # of JPEGs of rich texture
JPEG_QUALITY = 92  # 45 dB: below what movement and hue are judged by; 40-80 kB a picture


@frozen(eq=False)
class Sample:
    """All cameras at one programme frame.

    Attributes
    ----------
    frame
        The programme frame.
    pictures
        Camera -> (`SAMPLE_HEIGHT`, W, 3) BGR; None where a camera has no picture.
    shown_frames
        Camera -> the programme frame that its picture really belongs to, half a second off ``frame`` at most where
        samples lie a second apart; ``frame`` itself of a camera that is not in it.
    """

    frame: int
    pictures: Mapping[str, NDArray[np.uint8] | None]
    shown_frames: Mapping[str, int] = field(factory=dict)


@frozen
class _Contents:
    """Where each picture lies: by sample, camera -> (first byte, bytes, the programme frame that it belongs to).

    ``damaged``: as `SampleStore` has it.
    """

    cameras: tuple[str, ...]
    frames: tuple[int, ...]
    pictures: tuple[dict[str, tuple[int, int, int]], ...]
    damaged: dict[str, tuple[int, ...]] = field(factory=dict)

    def __attrs_post_init__(self) -> None:
        rising = all(a < b for a, b in pairwise((-1, *self.frames)))
        spans = [span[:2] for row in self.pictures for span in row.values()]
        known = {name for row in self.pictures for name in row} <= set(self.cameras)
        if not (rising and known and len(self.frames) == len(self.pictures)) or min(map(min, spans), default=0) < 0:
            raise Fault("do not fit each other")

    @property
    def size(self) -> int:
        return max((sum(span[:2]) for row in self.pictures for span in row.values()), default=0)


@define(eq=False)
class SampleStore:
    """The samples of a recording in order; iterate it as often as needed, from several threads too.

    Memory stays flat: pictures lie in a file.

    Attributes
    ----------
    frames
        The programme frame of each sample, rising.
    cameras
        Their names.
    damaged
        Camera -> programme frames at which sampling met pictures that could not be decoded whole.

    Examples
    --------
    >>> samples = SampleStore.record(footage, Path("samples"), Silent())  # doctest: +SKIP
    >>> for sample in samples:  # doctest: +SKIP
    ...     print(sample.frame, sample.pictures["cam1"].shape)
    """

    frames: list[int]
    cameras: tuple[str, ...]
    _index: list[dict[str, tuple[int, int, int]]]
    _file: BinaryIO = field(repr=False)
    damaged: dict[str, tuple[int, ...]] = field(factory=dict)
    _lock: Any = field(init=False, repr=False, factory=threading.Lock)

    @classmethod
    def record(cls, footage: Footage, store: Path, progress: Progress, *, step_s: float = 1.0) -> SampleStore:
        """Decodes ``footage`` once into the file ``store``.

        Parameters
        ----------
        footage
            The cameras on the programme clock.
        store
            The file of the pictures. Beside it lies ``store``.json, which says where in it each picture is; with it
            `load` opens the store again.
        progress
            Told of the frames that have been passed.
        step_s
            Seconds from one sample to the next.
        """
        progress.stage("Sampling the recording", footage.frames, "frames")
        seconds = float(footage.frames / footage.rate)
        tell_of_space("The samples", store.parent, seconds / step_s * _sample_bytes(footage), seconds, progress)
        with writing(store):
            _contents_of(store).unlink(missing_ok=True)
            private_folder(store.parent)
            store.unlink(missing_ok=True)
            stream = open_private(store, "x+b")
        try:
            made = cls._recorded(footage, stream, store, progress, step_s)
            write_atomic(_contents_of(store), json.dumps(made._contents()).encode(), private=True)
        except BaseException:  # what was begun takes the room that is missing
            stream.close()
            store.unlink(missing_ok=True)
            raise
        return made

    @classmethod
    def _recorded(
        cls, footage: Footage, stream: BinaryIO, store: Path, progress: Progress, step_s: float
    ) -> SampleStore:
        made = cls([], tuple(camera.name for camera in footage.cameras), [], stream)
        for sample in sample_cameras(footage, step_s=step_s, height=SAMPLE_HEIGHT):
            spans = {}
            for name, picture in sample.pictures.items():
                if picture is not None:
                    data = cv2.imencode(".jpg", picture, [cv2.IMWRITE_JPEG_QUALITY, JPEG_QUALITY])[1].tobytes()
                    spans[name] = (stream.tell(), len(data), sample.shown_frames[name])
                    with writing(store):
                        stream.write(data)
            made.frames.append(sample.frame)
            made._index.append(spans)
            progress.advance(min(sample.frame, footage.frames))
        progress.advance(footage.frames)
        made.damaged = {name: tuple(n for piece in met for n in piece) for name, met in footage.damage_met().items()}
        with writing(store):
            stream.flush()
        return made

    def _contents(self) -> dict[str, Any]:
        return {"cameras": self.cameras, "frames": self.frames, "pictures": self._index, "damaged": self.damaged}

    @classmethod
    def load(cls, store: Path) -> SampleStore | None:
        """What `record` wrote to ``store``; None where that was not finished or is not complete."""
        try:
            value = read_json(_contents_of(store), wanted="the contents of samples")
            contents = structure_document(value, _Contents, _converter, where=str(store), name="samples")
            check_file(store)
            if store.stat().st_size != contents.size:
                return None
            index = list(contents.pictures)
            return cls(list(contents.frames), contents.cameras, index, store.open("rb"), contents.damaged)
        except (OSError, InputError):
            return None

    def close(self) -> None:
        """Closes the file; the samples cannot be read afterwards."""
        self._file.close()

    def __len__(self) -> int:
        return len(self.frames)

    def __getitem__(self, position: int) -> Sample:
        pictures = {name: self.picture(position, name) for name in self.cameras}
        return Sample(self.frames[position], pictures, {n: span[2] for n, span in self._index[position].items()})

    def picture(self, position: int, camera: str) -> NDArray[np.uint8] | None:
        """One camera's picture at one position; None where it has none."""
        spans = self._index[position]
        return self._read(*spans[camera][:2]) if camera in spans else None

    def shown_frame(self, position: int, camera: str) -> int:
        """The programme frame that a camera's picture at one position belongs to; reads none."""
        return self._index[position][camera][2]

    def shows(self, position: int, camera: str) -> bool:
        """Whether a camera has a picture at one position; reads none."""
        return camera in self._index[position]

    def __iter__(self) -> Iterator[Sample]:
        return (self[i] for i in range(len(self)))

    def within(self, piece: FrameRange) -> list[int]:
        """Positions of the samples whose frames lie in ``piece``."""
        return [i for i, frame in enumerate(self.frames) if frame in piece]

    def standing(self, piece: FrameRange, movements: Sequence[Movement]) -> list[int]:
        """Positions of those `within` ``piece`` at which the lamp stands still, outside all ``movements``."""
        return [i for i in self.within(piece) if not any(self.frames[i] in m.range for m in movements)]

    def _read(self, start: int, length: int) -> NDArray[np.uint8]:
        with self._lock:  # several threads read, and Windows has no `os.pread`
            self._file.seek(start)
            data = self._file.read(length)
        picture = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_COLOR) if data else None
        if picture is None:
            remedy = "Delete it, or the folder it lies in, and run the same command again"
            raise InputError("holds samples that are damaged", where=str(self._file.name), remedy=remedy)
        return picture  # pyright: ignore[reportReturnType]


def _sample_bytes(footage: Footage) -> float:
    """About what the pictures of all cameras take at one frame."""
    heights = {camera.name: min(SAMPLE_HEIGHT, camera.size[1]) for camera in footage.cameras}
    return sum(heights[c.name] ** 2 * c.size[0] / c.size[1] for c in footage.cameras) * _BYTES_A_PIXEL


def _contents_of(store: Path) -> Path:
    return store.with_name(store.name + ".json")
