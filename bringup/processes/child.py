"""One supervised process: its own group, its output in lines, nothing left after its end."""

from __future__ import annotations

import os
import select
import signal
import subprocess
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from bringup.processes.fork import Fork, can_fork, die_with


@dataclass(frozen=True)
class ChildSpec:
    """A child process to run.

    Attributes:
        name: Marks the lines of its output.
        needed: Whether the others end if it cannot be kept running.
        run: Does the same in a fork of this process, which is there at once; None to start the
            program.
    """

    name: str
    command: Sequence[str]
    needed: bool = True
    run: Callable[[], int] | None = None


class Child:
    """A running process; `write` takes each line of its output, standard error joined.

    The kernel kills it when the parent dies, however that happens, and its standard input is a
    pipe that the parent never writes to: the end of that pipe means the same.
    """

    def __init__(self, spec: ChildSpec, write: Callable[[str], None]) -> None:
        self.spec = spec
        self._write = write
        self._rest = b""
        self._process = _started(spec)
        os.set_blocking(self.output, False)

    @property
    def output(self) -> int:
        """The file descriptor of its output."""
        assert self._process.stdout is not None
        return self._process.stdout.fileno()

    @property
    def pid(self) -> int:
        """Its process id, also that of its process group."""
        return self._process.pid

    def poll(self) -> int | None:
        """Return its exit code, negative for a signal, None while it runs.

        What it started and left behind is killed with it, before its id can be used again.
        """
        if os.waitid(os.P_PID, self.pid, os.WEXITED | os.WNOHANG | os.WNOWAIT) is not None:
            self.send(signal.SIGKILL)
        return self._process.poll()

    def send(self, number: signal.Signals) -> None:
        """Send a signal to the process and all it started."""
        try:
            os.killpg(self.pid, number)
        except ProcessLookupError:
            return  # it ended meanwhile

    def read(self, size: int = 65536) -> bool:
        """Hand on the lines that wait, at most a pipe's capacity (pipe(7)); False at the end."""
        try:
            data = os.read(self.output, size)
        except BlockingIOError:
            return True
        *lines, self._rest = (self._rest + data).split(b"\n")
        for line in lines:
            self._write(line.decode(errors="replace"))
        return bool(data)

    def close(self) -> None:
        """Hand on what is left of its output and free the pipes."""
        while self.read() and bool(select.select([self.output], [], [], 0)[0]):
            pass
        if self._rest:
            self._write(self._rest.decode(errors="replace"))
        for pipe in (self._process.stdin, self._process.stdout):
            if pipe is not None:
                pipe.close()


def describe_exit(code: int) -> str:
    """Phrase an exit code: a signal's name where it is negative."""
    if code >= 0:
        return f"exit code {code}"
    try:
        return signal.Signals(-code).name
    except ValueError:
        return f"signal {-code}"


def _started(spec: ChildSpec) -> subprocess.Popen[bytes] | Fork:
    if spec.run is not None and can_fork():
        return Fork(spec.command, spec.run)
    parent = os.getpid()
    return subprocess.Popen(  # noqa: S603 - our own modules, no shell
        list(spec.command),
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        env=dict(os.environ, PYTHONUNBUFFERED="1"),
        start_new_session=True,
        preexec_fn=lambda: die_with(parent),  # safe: the supervisor has no threads
    )
