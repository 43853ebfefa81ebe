"""The page of messages: what errors, logs and the doctor say, read from the sources."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterable, Iterator

from scripts.reference import NOTE, ROOT, cell

_PACKAGES = ("arjuna", "arjuna_core", "arjuna_sim", "arjuna_slam", "arjuna_nav", "bringup")
_INTRO = f"""# Messages

What can go wrong says so in words; `...` stands for what varies: a file, a name, a number. Search
this page for the words that do not vary. An *error* refuses an input or ends a command, a
*warning* stands in a node's log while it goes on, and a *finding* is the doctor's, with its remedy.

{NOTE}
"""
_ROOT_ERROR = "ArjunaError"
_LOGGED = {"warn": "warning", "warning": "warning", "error": "error in the log",
           "fatal": "error in the log"}  # fmt: skip
_WORDS = re.compile(r"[A-Za-z]{2,}")


def page() -> str:
    """Return the page."""
    trees = {
        path.relative_to(ROOT): ast.parse(path.read_text(encoding="utf-8"))
        for package in _PACKAGES
        for path in sorted((ROOT / package).rglob("*.py"))
    }
    errors = _errors(trees.values())
    lines = [_INTRO]
    for package in _PACKAGES:
        rows = sorted(
            {
                f"| {cell(text)} | {kind} | [{path.name}](../../{path}) |"
                for path, tree in trees.items()
                if path.parts[0] == package
                for text, kind in _said(tree, errors)
            },
            key=str.lower,
        )
        if rows:
            lines += [f"## {package}\n", "| message | is | from |", "|---|---|---|", *rows, ""]
    return "\n".join(lines).rstrip("\n") + "\n"


def _errors(trees: Iterable[ast.Module]) -> set[str]:
    bases = {
        node.name: {base.id for base in node.bases if isinstance(base, ast.Name)}
        for tree in trees
        for node in tree.body
        if isinstance(node, ast.ClassDef)
    }
    found = {_ROOT_ERROR}
    while more := {name for name, above in bases.items() if above & found} - found:
        found |= more
    return found


def _said(tree: ast.Module, errors: set[str]) -> Iterator[tuple[str, str]]:
    for scope in ast.walk(tree):
        if isinstance(scope, ast.FunctionDef):
            calls = [node for node in ast.walk(scope) if isinstance(node, ast.Call)]
            yield from _said_in(scope, calls, errors)
            yield from _findings_in(scope, calls)


def _said_in(
    scope: ast.FunctionDef, calls: list[ast.Call], errors: set[str]
) -> Iterator[tuple[str, str]]:
    made = {*errors, *_LOGGED}
    calls = [call for call in calls if _name(call.func) in made]
    values = _assigned(scope) if calls else {}
    for node in calls:
        name = _name(node.func)
        if name in errors or ast.unparse(node.func) == "self.error":
            for text in _texts(node.args, values):
                yield text, "error"
        elif "logger" in ast.unparse(node.func).lower():
            for text in _texts(node.args[:1], values):
                yield text, _LOGGED[name]


def _findings_in(scope: ast.FunctionDef, calls: list[ast.Call]) -> Iterator[tuple[str, str]]:
    """Yield the findings of a function; a name stands for its values since the last one."""
    calls = [c for c in calls if _name(c.func) == "Finding" and len(c.args) == 2]
    values, before = _assigned(scope) if calls else {}, 0
    for call in sorted(calls, key=lambda call: call.lineno):
        near = {
            name: [node for node in nodes if before < node.lineno <= call.lineno] or nodes
            for name, nodes in values.items()
        }
        whats, remedies = (list(_texts([one], near)) for one in call.args)
        for what in whats:
            yield f"{what}: {remedies[-1] if remedies else '...'}", "finding"
        before = call.lineno


def _name(function: ast.expr) -> str:
    if isinstance(function, ast.Attribute):
        return function.attr
    return function.id if isinstance(function, ast.Name) else ""


def _assigned(scope: ast.FunctionDef) -> dict[str, list[ast.expr]]:
    """Return what each name of a function is set to, extended by or holds."""
    found: dict[str, list[ast.expr]] = {}
    for node in ast.walk(scope):
        if isinstance(node, ast.Assign) and isinstance(node.targets[0], ast.Name):
            found.setdefault(node.targets[0].id, []).append(node.value)
        elif isinstance(node, ast.AugAssign) and isinstance(node.target, ast.Name):
            found.setdefault(node.target.id, []).append(node.value)
        elif isinstance(node, ast.Call) and _name(node.func) == "append" and node.args:
            owner = node.func.value if isinstance(node.func, ast.Attribute) else None
            if isinstance(owner, ast.Name):
                found.setdefault(owner.id, []).append(node.args[0])
    return found


def _texts(
    nodes: list[ast.expr], values: dict[str, list[ast.expr]], fixed_words: int = 2
) -> Iterator[str]:
    """Return the sentences that expressions stand for.

    Those with fewer fixed words are left out: nobody could search for them.
    """
    for node in nodes:
        if isinstance(node, ast.Constant | ast.JoinedStr | ast.BinOp):
            text = _text(node)
            if len(_WORDS.findall(text)) >= fixed_words:
                yield text
        elif isinstance(node, ast.Name):
            yield from _texts(values.get(node.id, []), {})
        elif isinstance(node, ast.Starred):
            yield from _texts([node.value], values)
        elif isinstance(node, ast.List | ast.Tuple):
            yield from _texts(node.elts, values)
        elif isinstance(node, ast.ListComp | ast.GeneratorExp):
            yield from _texts([node.elt], values)
        elif isinstance(node, ast.IfExp):
            yield from _texts([node.body, node.orelse], values)


def _text(node: ast.expr) -> str:
    if isinstance(node, ast.Constant):
        return node.value if isinstance(node.value, str) else ""
    if isinstance(node, ast.JoinedStr):
        return "".join(
            _text(one) if isinstance(one, ast.Constant) else "..." for one in node.values
        )
    if isinstance(node, ast.BinOp) and isinstance(node.op, ast.Add):
        return _text(node.left) + _text(node.right)
    return "..."
