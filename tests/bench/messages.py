"""Robustness to messages: random ones on every topic, service and action of every node."""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[2]
STACKS = ("nav", "slam")
_SESSION = 1000  # messages one robot is sent before it is made whole and sent to a goal
_DEADLINE = 600.0  # [s, wall] of a session


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add this benchmark's options."""
    parser.add_argument("--count", type=int, default=20_000, metavar="N", help="messages in all")
    parser.add_argument("--seed", type=int, default=0, help="of the first session")


def run(arguments: argparse.Namespace) -> dict[str, Any]:
    """Send random messages to robots in lock-step, a process and a seed for each session.

    Returns:
        `sent`, `died` (sessions whose process ended), `timed_out` (messages over a second of a
        core's time, or sessions that did not end), `goals_missed` (of those that followed),
        `failed` (exceptions that callbacks raised, by node and source), `refused` and `peak_mb`.
    """
    total: dict[str, Any] = {"sent": 0, "sessions": 0, "died": [], "timed_out": []}
    total |= {"goals_missed": [], "failed": {}, "refused": 0, "peak_mb": 0.0}
    while total["sent"] < arguments.count:
        number = total["sessions"]
        stack, seed = STACKS[number % len(STACKS)], arguments.seed + number
        count = min(_SESSION, arguments.count - total["sent"])
        with tempfile.TemporaryDirectory() as folder:
            _session(total, stack, seed, count, Path(folder))
        total["sessions"] += 1
        total["sent"] += count
        print(
            f"{total['sent']:6d} sent, {len(total['died'])} died, {len(total['timed_out'])} "
            f"timed out, {len(total['goals_missed'])} goals missed, "
            f"{len(total['failed'])} sources failed"
        )
    print(json.dumps({key: total[key] for key in ("died", "timed_out", "failed")}, indent=2))
    return total


def _session(total: dict[str, Any], stack: str, seed: int, count: int, folder: Path) -> None:
    """Run one session in a process of its own and add what came of it."""
    session = f"{stack}, seed {seed}"
    command = [sys.executable, "-m", "tests.fuzz.barrage"]
    command += [stack, str(seed), str(count), str(folder)]
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    try:
        done = subprocess.run(
            command,
            cwd=folder,  # what is saved by a request is saved there
            env=environment,
            timeout=_DEADLINE,
            capture_output=True,
            check=False,
        )
    except subprocess.TimeoutExpired:
        total["timed_out"].append(f"{session}: {_last(folder)}")
        return
    if done.returncode != 0:
        end = done.stderr.decode(errors="replace").strip().splitlines()[-1:]
        total["died"].append(f"{session}: {_last(folder)}: exit {done.returncode}: {end}")
        return
    outcome = json.loads((folder / "outcome.json").read_text(encoding="utf-8"))
    total["timed_out"] += [f"{session}: {what}" for what in outcome["timed_out"]]
    if not outcome["goal_after"]:
        total["goals_missed"].append(session)
    for where, tally in outcome["failed"].items():
        before = total["failed"].get(where, {"count": 0})
        total["failed"][where] = {**tally, "count": tally["count"] + before["count"]}
    total["refused"] += sum(tally["count"] for tally in outcome["refused"].values())
    total["peak_mb"] = max(total["peak_mb"], outcome["peak_mb"])


def _last(folder: Path) -> str:
    """Return the message that a session was at when it ended."""
    lines = (folder / "log.jsonl").read_text(encoding="utf-8").splitlines()
    return lines[-1] if lines else "before the first message"
