"""What is removed is not in the video: its pictures are those that are left, its sound stays in time and fades."""

import av
import numpy as np
import pytest
from two_cameras import CLICK_S, EXPECTED, FRAMES, RATE, click_track, make, shown

from mcsl_core.delivery.audio import delivered_sound
from mcsl_core.delivery.conform import conform
from mcsl_core.delivery.direct import write_direct
from mcsl_core.delivery.source import ProgrammeSource
from mcsl_core.edl.removal import delivered
from mcsl_core.errors import InputError
from mcsl_core.recording.footage import footage_of
from mcsl_core.timing import FrameRange

REMOVED = (FrameRange(10, 31), FrameRange(45, 52), FrameRange(120, FRAMES))
LEFT = [n for n in range(FRAMES) if not any(n in piece for piece in REMOVED)]


def sound_of(path, count):
    sound = np.zeros(count)
    with av.open(str(path)) as container:
        for frame in container.decode(audio=0):
            start, data = round(frame.time * 48000), frame.to_ndarray()[0]
            sound[start : start + len(data)] = data[: max(0, count - start)]
    return sound


@pytest.mark.parametrize("conformed", [False, True])
def test_the_video_has_what_is_left_and_its_sound_in_time(sources, tmp_path, conformed):
    source = ProgrammeSource(make(removed=REMOVED), sources)
    if conformed:
        assert sum(len(chunk.range) for chunk in conform(source, tmp_path / "out").chunks) == FRAMES  # all of it
    out = tmp_path / "video.mp4"
    write_direct(source, out, conformed=tmp_path / "out")
    assert shown(out) == [EXPECTED[n] for n in LEFT]
    sound = sound_of(out, len(LEFT) * 1600 + 4096)
    click = np.correlate(sound, click_track(0.2, 0)[:480]).argmax()
    assert abs(int(click) - LEFT.index(round(CLICK_S * 30)) * 1600) <= 4


def test_a_stretch_of_it_and_nothing_left_of_a_stretch(sources, tmp_path):
    source = ProgrammeSource(make(removed=REMOVED), sources)
    write_direct(source, tmp_path / "part.mp4", piece=FrameRange(5, 50))
    assert shown(tmp_path / "part.mp4") == [EXPECTED[n] for n in LEFT if 5 <= n < 50]
    with pytest.raises(InputError, match=r"all of \[12, 20\) is removed"):
        write_direct(source, tmp_path / "none.mp4", piece=FrameRange(12, 20))
    assert not (tmp_path / "none.mp4").exists()


def test_the_sound_fades_over_two_frames_on_both_sides_of_a_seam_and_nowhere_else(sources):
    class Tone:
        """Footage whose sound is 1 throughout, so that what is given are the gains."""

        def audio_blocks(self, camera, start_s, stop_s, rate, *, block_s):
            count = round((stop_s - start_s) * rate)
            for at in range(0, count, 1000):
                yield np.ones(min(1000, count - at), np.float32)

    edl = make(removed=REMOVED)
    gains = np.concatenate(list(delivered_sound(Tone(), "a", edl, delivered(edl))))
    assert len(gains) == len(LEFT) * 48000 / RATE
    near = np.zeros(len(gains), bool)
    for frame in (10, 24):  # of the video, where a stretch is taken out
        seam = frame * 1600
        near[seam - 3200 : seam + 3200] = True
        assert gains[seam - 1] < 0.001 > gains[seam]
        assert np.all(np.diff(gains[seam - 3200 : seam]) < 0)
        assert np.all(np.diff(gains[seam : seam + 3200]) > 0)
    assert np.all(gains[~near] == 1)


def test_without_anything_removed_the_sound_is_the_camera_s_own(sources):
    edl = make()
    footage = footage_of(edl, sources, 1)
    given = np.concatenate(list(delivered_sound(footage, "a", edl, delivered(edl))))
    assert np.array_equal(given, footage.audio("a", 0, FRAMES / RATE))
