"""The command line in Japanese: every text that the source shows has its Japanese, and real messages are recognised."""

from __future__ import annotations

import errno
import json
import os
import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import av
import click
import pytest
import shown_texts
from click.testing import CliRunner
from rich.cells import cell_len

from mcsl_core.cli import language
from mcsl_core.cli.japanese import COMPOSED, OTHERS, OURS, TEXTS, WORDS
from mcsl_core.cli.main import cli, main
from mcsl_core.cli.output import Session

JAPANESE = re.compile("[\u3001-\u30ff\u4e00-\u9fff]")
SAME = {  # the same in every language
    "MCSL CUT",
    "MCSL CUT SHOWN",
    "--audio {audio_from}",
    "--centre {centre}: {what}",
    "--polygon: {what}",
    "--rate: {error}",
    "FROM CLIP",
    "FROM CLIP NAME",
    "FROM FILE",
    *("TO CLIP", "TO CLIP NAME", "TO FILE"),
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


@pytest.mark.parametrize(
    ("environ", "japanese"),
    [
        ({"LANG": "ja_JP.UTF-8"}, True),
        ({"LANGUAGE": "ja"}, True),
        ({"LANGUAGE": "fr:ja:en", "LANG": "C"}, True),
        ({"LANGUAGE": "en:ja"}, False),
        ({"LANGUAGE": "", "LC_ALL": "ja_JP"}, True),
        ({"LC_ALL": "C", "LANG": "ja_JP.UTF-8"}, False),
        ({"LC_MESSAGES": "ja_JP.eucJP", "LANG": "de_DE.UTF-8"}, True),
        ({"LANG": "de_DE.UTF-8"}, False),
        ({"LANG": "POSIX"}, False),
        ({}, False),
    ],
)
def test_the_language_is_that_of_the_environment(environ: dict[str, str], japanese: bool) -> None:
    assert language.is_japanese(environ) is japanese


@pytest.fixture
def in_japanese(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("LANGUAGE", "ja")


@pytest.mark.usefixtures("in_japanese")
def test_every_text_is_recognised_when_it_is_filled_in() -> None:
    wrong = []
    for english, japanese in TEXTS.items():
        # a word of no language, and what is left out of a text that ends in "and 3 more"
        given = {name: "7" if name == "count" else f"xq{at}" for at, name in enumerate(dict.fromkeys(fields(english)))}
        given |= {name: "" for name in re.findall(r"\}\{(\w+)\}", english)}
        if fields(english) and language.told(english.format(**given)) != japanese.format(**given):
            wrong.append((english, language.told(english.format(**given))))
        elif not fields(english) and language.told(english) != japanese:
            wrong.append((english, language.told(english)))
    assert wrong == []


@pytest.mark.usefixtures("in_japanese")
@pytest.mark.parametrize(
    ("english", "japanese"),
    [
        ("cannot be written (No space left on device)", "書き込めません（ディスクに空きがありません）"),
        ("is a folder, not an EDL", "EDLではなくフォルダーです"),
        ("a.mp4 and b.mp4", "a.mp4 と b.mp4"),
        ("3 operations failed", "手術 3 件が失敗しました"),
        (
            "leads out of the EDL's folder, to /a b (and 2 more paths)",
            "EDL のフォルダーの外の /a b を指しています（ほか 2 個のパス）",
        ),
        ("must be 0 to 1, got 7 (and 3 more faults)", "0〜1でなければなりませんが、7 です（ほかに 3 件の誤り）"),
        (
            "x: 2 cameras, 0:00:06 at 25 frames/s, 1 shot, 0 overrides",
            "x: カメラ 2 台、0:00:06、25 フレーム/秒、1 ショット、手動変更 0 件",
        ),
        ("s/cut.fcpxml: 7 shots, 5 cameras", "s/cut.fcpxml: 7 ショット、カメラ 5 台"),
        ("edl.json at $.rate", "edl.json の $.rate"),
        # names stay: a camera called as a stage is, a file called as a word
        ("camera timeline", "カメラ timeline"),
        ("a sentence that nobody knows, from here to there", "a sentence that nobody knows, from here to there"),
        ("Traceback (most recent call last):\n  File x", "Traceback (most recent call last):\n  File x"),
    ],
)
def test_what_fills_a_text_is_told_as_well(english: str, japanese: str) -> None:
    assert language.told(english) == japanese


def lines_of(capsys: pytest.CaptureFixture[str]) -> list[str]:
    captured = capsys.readouterr()
    return (captured.out + captured.err).splitlines()


@pytest.mark.usefixtures("in_japanese")
def test_an_error_says_what_where_and_what_to_do(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    (tmp_path / "edl.json").write_text('{"schema": ')
    assert main(["look", str(tmp_path / "edl.json")]) == 3
    assert lines_of(capsys) == [
        f"mcsl: {tmp_path}/edl.json の 1 行目 12 文字目: JSON ではありません: 値がありません。"
        "ファイルが途中で切れているかもしれません。元に戻すか、作り直してください"
    ]


@pytest.mark.usefixtures("in_japanese")
def test_json_tells_people_and_names_for_programs(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    assert main(["--progress", "json", "look", str(tmp_path / "none.json")]) == 3
    (line,) = lines_of(capsys)
    assert json.loads(line)["error"] == {
        "what": "見つかりません",
        "where": f"{tmp_path}/none.json",
        "remedy": "パスを確認してください",
        "exit_code": 3,
    }
    with Session("json").progress() as progress:
        progress.stage("Scoring the views", 8, "samples")
        progress.note("cam1 has no sound, so the programme has none")
    stage, note = map(json.loads, lines_of(capsys))
    assert stage == {"stage": "Scoring the views", "total": 8, "unit": "samples", "shown": "画像の採点"}
    assert note == {"note": "cam1 に音声がないので、本編にも音声がありません"}


@pytest.mark.usefixtures("in_japanese")
def test_stages_and_notes_at_a_terminal(capsys: pytest.CaptureFixture[str]) -> None:
    with Session("lines").progress() as progress:
        progress.stage("Scoring the views", 8, "samples")
        progress.note("cam1 has no sound, so the programme has none")
    stage, note = lines_of(capsys)
    assert stage.endswith("s  画像の採点 (8 サンプル)")
    assert note.endswith("s  お知らせ: cam1 に音声がないので、本編にも音声がありません")


def every_command(group: click.Group, *words: str) -> Iterator[tuple[str, ...]]:
    yield words
    for name, command in group.commands.items():
        yield from every_command(command, *words, name) if isinstance(command, click.Group) else [(*words, name)]


@pytest.mark.usefixtures("in_japanese")
@pytest.mark.parametrize("words", [*every_command(cli)], ids=" ".join)
def test_help_is_japanese_and_fits_a_terminal(words: tuple[str, ...]) -> None:
    done = CliRunner().invoke(cli, [*words, "--help"], prog_name="mcsl", terminal_width=80)
    assert done.exit_code == 0
    lines = done.output.splitlines()
    assert lines[0].startswith(" ".join(("使い方: mcsl", *words, "[オプション]")))
    assert max(map(cell_len, lines)) <= 80
    assert not re.search(r"[a-z]{3,} [a-z]{3,} [a-z]{3,}", "\n".join(lines[1:])), "an English sentence"
    assert not any(line.lstrip().startswith(tuple("、。）ー")) for line in lines)
    starts = {match.end() for line in lines if (match := re.match(r"  -.*?\S {2,}(?=\S)", line))}
    assert len(starts) <= 1, "ragged"


@pytest.mark.usefixtures("in_japanese")
@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (["render"], "エラー: 引数 'SOURCE' が必要です。"),
        (["rendr"], "エラー: コマンド 'rendr' はありません。（次のどれかですか: 'blender', 'render'）"),
        (["look", "--fil"], "エラー: オプション '--fil' はありません。"),
        (
            ["render", "e.json", "-o", "x.mp4", "--jobs", "0"],
            "エラー: '--jobs' の値が正しくありません: 0 は範囲 x>=1 の外です。",
        ),
    ],
)
def test_a_wrong_call_is_told_with_where_help_is(
    capsys: pytest.CaptureFixture[str], arguments: list[str], told: str
) -> None:
    assert main(arguments) == 2
    usage, hint, *_, error = lines_of(capsys)
    assert usage.startswith("使い方: mcsl")
    assert re.fullmatch(r"使い方は 'mcsl.* --help' で表示します。", hint)
    assert error.startswith(told)


def test_english_imports_no_japanese(tmp_path: Path) -> None:
    code = (
        "import sys; from mcsl_core.cli.main import main; main(sys.argv[1:]); "
        "print([name for name in sys.modules if 'japanese' in name])"
    )
    command = [sys.executable, "-c", code, "look", str(tmp_path / "none.json")]
    done = subprocess.run(command, capture_output=True, text=True, env={**os.environ, "LANGUAGE": "en"}, check=True)
    assert done.stdout.split() == ["[]"]
    assert done.stderr == f"mcsl: {tmp_path}/none.json: does not exist. Check the path\n"


def test_texts_of_others_are_theirs() -> None:
    """click's templates, and the system's and FFmpeg's words, are still what the catalogue has."""
    files = [*Path(click.__file__).parent.glob("*.py"), *Path(json.__file__).parent.glob("*.py")]
    source = re.sub(r'"\s*\n\s*"', "", "".join(path.read_text("utf-8") for path in files)).replace("!r}", "}")
    system = {os.strerror(number) for number in errno.errorcode} | {kind.strerror for kind in av.error.ErrorType}
    with pytest.raises(json.JSONDecodeError) as raised:
        json.loads('"\n"')
    system.add(raised.value.msg)
    assert [text for text in OTHERS if text not in source and text not in system] == []
