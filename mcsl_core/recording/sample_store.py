"""The recording looked at about once a second, decoded once and kept on disk small enough to be looked at again.

Every stage of the analysis iterates the same samples; pictures are BGR, reduced to `SAMPLE_HEIGHT` rows.
"""

from __future__ import annotations

import json
import os
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import BinaryIO

import cv2
import numpy as np
from attrs import define, field, frozen
from numpy.typing import NDArray

from mcsl_core.documents import write_atomic
from mcsl_core.edl import Movement
from mcsl_core.progress import Progress
from mcsl_core.timing import FrameRange

from .footage import Footage
from .keyframe_sampling import sample_cameras

SAMPLE_HEIGHT = 360
JPEG_QUALITY = 92  # 45 dB: below what movement and hue are judged by; 40-80 kB a picture


def _contents_of(store: Path) -> Path:
    return store.with_name(store.name + ".json")


@frozen(eq=False)
class Sample:
    """All cameras at one programme frame; None where a camera has no picture."""

    frame: int
    pictures: Mapping[str, NDArray[np.uint8] | None]


@define(eq=False)
class SampleStore:
    """The moments of a recording in order; iterate it as often as needed. Memory stays flat: pictures lie in a file."""

    frames: list[int]
    cameras: tuple[str, ...]
    _index: list[dict[str, tuple[int, int]]]
    _file: BinaryIO = field(repr=False)

    @classmethod
    def record(cls, footage: Footage, store: Path, progress: Progress, *, step_s: float = 1.0) -> SampleStore:
        """Decodes ``footage`` once, about a picture every ``step_s`` seconds, into the file ``store``.

        Beside it lies ``store``.json, which says where in it each picture is; with it `load` opens the store again.
        """
        cameras = tuple(c.name for c in footage.cameras)
        _contents_of(store).unlink(missing_ok=True)
        stream = store.open("w+b")
        frames: list[int] = []
        index: list[dict[str, tuple[int, int]]] = []
        progress.stage("Looking through the recording", footage.frames, "frames")
        for sample in sample_cameras(footage, step_s=step_s, height=SAMPLE_HEIGHT):
            places = {}
            for name, picture in sample.pictures.items():
                if picture is not None:
                    data = cv2.imencode(".jpg", picture, [cv2.IMWRITE_JPEG_QUALITY, JPEG_QUALITY])[1].tobytes()
                    places[name] = (stream.tell(), len(data))
                    stream.write(data)
            frames.append(sample.frame)
            index.append(places)
            progress.advance(min(sample.frame, footage.frames))
        progress.advance(footage.frames)
        stream.flush()
        contents = {"cameras": cameras, "frames": frames, "pictures": index}
        write_atomic(_contents_of(store), json.dumps(contents).encode())
        return cls(frames, cameras, index, stream)

    @classmethod
    def load(cls, store: Path) -> SampleStore | None:
        """What `record` wrote to ``store``; None where it was not finished or is not whole."""
        try:
            contents = json.loads(_contents_of(store).read_text("utf-8"))
            index = [{name: (start, length) for name, (start, length) in row.items()} for row in contents["pictures"]]
            frames, cameras = contents["frames"], tuple(contents["cameras"])
            if store.stat().st_size != max((sum(place) for row in index for place in row.values()), default=0):
                return None
            return cls(frames, cameras, index, store.open("rb"))
        except (OSError, ValueError, KeyError, TypeError):
            return None

    def close(self) -> None:
        """Lets go of the file; the samples cannot be looked at afterwards."""
        self._file.close()

    def __len__(self) -> int:
        return len(self.frames)

    def __getitem__(self, position: int) -> Sample:
        return Sample(self.frames[position], {name: self.picture(position, name) for name in self.cameras})

    def picture(self, position: int, camera: str) -> NDArray[np.uint8] | None:
        """One camera's picture at one position; None where it has none."""
        places = self._index[position]
        return self._read(*places[camera]) if camera in places else None

    def __iter__(self) -> Iterator[Sample]:
        return (self[i] for i in range(len(self)))

    def within(self, piece: FrameRange) -> list[int]:
        """Positions of the samples whose frames lie in ``piece``."""
        return [i for i, frame in enumerate(self.frames) if frame in piece]

    def standing(self, piece: FrameRange, movements: Sequence[Movement]) -> list[int]:
        """Those `within` ``piece`` during which the lamp stands still."""
        return [i for i in self.within(piece) if not any(self.frames[i] in m.range for m in movements)]

    def _read(self, start: int, length: int) -> NDArray[np.uint8]:
        data = np.frombuffer(os.pread(self._file.fileno(), length, start), np.uint8)  # safe from several threads
        picture = cv2.imdecode(data, cv2.IMREAD_COLOR)
        assert picture is not None, "the sample store was changed by another process"
        return picture  # pyright: ignore[reportReturnType]
