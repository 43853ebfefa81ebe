"""`make setup`: everything Arjuna needs, in `.venv`, from the lock file. Standard library only.

Each step leaves a stamp that holds a hash of all it depends on, so that a second run does nothing
and needs no network, and a run that was interrupted starts that environment again.
"""

from __future__ import annotations

import fcntl
import hashlib
import shutil
import sys
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path

from scripts import installing, kernels, preflight
from scripts.installing import EXTRAS, ON_REQUEST, find_uv, lines_of, locked, wanted_extras
from scripts.steps import Step, StepError, run, say, stopped_at_the_end

ROOT = Path(__file__).resolve().parent.parent
VENV = ROOT / ".venv"
PYTHON = VENV / "bin" / "python"
STATE = ROOT / ".setup"
LOCK = ROOT / "requirements.lock"
MESSAGES = ROOT / "arjuna_interfaces"
REINSTALL = "--force-reinstall"
UNFINISHED = VENV / "unfinished"
"""Lies in the environment while its packages change."""
BUILD_PREFIXES = ("ros-", "numpy=", "setuptools=", "empy=", "lark-parser=", "pyyaml=")
"""The lock file's packages that the message packages are built with."""


def main() -> int:
    """Set up what is not set up yet; return the exit code, 2 where something is missing."""
    STATE.mkdir(exist_ok=True)
    with (STATE / "lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)  # two `make` at once take turns
        try:
            return set_up()
        except StepError as error:
            sys.stderr.write(f"error: {error}\n")
            return 1
        except KeyboardInterrupt:
            sys.stderr.write("error: interrupted; run it again to continue\n")
            return 130


def set_up() -> int:
    """Run the steps whose stamps do not hold."""
    extras = wanted_extras()
    packages, messages, ours, compiled = keys()
    missing = [extra for extra in extras if not stamp_holds(f"extra-{extra}", extra_key(extra))]
    fresh = UNFINISHED.exists() or not stamp_holds("packages", packages)
    if fresh or missing:
        if not passes(preflight.ALWAYS + preflight.TO_INSTALL + compile_checks(messages)):
            return 2
        install_packages(packages, missing)
    if not passes(() if stamp_holds("messages", messages) else compile_checks(messages)):
        return 2
    forget_moved()
    build_beside_kernels(messages, compiled)
    if not stamp_holds("ours", ours):
        install("Arjuna itself", "ours", ["--no-build-isolation", "-e", "."])
        write_stamp("ours", ours)
    return 0


def forget_moved() -> None:
    """Delete what Numba has compiled if a module is gone: it asks for types where they were."""
    known, files = STATE / "modules", ROOT.glob("arjuna_*/**/*.py")
    modules = {str(path.relative_to(ROOT)) for path in files}
    if known.exists() and not modules.issuperset(known.read_text().splitlines()):
        for path in ROOT.glob("arjuna_*/**/__pycache__/*.nb[ic]"):
            path.unlink()
    known.write_text("\n".join(sorted(modules)))


def keys() -> tuple[str, str, str, str]:
    """Return the hashes of what packages, messages, our own install and kernels depend on."""
    python = f"{sys.version} {sys.base_prefix}"
    lines = lines_of(LOCK)
    packages = digest([python, *lines])
    files = sorted(path for path in MESSAGES.rglob("*") if is_source(path))
    contents = [f"{path.relative_to(ROOT)} {digest([path.read_bytes()])}" for path in files]
    messages = digest([python, *build_lines(lines), *contents])
    ours = digest([packages, str(ROOT), (ROOT / "pyproject.toml").read_bytes()])
    listed = kernels.LIST.read_bytes()
    compiled = digest([packages, listed, *kernels.digests(ROOT).values()])
    return packages, messages, ours, compiled


def extra_key(extra: str) -> str:
    """Return the hash of what an extra's packages depend on."""
    return digest([sys.version, *lines_of(LOCK, extra)])


def is_source(path: Path) -> bool:
    """Return whether a file below `arjuna_interfaces/` is a source, not a build's output."""
    parts = path.relative_to(MESSAGES).parts
    built = any(part == "__pycache__" or part.endswith(".egg-info") for part in parts)
    return path.is_file() and not built and parts[0] != "build"


def build_lines(lines: Iterable[str]) -> list[str]:
    """Return the lock file's lines that the message packages are built with."""
    return [line for line in lines if line.startswith(BUILD_PREFIXES)]


def passes(checks: tuple[Callable[[], preflight.Missing | None], ...]) -> bool:
    """Print what checks miss; return whether the set-up can continue."""
    missing = preflight.find_missing(checks)
    for line in preflight.explain(missing):
        sys.stderr.write(f"{line}\n")
    return not any(item.fatal for item in missing)


def compile_checks(messages: str) -> tuple[Callable[[], preflight.Missing | None], ...]:
    """Return the compiler's checks, or none where the message packages are built already."""
    return () if built_wheel(messages) else preflight.TO_COMPILE


def install_packages(packages: str, extras: list[str]) -> None:
    """Make the environment if need be, and fill it."""
    fresh = UNFINISHED.exists() or not stamp_holds("packages", packages)
    if fresh:
        create_environment()
        extras = [*extras, *kept_extras(set(extras))]
    UNFINISHED.touch()
    lines = [*(lines_of(LOCK) if fresh else ()), *(x for e in extras for x in lines_of(LOCK, e))]
    chosen = STATE / "requirements.txt"
    chosen.write_text("\n".join(dict.fromkeys(lines)) + "\n")
    title = "Python packages" if fresh else f"Python packages of {', '.join(extras)}"
    install(title, "packages", locked(chosen))
    write_stamp("packages", packages)
    for extra in extras:
        write_stamp(f"extra-{extra}", extra_key(extra))
    UNFINISHED.unlink()


def kept_extras(others: set[str]) -> list[str]:
    """Return the extras that the environment has already, to be brought up to date too."""
    return [
        e
        for e in (*EXTRAS, *ON_REQUEST)
        if e not in others and (VENV / f"extra-{e}.stamp").exists()
    ]


def install(title: str, log: str, arguments: list[str]) -> None:
    """Install something into the environment."""
    uv = find_uv(LOCK, PYTHON, STATE / "uv-bin", STATE / "uv.log")
    installing.install(title, STATE / f"{log}.log", PYTHON, uv, arguments)


def build_beside_kernels(messages: str, compiled: str) -> None:
    """Build and install the message packages, and compile the kernels beside it."""
    if stamp_holds("compiled", compiled):
        install_messages(messages)
        return
    command = [str(PYTHON), "-m", "scripts.kernels", "compile"]
    step = Step("compiling kernels", command, STATE / "kernels.log")
    with stopped_at_the_end(step):
        install_messages(messages)
        step.finish()
    write_stamp("compiled", compiled)


def create_environment() -> None:
    """Make `.venv`, again where one was left half done or belongs to another Python."""
    if VENV.exists() and not (VENV / "pyvenv.cfg").exists():
        raise StepError(f"{VENV} is not an environment that this made; move it away")
    if UNFINISHED.exists() or not stamp_holds("python", sys.version):
        command = [sys.executable, "-m", "venv", "--clear", str(VENV)]
        run(Step("environment in .venv", command, STATE / "venv.log"))
        write_stamp("python", sys.version)
    UNFINISHED.touch()


def install_messages(messages: str) -> None:
    """Install the message packages, built first if no build of these sources is kept."""
    if stamp_holds("messages", messages):
        return
    with messages_step(messages) as build:
        if build:
            build.finish()
            keep_wheel(messages)
    install("message packages", "install-messages", [REINSTALL, str(built_wheel(messages))])
    write_stamp("messages", messages)


@contextmanager
def messages_step(messages: str) -> Iterator[Step | None]:
    """Start the build of the message packages, None where one of these sources is kept."""
    if built_wheel(messages):
        yield None
        return
    shutil.rmtree(MESSAGES / "build", ignore_errors=True)
    target = wheel_folder(messages).with_suffix(".new")
    shutil.rmtree(target, ignore_errors=True)
    options = ["-v", "--no-deps", "--no-build-isolation", "-w", str(target)]
    step = pip_step("compiling message packages", "messages", "wheel", *options, str(MESSAGES))
    with stopped_at_the_end(step):
        yield step


def keep_wheel(messages: str) -> None:
    """Move a finished build to where it is looked for; older builds and its scraps go."""
    folder = wheel_folder(messages)
    new = folder.with_suffix(".new")
    for other in folder.parent.iterdir():
        if other != new:
            shutil.rmtree(other)
    new.rename(folder)
    shutil.rmtree(MESSAGES / "build", ignore_errors=True)


def built_wheel(messages: str) -> Path | None:
    """Return the kept build of these sources, None where there is none."""
    return next(iter(wheel_folder(messages).glob("*.whl")), None)


def wheel_folder(messages: str) -> Path:
    """Return where a build of these sources is kept."""
    return STATE / "wheels" / messages


def pip_step(title: str, log: str, *arguments: str) -> Step:
    """Start pip in the environment."""
    return Step(title, [str(PYTHON), "-m", "pip", *arguments], STATE / f"{log}.log")


def stamp_holds(name: str, key: str) -> bool:
    """Return whether a step was done with all that it depends on as it is now."""
    path = VENV / f"{name}.stamp"
    return PYTHON.exists() and path.is_file() and path.read_text() == key


def write_stamp(name: str, key: str) -> None:
    """Remember that a step is done."""
    (VENV / f"{name}.stamp").write_text(key)


def digest(parts: Iterable[str | bytes]) -> str:
    """Return a SHA-256 of parts, as 16 hex digits."""
    total = hashlib.sha256()
    for part in parts:
        data = part.encode() if isinstance(part, str) else part
        total.update(b"%d:" % len(data) + data)
    return total.hexdigest()[:16]


if __name__ == "__main__":
    code = main()
    if code == 0:
        say("ready (.venv)")
    sys.exit(code)
