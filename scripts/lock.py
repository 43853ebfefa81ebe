"""`make lock`: the lock files from their `.in` files, with uv in an environment of its own."""

from __future__ import annotations

import re
import sys

from scripts.setup_env import LOCK, ROOT, STATE
from scripts.steps import Step, StepError, run

HEADER = """\
# Every package that `make {target}` installs, exact, for Linux x86-64 and Python 3.10 to 3.13.
# Made from {source} by `make lock`; do not edit by hand. A line's comment names its extras.
"""
OPTIONS = ["--universal", "--python-version", "3.10", "--no-header", "--upgrade"]
_FILE = re.compile(r'url = "[^"]*/([^/"]+)"[^}]*?sha256 = "([0-9a-f]{64})"')
_NAME = re.compile(r"[\w.-]+")
FILES = ["--universal", "--python-version", "3.10", "--no-deps", "--format", "pylock.toml"]
LOCKS = {"setup": LOCK, "docs": ROOT / "requirements-docs.lock"}
"""The lock files, by the target that installs what stands in them."""


def main() -> int:
    """Write the lock files again; return the exit code."""
    STATE.mkdir(exist_ok=True)
    tool, log = STATE / "uv", STATE / "lock.log"
    uv = tool / "bin" / "uv"
    try:
        run(Step("environment for uv", [sys.executable, "-m", "venv", "--clear", str(tool)], log))
        run(Step("uv", [str(tool / "bin" / "pip"), "install", "uv"], log))
        for target, lock in LOCKS.items():
            source, result = lock.with_suffix(".in"), STATE / "lock.txt"
            command = [str(uv), "pip", "compile", *OPTIONS, str(source)]
            run(Step(f"resolving {source.name}", [*command, "-o", str(result)], log))
            pinned = for_linux(with_extras(result.read_text(), source.read_text()))
            result.write_text(pinned)
            files = STATE / "pylock.toml"
            command = [str(uv), "pip", "compile", *FILES, str(result), "-o", str(files)]
            run(Step(f"hashes of {source.name}", command, log))
            lock.write_text(header(target) + with_hashes(pinned, files.read_text()))
    except StepError as error:
        sys.stderr.write(f"error: {error}\n")
        return 1
    return 0


def header(target: str) -> str:
    """Return the first lines of the lock file that a target installs from."""
    return HEADER.format(target=target, source=LOCKS[target].with_suffix(".in").name)


def with_extras(resolved: str, source: str) -> str:
    """Return the pinned lines, each that only extras need with their names as its comment.

    Args:
        resolved: uv's answer: pinned lines, each followed by comments that say who asks for it.
        source: The file it is made from; a line `# extra: NAME` begins what an extra asks for.
    """
    wanted = _direct(source)
    asked_by: dict[str, set[str]] = {}
    lines = []
    for line in resolved.splitlines():
        if not line.lstrip().startswith("#"):
            lines.append(line)
            name = _NAME.match(line)[0].lower()  # type: ignore[index]
        elif word := line.strip(" #").removeprefix("via").strip():
            asked_by.setdefault(name, set()).add(word)
    own = {name for extra, names in wanted.items() if extra for name in names}
    needed = {extra: _closure(names, asked_by, own) for extra, names in wanted.items()}
    base = needed.pop("")
    marked = []
    for line in lines:
        name = _NAME.match(line)[0].lower()  # type: ignore[index]
        extras = "" if name in base else " ".join(sorted(e for e in needed if name in needed[e]))
        marked.append(f"{line}  # {extras}" if extras else line)
    return "\n".join(marked) + "\n"


def with_hashes(pinned: str, files: str) -> str:
    """Return the pinned lines, each with the hashes of the files that may be installed for it.

    Args:
        files: The same as a pylock.toml, which names all files of each.

    Raises:
        StepError: A package has no file for Linux on x86-64, nor a source.
    """
    known: dict[str, list[str]] = {}
    for package in files.split("[[packages]]")[1:]:
        fields = dict(re.findall(r'^(name|version) = "([^"]+)"', package, re.MULTILINE))
        wheels = [found for found in _FILE.findall(package) if _fits(found[0])]
        usable = wheels or [found for found in _FILE.findall(package) if ".tar." in found[0]]
        hashes = sorted(f"--hash=sha256:{digest}" for _, digest in usable)
        known[f"{fields['name']}=={fields['version']}"] = hashes
    lines = []
    for line in pinned.splitlines():
        pin, comment, extras = line.partition("  # ")
        if not known.get(pin.split(" ")[0]):
            raise StepError(f"no file of {pin} can be installed on Linux on x86-64")
        lines.append(" ".join([pin, *known[pin.split(" ")[0]]]) + comment + extras)
    return "\n".join(lines) + "\n"


def _fits(name: str) -> bool:
    """Return whether a wheel is for Linux on x86-64 and one of our Python versions."""
    if not name.endswith(".whl"):
        return False
    pythons, abi, platforms = name.removesuffix(".whl").split("-")[-3:]
    here = platforms == "any" or ("linux" in platforms and "x86_64" in platforms)
    old = abi == "abi3" and re.search(r"cp3\d?\b", pythons)
    ours = "py3" in pythons.split(".") or re.search(r"cp31[0-3]\b", pythons) or old
    return here and "musl" not in platforms and not abi.endswith("t") and bool(ours)


def _direct(source: str) -> dict[str, set[str]]:
    """Return the names that each extra asks for, under "" what every user needs."""
    wanted: dict[str, set[str]] = {"": set()}
    extra = ""
    for line in source.splitlines():
        if started := re.match(r"# extra: (\w+)", line):
            extra = started[1]
            wanted[extra] = set()
        elif line and not line.startswith("#"):
            wanted[extra].add(_NAME.match(line)[0].lower())  # type: ignore[index]
    return wanted


def _closure(names: set[str], asked_by: dict[str, set[str]], own: set[str]) -> set[str]:
    """Return names and all they ask for, but for what an extra asks for by itself."""
    reached = set(names)
    while new := {
        name
        for name, users in asked_by.items()
        if name not in reached and users & reached and (name not in own or names & own)
    }:
        reached |= new
    return reached


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
