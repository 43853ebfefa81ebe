"""A node brought up alone, and a logger that keeps its lines."""

from __future__ import annotations

from typing import Any


class Logged:
    """A logger that keeps warnings and errors."""

    def __init__(self) -> None:
        self.warnings: list[str] = []
        self.errors: list[str] = []

    def warning(self, text: str, **_: bool) -> None:
        self.warnings.append(text)

    def error(self, text: str, **_: bool) -> None:
        self.errors.append(text)

    def info(self, text: str, **_: bool) -> None:
        pass

    debug = info


def activated(bench: Any, cls: type[Any], **values: Any) -> Any:
    """Return a node of some parameters that is active."""
    node = cls(bench.process, values)
    node.trigger_configure()
    node.trigger_activate()
    bench.process.drain()
    return node
