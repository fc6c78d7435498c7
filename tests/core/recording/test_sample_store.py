"""The samples' file is read from several threads at once, on systems without `os.pread` too."""

import os
from concurrent.futures import ThreadPoolExecutor

from coded_video import SIZE, read_number, write_coded

from mcsl_core.edl import Camera, Media
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
