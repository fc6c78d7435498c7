"""A plugin's folder, written from templates: a small working one of its stage, to be changed into another."""

from __future__ import annotations

import importlib.util
import keyword
import re
import shutil
from collections.abc import Mapping
from pathlib import Path

import jinja2
from attrs import frozen

from mcsl_core import hooks
from mcsl_core.errors import InputError, UsageError, writing
from mcsl_core.hooks.registry import discover
from mcsl_core.hooks.stages import STAGES
from mcsl_core.outputs.claim import check_place
from mcsl_core.temporary import temporary_beside


@frozen
class _Example:
    """What the template of a stage does, in words for its description, and what it needs besides mcsl."""

    does: str
    needs: tuple[str, ...] = ("numpy",)


_NAMES_IN_TEMPLATES = ("Array", "Sequence", "Mapping", "Callable", "Scorer", "NDArray")
_WITH_CV2 = ("numpy", "opencv-python-headless")
EXAMPLES: Mapping[str, _Example] = {
    "movement": _Example("the lamp moves when most of the picture changes at once", _WITH_CV2),
    "matcher": _Example("ORB's points, matched where each is the other's best", _WITH_CV2),
    "aligner": _Example("each camera tied to the reference camera by itself", _WITH_CV2),
    "relief": _Example("what the matches say of the relief, spread smoothly between them"),
    "tracker": _Example("the background followed from frame to frame, the lamp fitted to all cameras", _WITH_CV2),
    "occlusion": _Example("what does not look as it usually does is in the way"),
    "selector": _Example("whoever sees most over the next seconds is shown for as long"),
    "centerer": _Example("the field in the middle while the lamp stands still", ()),
    "filler": _Example("one other camera behind the chosen one, along a hard edge"),
}


def new_plugin(name: str, stage: str, folder: Path) -> list[Path]:
    """Writes a plugin of that name for ``stage`` into ``folder``, whole or not at all; returns its files.

    Raises
    ------
    UsageError
        Where the name is none for a package, or is taken.
    InputError
        Where ``folder`` is there already.
    """
    module = name.replace("-", "_")
    _check_name(name, module, stage)
    check_place(folder)
    if folder.exists():
        raise InputError("is there already", where=str(folder), remedy="Choose another name, or another folder with -o")
    example, noun = EXAMPLES[stage], STAGES[stage].noun
    words = {
        "name": name,
        "module": module,
        "cls": _class_name(name),
        "stage": stage,
        "noun": noun,
        "noun_capital": f"{'An' if noun[0] in 'aeiou' else 'A'} {noun}",
        "does": example.does,
        "dependencies": ", ".join(f'"{package}"' for package in ("mcsl>=0.2", "attrs", *example.needs)),
    }
    files = {
        "pyproject.toml": "pyproject.toml.j2",
        "README.md": "README.md.j2",
        f"{module}/__init__.py": f"{stage}.py.j2",
        f"tests/test_{module}.py": f"test_{stage}.py.j2",
    }
    texts = {file: _rendered(template, words) for file, template in files.items()}
    part = temporary_beside(folder)
    try:
        with writing(folder):
            for file, text in texts.items():
                (part / file).parent.mkdir(parents=True, exist_ok=True)
                (part / file).write_text(text, "utf-8")
            part.rename(folder)
    finally:
        shutil.rmtree(part, ignore_errors=True)
    return [folder / file for file in files]


def _rendered(template: str, words: Mapping[str, str]) -> str:
    environment = jinja2.Environment(
        loader=jinja2.PackageLoader("mcsl_core.cli", "templates"),
        keep_trailing_newline=True,
        undefined=jinja2.StrictUndefined,
    )
    return environment.get_template(template).render(words)


def _class_name(name: str) -> str:
    return "".join(part.capitalize() for part in name.split("-"))


def _check_name(name: str, module: str, stage: str) -> None:
    if not re.fullmatch(r"[a-z][a-z0-9]*(-[a-z0-9]+)*", name) or keyword.iskeyword(module):
        remedy = "Take small letters, digits and single hyphens, such as usual-look"
        raise UsageError(f"{name!r} is no name for a plugin", remedy=remedy)
    for offer in discover().offers:
        if (offer.stage, offer.name) == (stage, name):
            taken = f"the name is that of the {STAGES[stage].noun} {offer}"
            raise UsageError(taken, remedy="Choose another name")
    cls = _class_name(name)
    if keyword.iskeyword(cls) or cls in {*hooks.__all__, *_NAMES_IN_TEMPLATES}:
        raise UsageError(f"its class would be called {cls}, which is taken", remedy="Choose another name")
    if importlib.util.find_spec(module) is not None:
        raise UsageError(f"there is a Python package {module!r} already", remedy="Choose another name")
