"""`make lock`: requirements.lock from requirements.in, with uv in an environment of its own."""

from __future__ import annotations

import re
import sys

from scripts.setup_env import LOCK, ROOT, STATE
from scripts.steps import Step, StepError, run

HEADER = """\
# Every package that `make setup` installs, exact, for Linux x86-64 and Python 3.10 to 3.13.
# Made from requirements.in by `make lock`; do not edit by hand.
"""
OPTIONS = ["--universal", "--python-version", "3.10", "--no-header", "--no-annotate", "--upgrade"]


def main() -> int:
    """Write the lock file anew; return the exit code."""
    STATE.mkdir(exist_ok=True)
    tool, log, result = STATE / "uv", STATE / "lock.log", STATE / "lock.txt"
    source = str(ROOT / "requirements.in")
    commands = {
        "environment for uv": [sys.executable, "-m", "venv", "--clear", str(tool)],
        "uv": [str(tool / "bin" / "pip"), "install", "uv"],
        "resolving": [
            str(tool / "bin" / "uv"),
            "pip",
            "compile",
            *OPTIONS,
            source,
            "-o",
            str(result),
        ],
    }
    try:
        for title, command in commands.items():
            run(Step(title, command, log))
    except StepError as error:
        sys.stderr.write(f"error: {error}\n")
        return 1
    LOCK.write_text(HEADER + for_linux(result.read_text()))
    return 0


def for_linux(text: str) -> str:
    """Drop what a universal resolution says of other systems and interpreters."""
    lines = [line for line in text.splitlines() if "sys_platform == 'win32'" not in line]
    other = (
        r" (;|and) (platform_(python_impl\w+ != 'PyPy'|machine != 'aarch64')"
        r"|\(?platform_machine == [^)]*'x86_64'[^)]*\)?)"
    )
    kept = [re.sub(other, "", line) for line in lines]
    return "\n".join(kept).replace("python_full_version", "python_version") + "\n"


if __name__ == "__main__":
    sys.exit(main())
