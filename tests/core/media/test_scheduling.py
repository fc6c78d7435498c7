"""Root writes AV1, and the machine's other work goes on."""

import contextlib
import os
import subprocess
import sys
from fractions import Fraction

import numpy as np
import pytest

from mcsl_core.media.scheduling import scheduled_as_before
from mcsl_core.media.writing import Encoding, VideoWriter

AV1 = Encoding(codec="libsvtav1", options={"preset": "12", "svtav1-params": "lp=1"})
linux = pytest.mark.skipif(sys.platform != "linux", reason="scheduling as Linux has it")


def policies():
    """Of every thread of this process, as `ps` says."""
    command = ["ps", "-L", "-o", "cls=", "-p", str(os.getpid())]
    return set(subprocess.run(command, capture_output=True, text=True, check=True).stdout.split())


@linux
def test_an_encoder_leaves_every_thread_as_urgent_as_it_was(tmp_path):
    before = policies()
    with VideoWriter(tmp_path / "a.mp4", size=(64, 64), rate=Fraction(25), encoding=AV1) as writer:
        for _ in range(3):
            writer.write(np.zeros((64, 64, 3), np.uint8))
            assert policies() == before
    assert policies() == before


@linux
@pytest.mark.skipif(sys.platform != "linux" or os.geteuid() != 0, reason="nobody else may change it")
def test_what_was_changed_is_set_back_whatever_happens():
    before = os.sched_getscheduler(0)
    with contextlib.suppress(KeyError), scheduled_as_before():
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(1))
        raise KeyError
    assert os.sched_getscheduler(0) == before
