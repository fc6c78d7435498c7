"""Which sound track of a camera is heard, and how its channels become one: that which has the sound.

Recorders write several tracks, and often the first is an input that nothing is plugged into; they write two channels of
which one is dead, or two that cancel each other out. So pieces of each are listened to, the same for all files of a
camera, lest the sound changes with the file.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fractions import Fraction
from functools import lru_cache

import numpy as np
from attrs import field, frozen
from numpy.typing import NDArray

from mcsl_core.media.audio import read_audio
from mcsl_core.media.facts import MediaFacts
from mcsl_core.media.tracks import AudioTrack

_RATE, _WINDOW = 8000, 512  # samples a second, and those of one spectrum: 64 ms
_BAND_HZ = (300, 3400)  # voices and instruments; neither hum nor an offset
_PIECES, _PIECE_S = 12, Fraction(4)  # listened to of each camera
_SILENT = 1e-10  # power, -100 dB: less than the last of 16 bits
_FAINTER = 1e-2  # 20 dB: a track this much fainter than another is not the one that was plugged in
_DEAD = 1e-3  # 30 dB: what a channel catches of its neighbour's cable
_CANCELLED = 0.25  # of the power that is left where channels are averaged that have nothing to do with each other

Powers = Mapping[int, NDArray[np.float64]]  # number of channels -> (channels, channels) mean products in the band


@frozen
class SoundTrack:
    """What is heard of a camera.

    Attributes
    ----------
    position
        The track, among the sound tracks of each file; None where no file has any that can be decoded.
    shares
        Number of channels -> the share of each in what is heard; even shares where none are given.
    notes
        What a person should know of the choice.
    """

    position: int | None = None
    shares: Mapping[int, tuple[float, ...]] = field(factory=dict)
    notes: tuple[str, ...] = ()

    def of(self, facts: MediaFacts) -> AudioTrack | None:
        """The track that is heard of one of the camera's files: the chosen one, or the first where it lacks that."""
        usable = {track.position: track for track in facts.audio_tracks if track.can_be_decoded}
        first = next(iter(usable.values()), None)
        return first if self.position is None else usable.get(self.position, first)

    def mixed(self, samples: NDArray[np.float32]) -> NDArray[np.float32]:
        """(n,): channels (channels, n) made one."""
        if len(samples) == 1:
            return samples[0]
        shares = self.shares.get(len(samples)) or (1 / len(samples),) * len(samples)
        return np.asarray(shares, np.float32) @ samples


def sound_track(files: Sequence[MediaFacts]) -> SoundTrack:
    """What is heard of the camera with these files: the first track that has sound, and those of its channels that do.

    A track that has sound is neither silent nor much fainter than another. Where there is no choice, nothing is
    listened to.
    """
    states = ((file.path.stat().st_size, file.path.stat().st_mtime_ns) for file in files)
    return _sound_track(tuple(files), tuple(states))


@lru_cache(maxsize=64)
def _sound_track(files: tuple[MediaFacts, ...], _states: tuple[tuple[int, int], ...]) -> SoundTrack:
    tracks = {track.position: track for file in reversed(files) for track in file.audio_tracks}
    usable = sorted({t.position for file in files for t in file.audio_tracks if t.can_be_decoded})
    heard: dict[int, Powers] = {}
    chosen = next(iter(usable), None)
    if len(usable) > 1 or any(track.channels > 1 for file in files for track in file.audio_tracks):
        # A file with one track has no say in which of several has the sound.
        judged = [file for file in files if sum(t.can_be_decoded for t in file.audio_tracks) > 1] or files
        heard = {position: _powers(position, _pieces(judged)) for position in usable}
        if len(usable) > 1 and max(map(_loudness, heard.values())) < _SILENT:  # a word said once may lie between them
            heard = {position: _powers(position, _whole(judged)) for position in usable}
        loudest = max(map(_loudness, heard.values()), default=0.0)
        audible = (p for p in usable if _loudness(heard[p]) >= max(_SILENT, _FAINTER * loudest))
        chosen = next(audible, chosen)
    notes = []
    if chosen != 0 and tracks:
        passed = [f"{t} {_why_not(t, heard)}" for p, t in sorted(tracks.items()) if chosen is None or p < chosen]
        is_heard = "it has no sound" if chosen is None else f"{tracks[chosen]} is heard"
        notes.append(f"{is_heard}: {', '.join(passed)}")
    shares = {}
    for channels, products in (heard.get(chosen, {}) if chosen is not None else {}).items():
        shares[channels], note = _shares(products)
        notes += [note] * bool(note)
    return SoundTrack(chosen, shares, tuple(notes))


def _why_not(track: AudioTrack, heard: Mapping[int, Powers]) -> str:
    if not track.can_be_decoded or not heard.get(track.position):
        return "cannot be decoded"
    return "is silent" if _loudness(heard[track.position]) < _SILENT else "is much fainter"


def _shares(products: NDArray[np.float64]) -> tuple[tuple[float, ...], str]:
    """The share of each channel, and what is to be told of it: even shares of those that have sound.

    Where they cancel each other out, the loudest alone.
    """
    powers = products.diagonal()
    live = powers >= max(_SILENT, _DEAD * powers.max())
    count = int(live.sum())
    if len(powers) == 1 or count == 0:
        return (1 / len(powers),) * len(powers), ""
    shares = live / count
    if shares @ products @ shares < _CANCELLED * powers[live].mean() / count:
        shares = np.eye(len(powers))[powers.argmax()]
        note = f"its channels cancel each other out, so channel {powers.argmax() + 1} alone is heard"
    else:
        named = ", ".join(str(index + 1) for index in np.flatnonzero(live))
        note = f"of its {len(powers)} channels only {named} has sound" if count < len(powers) else ""
    return tuple(map(float, shares)), note


# ------------------------------------------------------------------------------------------------------- listening


def _pieces(files: Sequence[MediaFacts]) -> list[tuple[MediaFacts, Fraction, Fraction]]:
    """(file, start, stop): what is listened to, spread evenly over all of the camera's files."""
    total = sum((file.end_s for file in files), Fraction(0))
    starts = [total * (2 * n + 1) / (2 * _PIECES) - _PIECE_S / 2 for n in range(_PIECES)]
    pieces, begin = [], Fraction(0)
    for file in files:
        inside = [max(start - begin, Fraction(0)) for start in starts if begin <= max(start, 0) < begin + file.end_s]
        pieces += [(file, start, start + _PIECE_S) for start in inside]
        begin += file.end_s
    return pieces


def _whole(files: Sequence[MediaFacts]) -> list[tuple[MediaFacts, Fraction, Fraction]]:
    return [(file, Fraction(0), file.end_s) for file in files]


def _powers(position: int, pieces: Sequence[tuple[MediaFacts, Fraction, Fraction]]) -> Powers:
    """The mean powers of a track's channels in the band, and how they go together; empty where nothing is decoded."""
    sums: dict[int, NDArray[np.float64]] = {}
    counts: dict[int, int] = {}
    window = np.hanning(_WINDOW)
    hertz = np.fft.rfftfreq(_WINDOW, 1 / _RATE)
    band = (hertz >= _BAND_HZ[0]) & (hertz <= _BAND_HZ[1])
    scale = 2 / (_WINDOW * float((window**2).sum()))  # so that it is the variance of the samples
    for file, start, stop in pieces:
        track = next((t for t in file.audio_tracks if t.position == position and t.can_be_decoded), None)
        for at, samples in read_audio(file, track, start, _RATE) if track else ():
            if at >= stop:
                break
            whole = samples.shape[1] // _WINDOW * _WINDOW
            spectra = np.fft.rfft(samples[:, :whole].reshape(len(samples), -1, _WINDOW) * window)[..., band]
            products = np.einsum("awf,bwf->ab", spectra, spectra.conj()).real * scale
            sums[len(samples)] = sums.get(len(samples), 0) + products
            counts[len(samples)] = counts.get(len(samples), 0) + whole // _WINDOW
    return {channels: sums[channels] / max(1, counts[channels]) for channels in sums}


def _loudness(powers: Powers) -> float:
    return max((float(products.max()) for products in powers.values()), default=-1.0)
