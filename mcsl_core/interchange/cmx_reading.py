"""CMX3600 edit decision lists as they come back from an editor."""

from __future__ import annotations

import re
from collections.abc import Iterator
from fractions import Fraction
from itertools import pairwise, zip_longest
from pathlib import Path

from mcsl_core.errors import DocumentError, UsageError
from mcsl_core.input_files import read_text
from mcsl_core.timing import FrameRange

from .found import FoundClip, FoundCut
from .timecode import count_of, day_s, may_drop
from .xml_text import path_of

WHAT = "an edit decision list (CMX3600)"
_CODE = r"(\d{2}:\d{2}:\d{2}[:;.,]\d{2})"
_EVENT = re.compile(rf"(\d+)\s+(\S.*?)\s+(\S+)\s+([CDWK]\S*)\s+(?:(\S+)\s+)?{_CODE}\s+{_CODE}\s+{_CODE}\s+{_CODE}")
_NUMBERED_TRACK = re.compile(r"V[1-9]\d?")
_LEVEL = re.compile(r"\*?\s*AUDIO LEVEL AT (\S+) IS ([-+ ]*\d+(?:\.\d+)?) DB.*", re.IGNORECASE)
_NUMBERED = re.compile(r"\d{3,}\s")
_FROM, _TO = ("FROM CLIP NAME", "SOURCE FILE", "FROM FILE", "FROM CLIP"), ("TO CLIP NAME", "TO FILE", "TO CLIP")
_COMMENT = re.compile(rf"\*?\s*({'|'.join((*_FROM, *_TO))}|LOC|MCSL CUT SHOWN|MCSL CUT)\s*:\s*(.*)")
_SPEED = re.compile(r"M2\s+\S+\s+0*(\d+(?:\.\d+)?)\b.*")
_LOCATOR = re.compile(rf"{_CODE}\s+\S+\s*(.*)")
_CUT = re.compile(rf"([0-9a-f]{{16}})\s+{_CODE}")
_BLACK = ("BL", "BLACK")
_Event = tuple[re.Match[str], bool, dict[str, str]]  # and whether its timecode is drop-frame, and its comments


def read_cmx(path: Path, rate: Fraction) -> FoundCut:
    """The events of a list.

    Parameters
    ----------
    path
        The list.
    rate
        Frames a second, which a list does not say: the programme's.

    Raises
    ------
    InputError
        Where it cannot be read, or is no list.
    """
    lines = read_text(path, wanted=WHAT, remedy="Hand in the .edl file as the editor exported it").splitlines()
    return _Reader(path, rate).read(lines)


class _Reader:
    """Frames are counted from where the export began, as a comment says; where it is lost, from the first event."""

    def __init__(self, path: Path, rate: Fraction) -> None:
        self._path, self._rate = path, rate
        self._drop = False
        self.notes: list[str] = []

    def read(self, lines: list[str]) -> FoundCut:
        events: list[_Event] = []
        shown: list[str] = []
        markers, basis, zero = [], "", None
        for number, line in enumerate(map(str.strip, lines), start=1):
            if line.startswith("FCM:"):
                self._drop = "NON" not in line and may_drop(self._rate)
            elif event := _EVENT.fullmatch(line):
                self._check(event, number)
                events.append((event, self._drop, {}))
            elif comment := _COMMENT.fullmatch(line):
                name, text = comment.groups()
                if name == "MCSL CUT" and (cut := _CUT.fullmatch(text)):
                    basis, zero = cut[1], self._count(cut[2], self._drop, number)
                elif name == "MCSL CUT SHOWN":
                    shown.append(text)
                elif name == "LOC" and (locator := _LOCATOR.fullmatch(text)):
                    markers.append((self._count(locator[1], self._drop, number), locator[2]))
                elif events:
                    events[-1][2][name] = text
            elif level := _LEVEL.fullmatch(line):
                if set(level[2]) & set("123456789"):
                    self.notes.append(f"a level of the sound of {level[2].strip()} dB at {level[1]}")
            elif line.startswith("M2") and not self._is_usual(line):
                self.notes.append(f"a change of speed in line {number}")
                if events:
                    events[-1][2]["M2"] = line
            elif _NUMBERED.match(line):
                raise self._unreadable(number)
        _share(events)
        if not events:
            raise DocumentError("has no events", where=str(self._path), remedy=f"Check that it is {WHAT}")
        self.notes += [f"the transition {event[4]} of event {event[1]}" for event, _, _ in events if event[4] != "C"]
        pictures = [event for event in events if "V" in event[0][3] or event[0][3] == "B"]
        if zero is None and pictures:
            zero = self._count(pictures[0][0][8], pictures[0][1])
        clips = tuple(self._clips(pictures, zero or 0))
        unread = [clip for clip in clips if clip.unread]
        self.notes += [f"the clip {clip.name!r} at frame {clip.range.start}, which has no reel" for clip in unread]
        heard = [event for event in events if "A" in event[0][3] or event[0][3] == "B"]
        return FoundCut(
            rate=self._rate,
            clips=clips,
            sounds=tuple(self._clips(heard, zero or 0)),
            markers=tuple((self._since(zero or 0, at), name) for at, name in markers),
            origin=" ".join([basis, *shown]) if basis else "",
            notes=tuple(self.notes),
        )

    def _check(self, event: re.Match[str], number: int) -> None:
        """DocumentError where an event ends before it begins; what passes midnight does not."""
        start, stop = (self._count(code, self._drop, number) for code in (event[8], event[9]))
        day = int(day_s(self._rate, drop=self._drop) * self._rate)
        if (stop - start) % day > day // 2:
            raise self._unreadable(number)

    def _unreadable(self, number: int) -> DocumentError:
        what = "begins as an event and is none that can be read"
        return DocumentError(what, where=f"{self._path}, line {number}", remedy="Correct it, or export again")

    def _is_usual(self, line: str) -> bool:
        """Whether a line of speed, in pictures a second, says that it is the usual one."""
        said = _SPEED.fullmatch(line)
        return said is not None and abs(float(said[1]) - float(self._rate)) < 0.02  # two decimals are written

    def _clips(self, events: list[_Event], zero: int) -> Iterator[FoundClip]:
        for (event, drop, said), (after, _, _) in zip_longest(events, events[1:], fillvalue=(None, False, {})):
            assert event is not None  # there are fewer that follow
            yield from self._clip(event, drop, said, zero, after)

    def _clip(
        self, event: re.Match[str], drop: bool, said: dict[str, str], zero: int, after: re.Match[str] | None
    ) -> Iterator[FoundClip]:
        """An event's clip; under a transition into it, or into the one ``after`` it, the cut is in the middle."""
        reel, track = event[2], event[3]
        marked = ";" in event[8]  # then a label without it is none of drop-frame, whatever the list says
        late = _half(event)
        source = self._count(event[6], drop and not marked) + late
        start, stop = (self._since(zero, self._count(code, drop)) for code in (event[8], event[9]))
        start += late
        if after is not None and after[8] == event[9]:
            stop += _half(after)
        name = said.get("FROM CLIP NAME", "")
        if start >= stop or (reel in _BLACK and not name):
            return
        yield FoundClip(
            name=name,
            range=FrameRange(start, stop),
            layer=int(track[1:]) if _NUMBERED_TRACK.fullmatch(track) else 1,
            path=said.get("SOURCE FILE") or said.get("FROM FILE") or _file_of(said.get("FROM CLIP", "")),
            reel=reel,
            source_s=source / self._rate,
            retimed="M2" in said,
            unread=reel in _BLACK,  # black bears no name: this was made in the editor
        )

    def _since(self, zero: int, count: int) -> int:
        """Frames from ``zero`` on, past midnight too."""
        return (count - zero) % int(day_s(self._rate, drop=self._drop) * self._rate)

    def _count(self, code: str, drop: bool, line: int | None = None) -> int:
        text = code.replace(",", ";").replace(".", ":")
        text = text[:8] + (";" if drop or text[8] == ";" else ":") + text[9:]
        try:
            return count_of(text, self._rate)[0]
        except UsageError as error:
            where = f"{self._path}, line {line}" if line else str(self._path)
            raise DocumentError(error.what, where=where, remedy="Check the rate of the EDL and of this list") from error


def _share(events: list[_Event]) -> None:
    """Of comments that name both clips of a transition, each gets its own: the line before it, of one event, what goes.

    A list that names one clip names the event's own.
    """
    for (before, _, goes), (event, _, comes) in pairwise(events):
        if event[4][0] not in "DWK" or not any(name in comes for name in _TO):
            continue
        left = {name: comes.pop(name) for name in _FROM if name in comes}
        if before[1] == event[1]:
            goes.update({name: text for name, text in left.items() if name not in goes})
        file = comes.get("TO FILE") or _file_of(comes.get("TO CLIP", ""))
        comes |= {"FROM CLIP NAME": comes.get("TO CLIP NAME", ""), "SOURCE FILE": file}


def _file_of(text: str) -> str:
    """The path in a comment that some programs fill with one, others with a name."""
    return path_of(text) if text.startswith("file:") else text if "/" in text or "\\" in text else ""


def _half(event: re.Match[str]) -> int:
    """Frames from where an event's dissolve or wipe begins to its middle; where the cut was, a list does not say."""
    lasts = event[5] or ""
    return int(lasts) // 2 if event[4][0] in "DW" and re.fullmatch(r"\d{1,4}", lasts) else 0
