"""Compiles the Numba functions that a robot calls, so that no user waits for them.

`kernels.json` lists each function with the types of its arguments, as a demo and a drive with each
plug-in called it. It is written by `python -m scripts.kernels record`; a test says when it is out
of date. `ship` compiles for a wheel, into the copy of the sources that it runs in.

Numba keeps what it compiled beside each module until that file changes, whatever the functions of
other modules that it calls, and the constants, have become. Here those count too.
"""

from __future__ import annotations

import contextlib
import fcntl
import hashlib
import importlib
import json
import multiprocessing
import os
import re
import subprocess
import sys
import time
from collections.abc import Iterator
from itertools import groupby
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parent.parent
LIST = Path(__file__).with_suffix(".json")
STATE = ROOT / ".setup"
PACKAGES = ("arjuna_core", "arjuna_sim", "arjuna_slam", "arjuna_nav")
_IMPORT = re.compile(r"^\s*from (arjuna_[\w.]+) import ([\w, ]+|\([^)]*\))", re.MULTILINE)
_NAME = re.compile(r"\w+")


def main(arguments: list[str]) -> int:
    """Write the list, or compile what is in it, for this CPU or a wheel; return the exit code."""
    if arguments == ["record"]:
        from scripts.kernels_in_use import in_use, use_all

        # Once before: what is compiled then calls further ones, which a later run does not load.
        once = "from scripts.kernels_in_use import use_all; use_all()"
        subprocess.run([sys.executable, "-c", once], cwd=ROOT, check=True)  # noqa: S603
        use_all()
        rows = ",\n".join(f" {json.dumps(list(row))}" for row in in_use())
        LIST.write_text(f"[\n{rows}\n]\n")
    elif arguments in (["compile"], ["ship"]):
        if arguments == ["ship"]:
            from arjuna_core.shipped_kernels import MARK, TARGET

            os.environ.update(TARGET)
            MARK.touch()
        forget_stale(ROOT, STATE / "kernels.json")
        compile_all(read_list())
    else:
        sys.stderr.write("error: python -m scripts.kernels record|compile|ship\n")
        return 2
    return 0


def read_list() -> list[tuple[str, str, Any]]:
    """Return module, function and encoded argument types of each entry."""
    return [(module, name, types) for module, name, types in json.loads(LIST.read_text())]


def digests(root: Path) -> dict[str, str]:
    """Return for each module that uses Numba a hash of all that its compiled code depends on.

    That is its source, the modules that it imports, and so on through those that use Numba.
    """
    texts = dict(_sources(root))
    imports = {name: _imported(text, texts) for name, text in texts.items() if "numba" in text}
    return {name: _digest(_reached(name, imports), texts) for name in sorted(imports)}


def forget_stale(root: Path, state: Path) -> None:
    """Delete what Numba compiled of modules of which something else has changed."""
    now = digests(root)
    before = json.loads(state.read_text()) if state.exists() else {}
    for module, value in now.items():
        if before.get(module, value) != value:
            path = root.joinpath(*module.split("."))
            for compiled in (path.parent / "__pycache__").glob(f"{path.name}.*.nb[ic]"):
                compiled.unlink(missing_ok=True)
    state.parent.mkdir(exist_ok=True)
    state.write_text(json.dumps(now, indent=1))


def compile_all(entries: list[tuple[str, str, Any]]) -> None:
    """Compile the entries on all cores, each wing's in one process, the largest first."""
    os.environ["OPENBLAS_NUM_THREADS"] = "1"
    modules = {module for module, _, _ in entries}
    for module in sorted(modules):
        with contextlib.suppress(ImportError):  # its compilation says what is missing
            importlib.import_module(module)
    wings = [list(group) for _, group in groupby(sorted(entries, key=_wing), key=_wing)]
    tasks = sorted(wings, key=_size, reverse=True)
    context = multiprocessing.get_context("fork")  # the imports are shared
    with context.Pool(min(os.cpu_count() or 1, len(tasks)), _take_turns) as pool:
        for _ in pool.imap_unordered(_compile_wing, tasks):
            pass


def _wing(entry: tuple[str, str, Any]) -> str:
    return ".".join(entry[0].split(".")[:2])


def _size(entries: list[tuple[str, str, Any]]) -> int:
    """Return the length of a wing's modules [bytes], which says how long they take to compile."""
    paths = {ROOT.joinpath(*module.split(".")).with_suffix(".py") for module, _, _ in entries}
    return sum(path.stat().st_size for path in paths if path.exists())


def _compile_wing(entries: list[tuple[str, str, Any]]) -> None:
    from numba.core.errors import NumbaError

    from scripts.kernels_in_use import decode

    start = time.monotonic()
    for module, name, types in entries:
        try:
            function = getattr(importlib.import_module(module), name)
            function.compile(tuple(decode(each) for each in types))
        except (ImportError, AttributeError, TypeError, NumbaError) as error:
            # The list is older than the code: this one is compiled when it is called.
            print(f"{module}:{name} is not compiled: {error}")  # noqa: T201 - the step's log
    print(f"{_wing(entries[0])}: {time.monotonic() - start:.1f} s", flush=True)  # noqa: T201


def _take_turns() -> None:
    """Let one process at a time write: Numba reads an index, adds to it and writes it back."""
    cache_file: Any = importlib.import_module("numba.core.caching").IndexDataCacheFile
    save = cache_file.save

    def save_alone(file: Any, key: Any, data: Any) -> None:
        with (STATE / "kernels.lock").open("w") as lock:
            fcntl.flock(lock, fcntl.LOCK_EX)
            save(file, key, data)

    cache_file.save = save_alone


def _sources(root: Path) -> Iterator[tuple[str, str]]:
    for package in PACKAGES:
        for path in sorted(root.glob(f"{package}/**/*.py")):
            name = ".".join(path.relative_to(root).with_suffix("").parts)
            yield name.removesuffix(".__init__"), path.read_text(encoding="utf-8")


def _imported(text: str, modules: dict[str, str]) -> set[str]:
    found = set()
    for module, names in _IMPORT.findall(text):
        found |= {module, *(f"{module}.{name}" for name in _NAME.findall(names))}
    return found & modules.keys()


def _reached(module: str, imports: dict[str, set[str]]) -> set[str]:
    reached, waiting = {module}, [module]
    while waiting:
        new = imports.get(waiting.pop(), set()) - reached
        reached |= new
        waiting += new
    return reached


def _digest(names: set[str], texts: dict[str, str]) -> str:
    parts = "\0".join(f"{name}\0{texts[name]}" for name in sorted(names))
    return hashlib.sha256(parts.encode()).hexdigest()[:16]


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
