"""What mcsl and Blender say to each other: refused where it is wrong, the same bytes as `--progress json` writes."""

from __future__ import annotations

import io
import json
import subprocess
import sys
from pathlib import Path

import pytest
from click.testing import CliRunner

from mcsl_core.blender.messages import (
    ConformedMedia,
    ConformedPiece,
    Done,
    Failed,
    Failure,
    MessageFile,
    Note,
    OfferedPlugin,
    RefreshRequest,
    RenderRequest,
    Result,
    Stage,
    Step,
    TimelineRequest,
    parse_message,
    structure,
    to_json,
)
from mcsl_core.delivery.presets import load_preset
from mcsl_core.errors import DocumentError, Fault
from mcsl_core.progress import JsonLines
from mcsl_core.timing import FrameRange

R = FrameRange


def a_request(**fields) -> TimelineRequest:
    given = {
        "edl": Path("/edit/edl.json"),
        "blend": Path("/edit/edit.blend"),
        "conformed": (
            ConformedPiece(R(0, 60), Path("/edit/a.mp4")),
            ConformedPiece(R(60, 90), Path("/edit/b.mp4")),
        ),
        "sound": Path("/edit/sound.wav"),
        "preset": load_preset("prores"),
        "output": "edit.mov",
    }
    return TimelineRequest(**{**given, **fields})


def test_a_request_comes_out_as_it_went_in():
    for request in (a_request(), a_request(conformed=(), sound=None)):
        assert structure(json.loads(json.dumps(to_json(request))), TimelineRequest, where="it") == request


@pytest.mark.parametrize(
    ("key", "value", "message"),
    [
        ("conformed", [{"range": [0, 60], "path": 3}], r"it at \$\.conformed\[0\]\.path: expected a text, got 3"),
        ("conformed", [{"range": [9, 3], "path": "/a.mp4"}], r"it at \$\.conformed\[0\]\.range: "),
        ("edl", "edl.json", r"it at \$\.edl: must be an absolute path, got 'edl\.json'"),
        ("preset", {}, r"it at \$\.preset"),
        ("colour", True, r"it at \$\.colour: unknown key"),
        ("sound", [], r"it at \$\.sound: expected a text"),
    ],
)
def test_a_wrong_request_is_refused_with_the_path_to_the_value(key, value, message):
    request = {**to_json(a_request()), key: value}
    with pytest.raises(DocumentError, match=message + r".*of one version"):
        structure(request, TimelineRequest, where="it")


def test_a_relative_path_is_refused_where_the_request_is_made():
    with pytest.raises(Fault, match="must be an absolute path"):
        RefreshRequest(edl=Path("edl.json"), blend=Path("/edit/edit.blend"), conformed=(), sound=None)
    with pytest.raises(Fault, match="must be an absolute path"):
        RenderRequest(blend=Path("/edit/edit.blend"), preset=load_preset("h264"), output=Path("out.mp4"))


def test_what_progress_writes_is_what_messages_read():
    stream = io.StringIO()
    progress = JsonLines(stream)
    progress.step(3, 14)
    progress.stage("aligning", 8, "poses")
    progress.stage("starting")
    progress.advance(8)
    progress.note("cam3 is weak")
    progress.result({"edl": "x.json", "shots": 3})
    progress.error("is missing", "cam1.mp4", "Put it back", 3)
    assert [parse_message(line) for line in stream.getvalue().splitlines()] == [
        Step(3, 14),
        Stage("aligning", 8, "poses"),
        Stage("starting"),
        Done(8),
        Note("cam3 is weak"),
        Result({"edl": "x.json", "shots": 3}),
        Failed(Failure("is missing", "cam1.mp4", "Put it back", 3)),
    ]
    assert stream.getvalue().splitlines() == [
        json.dumps(to_json(parse_message(line))) for line in stream.getvalue().splitlines()
    ]


@pytest.mark.parametrize("line", ["", "hello", "[1]", "3", "{}", '{"other": 1}', b"\xff\xfe", '{"stage": "cut sh'])
def test_what_is_no_message_is_not_for_us(line):
    assert parse_message(line) is None


@pytest.mark.parametrize(
    ("line", "path"),
    [
        ('{"done": "3"}', r"\$\.done: expected a whole number"),
        ('{"step": 0, "of": 3}', r"\$\.step: must be 1 or more"),
        ('{"done": -1}', r"\$\.done: must be 0 or more"),
        ('{"stage": "x", "total": "9"}', r"\$\.total: expected a whole number"),
        ('{"error": {"where": "x"}}', r"\$\.error\.what: |\$\.error: "),
        ('{"result": 3}', r"\$\.result: expected an object"),
        ('{"note": "x", "loud": true}', r"\$\.loud: unknown key"),
    ],
)
def test_a_message_with_a_wrong_value_is_refused(line, path):
    with pytest.raises(DocumentError, match=path):
        parse_message(line)


def test_messages_are_read_as_they_come_and_the_last_without_its_end(tmp_path):
    file = tmp_path / "messages"
    file.touch()
    messages = MessageFile(file)
    assert messages.read(ended=False) == []
    with open(file, "a") as stream:
        stream.write('{"note": "one"}\nprinted by a library\n{"no')
    assert messages.read(ended=False) == [Note("one")]
    with open(file, "a") as stream:
        stream.write('te": "two"}\n{"note": "three"}')
    assert messages.read(ended=False) == [Note("two")]
    assert messages.read(ended=True) == [Note("three")]


def test_a_conformed_piece_has_the_form_it_had():
    """`mcsl --progress json conform` is read by other programs too."""
    media = ConformedMedia(Path("out"), 1, 0, (ConformedPiece(R(0, 60), Path("/out/a.mp4")),), None)
    assert json.dumps(to_json(media)) == (
        '{"folder": "out", "chunks": 1, "made": 0, "pieces": [{"range": [0, 60], "path": "/out/a.mp4"}], "sound": null}'
    )


def test_the_list_of_plugins_is_one_of_messages():
    from mcsl_core.cli.commands.plugins import list_plugins
    from mcsl_core.cli.output import Session

    done = CliRunner().invoke(list_plugins, ["--json"], obj=Session(debug=True))
    rows = structure(json.loads(done.stdout), tuple[OfferedPlugin, ...], where="mcsl plugins")
    assert [row.name for row in rows if row.stage == "occlusion" and row.default] == ["consensus"]


def test_blenders_python_can_load_them():
    """Blender has attrs and cattrs, and nothing else of ours."""
    code = (
        "import sys\nfor name in ('numpy', 'cv2', 'av', 'click', 'rich', 'pluggy', 'platformdirs', 'blender_addon'):\n"
        "    sys.modules[name] = None\nimport mcsl_core.blender.messages"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
