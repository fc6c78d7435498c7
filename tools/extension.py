#!/usr/bin/env python3
"""Builds the Blender extension: one zip for Blender 4.5 LTS, 5.0 and 5.2 LTS, from the working tree and PyPI.

    python tools/extension.py [OUT.zip]          (default: dist/mcsl-VERSION.zip; `python3 dev.py addon` calls it)

The zip holds blender_addon/ but for what only mcsl's child process runs, the render presets, and wheels: mcsl's
documents as far as the add-on imports them, made here, and the pinned packages it needs (tools/wheels.txt: hashes).
All of them are pure Python, so one zip fits every system and every Python. Blender's own tool validates and packs it.
The same tree gives the same bytes.
"""

from __future__ import annotations

import ast
import base64
import hashlib
import os
import shutil
import subprocess
import sys
import tempfile
import zipfile
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
if str(ROOT) not in sys.path:
    sys.path.insert(0, str(ROOT))

from mcsl_core import __version__  # noqa: E402
from mcsl_core.blender.installation import Blender, find  # noqa: E402
from mcsl_core.errors import BlenderError, McslError  # noqa: E402

ADDON = ROOT / "blender_addon"
PINNED = ROOT / "tools" / "wheels.txt"
IN_THE_CHILD = ADDON / "worker"  # mcsl runs it in a Blender of its own, from its own files
EPOCH = (1980, 1, 1, 0, 0, 0)  # the earliest a zip can say
LICENCE = ROOT / "LICENSE"


# ------------------------------------------------------------------------------------------------- mcsl's own wheel


def documents() -> list[Path]:
    """The files of mcsl_core that the add-on imports, and what those import, with the packages they lie in."""
    waiting = {name for path in ADDON.rglob("*.py") for name in _imported(path)}
    found: set[str] = set()
    while waiting:
        name = waiting.pop()
        if name in found or (path := _file_of(name)) is None:
            continue
        found.add(name)
        waiting |= {name.rpartition(".")[0], *_imported(path)} - found
    return sorted(path for name in found if (path := _file_of(name)) is not None)


def _file_of(module: str) -> Path | None:
    """The file of a module of mcsl_core by its dotted name; None where there is no such module."""
    path = ROOT / module.replace(".", "/")
    for file in (path / "__init__.py", path.with_suffix(".py")):
        if module and file.is_file():
            return file
    return None


def _imported(path: Path) -> set[str]:
    """Dotted names in mcsl_core that a file imports when it is loaded: modules, and what may be one."""
    package = path.relative_to(ROOT).parts[:-1]
    names: set[str] = set()
    for node in _loaded(ast.parse(path.read_text("utf-8"))):
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            base = package[: len(package) - node.level + 1] if node.level else ()
            module = ".".join([*base, *([node.module] if node.module else [])])
            names |= {module, *(f"{module}.{alias.name}" for alias in node.names)}
    return {name for name in names if name.split(".")[0] == "mcsl_core"}


def _loaded(tree: ast.AST) -> Iterator[ast.AST]:
    """All nodes below ``tree`` but for what type checkers alone read."""
    for node in ast.iter_child_nodes(tree):
        if not (isinstance(node, ast.If) and ast.unparse(node.test) == "TYPE_CHECKING"):
            yield node
            yield from _loaded(node)


def write_wheel(folder: Path) -> Path:
    """mcsl_core's documents as a wheel, by the wheel format's rules: files, METADATA, WHEEL, RECORD.

    Its version ends in a digest of the files: Blender keeps an installed wheel as long as one of its name is asked for.
    """
    files = {path.relative_to(ROOT).as_posix(): path.read_bytes() for path in documents()}
    version = f"{__version__}+{hashlib.sha256(repr(files).encode()).hexdigest()[:10]}"
    info = f"mcsl_core-{version}.dist-info"
    metadata = (
        "Metadata-Version: 2.4\nName: mcsl_core\n"
        f"Version: {version}\nSummary: The documents of mcsl, for its Blender extension\n"
        "License-Expression: Apache-2.0\nLicense-File: LICENSE\nRequires-Python: >=3.11\n"
        "Requires-Dist: attrs>=24.2\nRequires-Dist: cattrs>=24.1\nRequires-Dist: filelock>=4.0\n"
    )
    files[f"{info}/METADATA"] = metadata.encode()
    files[f"{info}/WHEEL"] = b"Wheel-Version: 1.0\nGenerator: mcsl\nRoot-Is-Purelib: true\nTag: py3-none-any\n"
    files[f"{info}/licenses/LICENSE"] = LICENCE.read_bytes()
    record = [f"{name},sha256={_url_safe(data)},{len(data)}" for name, data in files.items()]
    files[f"{info}/RECORD"] = "\n".join([*record, f"{info}/RECORD,,", ""]).encode()
    target = folder / f"mcsl_core-{version}-py3-none-any.whl"
    _write_zip(target, files)
    return target


def _url_safe(data: bytes) -> str:
    return base64.urlsafe_b64encode(hashlib.sha256(data).digest()).rstrip(b"=").decode()


def _write_zip(path: Path, files: dict[str, bytes]) -> None:
    """A zip of ``files`` in their order, without times and owners."""
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, data in files.items():
            entry = zipfile.ZipInfo(name, EPOCH)
            entry.external_attr = 0o644 << 16
            entry.compress_type = zipfile.ZIP_DEFLATED
            archive.writestr(entry, data)


# ------------------------------------------------------------------------------------------------------ the package


def stage(folder: Path) -> None:
    """Everything that goes into the zip, laid out in ``folder``."""
    for path in sorted(ADDON.rglob("*.py")):
        if IN_THE_CHILD not in path.parents:
            target = folder / path.relative_to(ADDON)
            target.parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(path, target)
    shutil.copyfile(ADDON / "LICENSE", folder / "LICENSE")
    presets, wheels = folder / "render_presets", folder / "wheels"
    presets.mkdir()
    for path in sorted((ROOT / "render_presets").glob("*.json")):
        shutil.copyfile(path, presets / path.name)
    wheels.mkdir()
    write_wheel(wheels)
    download(wheels)
    names = "".join(f'  "./wheels/{path.name}",\n' for path in sorted(wheels.iterdir()))
    manifest = (ADDON / "blender_manifest.toml").read_text("utf-8")
    head, table, rest = manifest.partition("[permissions]")  # what stands after a table belongs to it
    (folder / "blender_manifest.toml").write_text(f"{head}wheels = [\n{names}]\n\n{table}{rest}", "utf-8")


def download(folder: Path) -> None:
    """The pinned packages from PyPI; pip refuses what has another hash."""
    command = [sys.executable, "-m", "pip", "download", "--quiet", "--disable-pip-version-check", "--no-deps"]
    command += ["--require-hashes", "--only-binary=:all:", "--dest", str(folder), "--requirement", str(PINNED)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode:
        last = (done.stderr.strip().splitlines() or ["pip said nothing"])[-1]
        raise McslError(f"the wheels could not be downloaded: {last}", where=str(PINNED))


def tool(blender: Blender) -> list[str]:
    """The words that start Blender's own tool for extensions."""
    if blender.kind == "binary":
        return [*blender.command, "-b", "--factory-startup", "--command", "extension"]
    code = "import importlib.util as u; print(u.find_spec('bpy').origin)"
    done = subprocess.run([*blender.command, "-c", code], capture_output=True, text=True, check=True)
    found = sorted(Path(done.stdout.strip()).parent.glob("*/scripts/addons_core/bl_pkg/cli/blender_ext.py"))
    if not found:
        raise BlenderError("has no tool for extensions (blender_ext.py)", where=str(blender))
    return [*blender.command, str(found[0])]


def build(out: Path, blender: Blender | None = None) -> Path:
    """Builds the zip at ``out``: whole or not at all. Raises McslError, with what Blender's tool said."""
    words = tool(blender or find())
    out.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(prefix="mcsl-extension-") as name:
        source, packed = Path(name) / "mcsl", Path(name) / "packed.zip"
        source.mkdir()
        stage(source)
        for arguments in (
            ["validate", str(source)],
            ["build", f"--source-dir={source}", f"--output-filepath={packed}"],
            ["validate", str(packed)],
        ):
            done = subprocess.run([*words, *arguments], capture_output=True, text=True, check=False)
            if done.returncode:
                raise BlenderError(f"refuses the extension: {(done.stdout + done.stderr).strip()}", where=words[-1])
        with zipfile.ZipFile(packed) as archive:  # the same files again, without the moment they were packed at
            files = {name: archive.read(name) for name in sorted(archive.namelist()) if not name.endswith("/")}
        part = out.with_name(f".{out.name}.part")
        _write_zip(part, files)
        os.replace(part, out)
    return out


def main() -> int:
    out = Path(sys.argv[1]) if len(sys.argv) > 1 else ROOT / "dist" / f"mcsl-{__version__}.zip"
    try:
        build(out)
    except McslError as error:
        print(f"tools/extension.py: {error}", file=sys.stderr)
        return error.exit_code
    print(f"{out}: install it in Blender by Edit > Preferences > Get Extensions > Install from Disk")
    return 0


if __name__ == "__main__":
    sys.exit(main())
