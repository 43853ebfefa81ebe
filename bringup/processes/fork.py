"""A process that is a fork of this one: what is imported and compiled here is there at once."""

from __future__ import annotations

import contextlib
import ctypes
import gc
import importlib
import inspect
import json
import os
import signal
import sys
from collections.abc import Callable, Iterable, Sequence
from io import TextIOWrapper
from pathlib import Path
from typing import IO, Any, NoReturn

from arjuna_core.errors import ArjunaError
from bringup.stack import MESSAGES, Group

_LIBC = ctypes.CDLL(None, use_errno=True)
_PR_SET_PDEATHSIG, _PR_SET_MM, _PR_SET_MM_MAP = 1, 35, 14  # linux/prctl.h
_STOP_SIGNALS = (signal.SIGINT, signal.SIGTERM)
_STANDARD = (0, 1, 2)
_SHOWN: list[Any] = []
"""Keeps buffers alive that the kernel reads in this process."""


def can_fork() -> bool:
    """Return whether a fork of this process is whole: it has no threads but the one that forks."""
    return sum(1 for _ in Path("/proc/self/task").iterdir()) == 1


def warm_up(groups: Iterable[Group], also: Iterable[str] = ()) -> None:
    """Import and compile what groups of nodes stand on, for processes that are forked then.

    It starts no thread, as rclpy's own modules would. A module that is missing is left to them.
    Ctrl-C waits for the end of an import: C extensions drop it, and print it.
    """
    before = signal.pthread_sigmask(signal.SIG_BLOCK, _STOP_SIGNALS)
    try:
        import numba

        for name in (*MESSAGES, *(core for group in groups for core in group.cores), *also):
            if not signal.sigpending().isdisjoint(_STOP_SIGNALS):
                return
            with contextlib.suppress(ImportError):
                importlib.import_module(name)
        compiled: Any = numba.njit(lambda: 0)
        compiled()  # the first compiled function takes ten times as long
        inspect.getmodule(warm_up.__code__)  # the first line that rclpy logs asks every module so
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
    gc.collect()
    gc.freeze()  # what is shared stays shared


def die_with(parent: int) -> None:
    """Let the kernel kill this process when its parent dies, however that happens."""
    _LIBC.prctl(_PR_SET_PDEATHSIG, signal.SIGKILL)
    if os.getppid() != parent:  # it died before prctl
        os._exit(1)


class Fork:
    """A running fork with pipes for its standard streams, as `subprocess.Popen` has them.

    It leads a process group of its own and holds nothing else that this process has open.

    Args:
        command: What it calls itself, to `ps` and in `sys.argv`: a Python program and arguments.
        run: What it does; its result is the exit code.
    """

    def __init__(self, command: Sequence[str], run: Callable[[], int]) -> None:
        (its_input, stdin), (stdout, its_output) = os.pipe(), os.pipe()
        parent = os.getpid()
        _flush()
        before = signal.pthread_sigmask(signal.SIG_BLOCK, _STOP_SIGNALS)
        self.pid = os.fork()
        if self.pid == 0:
            _live(parent, (its_input, its_output, its_output), command, run)
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
        os.close(its_input)
        os.close(its_output)
        self.stdin: IO[bytes] = os.fdopen(stdin, "wb", buffering=0)
        self.stdout: IO[bytes] = os.fdopen(stdout, "rb", buffering=0)
        self._code: int | None = None

    def poll(self) -> int | None:
        """Return its exit code, negative for a signal, None while it runs."""
        if self._code is None:
            pid, status = os.waitpid(self.pid, os.WNOHANG)
            self._code = os.waitstatus_to_exitcode(status) if pid else None
        return self._code


def in_fork(work: Callable[[], Any]) -> Any:
    """Return what some work returns, as JSON carries it; what it imports stays in a fork.

    A process with threads does the work itself: a lock that one of them holds would never open in
    a fork.

    Raises:
        ArjunaError: The work raised one.
        SystemExit: It ended otherwise; it has said why.
    """
    if not can_fork():
        return work()
    reader, writer = os.pipe()
    parent = os.getpid()
    _flush()
    pid = os.fork()
    if pid == 0:
        signal.signal(signal.SIGINT, signal.SIG_DFL)
        die_with(parent)
        _end(lambda: _answer(work, writer))
    os.close(writer)
    with os.fdopen(reader, encoding="utf-8") as stream:
        text = stream.read()
    _, status = os.waitpid(pid, 0)
    if status or not text:
        raise SystemExit(1)
    answer = json.loads(text)
    if "refused" in answer:
        raise ArjunaError(answer["refused"])
    return answer["result"]


def _answer(work: Callable[[], Any], writer: int) -> int:
    try:
        answer = {"result": work()}
    except ArjunaError as error:
        answer = {"refused": str(error)}
    with os.fdopen(writer, "w", encoding="utf-8") as stream:
        json.dump(answer, stream)
    return 0


def _live(
    parent: int, streams: Sequence[int], command: Sequence[str], run: Callable[[], int]
) -> NoReturn:
    """Become a process of one's own and run until the end; the parent's frames lie below."""
    os.setsid()
    die_with(parent)
    for stream, standard in zip(streams, _STANDARD, strict=True):
        os.dup2(stream, standard)
    for name in os.listdir("/proc/self/fd"):  # noqa: PTH208 - names alone are wanted
        if int(name) not in _STANDARD:
            with contextlib.suppress(OSError):  # the one that listed them
                os.close(int(name))
    signal.set_wakeup_fd(-1)
    for each in _STOP_SIGNALS:
        signal.signal(each, signal.SIG_DFL)
    signal.pthread_sigmask(signal.SIG_UNBLOCK, _STOP_SIGNALS)
    if isinstance(sys.stdout, TextIOWrapper):
        sys.stdout.reconfigure(line_buffering=True)
    sys.argv = [*command[2:]]
    _show_as(command)
    _end(run)


def _end(run: Callable[[], int]) -> NoReturn:
    """Run, and leave without what this process planned for its own end."""
    code = 1
    try:
        code = run()
    finally:
        kind, error, trace = sys.exc_info()
        if kind is not None and error is not None:
            sys.excepthook(kind, error, trace)
        _flush()
        os._exit(code)


def _flush() -> None:
    sys.stdout.flush()
    sys.stderr.flush()
    _LIBC.fflush(None)


class _Map(ctypes.Structure):
    """Bounds of a process's memory segments: `struct prctl_mm_map` of Linux."""

    _fields_ = (
        *((name, ctypes.c_uint64) for name in ("start_code", "end_code", "start_data")),
        *((name, ctypes.c_uint64) for name in ("end_data", "start_brk", "brk", "start_stack")),
        *((name, ctypes.c_uint64) for name in ("arg_start", "arg_end", "env_start", "env_end")),
        *(("auxv", ctypes.c_uint64), ("auxv_size", ctypes.c_uint32), ("exe_fd", ctypes.c_uint32)),
    )


def _show_as(command: Sequence[str]) -> None:
    """Let `ps` show a command for this process.

    Source: prctl(2), PR_SET_MM_MAP, and proc_pid_stat(5), whose fields count from 1. A kernel
    that cannot leaves the parent's command line.
    """
    words = b"".join(word.encode() + b"\0" for word in command)
    title = ctypes.create_string_buffer(words, len(words))
    stat = Path("/proc/self/stat").read_text(encoding="utf-8").rpartition(")")[2].split()
    field = {number: int(word) for number, word in enumerate(stat[1:], start=4)}
    begin = ctypes.addressof(title)
    _LIBC.sbrk.restype = ctypes.c_void_p
    layout = _Map(
        *(field[26], field[27], field[45], field[46], field[47], _LIBC.sbrk(0), field[28]),
        *(begin, begin + len(words), field[50], field[51], 0, 0, 2**32 - 1),
    )
    _SHOWN.append(title)
    _LIBC.prctl(_PR_SET_MM, _PR_SET_MM_MAP, ctypes.byref(layout), ctypes.sizeof(layout), 0)
