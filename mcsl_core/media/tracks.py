"""A file's sound tracks: which there are, and a decoder for each that survives any order of channels.

PyAV 18 copies a channel layout without the list of channels that a layout of custom order points to, and frees that
list once for each copy: to ask a stream for its layout, or to let go of one decoded frame of it, aborts the process.
"""

from __future__ import annotations

import ctypes
from typing import Any

import av
from attrs import frozen

_MOST_CHANNELS = 64  # FFmpeg resamples no more


@frozen
class AudioTrack:
    """A sound track of a file.

    Attributes
    ----------
    position
        Among the file's sound tracks, from 0.
    codec
        FFmpeg's name; empty where it has no decoder.
    rate
        Samples per second; 0 without a decoder.
    channels
        How many; 0 without a decoder.
    order
        FFmpeg's name of the order of the channels.
    language
        As the file has it; empty without.
    """

    position: int
    codec: str
    rate: int
    channels: int
    order: str
    language: str

    @property
    def can_be_decoded(self) -> bool:
        """Whether there is a decoder, and it can be used without harm.

        xHE-AAC brings orders of its own, which nothing here can turn into plain ones before PyAV sees them.
        """
        plain = not (self.codec == "aac" and self._may_be_custom)
        return 0 < self.channels <= _MOST_CHANNELS and self.rate > 0 and plain

    @property
    def _may_be_custom(self) -> bool:
        return " channels (" in self.order or "ambisonic" in self.order

    def __str__(self) -> str:
        kind = ", ".join(filter(None, (self.codec or "without a decoder", self.language)))
        return f"sound track {self.position + 1} ({kind})"


def audio_tracks(container: Any) -> tuple[AudioTrack, ...]:
    """The sound tracks of an open container, in the file's order; none of them is decoded."""
    return tuple(_track(position, stream) for position, stream in enumerate(container.streams.audio))


def _track(position: int, stream: Any) -> AudioTrack:
    language = stream.metadata.get("language", "")
    language = "" if language == "und" else language
    context = stream.codec_context
    if context is None:
        return AudioTrack(position, "", 0, 0, "", language)
    layout = _kept(context.layout)
    rate = context.sample_rate or 0
    return AudioTrack(position, context.name, rate, layout.nb_channels, layout.name, language)


def _kept(layout: Any) -> Any:
    """A channel layout that is never let go of: 40 bytes lost each time a file is opened, against a process."""
    ctypes.pythonapi.Py_IncRef(ctypes.py_object(layout))
    return layout


def decoder_of(stream: Any, track: AudioTrack) -> Any:
    """What decodes the packets of ``stream``: its own context, or one that never heard of a custom order.

    The order is lost on the way, which does not matter to whoever mixes the channels into one.
    """
    own = stream.codec_context
    if not (track._may_be_custom or track.codec.startswith("pcm_")):
        return own
    context: Any = av.CodecContext.create(own.codec, "r")
    context.sample_rate = track.rate
    context.layout = {1: "mono", 2: "stereo"}.get(track.channels, f"{track.channels}C")
    if own.extradata:
        context.extradata = own.extradata
    return context
