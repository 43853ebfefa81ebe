"""Tests of pytest beside a launch, by launch_pytest's names; see docs/ci.md."""

from __future__ import annotations

import importlib
from collections.abc import Callable
from typing import Any

__all__ = ["actions", "fixture", "tools"]


def fixture(
    decorated: Callable[..., Any] | None = None, *, shutdown_when_idle: bool = False, **kwargs: Any
) -> Any:
    """Have a description be launched for tests that name it: `@pytest.mark.launch(fixture=it)`."""
    import pytest

    kwargs.pop("auto_shutdown", None)

    def decorate(function: Callable[..., Any]) -> Any:
        function.launch_pytest_options = {"shutdown_when_idle": shutdown_when_idle}  # type: ignore[attr-defined]
        return pytest.fixture(**kwargs)(function)

    return decorate if decorated is None else decorate(decorated)


def __getattr__(name: str) -> Any:
    """Import a part when it is asked for: pytest loads this package in every run."""
    if name in ("actions", "tools"):
        return importlib.import_module(f"launch_pytest.{name}")
    raise AttributeError(f"module 'launch_pytest' has no attribute '{name}'; valid: {__all__}")
