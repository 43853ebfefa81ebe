"""`make docs`: the pages as a site in out/docs, every link between them checked.

The pages are plain Markdown that links files all over the checkout, so they are first copied with
all they link into a tree of its own, which mkdocs turns into the site. It installs mkdocs into an
environment of its own; standard library only.
"""

from __future__ import annotations

import re
import shutil
import sys
from collections.abc import Iterable, Iterator
from pathlib import Path

from scripts.installing import PIP, locked
from scripts.lock import LOCKS
from scripts.setup_env import ROOT, STATE, digest
from scripts.steps import Step, StepError, run, say

VENV = STATE / "docs-venv"
PAGES, SITE = STATE / "docs-pages", ROOT / "out" / "docs"
START = ("README.md", "CONTRIBUTING.md", "CHANGELOG.md", "SECURITY.md", "docs/**/*.md")
_LINK = re.compile(r"\]\(([^)\s#]+)")


def main() -> int:
    """Build the site; return the exit code, 1 where a link leads nowhere."""
    STATE.mkdir(exist_ok=True)
    try:
        install()
        gather(ROOT, PAGES, START)
        run(Step("site", [str(VENV / "bin" / "mkdocs"), "build", "--strict"], STATE / "docs.log"))
    except StepError as error:
        sys.stderr.write(f"error: {error}\n")
        return 1
    say(f"see {(SITE / 'index.html').relative_to(ROOT)}")
    return 0


def install() -> None:
    """Make the environment that the lock file asks for, if it is not there."""
    stamp, key = VENV / "packages.stamp", digest([sys.version, LOCKS["docs"].read_bytes()])
    if stamp.is_file() and stamp.read_text() == key:
        return
    log = STATE / "docs.log"
    run(Step("environment for mkdocs", [sys.executable, "-m", "venv", "--clear", str(VENV)], log))
    run(
        Step(
            "mkdocs",
            [str(VENV / "bin" / "python"), *PIP, "--no-compile", *locked(LOCKS["docs"])],
            log,
        )
    )
    stamp.write_text(key)


def gather(root: Path, target: Path, start: Iterable[str]) -> None:
    """Copy pages, by patterns of the root, and what they link to, into an emptied tree."""
    shutil.rmtree(target, ignore_errors=True)
    waiting = [path for pattern in start for path in sorted(root.glob(pattern))]
    done = set(waiting)
    while waiting:
        page = waiting.pop()
        copy = target / page.relative_to(root)
        copy.parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(page, copy)
        new = [path for path in _linked(page, root) if path not in done]
        done.update(new)
        waiting += new


def _linked(page: Path, root: Path) -> Iterator[Path]:
    if page.suffix != ".md":
        return
    for target in _LINK.findall(page.read_text(encoding="utf-8")):
        path = (page.parent / target).resolve()
        if "://" not in target and path.is_file() and path.is_relative_to(root):
            yield path


if __name__ == "__main__":
    sys.exit(main())
