"""The lock file's lines, and their installer: uv in a tenth of pip's time, or pip."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
from pathlib import Path

from scripts.steps import Step, StepError, clean_environment, run, say

EXTRAS = ("campaign", "dev", "gpu", "learn", "tune", "view")
"""Optional packages: those that the demo does not need."""
ON_REQUEST = ("cluster",)
"""Those that `all` leaves out, for they are large and few machines need them."""
INSTALLER = "setup"
"""The extra of the program that installs the others."""
PIP = ("-m", "pip", "install", "--no-deps")
UV = ("pip", "install", "--no-deps")
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

    `all` may stand beside those that it leaves out.

    Raises:
        StepError: It names others.
    """
    words = set(os.environ.get("EXTRAS", "all").replace(",", " ").split())
    if "all" in words:
        words = words - {"all"} | set(EXTRAS)
    valid = (*EXTRAS, *ON_REQUEST)
    if unknown := sorted(words - set(valid)):
        raise StepError(
            f"EXTRAS has no {', '.join(unknown)}; valid: {', '.join(valid)}, all, or nothing"
        )
    return tuple(sorted(words))


def install(title: str, log: Path, python: Path, uv: Path | None, arguments: list[str]) -> None:
    """Install into the environment of `python`.

    Args:
        uv: The program; None where only pip is.
        arguments: What to install, in words that both understand.

    Raises:
        StepError: pip failed.
    """
    if uv is not None:
        try:
            run(Step(title, [str(uv), *UV, "--python", str(python), *arguments], log, _index()))
        except StepError:
            say(f"{title}: once more, with pip, which may be set up for another index")
        else:
            return
    run(Step(title, [str(python), *PIP, "--no-compile", *arguments], log))


def locked(requirements: Path) -> list[str]:
    """Return the words that install a file of locked lines, and nothing of another hash."""
    return ["--require-hashes", "-r", str(requirements)]


def find_uv(lock: Path, python: Path, folder: Path, log: Path) -> Path | None:
    """Return uv as the lock file has it, installed beside the environment; None where it is not."""
    pins = lines_of(lock, INSTALLER)
    stamp, uv = folder / "version", folder / "bin" / "uv"
    if not pins:
        return None
    if stamp.is_file() and stamp.read_text() == pins[0] and uv.exists():
        return uv
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir()
    requirements = folder / "requirements.txt"
    requirements.write_text("\n".join(pins) + "\n")
    command = [str(python), *PIP, "--no-compile", "--target", str(folder), *locked(requirements)]
    with log.open("wb") as stream:
        done = subprocess.run(  # noqa: S603 - fixed program, no shell
            command, stdin=subprocess.DEVNULL, stdout=stream, stderr=stream, env=clean_environment()
        )
    if done.returncode != 0:
        return None
    stamp.write_text(pins[0])
    return uv


def _index() -> dict[str, str]:
    """Return the variable that gives uv the index that pip's own variable names."""
    index = os.environ.get("PIP_INDEX_URL")
    return {"UV_DEFAULT_INDEX": index} if index else {}
