"""The samples' file: read from several threads at once, without `os.pread` too; which frame every picture is of."""

import os
from concurrent.futures import ThreadPoolExecutor
from contextlib import closing

import pytest
from coded_video import SIZE, read_number, write_coded

from mcsl_core.edl import Camera, Clock, Media
from mcsl_core.media.probing import probe
from mcsl_core.progress import Silent
from mcsl_core.recording.footage import Footage
from mcsl_core.recording.sample_store import SampleStore


def test_several_threads_read_what_one_does(tmp_path, monkeypatch):
    monkeypatch.delattr(os, "pread", raising=False)
    path = write_coded(tmp_path / "a.mp4", range(60), gop=5)
    facts = probe(path)
    camera = Camera("cam", (Media(path.name, facts.frames),), SIZE, facts.rate)
    footage = Footage([camera], rate=facts.rate, frames=60, base=tmp_path, threads=1)
    SampleStore.record(footage, tmp_path / "samples", Silent(), step_s=0.1).close()
    samples = SampleStore.load(tmp_path / "samples")
    assert samples is not None

    def number_at(position):
        picture = samples.picture(position, "cam")
        return None if picture is None else read_number(picture)

    numbers = [number_at(position) for position in range(len(samples))]
    assert len(set(numbers)) > 5
    positions = [*range(len(samples))] * 40
    with ThreadPoolExecutor(8) as threads:
        read = list(threads.map(number_at, positions))
    samples.close()
    assert read == numbers * 40


@pytest.mark.parametrize("offset_s", [0.0, 0.4, -0.3, 1.7])
@pytest.mark.parametrize(("rate", "gop"), [(30, 30), (10, 10), (25, 7), (10, 250)])  # the last is decoded whole
def test_every_picture_says_which_programme_frame_it_is_of(tmp_path, rate, gop, offset_s):
    numbers = range(6 * rate)
    facts = probe(write_coded(tmp_path / "a.mp4", numbers, gop=gop, rate=rate))
    camera = Camera("cam", (Media("a.mp4", facts.frames),), SIZE, facts.rate, Clock(offset_s))
    footage = Footage([camera], rate=facts.rate, frames=6 * rate, base=tmp_path, threads=1)
    SampleStore.record(footage, tmp_path / "samples", Silent()).close()
    samples = SampleStore.load(tmp_path / "samples")
    assert samples is not None
    with closing(samples):
        for sample in samples:
            assert sample.shown_frames.keys() == {n for n, p in sample.pictures.items() if p is not None}
            if (picture := sample.pictures["cam"]) is not None:
                assert abs(read_number(picture) - (sample.shown_frames["cam"] - offset_s * rate)) < 0.6
                assert abs(sample.shown_frames["cam"] - sample.frame) <= 1.5 * rate
