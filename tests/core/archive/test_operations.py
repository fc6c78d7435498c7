"""Which operations an archive holds, what its table asks for, and what they are called."""

from __future__ import annotations

from pathlib import Path

import pytest

from mcsl_core.archive.operations import find_operations
from mcsl_core.errors import DocumentError, InputError, UsageError


def made(root: Path, *names: str) -> Path:
    for name in names:
        (root / name).mkdir(parents=True)
    return root


def found(
    archive: Path, out: Path, table: str | None = None, *, anonymous: bool = False
) -> dict[str, tuple[str, dict]]:
    path = None
    if table is not None:
        path = out.parent / "table.csv"
        path.write_text(table, "utf-8")
    operations = find_operations(archive, out, table=path, anonymous=anonymous)
    return {o.folder: (o.key, dict(o.options)) for o in operations}


def test_every_folder_is_an_operation_but_hidden_ones_and_the_results(tmp_path: Path) -> None:
    archive = made(tmp_path / "a", "b", "a", ".trash", "results")
    (archive / "notes.txt").touch()
    assert found(archive, archive / "results") == {"a": ("a", {}), "b": ("b", {})}


def test_the_table_gives_options_and_names_deeper_folders(tmp_path: Path) -> None:
    archive = made(tmp_path / "a", "2024/x", "2024/y", "b")
    table = "operation;reference;preset;parts\n2024/x;cam2;review;\nb;;;3\n"
    assert found(archive, tmp_path / "out", table) == {
        "2024/x": ("2024_x", {"reference": "cam2", "preset": "review"}),
        "b": ("b", {"parts": "3"}),
    }


@pytest.mark.parametrize(
    ("table", "said"),
    [
        ("operation,colour\na,red\n", "column 'colour'"),
        ("preset\nreview\n", "no column 'operation'"),
        ("operation\nnowhere\n", "no operation 'nowhere'"),
        ("operation\n../a\n", "no operation '../a'"),
        ("operation\na\na\n", "a second time"),
        ("operation,parts\na,0\n", "'0' is no number of parts"),
    ],
)
def test_a_wrong_table_is_refused_by_its_line(tmp_path: Path, table: str, said: str) -> None:
    with pytest.raises((InputError, DocumentError), match=said):
        found(made(tmp_path / "a", "a"), tmp_path / "out", table)


def test_names_are_safe_differ_and_stay(tmp_path: Path) -> None:
    archive = made(tmp_path / "a", "Fall {1}", "fall (1)", "-x", "ü b")
    first = {folder: key for folder, (key, _) in found(archive, tmp_path / "out").items()}
    assert first == {"-x": "x", "Fall {1}": "Fall__1_", "fall (1)": "fall__1__2", "ü b": "ü_b"}
    made(archive, "A new one", "archive.json")
    again = {folder: key for folder, (key, _) in found(archive, tmp_path / "out").items()}
    assert again == {**first, "A new one": "A_new_one", "archive.json": "archive.json_2"}


def test_numbers_say_nothing_and_stay(tmp_path: Path) -> None:
    archive = made(tmp_path / "a", "Meier", "Schulz")
    out = tmp_path / "out"
    assert {f: key for f, (key, _) in found(archive, out, anonymous=True).items()} == {
        "Meier": "000001",
        "Schulz": "000002",
    }
    made(archive, "Becker")
    assert found(archive, out, anonymous=True)["Becker"][0] == "000003"
    assert found(archive, out, anonymous=True)["Meier"][0] == "000001"
    assert (out / "archive.json").stat().st_mode & 0o077 == 0  # who is who is nobody else's
    with pytest.raises(UsageError, match="--anonymous"):
        found(archive, out)


def test_results_of_one_archive_are_not_anothers(tmp_path: Path) -> None:
    found(made(tmp_path / "a", "x"), tmp_path / "out")
    with pytest.raises(InputError, match="holds results of"):
        found(made(tmp_path / "b", "x"), tmp_path / "out")


def test_an_archive_without_folders_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="holds no folders"):
        found(made(tmp_path, "a") / "a", tmp_path / "out")
    with pytest.raises(InputError, match="is no folder"):
        found(tmp_path / "nowhere", tmp_path / "out")


def test_results_are_not_written_among_recordings(tmp_path: Path) -> None:
    archive = made(tmp_path / "a", "x", "y")
    for out in (archive, archive / "x" / "deeper"):
        with pytest.raises(UsageError, match="where the recordings lie"):
            found(archive, out)
    assert not (archive / "archive.json").exists()


def test_no_operation_is_called_as_what_lies_beside_it(tmp_path: Path) -> None:
    archive = made(tmp_path / "out" / "Archive", "Triage.html", "operations.csv", "LOG", "archive")
    keys = {key.casefold() for key, _ in found(archive, tmp_path / "out").values()}
    assert len(keys) == 4
    assert not keys & {"triage.html", "operations.csv", "log", "archive"}


def test_long_names_stay_within_what_file_systems_take(tmp_path: Path) -> None:
    archive = made(tmp_path / "a", f"{'ü' * 100}/{'ö' * 100}")
    table = f"operation\n{'ü' * 100}/{'ö' * 100}\n"
    (key, _) = next(iter(found(archive, tmp_path / "out", table).values()))
    (tmp_path / f".{key}.archive.lock").touch()


def test_a_look_keeps_no_names(tmp_path: Path) -> None:
    archive = made(tmp_path / "a", "x")
    assert find_operations(archive, tmp_path / "out", table=None, anonymous=True, write=False)[0].key == "000001"
    assert not (tmp_path / "out").exists()
