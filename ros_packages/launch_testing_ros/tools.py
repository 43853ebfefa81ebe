"""Filters of what nodes write."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable
from typing import Any

from launch_testing import tools

_MIDDLEWARE = re.compile(r"pid \d+|.*\b(rmw_\w+|rtps|RTPS|DDS)\b")


def basic_output_filter(
    *,
    filtered_prefixes: Iterable[str] = (),
    filtered_patterns: Iterable[Any] = (),
    filtered_rmw_implementation: str | None = None,
) -> Callable[[str], str]:
    """Return what drops lines by prefix or pattern, and with a middleware's name those of it."""
    patterns = [*filtered_patterns, *([_MIDDLEWARE] if filtered_rmw_implementation else [])]
    return tools.basic_output_filter(
        filtered_prefixes=filtered_prefixes, filtered_patterns=patterns
    )
