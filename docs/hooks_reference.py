"""The generated part of docs/hooks.md, read from the source text of mcsl_core/hookspecs.py; see generate.py."""

from __future__ import annotations

import ast
import re
from pathlib import Path

PACKAGE = Path(__file__).resolve().parent.parent / "mcsl_core"
MARKER = "<!-- Below this line: written by docs/generate.py from mcsl_core/hookspecs.py. -->"


def module_ast(name: str) -> ast.Module:
    return ast.parse((PACKAGE / f"{name}.py").read_text("utf-8"))


def imported_from(module: ast.Module) -> dict[str, str]:
    """name -> module of mcsl_core it is imported from."""
    return {
        alias.name: node.module
        for node in module.body
        if isinstance(node, ast.ImportFrom) and node.level == 1 and node.module
        for alias in node.names
    }


def class_node(module: ast.Module, name: str) -> ast.ClassDef | None:
    return next((n for n in module.body if isinstance(n, ast.ClassDef) and n.name == name), None)


def names_in(node: ast.AST) -> set[str]:
    return {n.id for n in ast.walk(node) if isinstance(n, ast.Name)}


def functions(cls: ast.ClassDef) -> list[ast.FunctionDef]:
    return [n for n in cls.body if isinstance(n, ast.FunctionDef)]


def signature(function: ast.FunctionDef) -> str:
    returns = f" -> {ast.unparse(function.returns)}" if function.returns else ""
    return f"{function.name}({ast.unparse(function.args)}){returns}"


def document(node: ast.ClassDef | ast.FunctionDef) -> str:
    text = ast.get_docstring(node)
    if not text:
        raise ValueError(f"{node.name} has no docstring, and this page is made of them")
    return text


def hooks_reference() -> str:
    """Each hook, the protocol of what it registers, and the values that are handed over; read from the source text."""
    specs = module_ast("hookspecs")
    origin = imported_from(specs)
    hooks = class_node(specs, "Hooks")
    assert hooks is not None, "mcsl_core/hookspecs.py has no class Hooks"

    def find(name: str) -> ast.ClassDef | None:
        return class_node(specs, name) or (class_node(module_ast(origin[name]), name) if name in origin else None)

    parts = ["## Reference\n"]
    handed: set[str] = set()
    described: set[str] = set()

    def describe(protocol: ast.ClassDef) -> None:
        described.add(protocol.name)
        parts.append(f"#### {protocol.name}\n\n{document(protocol)}\n")
        helpers = []
        for method in functions(protocol):
            if any(ast.unparse(d) == "property" for d in method.decorator_list):
                kind = ast.unparse(method.returns) if method.returns else "str"
                text = ast.get_docstring(method) or "the name it is chosen by"
                parts.append(f"- `{method.name}: {kind}`: {text}")
                continue
            parts.append(f"\n```python\n{signature(method)}\n```\n\n{document(method)}\n")
            for name in sorted(names_in(method.args) | (names_in(method.returns) if method.returns else set())):
                node = find(name)
                if node is not None and any(ast.unparse(b) == "Protocol" for b in node.bases):
                    helpers.append(node)
                elif node is not None:
                    handed.add(name)
        for node in helpers:
            if node.name not in described:
                describe(node)

    for hook in functions(hooks):
        parts.append(f"### {hook.name}\n\n{document(hook)}\n")
        for name in sorted(names_in(hook.returns) if hook.returns else set()):
            node = find(name)
            if node is not None and name not in described:
                describe(node)
    parts.append("### Values that are handed over\n\n| name | where | what |\n|---|---|---|")
    for name in sorted(handed):
        node = find(name)
        assert node is not None
        first = " ".join(document(node).split("\n\n")[0].split())
        parts.append(f"| `{name}` | `mcsl_core.{origin.get(name, 'hookspecs')}` | {first} |")
    return re.sub(r"\n{3,}", "\n\n", "\n".join(parts)) + "\n"


def hooks_page(path: Path) -> str:
    """What is written by hand above the marker in the page at ``path``, the marker, and the reference."""
    above, marker, _ = path.read_text("utf-8").partition(MARKER) if path.exists() else ("# Hooks\n\n", "", "")
    if path.exists() and not marker:
        raise ValueError(f"{path} lacks the line {MARKER!r}, below which the reference goes")
    return f"{above}{MARKER}\n\n{hooks_reference()}"
