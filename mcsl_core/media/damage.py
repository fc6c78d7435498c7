"""Where a file has no whole pictures: what its packets tell, the file read once from end to end."""

from __future__ import annotations

from array import array
from collections.abc import Callable, Iterable, Sequence
from fractions import Fraction
from pathlib import Path

import numpy as np
from attrs import frozen
from numpy.typing import NDArray

from .checksums import damaged_clusters
from .facts import MediaFacts
from .opening import main_video, open_file, timestamp_of
from .packets import judged_packets

_HOLE_S = 1.0  # without any packet: less is a recorder that dropped some pictures
_HOLE_STEPS = 6  # times the widest usual step, for films whose rate varies
_TOLD_BYTES = 8 << 20
_TS_SYNC, _TS_PACKET, _M2TS_PACKET, _M2TS_HEAD = b"G", 188, 192, 4  # M2TS puts a time before each packet


@frozen
class Damage:
    """A stretch of a file without a picture, on the file's own time.

    Attributes
    ----------
    start_s, stop_s
        From the first picture that is not whole, or not there, to the next that is.
    why
        In words for a person.
    """

    start_s: Fraction
    stop_s: Fraction
    why: str


def find_damage(facts: MediaFacts, told: Callable[[int], None] | None = None) -> tuple[Damage, ...]:
    """Where a file has no whole pictures.

    Parameters
    ----------
    facts
        The file, as `probe` describes it.
    told
        Called with the bytes that have been passed, again and again; what it raises ends the work.

    Returns
    -------
    tuple of Damage
        In order, apart from each other. The end that a file lacks (`MediaFacts.truncated`) is one; of a transport
        stream, which promises none, its last picture.

    Notes
    -----
    Nothing is decoded; `packets` says what that cannot see, and a file with checksums (`checksums`) hides nothing. A
    source that stands still is no damage: its pictures are there.
    """
    stamps, spans = _read(facts, told or (lambda _: None))
    found = [Damage(start, facts.usable_s if stop is None else stop, "damaged") for start, stop in spans]
    found += [Damage(start, stop, "nothing recorded") for start, stop in _holes(stamps, facts)]
    if facts.usable_s < facts.end_s:
        found.append(Damage(facts.usable_s, facts.end_s, "cut short"))
    elif _ends_inside_a_packet(facts.path):
        found.append(Damage(facts.end_s - 1 / facts.rate, facts.end_s, "cut short"))
    return _merged(found, 1 / facts.rate)


def _read(facts: MediaFacts, told: Callable[[int], None]) -> tuple[list[int], list[tuple[Fraction, Fraction | None]]]:
    """The timestamps of all pictures, and from where to where they are not whole; to the end without a stop."""
    pictures = _pictures(facts, told)
    hidden = _hidden(pictures, damaged_clusters(facts.path, told))
    spans: list[tuple[Fraction, Fraction | None]] = []
    begun: int | None = None
    smears = False
    for number, (stamp, _, is_keyframe, whole) in enumerate(pictures.tolist()):
        smears = number in hidden or (smears and not is_keyframe)
        if not whole or smears:
            begun = stamp if begun is None else min(begun, stamp)
        elif begun is not None:
            spans.append((_own_time(begun, facts), _own_time(stamp, facts)))
            begun = None
    if begun is not None:
        spans.append((_own_time(begun, facts), None))
    return pictures[:, 0].tolist(), spans


def _pictures(facts: MediaFacts, told: Callable[[int], None]) -> NDArray[np.int64]:
    """(N, 4) of the file's pictures in its order: timestamp in ticks, byte, whether it is a keyframe, whether whole."""
    rows, passed = array("q"), 0
    with open_file(facts.path) as container:
        stream = main_video(container, facts.path)
        for packet, whole in judged_packets(container, stream, facts.rate):
            stamp = timestamp_of(packet)
            if stamp is None or not packet.size:
                continue
            byte = -1 if packet.pos is None else packet.pos
            rows.extend((stamp, byte, packet.is_keyframe, whole))
            if byte - passed > _TOLD_BYTES:
                passed = byte
                told(passed)
    return np.array(rows, np.int64).reshape(-1, 4)


def _hidden(pictures: NDArray[np.int64], wrong: Sequence[range]) -> set[int]:
    """The pictures of which checksums alone tell: of clusters that are ``wrong`` where no packet looks it."""
    hidden: set[int] = set()
    for place in wrong:
        inside = np.flatnonzero((pictures[:, 1] >= place.start) & (pictures[:, 1] < place.stop))
        if pictures[inside, 3].all():
            hidden.update(inside.tolist())
    return hidden


def _own_time(ticks: int, facts: MediaFacts) -> Fraction:
    return ticks * facts.tick_s - facts.zero_s


def _holes(stamps: list[int], facts: MediaFacts) -> list[tuple[Fraction, Fraction]]:
    """Where no packet is for so long that nothing was recorded, or nothing of it is left."""
    shown = np.sort(np.array(stamps, np.int64))
    steps = np.diff(shown)
    if len(steps) < 2:
        return []
    usual, widest = int(np.median(steps)), float(np.percentile(steps, 99))
    wide = np.flatnonzero(steps > max(_HOLE_S / float(facts.tick_s), _HOLE_STEPS * widest))
    ends = [(int(shown[i]) + usual, int(shown[i + 1])) for i in wide]
    return [(_own_time(start, facts), _own_time(stop, facts)) for start, stop in ends]


def _ends_inside_a_packet(path: Path) -> bool:
    """Whether a transport stream was cut short: it promises no end, but its packets are of one length."""
    with path.open("rb") as stream:
        head = stream.read(_M2TS_HEAD + _M2TS_PACKET + 1)
    for length, at in ((_TS_PACKET, 0), (_M2TS_PACKET, _M2TS_HEAD)):
        if head[at : at + 1] == head[at + length : at + length + 1] == _TS_SYNC:
            return path.stat().st_size % length != 0
    return False


def _merged(found: Iterable[Damage], step_s: Fraction) -> tuple[Damage, ...]:
    merged: list[Damage] = []
    for damage in sorted(found, key=lambda d: (d.start_s, d.stop_s)):
        if damage.stop_s <= damage.start_s:
            continue
        if merged and damage.start_s <= merged[-1].stop_s + step_s:
            last = merged.pop()
            reasons = dict.fromkeys([*last.why.split(", "), damage.why])
            if "damaged" in reasons:
                reasons.pop("nothing recorded", None)
            damage = Damage(last.start_s, max(last.stop_s, damage.stop_s), ", ".join(reasons))
        merged.append(damage)
    return tuple(merged)
