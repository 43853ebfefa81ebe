"""Commands with a log, a line of progress and a clear failure. Standard library only."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

QUIET_S = 2.0
"""A step shorter than this says nothing [s]."""
REPORT_S = 20.0
"""Period of the notes that a long step is still running [s]."""
TAIL_LINES = 25


class StepError(Exception):
    """A command failed; its log's tail has been printed."""


def say(text: str) -> None:
    """Print one line of progress at once."""
    sys.stdout.write(f"setup: {text}\n")
    sys.stdout.flush()


class Step:
    """A titled command in the background, its log replaced; variables are set where none is yet."""

    def __init__(
        self, title: str, command: list[str], log: Path, variables: dict[str, str] | None = None
    ) -> None:
        self.title = title
        self._log = log
        self._start = time.monotonic()
        self._said = 0.0
        with log.open("wb") as stream:
            self._process = subprocess.Popen(  # noqa: S603 - fixed programs, no shell
                command,
                stdin=subprocess.DEVNULL,
                stdout=stream,
                stderr=subprocess.STDOUT,
                env={**(variables or {}), **clean_environment()},
                start_new_session=True,
            )

    def finish(self) -> None:
        """Wait for the end, saying now and then how far it is.

        Raises:
            StepError: The command failed.
        """
        while self._running():
            self._report()
        seconds = time.monotonic() - self._start
        if self._process.returncode != 0:
            say(f"{self.title}: failed after {seconds:.0f} s; the end of {self._log}:")
            sys.stdout.write("\n".join(self._tail(TAIL_LINES)) + "\n")
            raise StepError(f"{self.title} failed; the whole log is {self._log}")
        if seconds >= QUIET_S:
            say(f"{self.title}: done in {seconds:.0f} s")

    def stop(self) -> None:
        """End the command and what it started, if it still runs."""
        if self._process.poll() is None:
            os.killpg(self._process.pid, signal.SIGTERM)
            self._process.wait()

    def _running(self) -> bool:
        try:
            self._process.wait(timeout=QUIET_S)
        except subprocess.TimeoutExpired:
            return True
        return False

    def _report(self) -> None:
        seconds = time.monotonic() - self._start
        if self._said == 0.0:
            say(f"{self.title} ...")
        elif seconds - self._said < REPORT_S:
            return
        else:
            last = (self._tail(1) or [""])[0].strip()
            say(f"{self.title}: {seconds:.0f} s so far; {last[:80]}")
        self._said = seconds

    def _tail(self, lines: int) -> list[str]:
        return self._log.read_text(errors="replace").splitlines()[-lines:]


@contextmanager
def stopped_at_the_end(step: Step) -> Iterator[None]:
    """Leave no command behind, not even after a failure or Ctrl-C."""
    try:
        yield
    finally:
        step.stop()


def run(step: Step) -> None:
    """Wait for a step's end.

    Raises:
        StepError: The command failed.
    """
    with stopped_at_the_end(step):
        step.finish()


def clean_environment() -> dict[str, str]:
    """Return the environment less what would let another Python's packages leak in."""
    environment = dict(os.environ, PIP_DISABLE_PIP_VERSION_CHECK="1", PIP_NO_INPUT="1")
    for name in ("PYTHONPATH", "PYTHONHOME", "PIP_USER", "PIP_TARGET", "PIP_PREFIX"):
        environment.pop(name, None)
    # The ROS wheels re-execute Python once to set the library path; a guard inherited from
    # another environment would keep that environment's libraries.
    if environment.pop("_ROS_WHEELS_BOOTSTRAP_COMPLETE", None):
        environment.pop("LD_LIBRARY_PATH", None)
    return environment
