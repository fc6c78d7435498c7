"""What sampling met damaged is looked at once, however long it lasts, is told, and can be stopped."""

from contextlib import closing

import pytest
from changing_films import EACH, film, footage_of
from notes import Notes

from mcsl_core.errors import Cancelled
from mcsl_core.media.reading import VideoReader
from mcsl_core.progress import Silent
from mcsl_core.recording import damage
from mcsl_core.recording.sample_store import SampleStore

USUAL, OTHER = (256, 144), (320, 240)
LASTING = 6  # times `EACH` of another shape


@pytest.fixture
def counts(monkeypatch):
    """How many readers were opened, and how many pictures they gave."""
    seen = {"readers": 0, "pictures": 0}

    class Counted(VideoReader):
        def __init__(self, *given, **named):
            seen["readers"] += 1
            super().__init__(*given, **named)

        def read(self, from_s):
            for picture in super().read(from_s):
                seen["pictures"] += 1
                yield picture

    monkeypatch.setattr(damage, "VideoReader", Counted)
    return seen


def met_in(tmp_path, sizes, progress, *, step_s=0.25):
    footage = footage_of(film(tmp_path / "a.ts", sizes), len(sizes))
    with closing(SampleStore.record(footage, tmp_path / "samples", Silent(), step_s=step_s)) as samples:
        assert len(samples.damaged["cam"]) > 20
        return damage.damage_met(footage, samples, progress)["cam"][0]


@pytest.mark.parametrize("whole_again", [True, False])
def test_a_long_damaged_stretch_is_read_once_and_told(tmp_path, counts, whole_again):
    class Counting(Notes):
        done: list = []  # noqa: RUF012

        def advance(self, done):
            self.done = [*self.done, done]

    told = Counting()
    sizes = [USUAL, *[OTHER] * LASTING, *[USUAL] * whole_again]
    (found,) = met_in(tmp_path, sizes, told)
    assert EACH - 3 <= found.start_s * 30 <= EACH
    assert found.stop_s * 30 == pytest.approx(EACH * (LASTING + 1), abs=1)
    assert counts["readers"] == 1
    assert counts["pictures"] < EACH * (LASTING + 3), "the stretch, and a little of what lies before it"
    assert told.stages == ["Looking around damaged pictures"]
    assert told.done == sorted(told.done)
    assert told.done[-1] == EACH * len(sizes)
    assert len(set(told.done)) > EACH * LASTING / 2, "it moves on within the stretch"


def test_two_stretches_are_two(tmp_path, counts):
    found = met_in(tmp_path, [USUAL, OTHER, OTHER, USUAL, OTHER, OTHER, USUAL], Silent())
    assert [round(float(d.start_s * 30 / EACH), 1) for d in found] == [1, 4]
    assert [round(float(d.stop_s * 30 / EACH), 1) for d in found] == [3, 6]
    assert counts["readers"] == 2


def test_it_can_be_stopped_within_the_stretch(tmp_path, counts):
    class Stopped(Silent):
        def advance(self, done):
            if done > 2 * EACH:
                self.token.cancel()
            super().advance(done)

    with pytest.raises(Cancelled):
        met_in(tmp_path, [USUAL, *[OTHER] * LASTING, USUAL], Stopped())
    assert counts["pictures"] < 4 * EACH
