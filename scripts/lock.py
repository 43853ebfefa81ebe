"""`make lock`: the lock files from their `.in` files, with uv in an environment of its own."""

from __future__ import annotations

import re
import sys

from scripts.setup_env import LOCK, ROOT, STATE
from scripts.steps import Step, StepError, run

HEADER = """\
# Every package that `make {target}` installs, exact, for Linux x86-64 and Python 3.10 to 3.13.
# Made from {source} by `make lock`; do not edit by hand.
"""
OPTIONS = ["--universal", "--python-version", "3.10", "--no-header", "--no-annotate", "--upgrade"]
LOCKS = {"setup": LOCK, "docs": ROOT / "requirements-docs.lock"}
"""The lock files, by the target that installs what stands in them."""


def main() -> int:
    """Write the lock files anew; return the exit code."""
    STATE.mkdir(exist_ok=True)
    tool, log = STATE / "uv", STATE / "lock.log"
    try:
        run(Step("environment for uv", [sys.executable, "-m", "venv", "--clear", str(tool)], log))
        run(Step("uv", [str(tool / "bin" / "pip"), "install", "uv"], log))
        for target, lock in LOCKS.items():
            source, result = lock.with_suffix(".in"), STATE / "lock.txt"
            command = [str(tool / "bin" / "uv"), "pip", "compile", *OPTIONS, str(source)]
            run(Step(f"resolving {source.name}", [*command, "-o", str(result)], log))
            lock.write_text(header(target) + for_linux(result.read_text()))
    except StepError as error:
        sys.stderr.write(f"error: {error}\n")
        return 1
    return 0


def header(target: str) -> str:
    """Return the first lines of the lock file that a target installs from."""
    return HEADER.format(target=target, source=LOCKS[target].with_suffix(".in").name)


def for_linux(text: str) -> str:
    """Drop what a universal resolution says of other systems and interpreters."""
    lines = [line for line in text.splitlines() if "sys_platform == 'win32'" not in line]
    other = (
        r" (;|and) (platform_(python_impl\w+ != 'PyPy'|machine != 'aarch64')"
        r"|\(?platform_machine == [^)]*'x86_64'[^)]*\)?)"
    )
    kept = [re.sub(other, "", line) for line in lines]
    minor = r"python_full_version( [<>=!]+ '\d+\.\d+(\.\*)?')"
    return re.sub(minor, r"python_version\1", "\n".join(kept)) + "\n"


if __name__ == "__main__":
    sys.exit(main())
