"""Filming: all cameras of a scene side by side, each into its file, in processes of their own where it is worth it."""

from __future__ import annotations

import os
import sys
import threading
from collections.abc import Callable
from concurrent.futures import FIRST_EXCEPTION, ThreadPoolExecutor, wait
from functools import partial
from pathlib import Path

import attrs
import numpy as np
from numpy.typing import NDArray

from mcsl_core.children import in_child
from mcsl_core.errors import Cancelled
from mcsl_core.imaging.planes import Planes
from mcsl_core.parallel import opencv_in_one_thread
from mcsl_core.progress import Progress

from .clocks import clocks, frame_counts
from .ground import Ground
from .recorder import Recorder
from .render import CameraPictures
from .scene import Scene
from .sound import RATE, Microphone, Room

WORTH_A_PROCESS = 150e6
"""Pixels a camera: 290 pictures of 960x540, over two seconds of work, where a process takes most of one to begin."""


@attrs.frozen(eq=False)
class Film:
    """What is filmed, and into which folder.

    Attributes
    ----------
    scene, ground
        What is filmed.
    recorder
        How the files are written.
    out
        The folder for them.
    """

    scene: Scene
    ground: Ground
    recorder: Recorder
    out: Path

    def run(self, progress: Progress, *, apart: bool | None = None) -> list[NDArray]:
        """Films with all cameras at once.

        Parameters
        ----------
        progress
            Told of the frames.
        apart
            Whether each camera has a process of its own: threads wait for one another at every step of Python between
            two of OpenCV's. By the size of the work without. The files are the same.

        Returns
        -------
        list
            Per camera (own frames, 2): visible fractions of the field, everything counted, and without hands.
        """
        counts = frame_counts(self.scene.scenario)
        apart = self._is_worth_processes(counts) if apart is None else apart
        done = [0] * len(counts)
        stop = threading.Event()

        def told(camera: int, count: int) -> None:
            if stop.is_set():
                raise Cancelled
            done[camera] = count

        def filmed(camera: int) -> NDArray:
            work, tell = partial(self.camera, camera), partial(told, camera)
            return in_child(work, tell) if apart else work(tell)

        finished = False
        with opencv_in_one_thread(), ThreadPoolExecutor(len(counts)) as pool:
            jobs = [pool.submit(filmed, camera) for camera in range(len(counts))]
            try:
                pending = set(jobs)
                while pending:
                    _, pending = wait(pending, 0.2, FIRST_EXCEPTION)
                    for job in jobs:
                        if job.done():
                            job.result()
                    progress.advance(sum(done))
                finished = True
            finally:
                if not finished:
                    stop.set()
                    wait(jobs)
        return [job.result() for job in jobs]

    def _is_worth_processes(self, counts: tuple[int, ...]) -> bool:
        width, height = self.scene.scenario.size
        can = bool(sys.executable) and (os.cpu_count() or 1) > 1  # Python inside a program may have none to start
        return can and len(counts) > 1 and min(counts) * width * height > WORTH_A_PROCESS

    def camera(self, camera: int, told: Callable[[int], None]) -> NDArray:
        """Writes one camera's file; ``told`` is called with the number of frames so far, and may raise.

        Returns
        -------
        NDArray
            (own frames, 2), as in `run`.
        """
        scenario, clock = self.scene.scenario, clocks(self.scene.scenario)[camera]
        count = frame_counts(scenario)[camera]
        pictures = CameraPictures(self.scene, self.ground, camera, clock)
        microphone = Microphone(Room(scenario), scenario, camera, clock) if scenario.audio else None
        visible = np.zeros((count, 2))
        heard, length = 0, round(count / scenario.rate * RATE)
        missing = self.recorder.missing(scenario, camera, count)
        file = self.out / f"{scenario.camera_names[camera]}.mp4"
        with opencv_in_one_thread(), self.recorder.writer(file, scenario, microphone is not None) as writer:

            def at(k: float) -> Planes:
                planes, shares = pictures.frame(k)
                if k == int(k):
                    visible[int(k)] = shares
                return planes

            for k in range(count):
                told(k)
                if microphone and heard <= k / scenario.rate * RATE and heard < length:
                    piece = min(RATE, length - heard)
                    writer.write_audio(microphone.read(piece))
                    heard += piece
                planes = self.recorder.picture(at, k)
                if missing[k]:
                    writer.leave_out()
                else:
                    writer.write(planes)
            told(count)
        self.recorder.finish(file)
        return visible
