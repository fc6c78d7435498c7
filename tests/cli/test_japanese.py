"""The command line in Japanese: every text that the source shows has its Japanese, and real messages are recognised."""

from __future__ import annotations

import re

import pytest
import shown_texts

from mcsl_core.cli.japanese import COMPOSED, OTHERS, OURS, TEXTS, WORDS

JAPANESE = re.compile("[\u3001-\u30ff\u4e00-\u9fff]")
SAME = {  # the same in every language
    "--audio {audio_from}",
    "--centre {centre}: {what}",
    "--polygon: {what}",
    "--rate: {error}",
    "FROM CLIP NAME",
    "FROM FILE",
    "LUT_3D_SIZE {NODES}",
    "SOURCE FILE",
    "IPT (Dolby Vision)",
    "MiB",
    "p (Holm)",
    "apt-get install -y {packages}",
    "rate: {error}",
    "{count} GB",
    "{count} MB",
    "{size} MB",
    "{size} kB",
}
NAMES = {"EDL", "EDL (edl.md)"}  # what a text may be without a Japanese letter


@pytest.fixture(scope="module")
def shown() -> set[str]:
    found = shown_texts.sources()
    shown_texts.messages(found)
    shown_texts.help_texts(found)
    return set(found.found) - SAME


def test_every_text_has_its_japanese(shown: set[str]) -> None:
    missing = sorted(shown - OURS.keys() - WORDS.keys())
    assert not missing, "\n".join(["mcsl_core/cli/japanese lacks:", *map(repr, missing)])


def test_no_japanese_is_left_over(shown: set[str]) -> None:
    assert sorted(OURS.keys() - shown) == []
    assert not OURS.keys() & (COMPOSED.keys() | OTHERS.keys())


def fields(text: str) -> list[str]:
    return sorted(re.findall(r"(?<!\{)\{(\w+)\}(?!\})", text))


def test_the_fields_of_a_text_are_kept() -> None:
    assert [english for english, japanese in TEXTS.items() if fields(english) != fields(japanese)] == []
    assert [
        e for e, japanese in (TEXTS | WORDS).items() if not JAPANESE.search(japanese) and japanese not in NAMES
    ] == []
