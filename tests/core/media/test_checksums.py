"""A byte changed anywhere in a Matroska film of FFmpeg's is known by its checksums, whatever its codec."""

from __future__ import annotations

import random
from fractions import Fraction

import av
import pytest
from damaged_films import FRAMES, GOP, damaged, noise, place_of, write_film, zeros

from mcsl_core.media.checksums import damaged_clusters
from mcsl_core.media.damage import find_damage
from mcsl_core.media.probing import probe


def spans(path):
    return [(round(d.start_s * 30), round(d.stop_s * 30)) for d in find_damage(probe(path))]


@pytest.mark.parametrize("codec", ["libx264", "libx265", "libvpx-vp9", "mpeg4"])
def test_one_changed_byte_is_a_gap_of_its_cluster(tmp_path, codec):
    path = write_film(tmp_path, "a.mkv", codec)
    assert spans(path) == []
    damaged(path, place_of(path, 100) + 90, noise(1))
    ((start, stop),) = spans(path)
    assert 80 <= start <= 100
    assert 100 < stop <= 150


@pytest.mark.parametrize(("way", "count"), [(noise, 1), (zeros, 300), (zeros, 100_000), (noise, 100_000)])
def test_any_damage_in_any_place_is_within_a_gap(tmp_path, way, count):
    path = write_film(tmp_path, "a.mkv", "libx265")
    whole = path.read_bytes()
    for seed in range(6):
        path.write_bytes(whole)
        at = random.Random(seed).randrange(len(whole) // 8, len(whole) * 6 // 8)
        with av.open(str(path)) as container:
            packets = [(p.pos or 0, p.size, p.pts or 0) for p in container.demux(video=0) if p.size]
        hit = [stamp for pos, size, stamp in packets if at <= pos + size and pos < at + count]
        if not hit:
            continue
        damaged(path, at, way(count))
        found = spans(path)
        numbers = {round(stamp * 30 / 1000) for stamp in hit}
        leading = 3  # pictures shown before a keyframe and coded behind it, lost with it; the decoder shows none there
        assert all(any(start - leading <= n < stop for start, stop in found) for n in numbers), seed
        assert sum(stop - start for start, stop in found) <= len(numbers) + 4 * GOP


def test_the_sound_beside_the_pictures_counts_as_well_and_the_rest_is_whole(tmp_path):
    path = write_film(tmp_path, "a.mkv")
    places = damaged_clusters(path, lambda _: None)
    assert places == []
    data = path.read_bytes()
    assert data.count(b"\x1f\x43\xb6\x75") >= FRAMES // GOP - 1


def test_files_without_checksums_or_with_a_writer_s_own_are_left(tmp_path):
    """None of them right is not a film of which every cluster is damaged."""
    webm = write_film(tmp_path, "v.webm", "libvpx-vp9", frames=60)
    mp4 = write_film(tmp_path, "a.mp4", frames=60)
    plain = write_film(tmp_path, "p.mkv", frames=60, container_options={"write_crc32": "0"})
    assert [damaged_clusters(path, lambda _: None) for path in (webm, mp4, plain)] == [[], [], []]
    own = write_film(tmp_path, "o.mkv", frames=90)
    data = own.read_bytes().split(b"\x1f\x43\xb6\x75")
    changed = [data[0]]
    for cluster in data[1:]:
        at = cluster.index(b"\xbf\x84") + 2
        changed.append(cluster[:at] + bytes(b ^ 255 for b in cluster[at : at + 4]) + cluster[at + 4 :])
    own.write_bytes(b"\x1f\x43\xb6\x75".join(changed))
    assert damaged_clusters(own, lambda _: None) == []


def test_a_file_cut_short_or_killed_while_recording_is_no_damage(tmp_path):
    path = write_film(tmp_path, "a.mkv")
    path.write_bytes(path.read_bytes()[: path.stat().st_size * 7 // 10])
    assert damaged_clusters(path, lambda _: None) == []
    assert [d.why for d in find_damage(probe(path))] == ["cut short"]
    assert find_damage(probe(path))[0].stop_s == Fraction(FRAMES, 30)
