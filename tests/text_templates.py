"""Texts as templates, and what a name stands for in a function or a file: what `source_texts` reads the source with."""

from __future__ import annotations

import ast
from collections import defaultdict
from collections.abc import Iterable, Iterator
from functools import cached_property
from pathlib import Path

from attrs import define, frozen

SAME_TEXT = {"strip", "rstrip", "lstrip", "removesuffix", "removeprefix", "capitalize", "replace", "lower"}
"""Methods of a text that change little of it."""


@frozen
class Field:
    """A place in a text that is filled in; ``key`` tells two different ones of a name apart."""

    name: str
    key: str


Text = tuple["str | Field", ...]


@define
class Function:
    """A function with its place."""

    node: ast.FunctionDef | ast.AsyncFunctionDef
    module: Module
    outer: Function | None = None

    @cached_property
    def parameters(self) -> list[str]:
        a = self.node.args
        names = [p.arg for p in (*a.posonlyargs, *a.args)]
        return names[1:] if names[:1] in (["self"], ["cls"]) else names

    @cached_property
    def keywords(self) -> list[str]:
        return [p.arg for p in self.node.args.kwonlyargs]

    @cached_property
    def returned(self) -> list[ast.expr]:
        """What its return statements give back."""
        return [node.value for node in own_nodes(self.node) if isinstance(node, ast.Return) and node.value is not None]

    @cached_property
    def assigned(self) -> dict[str, list[ast.expr]]:
        return assignments(own_nodes(self.node))


@define
class Module:
    """A file's tree."""

    path: Path
    tree: ast.Module

    @cached_property
    def assigned(self) -> dict[str, list[ast.expr]]:
        return assignments(self.tree.body)

    @cached_property
    def imported(self) -> dict[str, str]:
        """Of what module each imported name is."""
        lines = [node for node in ast.walk(self.tree) if isinstance(node, ast.ImportFrom) and node.module]
        return {a.asname or a.name: (line.module or "").split(".")[-1] for line in lines for a in line.names}


def own_nodes(node: ast.AST) -> Iterator[ast.AST]:
    """The nodes of a function that are not another function's."""
    for child in ast.iter_child_nodes(node):
        if not isinstance(child, ast.FunctionDef | ast.AsyncFunctionDef | ast.Lambda):
            yield child
            yield from own_nodes(child)


def assignments(nodes: Iterable[ast.AST]) -> dict[str, list[ast.expr]]:
    found: defaultdict[str, list[ast.expr]] = defaultdict(list)

    def bind(target: ast.expr, value: ast.expr) -> None:
        if isinstance(target, ast.Name):
            found[target.id].append(value)
        elif isinstance(target, ast.Tuple | ast.List):
            if isinstance(value, ast.Tuple | ast.List) and len(value.elts) == len(target.elts):
                for one, part in zip(target.elts, value.elts, strict=True):
                    bind(one, part)
            elif isinstance(value, ast.IfExp):
                bind(target, value.body)
                bind(target, value.orelse)
            elif isinstance(value, ast.Call):
                for index, one in enumerate(target.elts):
                    bind(one, ast.Subscript(value, ast.Constant(index), ast.Load()))

    for node in nodes:
        if isinstance(node, ast.Assign):
            for target in node.targets:
                bind(target, node.value)
        elif isinstance(node, ast.AnnAssign | ast.AugAssign | ast.NamedExpr) and node.value is not None:
            bind(node.target, node.value)
        elif isinstance(node, ast.For | ast.comprehension):
            items = node.iter.elts if isinstance(node.iter, ast.Tuple | ast.List) else ()
            for item in items:
                bind(node.target, item)
    return dict(found)


def field_name(node: ast.expr) -> str:
    """The last name in an expression, which says best what is filled in."""
    match node:
        case ast.Name(name):
            return name.strip("_")
        case ast.Attribute(value, "name" | "value" | "range" | "text" as name):
            outer = field_name(value)
            return name if outer in ("self", "value") else f"{outer}_{name}"
        case ast.Attribute(_, name):
            return name.strip("_")
        case ast.Subscript(value, ast.Constant(str(name))) if name.isidentifier():
            return name
        case ast.Subscript(value, _) | ast.Starred(value) | ast.UnaryOp(_, value) | ast.NamedExpr(_, value):
            return field_name(value)
        case ast.Call(ast.Name(name), [first, *_]) if name in ("counted", "_counted"):
            noun = node.args[1] if len(node.args) > 1 else first
            return noun.value.split()[-1] if isinstance(noun, ast.Constant) else field_name(noun)
        case ast.Call(ast.Name(name), [_, first, *_]) if name == "map":
            return field_name(first)
        case ast.Call(ast.Attribute(ast.Constant(), _) | ast.Name(), [first, *_]):
            return field_name(first)
        case ast.Call(ast.Attribute(value, _), []):
            return field_name(value)
        case ast.Call(ast.Attribute(value, name), [first, *_]):
            return field_name(value) if name in SAME_TEXT else field_name(first)
        case ast.Call(function, _):
            return field_name(function)
        case ast.BinOp(left, _, right):
            return field_name(right if isinstance(left, ast.Constant) else left)
        case ast.GeneratorExp(element, _) | ast.ListComp(element, _) | ast.SetComp(element, _):
            return field_name(element)
        case ast.IfExp(_, body, _):
            return field_name(body)
        case ast.BoolOp(_, values):
            return field_name(values[0])
        case ast.JoinedStr(values):
            named = [v.value for v in values if isinstance(v, ast.FormattedValue)]
            return field_name(named[0]) if named else "text"
        case ast.Compare(left, _, _):
            return field_name(left)
        case _:
            return "value"


def written(text: Text) -> str:
    """A text as a template: its fields in braces, the second different one of a name numbered, braces doubled."""
    numbers: dict[str, list[str]] = defaultdict(list)
    parts = []
    for part in text:
        if isinstance(part, str):
            parts.append(part.replace("{", "{{").replace("}", "}}"))
            continue
        keys = numbers[part.name]
        if part.key not in keys:
            keys.append(part.key)
        number = keys.index(part.key) + 1
        parts.append("{" + part.name + (str(number) if number > 1 else "") + "}")
    return "".join(parts)


def chain(function: Function | None) -> Iterator[Function]:
    while function is not None:
        yield function
        function = function.outer


def last_name(node: ast.expr) -> str:
    return node.attr if isinstance(node, ast.Attribute) else getattr(node, "id", "")


def is_empty(node: ast.expr) -> bool:
    return isinstance(node, ast.Constant) and node.value == ""


def called(node: ast.Call) -> str:
    """The last name of what is called."""
    function = node.func
    if isinstance(function, ast.Attribute):
        return function.attr
    return function.id if isinstance(function, ast.Name) else ""
