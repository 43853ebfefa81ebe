"""Assertions on what processes of a launch have written, and how they ended."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from typing import Any

from launch.events.process import ProcessExited

from launch_testing.records import (
    NO_CMD_ARGS as NO_CMD_ARGS,
)
from launch_testing.records import (
    IoHandler,
    ProcInfoHandler,
    name_of,
    resolve,
    text_matcher,
)
from launch_testing.records import (
    NoMatchingProcessException as NoMatchingProcessException,
)

EXIT_OK, EXIT_FORCED = 0, 1
EXIT_SIGINT, EXIT_SIGQUIT, EXIT_SIGKILL, EXIT_SIGSEGV = 130, 131, 137, 139


def assertExitCodes(
    proc_info: ProcInfoHandler,
    allowable_exit_codes: Iterable[int] = (EXIT_OK,),
    process: Any = None,
    cmd_args: Any = None,
    *,
    strict_proc_matching: bool = True,
) -> None:
    """Assert how processes ended.

    Raises:
        AssertionError: One ended with another code, or runs.
    """
    allowed = list(allowable_exit_codes)
    for one in resolve(proc_info, process, cmd_args, strict_proc_matching):
        last = proc_info[one]
        ended = isinstance(last, ProcessExited)
        how = f"ended with exit code {last.returncode}" if ended else "runs"
        if not ended or last.returncode not in allowed:
            raise AssertionError(f"process {name_of(one)} {how}; allowed: {allowed}")


def assertInStdout(
    proc_output: IoHandler, expected_output: Any, process: Any = None, *args: Any, **how: Any
) -> None:
    """Assert that processes have written something to standard output."""
    _assert_in("stdout", proc_output, expected_output, process, *args, **how)


def assertInStderr(
    proc_output: IoHandler, expected_output: Any, process: Any = None, *args: Any, **how: Any
) -> None:
    """Assert that processes have written something to standard error."""
    _assert_in("stderr", proc_output, expected_output, process, *args, **how)


def _assert_in(
    stream: str,
    proc_output: IoHandler,
    expected_output: Any,
    process: Any = None,
    cmd_args: Any = None,
    *,
    output_filter: Callable[[str], str] | None = None,
    strict_proc_matching: bool = True,
) -> None:
    found = resolve(proc_output, process, cmd_args, strict_proc_matching)
    text = proc_output.text(found, stream)
    if not text_matcher(expected_output)(output_filter(text) if output_filter else text):
        names = [name_of(one) for one in found]
        raise AssertionError(f"{expected_output!r} is not in the {stream} of {names}: {text!r}")


@contextmanager
def assertSequentialStdout(
    proc_output: IoHandler, process: Any, cmd_args: Any = None
) -> Iterator[Any]:
    """Yield what asserts that lines of a process' standard output came in an order."""
    (one,) = resolve(proc_output, process, cmd_args)
    yield _Sequence(proc_output.text([one], "stdout"))


class _Sequence:
    """A text that is looked through from its beginning to its end."""

    def __init__(self, text: str) -> None:
        self._rest = text

    def assertInStdout(self, msg: str) -> None:
        """Assert that a line comes behind those of before."""
        before, found, self._rest = self._rest.partition(msg)
        if not found:
            raise AssertionError(f"{msg!r} does not come next: {before!r}")
