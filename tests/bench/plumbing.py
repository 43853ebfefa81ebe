"""Message plumbing's share of a lock-step run: CPU time by what it is spent on."""

from __future__ import annotations

import argparse
import contextlib
import functools
import signal
import sys
import tempfile
import time
from collections import defaultdict
from collections.abc import Callable, Iterator
from pathlib import Path
from types import FrameType
from typing import Any

ROOT = str(Path(__file__).resolve().parents[2]) + "/"
KINDS = (
    ("executor", ("/rclpy/executors.py", "/rclpy/task.py")),
    ("copies and new messages", ("arjuna_core/ros/messages.py", "<message>")),
    ("conversion", ("arjuna_core/ros/convert.py", "arjuna_core/ros/scan_queue.py")),
    ("checks and guard", ("arjuna_core/checks/", "arjuna_core/ros/health/")),
    ("serialisation for the recorder", ("arjuna_core/ros/local/cdr.py",)),
    ("transport", ("arjuna_core/ros/local/",)),
    ("node and process", ("arjuna_core/ros/",)),
    ("message constructors and fields", ("/msg/_", "/srv/_", "/action/_")),
    ("logging", ("/rclpy/impl/rcutils_logger.py",)),
    ("rclpy", ("/rclpy/",)),
    ("recorder", ("bringup/recording/", "arjuna_core/bags/")),
    ("nodes", ("/nodes/",)),
    ("transforms", ("arjuna_core/transforms.py", "arjuna_core/pose3.py", "arjuna_core/se2.py")),
)
"""What a file's CPU time is spent on: the first whose part its path contains."""
NOT_PLUMBING = ("logging", "serialisation for the recorder", "recorder", "nodes", "transforms")
"""Of those, what is no message plumbing."""
_FOREIGN = "/site-packages/"
_PACKAGES = ("arjuna_", "bringup/")
_INTERVAL = 0.002  # [s] of CPU time between samples


def kind_of(path: str) -> str | None:
    """Return what a file's time is spent on; None where that of its caller counts.

    Args:
        path: The file of a frame.
    """
    short = path.removeprefix(ROOT)
    for kind, parts in KINDS:
        if any(part in short for part in parts):
            return kind
    if short.startswith(_PACKAGES) and _FOREIGN not in path:
        return "/".join(short.split("/")[:2])
    return None


class CpuShares:
    """Samples of the running thread, each weighted by the CPU time since the one before.

    Time in C, also that of NumPy and of rclpy's own, is that of the Python function that called it;
    a file of neither the project nor the plumbing counts as its caller.

    Attributes:
        by_kind: CPU time by kind [s].
        by_function: CPU time by function [s].
    """

    def __init__(self) -> None:
        self.by_kind: dict[str, float] = defaultdict(float)
        self.by_function: dict[str, float] = defaultdict(float)
        self._last, self._within = 0.0, 0

    def within(self, step: Callable[..., Any]) -> Callable[..., Any]:
        """Return a function of whose run alone samples are counted."""

        @functools.wraps(step)
        def counted(*arguments: Any, **named: Any) -> Any:
            self._within += 1
            try:
                return step(*arguments, **named)
            finally:
                self._within -= 1

        return counted

    @contextlib.contextmanager
    def sampling(self) -> Iterator[None]:
        """Sample while the block runs."""
        before = signal.signal(signal.SIGPROF, self._sample)
        self._last = time.process_time()
        signal.setitimer(signal.ITIMER_PROF, _INTERVAL, _INTERVAL)
        try:
            yield
        finally:
            signal.setitimer(signal.ITIMER_PROF, 0.0)
            signal.signal(signal.SIGPROF, before)

    def _sample(self, number: int, frame: FrameType | None) -> None:
        now = time.process_time()
        spent, self._last = now - self._last, now
        if not self._within:
            return
        kind = None
        while frame is not None and kind is None:
            code = frame.f_code
            kind, frame = kind_of(code.co_filename), frame.f_back
        self.by_kind[kind or "other"] += spent
        self.by_function[f"{code.co_filename.removeprefix(ROOT)}:{code.co_name}"] += spent

    @property
    def plumbing(self) -> float:
        """The share of message plumbing (0..1)."""
        kinds = {kind for kind, _ in KINDS if kind not in NOT_PLUMBING}
        return sum(self.by_kind[kind] for kind in kinds) / sum(self.by_kind.values())


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add this benchmark's options."""
    parser.add_argument("--seed", type=int, default=0, help="of the demo")
    parser.add_argument("--functions", type=int, default=25, help="rows of the table of functions")


def run(arguments: argparse.Namespace) -> dict[str, Any]:
    """Run the demo and return the shares of its steps' CPU time.

    Returns:
        `plumbing` (0..1), `shares` by kind, `step_s` (CPU time of all steps) and `functions` [s].
    """
    from bringup import __main__ as command
    from bringup.lockstep import LockStep

    shares, step = CpuShares(), LockStep.step
    LockStep.step = shares.within(step)  # type: ignore[method-assign]
    with tempfile.TemporaryDirectory() as folder, shares.sampling():
        sys.argv = ["bringup", "demo", "--seed", str(arguments.seed), "--out", folder]
        command.main()
    LockStep.step = step  # type: ignore[method-assign]
    total = sum(shares.by_kind.values())
    by_kind = {kind: spent / total for kind, spent in _greatest(shares.by_kind)}
    functions = dict(_greatest(shares.by_function)[: arguments.functions])
    for kind, share in by_kind.items():
        print(f"{100.0 * share:6.1f} %  {kind}")
    for name, spent in functions.items():
        print(f"{100.0 * spent / total:6.2f} %  {name}")
    print(f"plumbing {100.0 * shares.plumbing:.1f} % of {total:.2f} s")
    return {
        "plumbing": shares.plumbing,
        "shares": by_kind,
        "step_s": total,
        "functions": functions,
    }


def _greatest(spent: dict[str, float]) -> list[tuple[str, float]]:
    return sorted(spent.items(), key=lambda item: -item[1])
