"""Robustness of the file readers: files changed at random, as many as there is time for."""

from __future__ import annotations

import argparse
import hashlib
import itertools
import resource
import tempfile
import time
from collections import Counter
from pathlib import Path
from typing import Any

from tests.fuzz.files import READERS, Finding, Fuzzer


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add this benchmark's options."""
    parser.add_argument("--seconds", type=float, default=60.0, metavar="S", help="(%(default)s)")
    parser.add_argument("--seed", type=int, default=0, help="of all changes")
    parser.add_argument("--count", type=int, metavar="N", help="files a reader, however long")
    names = ", ".join(reader.name for reader in READERS)
    parser.add_argument("--only", nargs="+", default=(), metavar="READER", help=f"of: {names}")
    parser.add_argument("--keep", type=Path, metavar="DIR", help="where inputs that fail are kept")


def run(arguments: argparse.Namespace) -> dict[str, Any]:
    """Have every reader read changed files in turn.

    Returns:
        `inputs` (read in all), `by_reader` (of each), `findings` by reader and
        problem with their counts, `grown_mb` (by how much the memory's peak rose).
    """
    before = _peak()
    found: dict[str, int] = {}
    with tempfile.TemporaryDirectory() as folder:
        fuzzers = []
        for reader in (r for r in READERS if not arguments.only or r.name in arguments.only):
            directory = Path(folder) / reader.name.replace(" ", "_")
            directory.mkdir()
            fuzzers.append(Fuzzer(reader, directory, arguments.seed))
        end, counts = time.monotonic() + arguments.seconds, Counter[str]()
        turns = itertools.count() if arguments.count is None else range(arguments.count)
        for fuzzer in (fuzzer for _ in turns for fuzzer in fuzzers):
            if arguments.count is None and time.monotonic() >= end:
                break
            counts[fuzzer.reader.name] += 1
            finding = fuzzer.once()
            if finding is not None:
                _note(found, finding, arguments.keep)
    grown, total = _peak() - before, counts.total()
    print(f"{total} inputs, {len(found)} findings, memory's peak rose by {grown:.0f} MB")
    return {"inputs": total, "by_reader": counts, "findings": found, "grown_mb": grown}


def _note(found: dict[str, int], finding: Finding, keep: Path | None) -> None:
    key = f"{finding.reader}: {finding.problem}"
    if key not in found:
        print(key)
        if keep is not None:
            keep.mkdir(parents=True, exist_ok=True)
            name = f"{finding.reader.replace(' ', '_')}-{hashlib.sha256(finding.data).hexdigest()}"
            (keep / name[:60]).write_bytes(finding.data)
    found[key] = found.get(key, 0) + 1


def _peak() -> float:
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0
