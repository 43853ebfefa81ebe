"""Expands the generators' templates without scanning them again for each definition.

EmPy 4 reads a template character by character every time that it is expanded, nested templates
included: 9 tenths of the time in which code for the messages is generated. Here each text is
scanned once, and each of its expressions and statements compiled once.
"""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import Any

import em

_tokens: dict[str, list[Any]] = {}


def remember_scans() -> None:
    """Make EmPy remember what it has scanned; other versions than 4 stay as they are."""
    if hasattr(em, "Core") and hasattr(em.Interpreter, "runSeveral"):
        em.Interpreter.string = _expand
        em.Core.evaluate = _evaluate
        em.Core.execute = _execute


def _expand(
    interpreter: Any,
    string: str,
    locals: dict[str, Any] | None = None,
    dispatcher: Callable[[], bool] | None = None,
) -> None:
    """Expand a text, as `Interpreter.string` does; an error is raised, whatever `dispatcher` is."""
    tokens = _tokens.get(string)
    if tokens is None:
        # The prefix and a line's end expand to nothing; EmPy too adds them where a text's last
        # token can only be told from what follows.
        text = f"{string}{interpreter.config.prefix}\n"
        scanner = em.Scanner(
            interpreter.config, interpreter.getContext(), interpreter.currents, text
        )
        tokens = _tokens[string] = list(_scan(scanner))
    interpreter.runSeveral(tokens, locals)


def _scan(scanner: Any) -> Any:
    while (token := scanner.one()) is not None:
        yield token
        scanner.accumulate()


@functools.cache
def _compiled(code: str, mode: str) -> Any:
    return compile(code, "<template>", mode)


def _evaluate(
    core: Any,
    code: str,
    globals: dict[str, Any],
    locals: dict[str, Any] | None = None,
) -> Any:
    return eval(_compiled(code.lstrip(" \t"), "eval"), globals, locals)  # noqa: S307 - a wheel's template


def _execute(
    core: Any,
    code: str,
    globals: dict[str, Any],
    locals: dict[str, Any] | None = None,
) -> None:
    exec(_compiled(code, "exec"), globals, locals)  # noqa: S102 - a wheel's template
