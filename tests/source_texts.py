"""The texts that a person can meet at the command line, read from the source, as templates with named fields.

A text is followed backwards from where it is shown (an error's ``what``, ``progress.note``, an option's ``help``)
through names, choices, and the parameters and results of our own functions. A field is named by the last name in its
expression: ``{str(self.path)!r}`` is ``{path}``, ``{len(chunks)}`` ``{chunks}``; where two differ, the second is
``{path2}``. Choices inside a text, ``{'s' if many else ''}``, are written out as a text each. Of what is filled in,
phrases are texts too; a single word may be anybody's name, and is none.
"""

from __future__ import annotations

import ast
import itertools
import re
import string
from collections import defaultdict
from collections.abc import Iterator, Sequence
from pathlib import Path

from attrs import define, field
from text_templates import (
    SAME_TEXT,
    Field,
    Function,
    Module,
    Text,
    called,
    chain,
    field_name,
    is_empty,
    last_name,
    written,
)

MOST = 24  # ways in which one text can be put together; more are a table, not a text
FEW = 3  # functions of one name, whichever may be meant
_TEXTS = (ast.Constant, ast.JoinedStr, ast.BinOp)


@define
class Sources:
    """All modules of some folders, and what is found in them."""

    modules: list[Module]
    functions: dict[str, list[Function]] = field(factory=lambda: defaultdict(list))
    found: dict[str, set[str]] = field(factory=lambda: defaultdict(set))
    unknown: set[str] = field(factory=set)
    _shown: set[tuple[int, str]] = field(factory=set)
    _calls: dict[str, list[tuple[ast.Call, Function | None, Module]]] = field(factory=lambda: defaultdict(list))

    @classmethod
    def of(cls, root: Path, paths: Sequence[Path]) -> Sources:
        sources = cls([Module(path.relative_to(root), ast.parse(path.read_text("utf-8"))) for path in paths])
        for module in sources.modules:
            sources._index(module.tree, None, module)
        return sources

    def _index(self, node: ast.AST, within: Function | None, module: Module, kind: str = "") -> None:
        for child in ast.iter_child_nodes(node):
            inside, name = within, kind
            if isinstance(child, ast.FunctionDef | ast.AsyncFunctionDef):
                inside = Function(child, module, within)
                self.functions[kind if child.name == "__init__" else child.name].append(inside)
            elif isinstance(child, ast.ClassDef):
                name = child.name
            elif isinstance(child, ast.Call):
                self._calls[called(child)].append((child, within, module))
            self._index(child, inside, module, name)

    def calls(self, name: str = "") -> Iterator[tuple[ast.Call, Function | None, Module]]:
        """The calls of whatever has that name; without, all."""
        yield from self._calls.get(name, ()) if name else itertools.chain.from_iterable(self._calls.values())

    def all_functions(self) -> Iterator[Function]:
        for functions in self.functions.values():
            yield from functions

    def descended_from(self, *names: str) -> set[str]:
        """These classes and all that are made from them."""
        classes = [n for m in self.modules for n in ast.walk(m.tree) if isinstance(n, ast.ClassDef)]
        found = set(names)
        while more := {c.name for c in classes if {last_name(b) for b in c.bases} & found} - found:
            found |= more
        return found

    def show(self, node: ast.expr | None, within: Function | None, module: Module, *, whole: bool = True) -> None:
        """A person sees what ``node`` is."""
        if node is None:
            return
        for text in self.texts(node, within, module):
            self._add(text, module, phrase=not whole)

    def _add(self, text: Text, module: Module, *, phrase: bool) -> None:
        """Keeps a text; of what is filled in only phrases, since a single word may be a name."""
        if not re.search(r"[A-Za-z]{2}", "".join(part for part in text if isinstance(part, str))):
            return
        for line in map(str.strip, written(text).split("\n")):
            if re.search("[A-Za-z]", re.sub(r"\{\w+\}", "", line)) and (not phrase or " " in line):
                self.found[line].add(module.path.as_posix())

    def say(self, function: Function) -> None:
        """A person is told later what ``function`` makes: every phrase in it."""

        def visit(node: ast.AST) -> None:
            made = isinstance(node, _TEXTS) or (isinstance(node, ast.Call) and called(node) == "format")
            texts = self.texts(node, function, function.module) if made else []
            for text in texts:
                self._add(text, function.module, phrase=True)
            if not texts:
                for child in ast.iter_child_nodes(node):
                    visit(child)

        body = function.node.body
        for line in body[1:] if ast.get_docstring(function.node) else body:
            visit(line)

    def texts(self, node: ast.expr, within: Function | None, module: Module, depth: int = 0) -> list[Text]:
        """What the expression can be; nothing where that is no text of ours."""
        if depth > 12:
            return []
        again = depth + 1
        match node:
            case ast.Constant(str(value)):
                return [(value,)]
            case ast.JoinedStr(values):
                return self._put_together(values, within, module, again)
            case ast.BinOp(left, ast.Add(), right):
                sides = [self.texts(side, within, module, again) or [(self._field(side),)] for side in (left, right)]
                return [a + b for a, b in itertools.product(*sides)][:MOST]
            case ast.IfExp(_, body, other):
                return self.texts(body, within, module, again) + self.texts(other, within, module, again)
            case ast.BoolOp(_, values):
                return [text for value in values for text in self.texts(value, within, module, again)]
            case ast.NamedExpr(_, value) | ast.Starred(value):
                return self.texts(value, within, module, again)
            case ast.Subscript(value, ast.Constant(int(index))) if isinstance(value, ast.Call):
                return self._returned(value, module, again, index)
            case ast.Subscript(value, ast.Slice()):
                return self.texts(value, within, module, again)
            case ast.Subscript(value, _):
                return self._values(value, within, module, again)
            case ast.Dict(_, values):
                return [text for value in values for text in self.texts(value, within, module, again)]
            case ast.Call():
                return self._call(node, within, module, again)
            case ast.Name(name):
                return self._name(name, within, module, again)
            case ast.Attribute(ast.Name(), name) if name.isupper() or name.strip("_").isupper():
                return self._constant(name, again)
            case _:
                return []

    def _field(self, node: ast.expr, form: str = "") -> Field:
        return Field(field_name(node), ast.unparse(node) + form)

    def _put_together(
        self, values: Sequence[ast.expr], within: Function | None, module: Module, depth: int
    ) -> list[Text]:
        choices: list[list[Text]] = []
        for value in values:
            if isinstance(value, ast.Constant):
                choices.append([(str(value.value),)])
                continue
            assert isinstance(value, ast.FormattedValue)
            inner = value.value
            form = f"{value.conversion}{ast.unparse(value.format_spec) if value.format_spec else ''}"
            inline = self._inline(inner, within, module, depth, form)
            if inline is None:
                self._parts(inner, within, module, depth)
                inline = [(self._field(inner, form),)]
            choices.append(inline)
        return [sum(chosen, ()) for chosen in itertools.islice(itertools.product(*choices), MOST)]

    def _inline(
        self, node: ast.expr, within: Function | None, module: Module, depth: int, form: str
    ) -> list[Text] | None:
        """The ways of a choice that is written out inside a text."""
        ways = {ast.IfExp: lambda n: [n.body, n.orelse], ast.BoolOp: lambda n: n.values}.get(type(node))
        match node:
            case ast.BinOp(ast.Constant(str(ending)), ast.Mult(), _):  # the s of a plural
                return [("",), (ending,)]
        if ways is None or form != "-1":
            return None
        given = ways(node)
        if not any(isinstance(way, ast.Constant | ast.JoinedStr | ast.IfExp) for way in given):
            return None
        found: list[Text] = []
        for way in given:
            deeper = self._inline(way, within, module, depth, form)
            if deeper is not None:
                found += deeper
            elif isinstance(way, ast.Constant | ast.JoinedStr):
                found += self.texts(way, within, module, depth) if not is_empty(way) else [("",)]
            else:
                self._parts(way, within, module, depth)
                found.append((self._field(way, form),))
        return found

    def _parts(self, node: ast.expr, within: Function | None, module: Module, depth: int) -> None:
        """What is filled in may be a text itself: it is told by itself."""
        for text in self.texts(node, within, module, depth):
            self._add(text, module, phrase=True)

    def _values(self, node: ast.expr, within: Function | None, module: Module, depth: int) -> list[Text]:
        """What a subscript or ``.get`` of a table of texts can be."""
        if isinstance(node, ast.Dict):
            return self.texts(node, within, module, depth)
        if isinstance(node, ast.Name):
            tables = [table for table in module.assigned.get(node.id, []) if isinstance(table, ast.Dict)]
            return [text for table in tables for text in self.texts(table, None, module, depth)]
        return []

    def _call(self, node: ast.Call, within: Function | None, module: Module, depth: int) -> list[Text]:
        match node.func:
            case ast.Name("counted"):
                noun = node.args[1]
                for text in self.texts(noun, within, module, depth):
                    plural = written(text)
                    self.found["{count} " + plural].add(module.path.as_posix())
                    self.found["{count} " + plural.removesuffix("s")].add(module.path.as_posix())
                return [(self._field(node),)]
            case ast.Attribute(ast.Constant(str(text)), "format"):
                names = iter(node.args)
                pieces: list[str | Field] = []
                for literal, name, spec, _ in string.Formatter().parse(text):
                    pieces.append(literal)
                    if name is not None:
                        argument = next(names, None)
                        word = field_name(argument) if argument is not None else "value"
                        pieces.append(Field(word, f"{len(pieces)}{spec}"))
                return [tuple(pieces)]
            case ast.Attribute(ast.Constant(str()), "join"):
                if node.args:
                    self._elements(node.args[0], within, module, depth)
                return []
            case ast.Attribute(value, name) if name in SAME_TEXT:
                return self.texts(value, within, module, depth)
            case ast.Attribute(value, "get"):
                default = self.texts(node.args[1], within, module, depth) if len(node.args) > 1 else []
                return self._values(value, within, module, depth) + default
            case ast.Name("next") if len(node.args) > 1:
                return self.texts(node.args[1], within, module, depth)
        return self._returned(node, module, depth)

    def _elements(self, node: ast.expr, within: Function | None, module: Module, depth: int) -> None:
        match node:
            case ast.List(items) | ast.Tuple(items):
                for item in items:
                    self._parts(item.value if isinstance(item, ast.Starred) else item, within, module, depth)
            case ast.GeneratorExp(element, _) | ast.ListComp(element, _):
                self._parts(element, within, module, depth)
            case ast.Name(name):
                for function in chain(within):
                    for value in function.assigned.get(name, []):
                        self._elements(value, within, module, depth)
                    for call in ast.walk(function.node):
                        if isinstance(call, ast.Call) and ast.unparse(call.func) == f"{name}.append":
                            self._parts(call.args[0], within, module, depth)

    def _candidates(self, name: str, module: Module, place: str = "") -> list[Function]:
        """What a call of that name may mean: the functions of the module called ``place``, of its own or of that it is
        imported from; else all, where they are few."""
        named = self.functions.get(name, [])
        for stem in (place, module.path.stem, module.imported.get(name)):
            own = [f for f in named if f.module.path.stem == stem and (stem != module.path.stem or f.module is module)]
            if own:
                return own
        return named if len(named) <= FEW else []

    def _returned(self, node: ast.Call, module: Module, depth: int, index: int | None = None) -> list[Text]:
        """What a call gives back; of a tuple the part ``index``."""
        found: list[Text] = []
        place = last_name(node.func.value) if isinstance(node.func, ast.Attribute) else ""
        for function in self._candidates(called(node), module, place):
            for value in function.returned:
                if index is not None:
                    if not isinstance(value, ast.Tuple) or index >= len(value.elts):
                        continue
                    value = value.elts[index]
                found += self.texts(value, function, function.module, depth)
        return found

    def _name(self, name: str, within: Function | None, module: Module, depth: int) -> list[Text]:
        for function in chain(within):
            if name in function.assigned:
                return [t for value in function.assigned[name] for t in self.texts(value, function, module, depth)]
            if name in function.parameters or name in function.keywords:
                self._given(function, name)
                return []
        if name in module.assigned:
            return [text for value in module.assigned[name] for text in self.texts(value, None, module, depth)]
        return self._constant(name, depth) if name.strip("_").isupper() else []

    def _constant(self, name: str, depth: int) -> list[Text]:
        for module in self.modules:
            if name in module.assigned:
                return [text for value in module.assigned[name] for text in self.texts(value, None, module, depth)]
        return []

    def _given(self, function: Function, parameter: str) -> None:
        """A parameter is shown: what any caller hands over, and its default, is."""
        if (id(function), parameter) in self._shown:
            return
        self._shown.add((id(function), parameter))
        a = function.node.args
        positional = [p.arg for p in (*a.posonlyargs, *a.args)]
        defaults = dict(zip(reversed(positional), reversed(a.defaults), strict=False))
        defaults |= {p.arg: d for p, d in zip(a.kwonlyargs, a.kw_defaults, strict=True) if d is not None}
        if parameter in defaults:
            self.show(defaults[parameter], None, function.module, whole=False)
        name = function.node.name
        if name == "__init__":
            name = next((k for k, fs in self.functions.items() if function in fs), name)
        for call, within, module in list(self.calls(name)):
            if function not in self._candidates(name, module):
                continue
            given = {k.arg: k.value for k in call.keywords}
            node = given.get(parameter)
            if node is None and parameter in function.parameters:
                place = function.parameters.index(parameter)
                if place < len(call.args) and not any(isinstance(x, ast.Starred) for x in call.args[:place]):
                    node = call.args[place]
            self.show(node, within, module, whole=False)
