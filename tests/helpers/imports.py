"""The imports of a tree of Python files, wherever they stand, and the circles they form."""

from __future__ import annotations

import ast
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import NamedTuple

_LOADERS = {"import_module", "__import__"}


class Import(NamedTuple):
    """One module that a file names in an import.

    Attributes:
        location: `path:line`.
        path: The file, relative to the root.
        module: The module; "(relative)" for a relative import.
        names: The names that are taken from it.
        typing: Whether only type checkers read it.
    """

    location: str
    path: str
    module: str
    names: tuple[str, ...] = ()
    typing: bool = False

    @property
    def package(self) -> str:
        """The top-level package that the file is in."""
        return self.path.split("/", maxsplit=1)[0]

    @property
    def targets(self) -> tuple[str, ...]:
        """The dotted names that may be modules: the module, and what is taken from it."""
        return (self.module, *(f"{self.module}.{name}" for name in self.names))


def imports(root: Path, *packages: str) -> Iterator[Import]:
    """Every import of the packages: at the top, inside functions, and by `import_module`."""
    for package in packages:
        for file in sorted((root / package).rglob("*.py")):
            path, text = file.relative_to(root).as_posix(), file.read_text(encoding="utf-8")
            tree, loads = ast.parse(text), any(name in text for name in _LOADERS)
            nodes = list(ast.walk(tree) if loads else _statements(tree))
            guards = [
                n for n in nodes if isinstance(n, ast.If) and _name(n.test) == "TYPE_CHECKING"
            ]
            typing = {id(node) for guard in guards for node in ast.walk(guard)}
            for node in nodes:
                location = f"{path}:{getattr(node, 'lineno', 0)}"
                for module, names in _modules(node):
                    yield Import(location, path, module, names, id(node) in typing)


def _statements(node: ast.AST) -> Iterator[ast.AST]:
    """Yield what may hold an import, which an expression cannot."""
    yield node
    for child in ast.iter_child_nodes(node):
        if not isinstance(child, ast.expr):
            yield from _statements(child)


def _modules(node: ast.AST) -> list[tuple[str, tuple[str, ...]]]:
    if isinstance(node, ast.Import):
        return [(alias.name, ()) for alias in node.names]
    if isinstance(node, ast.ImportFrom):
        module = "(relative)" if node.level else str(node.module)
        return [(module, tuple(alias.name for alias in node.names))]
    if isinstance(node, ast.Call) and node.args and _name(node.func) in _LOADERS:
        return [(text, ()) for text in [_constant(node.args[0])] if text]
    return []


def _name(function: ast.expr) -> str:
    return getattr(function, "attr", getattr(function, "id", ""))


def _constant(argument: ast.expr) -> str | None:
    """Return the module that a call names, as far as it stands in the code."""
    if isinstance(argument, ast.JoinedStr) and argument.values:
        argument = argument.values[0]
    value = getattr(argument, "value", None)
    return value.rstrip(".") if isinstance(value, str) else None


def file_graph(found: list[Import], root: Path) -> dict[str, set[str]]:
    """Return which files of the tree each file imports, by path."""
    graph: dict[str, set[str]] = {}
    for item in found:
        graph.setdefault(item.path, set()).update(
            path for target in item.targets for path in [file_of(target, root)] if path
        )
    return {path: targets - {path} for path, targets in graph.items()}


def file_of(module: str, root: Path) -> str | None:
    """Return the path of a module of the tree, or None."""
    stem = module.replace(".", "/")
    for path in (f"{stem}.py", f"{stem}/__init__.py"):
        if (root / path).is_file():
            return path
    return None


def circles(graph: Mapping[str, set[str]]) -> list[list[str]]:
    """Return the groups of files that import each other in a circle (Tarjan, 1972)."""
    index: dict[str, int] = {}
    low: dict[str, int] = {}
    stack: list[str] = []
    found: list[list[str]] = []

    def visit(node: str) -> None:
        index[node] = low[node] = len(index)
        stack.append(node)
        for target in sorted(graph.get(node, ())):
            if target not in index:
                visit(target)
                low[node] = min(low[node], low[target])
            elif target in stack:
                low[node] = min(low[node], index[target])
        if low[node] == index[node]:
            at = stack.index(node)
            group = stack[at:]
            del stack[at:]
            if len(group) > 1:
                found.append(sorted(group))

    for node in sorted(graph):
        if node not in index:
            visit(node)
    return sorted(found)
