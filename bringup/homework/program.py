"""A submission's process, as the grader holds it: a pipe, and deadlines that load does not move."""

from __future__ import annotations

import json
import os
import select
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from arjuna_core.errors import ArjunaError
from arjuna_core.files.whole_file import own_folder
from bringup.homework.bridge import Message, Topic, line_of
from bringup.processes.child import describe_exit

PROGRAM = (sys.executable, "-s", "-m", "bringup.homework.student")
"""What is started for a submission, with the pipe's ends and its folder."""
_SHOWN = 20_000  # of what a program prints [bytes]


class ProgramError(Exception):
    """A submission's program ended, or was ended; the message says why, to its author."""


class LostError(ProgramError):
    """It says no more: it has ended, or has to be ended."""


class ProtectionError(ArjunaError):
    """This machine cannot confine a submission."""


class Program:
    """A submission that runs in its sandbox; close it.

    Args:
        files: Its files by name.
        main: The one that is run.
        listen: The topics that it hears.
        publish: Those that it may publish.
        function: Whether it is no node, but functions to call.
        program: What is started.
        patience: How long it may wait in all for what is not the grader [s].
    """

    def __init__(
        self,
        files: Mapping[str, bytes],
        main: str,
        listen: Iterable[Topic] = (),
        publish: Iterable[Topic] = (),
        function: bool = False,
        program: Sequence[str] = PROGRAM,
        patience: float = 10.0,
    ) -> None:
        self._work = own_folder("homework")
        self._printed = tempfile.TemporaryFile()  # noqa: SIM115 - as long as the program
        (its_reader, self._writer), (self._reader, its_writer) = os.pipe(), os.pipe()
        os.set_blocking(self._writer, False)
        self._buffer, self._asleep, self._patience = b"", 0.0, patience
        self._process = subprocess.Popen(  # noqa: S603 - our own module, no shell
            [*program, f"{its_reader}", f"{its_writer}", self._work.name],
            cwd=self._work.name, env=_environment(self._work.name), stdin=subprocess.DEVNULL,
            stdout=self._printed, stderr=self._printed, pass_fds=(its_reader, its_writer),
        )  # fmt: skip
        os.close(its_reader)
        os.close(its_writer)
        hello = {
            "files": {name: data.hex() for name, data in files.items()},
            "main": main, "listen": list(listen), "publish": list(publish), "function": function,
        }  # fmt: skip
        self.send(hello)
        answer, self._asleep = self.receive(60.0), 0.0
        if "refused" in answer:
            self.close()
            raise ProtectionError(f"a submission cannot be confined here: {answer['refused']}")

    def send(self, message: Message) -> None:
        """Send a message; a program that has ended misses it.

        Raises:
            LostError: It does not read what was sent before.
        """
        data = line_of(message)
        while data:
            self._wait([], [self._writer], 2.0)
            try:
                data = data[os.write(self._writer, data) :]
            except BrokenPipeError:
                return

    def receive(self, cpu: float = 2.0) -> Message:
        """Return the program's next message, for which it may take some CPU time [s].

        Raises:
            LostError: None comes, or it is none.
        """
        while b"\n" not in self._buffer:
            if len(self._buffer) > 1 << 24:
                raise LostError("it sent more at once than a robot could take")
            self._wait([self._reader], [], cpu)
            data = os.read(self._reader, 1 << 16)
            if not data:
                raise LostError(self._end())
            self._buffer += data
        line, _, self._buffer = self._buffer.partition(b"\n")
        try:
            return dict(json.loads(line))
        except (ValueError, TypeError, RecursionError) as error:
            raise LostError("it wrote into the grader's pipe") from error

    def _wait(self, read: list[int], write: list[int], cpu: float, look: float = 0.05) -> None:
        """Wait for the pipe while the program works, up to a CPU time [s]; then look at it [s]."""
        start = self._cpu()
        while not any(select.select(read, write, [], look)):
            self._asleep += look if self._sleeps() else 0.0
            if self._cpu() - start > cpu:
                raise LostError(
                    f"it computed for {cpu:g} s without letting time pass: an endless loop, or one"
                    " without rclpy.spin_once or time.sleep in it"
                )
            if self._asleep > self._patience:
                raise LostError("it waits for something that never comes")

    def call(self, name: str, *arguments: Any) -> Any:
        """Return what one of its functions returns, as JSON has it.

        Raises:
            ProgramError: It raises.
            LostError: It takes too long, or has ended.
        """
        self.send({"name": name, "arguments": arguments})
        answer = self.receive()
        if "result" not in answer:
            raise ProgramError(f"{name}: {answer.get('error') or answer.get('ended')}")
        return answer["result"]

    @property
    def printed(self) -> str:
        """The last of what it printed."""
        size = os.fstat(self._printed.fileno()).st_size
        data = os.pread(self._printed.fileno(), _SHOWN, max(size - _SHOWN, 0))
        text = data.decode("utf-8", "replace").replace("\x00", "")
        return text.replace(f"{self._work.name}/", "")

    def close(self) -> None:
        """End it, whatever it does, and remove its folder."""
        self._process.kill()
        self._process.wait()
        os.close(self._reader)
        os.close(self._writer)
        self._printed.close()
        self._work.cleanup()

    def _cpu(self) -> float:
        """Return the CPU time of all its threads [s]; of one that has ended 0."""
        try:
            return time.clock_gettime((~self._process.pid << 3) | 2)  # CLOCK_PROCESS_CPUTIME_ID
        except OSError:
            return 0.0

    def _sleeps(self) -> bool:
        stat = Path(f"/proc/{self._process.pid}/stat").read_text(encoding="utf-8")
        return stat.rpartition(")")[2].split()[0] == "S"

    def _end(self) -> str:
        code = self._process.wait()
        if code in (-signal.SIGXCPU, -signal.SIGKILL):  # of the soft and the hard limit
            return "it took more CPU time in all than it may"
        last = self.printed.strip().splitlines()[-1:]
        return f"it ended with {describe_exit(code)}{f': {last[0][:200]}' if last else ''}"


def _environment(work: str) -> dict[str, str]:
    """Return what a program sees of this machine's settings: next to nothing."""
    return {
        "PATH": "/usr/bin:/bin", "LANG": "C.UTF-8", "HOME": work, "ROS_LOG_DIR": f"{work}/log",
        "MPLCONFIGDIR": work, "PYTHONHASHSEED": "0", "PYTHONUNBUFFERED": "1",
        "NUMBA_DISABLE_JIT": "1",
        "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1", "PYTHONDONTWRITEBYTECODE": "1",
        "RCUTILS_CONSOLE_OUTPUT_FORMAT": "[{severity}] [{name}]: {message}",
    }  # fmt: skip
