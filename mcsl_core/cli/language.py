"""The command line in the user's language, told where a text reaches a person; programs and logs read English.

English is the text itself. A text arrives filled in, ``cannot be read (Permission denied)``: it is recognised by the
template it was made from, ``cannot be read ({strerror})``, and what fills a field is told as well. What no template
knows stays English.
"""

from __future__ import annotations

import os
import re
from collections.abc import Mapping
from functools import cache, cached_property

from attrs import frozen

_LONGEST = 4000  # letters of a text that is recognised; what is longer is somebody's output
_SHORT = 5  # letters of a template, "{start} to {stop}", whose fields are words, else it would fit any sentence
_NUMBERS = ("count",)  # fields that are numbers
_MORE = r"(?:[ ,(]*and \d+ more.*)?"  # " (and 3 more paths)", or nothing


def is_japanese(environ: Mapping[str, str] = os.environ) -> bool:
    """Whether the user's language is Japanese: by LANGUAGE, LC_ALL, LC_MESSAGES or LANG, as gettext goes by them."""
    for name in ("LANGUAGE", "LC_ALL", "LC_MESSAGES", "LANG"):
        for wanted in environ.get(name, "").split(":"):
            language = re.split("[_.@]", wanted.strip())[0].lower()
            if language in ("ja", "en", "c", "posix"):
                return language == "ja"
        if environ.get(name):
            return False
    return False


def told(text: str) -> str:
    """``text`` in the user's language, each of its lines."""
    if not text or not is_japanese():
        return text
    return _catalogue().told(text)


def word(text: str) -> str:
    """A single word, a unit or a table's heading, in the user's language: in a sentence it may be a name."""
    if not is_japanese():
        return text
    return _catalogue().words.get(text) or _catalogue().told(text)


@frozen(slots=False)
class _Template:
    """An English text with fields, and its Japanese."""

    english: str
    japanese: str

    @cached_property
    def literals(self) -> tuple[str, ...]:
        """Its English between the fields."""
        parts = re.split(r"(?<!\{)\{\w+\}(?!\})", self.english)
        return tuple(part.replace("{{", "{").replace("}}", "}") for part in parts)

    @cached_property
    def weight(self) -> int:
        """How much of it is text: what says most is tried first."""
        return sum(map(len, self.literals))

    @cached_property
    def pattern(self) -> re.Pattern[str]:
        """What a text that was made of it looks like."""
        names = re.findall(r"(?<!\{)\{(\w+)\}(?!\})", self.english)
        short = sum(letter.isalpha() for literal in self.literals for letter in literal) < _SHORT
        seen: set[str] = set()
        pieces = [re.escape(self.literals[0])]
        for name, literal in zip(names, self.literals[1:], strict=True):
            form = r"\d[\d,.]*" if name in _NUMBERS else r"\S+?" if short else r".+?"
            if seen and pieces[-1] == "":  # right behind another field
                form = _MORE
            pieces += [f"(?P={name})" if name in seen else f"(?P<{name}>{form})", re.escape(literal)]
            seen.add(name)
        return re.compile("".join(pieces), re.DOTALL)

    def fields(self, text: str) -> Mapping[str, str] | None:
        """What fills its fields in ``text``; None where that was not made of it."""
        at = 0
        if not text.startswith(self.literals[0]) or not text.endswith(self.literals[-1]):
            return None
        for literal in self.literals:
            at = text.find(literal, at)
            if at < 0:
                return None
            at += len(literal)
        found = self.pattern.fullmatch(text)
        return found and found.groupdict()


class Catalogue:
    """Japanese by English.

    Parameters
    ----------
    texts : mapping of str to str
        Templates with the same fields.
    words : mapping of str to str
        What is looked up by itself alone.
    """

    def __init__(self, texts: Mapping[str, str], words: Mapping[str, str]) -> None:
        self.words = words
        self._whole = {english: japanese for english, japanese in texts.items() if "{" not in english}
        templates = [_Template(*each) for each in texts.items() if "{" in each[0]]
        numbers = tuple(f"{{{name}}}" for name in _NUMBERS)
        self._templates = sorted(templates, key=lambda each: (-each.weight, not each.english.startswith(numbers)))

    def told(self, text: str) -> str:
        """``text``, whose templates are known, in Japanese; else as it is."""
        if len(text) > _LONGEST:
            return text
        return self._known(text) or "\n".join(self._line(line) for line in text.split("\n"))

    def _line(self, line: str) -> str:
        within = line.strip()
        told = (self._known(within) or self._sentences(within)) if within else None
        if told is None:
            return line
        before, after = line.split(within, 1)
        return ("" if told.startswith("（") else before) + told + after  # the bracket is wide enough

    def _known(self, text: str) -> str | None:
        if text in self._whole:
            return self._whole[text]
        for template in self._templates:
            given = template.fields(text)
            if given is not None:
                return template.japanese.format(**{name: self._field(value) for name, value in given.items()})
        return None

    def _field(self, value: str) -> str:
        if " " not in value.strip():  # it may be a camera's or a file's name
            return value
        return self._line(value)

    def _sentences(self, text: str) -> str | None:
        """Known texts that stand together: ``a, b``, ``where: what. Remedy``."""
        for mark, ours in ((". ", "。"), ("; ", "; "), (", ", "、")):
            parts = text.split(mark)
            told = [self._phrase(part) or self._led(part) or part for part in parts]
            if len(parts) > 1 and told != parts:
                return ours.join(told)
        return self._led(text)

    def _led(self, text: str) -> str | None:
        """What is said of something: ``where: what``."""
        where, colon, rest = text.partition(": ")
        said = (self._phrase(rest) or self._sentences(rest)) if colon else None
        return said and f"{self._phrase(where) or where}: {said}"

    def _phrase(self, text: str) -> str | None:
        return self._known(text) if " " in text else None


@cache
def _catalogue() -> Catalogue:
    from .japanese import TEXTS, WORDS

    return Catalogue(TEXTS, WORDS)
