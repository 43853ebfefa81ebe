"""Text of processes."""

from __future__ import annotations


def normalize_lineseps(lines: str) -> str:
    """Return a text whose lines end as on this system."""
    return "\n".join(lines.splitlines()) + ("\n" if lines.endswith(("\r", "\n")) else "")
