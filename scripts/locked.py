"""The lock file's lines: which are for everybody, which for one of the extras."""

from __future__ import annotations

import os
import re
from pathlib import Path

from scripts.steps import StepError

EXTRAS = ("campaign", "dev", "tune", "view")
"""Optional packages: those that the demo does not need."""
INSTALLER = "setup"
"""The extra of the program that installs the others."""
_LINE = re.compile(r"(?P<pin>[^#\s][^#]*?)(?:\s+# (?P<extras>[\w ]+))?")


def lines_of(lock: Path, extra: str = "") -> list[str]:
    """Return the lines of one extra, without comments; those for everybody by default."""
    found = []
    for line in lock.read_text(encoding="utf-8").splitlines():
        match = _LINE.fullmatch(line)
        if match and extra in (match["extras"] or "").split(" "):
            found.append(match["pin"])
    return found


def wanted_extras() -> tuple[str, ...]:
    """Return the extras that `EXTRAS` names; all if it is not set, none if it is empty.

    Raises:
        StepError: It names others.
    """
    words = os.environ.get("EXTRAS", "all").replace(",", " ").split()
    if words == ["all"]:
        return EXTRAS
    if unknown := sorted(set(words) - set(EXTRAS)):
        raise StepError(
            f"EXTRAS has no {', '.join(unknown)}; valid: {', '.join(EXTRAS)}, all, or nothing"
        )
    return tuple(sorted(set(words)))
