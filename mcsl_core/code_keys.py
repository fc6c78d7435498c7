"""By which code a kept result was made: what the keys of the stage cache and of conformed media say of it.

A result may be used again only while the code would make it the same. Whether it would is told in one of two ways, and
in neither has anybody to remember anything (docs/decisions/012-kept-results.md):

- **A stage of the analysis: by the code itself**, `code_of`. Who uses its result again is often who changes the code: a
  wrong answer costs an afternoon, making it again costs minutes. The key holds the modules that the stage uses and no
  others, so that a changed chart throws nothing away.
- **Conformed pictures and sound: by what comes out**, `PICTURES` and `SOUND`. They are hours of an editor's machine,
  and cleaned-up code that makes the same pictures must leave them. Beside each number lies a record of what it makes
  (tests/core/delivery/test_recorded.py); where that comes out differently and the number has not risen, the test fails.
  So it is with the numbers that the built-in fillers bear, `Filler.version`.
"""

from __future__ import annotations

import hashlib
import os
import sys
from collections.abc import Iterable, Iterator
from functools import cache
from importlib import metadata
from modulefinder import ModuleFinder
from pathlib import Path
from types import CodeType
from typing import Any

from attrs import frozen

PICTURES = 3  # of an EDL and its media as the compositor makes them, but for what the filler adds
SOUND = 2  # of an EDL and its media

_PACKAGE = __name__.partition(".")[0]
_FACADE = f"{_PACKAGE}.hooks"  # what a plugin imports: names of other modules
_ROOT = Path(__file__).parent


def code_of(*used: Any) -> str:
    """A hash of the code behind functions, classes or modules.

    Of this package it is their own modules and all that those import, in whatever way; comments, docstrings, layout
    and assertions are no part of it. Of another package, a plugin, it is the whole of its source, since nobody knows
    how it hangs together, and what it imports of this one. The versions of all imported libraries stand beside.
    """
    digest = hashlib.sha256()
    libraries: set[str] = set()
    for module in modules_of(*used):
        source = _read(_file(module).read_bytes())
        libraries |= source.libraries
        digest.update(f"{module} {source.code}\n".encode())
    for package in sorted({name.partition(".")[0] for name in map(_module_of, used)} - {_PACKAGE}):
        for file in _files_of(package):
            digest.update(os.fsencode(file.name) + b"\0" + file.read_bytes())
    for library in sorted(libraries):
        digest.update(f"{library} {_version(library)}\n".encode())
    return digest.hexdigest()[:24]


def modules_of(*used: Any) -> tuple[str, ...]:
    """The modules of this package that `code_of` reads, in order of their names."""
    found: set[str] = set()
    waiting: list[str] = []
    for module in map(_module_of, used):
        if module.partition(".")[0] == _PACKAGE:
            waiting.append(module)
        else:
            for file in _files_of(module.partition(".")[0]):
                waiting += _followed(_read(file.read_bytes()).imports)
    while waiting:
        module = waiting.pop()
        if module not in found:
            found.add(module)
            file = _file(module)
            package = module if file.name == "__init__.py" else module.rpartition(".")[0]
            waiting += _behind(file.read_bytes(), package)
    return tuple(sorted(found))


def _module_of(used: Any) -> str:
    return getattr(used, "__module__", None) or used.__name__


def _files_of(package: str) -> list[Path]:
    """The Python files of a top-level package or module, none where there is no source."""
    module = sys.modules[package]
    folders = [Path(folder) for folder in getattr(module, "__path__", ())]
    files = sorted(file for folder in folders for file in folder.rglob("*.py"))
    alone = Path(getattr(module, "__file__", None) or "")
    return files or [alone] * alone.is_file()


def _file(module: str) -> Path:
    path = _ROOT.joinpath(*module.split(".")[1:])
    return path / "__init__.py" if path.is_dir() else path.with_suffix(".py")


@cache
def _version(library: str) -> str:
    """The versions of the distributions that bring a top-level module."""
    return " ".join(version for _, version in sorted({(e.name, e.version) for e in _distributions().get(library, ())}))


@cache
def _distributions() -> dict[str, list[metadata.Distribution]]:
    """The distributions that are installed, by the top-level modules that they bring.

    `importlib.metadata.packages_distributions` takes apart every line of their lists of files: 0.4 s where there are a
    hundred of them; this takes 0.07.
    """
    found: dict[str, list[metadata.Distribution]] = {}
    for each in metadata.distributions():
        listed = each.read_text("RECORD") or each.read_text("top_level.txt") or ""
        tops = {line.partition(",")[0].partition("/")[0] for line in listed.splitlines()}
        for name in {top.partition(".")[0] for top in tops}:
            found.setdefault(name, []).append(each)
    return found


# ------------------------------------------------------------------------------------------------ reading source


@frozen
class _Import:
    """``from <level dots><module> import <names>``, or ``import <module>``, without names."""

    level: int
    module: str
    names: tuple[str, ...] = ()


@frozen
class _Source:
    """What a file's code hashes to, and what it imports: of this package, and which libraries."""

    code: str
    imports: tuple[_Import, ...]
    libraries: frozenset[str]


@cache  # by content: it can never be out of date
def _read(source: bytes) -> _Source:
    # As `python -OO` compiles it, without docstrings and assertions: a quarter of the time that its syntax tree takes.
    compiled = compile(source, "", "exec", dont_inherit=True, optimize=2)
    digest, imports = hashlib.sha256(), list[_Import]()
    for code in _codes(compiled):
        taken = (code.co_name, code.co_flags, code.co_argcount, code.co_posonlyargcount, code.co_kwonlyargcount)
        names = (code.co_names, code.co_varnames, code.co_cellvars, code.co_freevars)
        constants = [_stable(value) for value in code.co_consts if not isinstance(value, CodeType)]
        digest.update(repr((taken, names, constants, code.co_exceptiontable, code.co_code)).encode())
        imports += _imports(code)
    tops = {each.module.partition(".")[0] for each in imports if not each.level}
    own = tuple(each for each in imports if each.level or each.module.partition(".")[0] == _PACKAGE)
    libraries = frozenset(tops - {_PACKAGE} - set(sys.stdlib_module_names))
    return _Source(digest.hexdigest(), own, libraries)


def _codes(code: CodeType) -> Iterator[CodeType]:
    """A module's code and that of all functions and classes in it."""
    yield code
    for value in code.co_consts:
        if isinstance(value, CodeType):
            yield from _codes(value)


def _stable(constant: object) -> str:
    """A constant's text, which is another in every process where it holds a set."""
    match constant:
        case frozenset():
            return f"{{{', '.join(sorted(map(_stable, constant)))}}}"
        case tuple():
            return f"({', '.join(map(_stable, constant))})"
    return repr(constant)


def _imports(code: CodeType) -> Iterator[_Import]:
    # A method that modulefinder's page does not name; a test holds it against the syntax tree.
    for kind, what in ModuleFinder().scan_opcodes(code):
        match kind:
            case "absolute_import":
                names, module = what
                yield _Import(0, module, tuple(names or ()))
            case "relative_import":
                level, names, module = what
                yield _Import(level, module, tuple(names or ()))


@cache
def _behind(source: bytes, package: str) -> tuple[str, ...]:
    """The modules of this package that a file in ``package`` imports."""
    return tuple(_followed(_absolute(_read(source).imports, package)))


def _absolute(imports: Iterable[_Import], package: str) -> Iterator[_Import]:
    """Imports of a module in ``package`` without leading dots."""
    for each in imports:
        above = package.split(".")[: len(package.split(".")) - each.level + 1] if each.level else []
        yield _Import(0, ".".join(filter(None, [*above, each.module])), each.names)


def _followed(imports: Iterable[_Import]) -> Iterator[str]:
    """The modules behind imports of this package; a folder's own only where a name of its own is taken from it.

    The package's front door is left out: it leads to everything and makes nothing. Of what plugins import, each name
    leads to where it is, and the marker of their functions nowhere.
    """
    for each in imports:
        if each.level:  # a plugin's own
            continue
        if each.module == _FACADE:
            behind = {name: taken for taken in _read(_file(_FACADE).read_bytes()).imports for name in taken.names}
            yield from _followed(
                _Import(0, behind[name].module, (name,)) for name in each.names if name in behind and name != "hookimpl"
            )
            continue
        submodules = [name for name in (f"{each.module}.{item}" for item in each.names) if _file(name).is_file()]
        yield from submodules
        if each.module != _PACKAGE and (not each.names or len(submodules) < len(each.names)):
            yield each.module
