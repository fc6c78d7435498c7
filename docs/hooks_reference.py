"""The generated part of docs/hooks.md, read from the source text of mcsl_core/hooks/specs.py; see generate.py."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from functools import cache, partial
from pathlib import Path

PACKAGE = Path(__file__).resolve().parent.parent / "mcsl_core"
MARKER = "<!-- Below this line: written by docs/generate.py from mcsl_core/hooks/specs.py. -->"


# Methods of values that are handed over, which only mcsl's own stages ask: they tell of what went on before.
INTERNAL = {("Footage", "damage_met")}


class Described:
    """A class and the module it stands in: the names in its annotations mean what they mean there."""

    def __init__(self, node: ast.ClassDef, module: str) -> None:
        self.node, self.module = node, module
        self.key = (module, node.name)
        self.is_protocol = any(ast.unparse(base) == "Protocol" for base in node.bases)

    def functions(self) -> list[ast.FunctionDef]:
        """Its public methods and properties, overloads left out."""
        methods = [n for n in self.node.body if isinstance(n, ast.FunctionDef) and not n.name.startswith("_")]
        return [m for m in methods if not any(ast.unparse(d) == "overload" for d in m.decorator_list)]

    def fields(self) -> Iterator[str]:
        for node in self.node.body:
            if isinstance(node, ast.AnnAssign) and isinstance(node.target, ast.Name) and node.target.id[0] != "_":
                yield f"{node.target.id}: {ast.unparse(node.annotation)}"

    def find(self, name: str) -> Described | None:
        """The class that ``name`` means in this one's module; None for what is not a class of mcsl_core."""
        return find(name, self.module)


def file_of(module: str) -> Path:
    path = PACKAGE.joinpath(*module.split("."))
    return path / "__init__.py" if path.is_dir() else path.with_suffix(".py")


@cache
def module_ast(module: str) -> ast.Module:
    return ast.parse(file_of(module).read_text("utf-8"))


def imported(node: ast.ImportFrom, module: str) -> str:
    """The module of mcsl_core that ``node``, an import standing in ``module``, takes from."""
    if not node.level:
        return (node.module or "").removeprefix("mcsl_core.")
    parts = module.split(".")
    inside = parts if file_of(module).name == "__init__.py" else parts[:-1]
    return ".".join([*inside[: len(inside) + 1 - node.level], node.module or ""])


def find(name: str, module: str) -> Described | None:
    for node in module_ast(module).body:
        if isinstance(node, ast.ClassDef) and node.name == name:
            return Described(node, module)
        if not isinstance(node, ast.ImportFrom) or not node.module:
            continue
        if not node.level and not node.module.startswith("mcsl_core."):
            continue
        if any((alias.asname or alias.name) == name for alias in node.names):
            return find(name, imported(node, module))
    return None


def names_in(node: ast.AST | None) -> list[str]:
    return sorted({n.id for n in ast.walk(node) if isinstance(n, ast.Name)}) if node else []


def is_property(function: ast.FunctionDef) -> bool:
    return any(ast.unparse(d) in ("property", "cached_property") for d in function.decorator_list)


@cache
def exported() -> frozenset[str]:
    """The names that a plugin may import: `__all__` of mcsl_core.hooks."""
    values = {ast.unparse(n.targets[0]): n.value for n in module_ast("hooks").body if isinstance(n, ast.Assign)}
    return frozenset(ast.literal_eval(values["__all__"]))


def is_for_plugins(value: Described, function: ast.FunctionDef) -> bool:
    """Whether a plugin's author can use a method: all classes of mcsl in its signature come from mcsl_core.hooks."""
    taken = (name for part in (function.args, function.returns) for name in names_in(part))
    hidden = any(value.find(name) is not None and name not in exported() for name in taken)
    return not hidden and (value.node.name, function.name) not in INTERNAL


def signature(function: ast.FunctionDef) -> str:
    """As one would write it, without self."""
    given = function.args

    def one(argument: ast.arg, default: ast.expr | None) -> str:
        kind = f": {ast.unparse(argument.annotation)}" if argument.annotation else ""
        return f"{argument.arg}{kind}" + (f" = {ast.unparse(default)}" if default else "")

    places = [*given.posonlyargs, *given.args]
    defaults = [None] * (len(places) - len(given.defaults)) + list(given.defaults)
    parts = [one(a, d) for a, d in zip(places, defaults, strict=True) if a.arg not in ("self", "cls")]
    parts += [f"*{given.vararg.arg}"] if given.vararg else ["*"] if given.kwonlyargs else []
    parts += [one(a, d) for a, d in zip(given.kwonlyargs, given.kw_defaults, strict=True)]
    returns = f" -> {ast.unparse(function.returns)}" if function.returns else ""
    return f"{function.name}({', '.join(parts)}){returns}"


def document(node: ast.ClassDef | ast.FunctionDef) -> str:
    text = ast.get_docstring(node)
    if not text:
        raise ValueError(f"{node.name} has no docstring, and docs/hooks.md is made of them")
    return as_markdown(text)


SECTION = re.compile(r"^(\w[\w ]*)\n-{3,}$", re.MULTILINE)
LISTS = ("Parameters", "Attributes", "Returns", "Yields", "Raises")


def as_markdown(text: str) -> str:
    """A docstring with numpydoc's sections: their titles bold, their entries as lists."""
    summary, *rest = SECTION.split(text)
    parts = [summary.strip()]
    for title, body in zip(rest[::2], rest[1::2], strict=True):
        body = body.strip("\n")
        if title in LISTS:
            entries = re.split(r"\n(?=\S)", body)
            body = "\n".join(entry_as_markdown(*entry.split("\n")) for entry in entries)
        parts.append(f"**{title}**\n\n{body.strip()}")
    return "\n\n".join(parts)


def entry_as_markdown(head: str, *told: str) -> str:
    text = " ".join(line.strip() for line in told).strip()
    return f"- `{head}`: {text}" if text else f"- `{head}`"


class Reference:
    """The text, put together: each hook, the protocol of what it registers, and what those are handed."""

    def __init__(self) -> None:
        self.parts = ["## Reference\n"]
        self.described: set[tuple[str, str]] = set()
        self.handed: dict[tuple[str, str], Described] = {}

    def hook(self, hooks: Described, function: ast.FunctionDef) -> None:
        self.parts.append(f"### {function.name}\n\n{document(function)}\n")
        for name in names_in(function.returns):
            if (protocol := hooks.find(name)) is not None:
                self.protocol(protocol)

    def protocol(self, protocol: Described) -> None:
        """What a plugin's object must have; protocols of what its methods return follow."""
        if protocol.key in self.described:
            return
        self.described.add(protocol.key)
        self.parts.append(f"#### {protocol.node.name}\n\n{document(protocol.node)}\n")
        made: list[Described] = []
        for method in protocol.functions():
            if is_property(method):
                text = ast.get_docstring(method) or ("the name it is chosen by" if method.name == "name" else "")
                kind = ast.unparse(method.returns) if method.returns else ""
                self.parts.append(f"- `{method.name}: {kind}`: {text}")
                continue
            self.parts.append(f"\n```python\n{signature(method)}\n```\n\n{document(method)}\n")
            self.hand_over(protocol, names_in(method.args))
            for name in names_in(method.returns):
                if (value := protocol.find(name)) is not None and value.is_protocol:
                    made.append(value)
                else:
                    self.hand_over(protocol, [name])
        for value in made:
            self.protocol(value)

    def hand_over(self, user: Described, names: list[str]) -> None:
        for name in names:
            if (value := user.find(name)) is not None:
                self.handed[value.key] = value

    def values(self) -> None:
        self.parts.append("### Values that are handed over\n\nAll of them come from `mcsl_core.hooks`.\n")
        for value in sorted(self.handed.values(), key=lambda v: (v.node.name, v.module)):
            self.parts.append(f"#### {value.node.name}\n\n{document(value.node)}\n")
            lines = list(value.fields())
            for function in filter(partial(is_for_plugins, value), value.functions()):
                if is_property(function):
                    lines.append(f"{function.name}: {ast.unparse(function.returns) if function.returns else 'object'}")
                else:
                    lines.append(signature(function))
            if lines:
                self.parts.append("```python\n" + "\n".join(lines) + "\n```\n")


def hooks_reference() -> str:
    hooks = find("Hooks", "hooks.specs")
    assert hooks is not None, "mcsl_core/hooks/specs.py has no class Hooks"
    reference = Reference()
    for function in hooks.functions():
        reference.hook(hooks, function)
    reference.values()
    return re.sub(r"\n{3,}", "\n\n", "\n".join(reference.parts)).rstrip() + "\n"


def hooks_page(path: Path) -> str:
    """What is written by hand above the marker in the page at ``path``, the marker, and the reference."""
    above, marker, _ = path.read_text("utf-8").partition(MARKER) if path.exists() else ("# Hooks\n\n", "", "")
    if path.exists() and not marker:
        raise ValueError(f"{path} lacks the line {MARKER!r}, below which the reference goes")
    return f"{above}{MARKER}\n\n{hooks_reference()}"
