"""Actions that run a process: its output in lines, nothing left of it after the end."""

from __future__ import annotations

import asyncio
import itertools
import os
import re
import shlex
import signal
import sys
from collections.abc import Iterable, Mapping
from contextlib import suppress
from functools import partial
from pathlib import Path
from typing import Any

from launch.action import Action, Entities
from launch.descriptions import Executable
from launch.event_handler import EventHandler
from launch.event_handlers import OnProcessExit
from launch.events.process import (
    ProcessExited,
    ProcessStarted,
    ProcessStderr,
    ProcessStdout,
    ShutdownProcess,
    SignalProcess,
)
from launch.launch_context import LaunchContext
from launch.logging import get_logger, write_to_file
from launch.substitution import (
    SomeSubstitutionsType,
    Substitution,
    normalize_to_list_of_substitutions,
    perform_substitutions,
    performed,
)

_NUMBERS = itertools.count(1)
_LONGEST = 2**20  # [bytes] of a line of output
_SHOWN = {  # what reaches the screen, by `output`: standard output, standard error
    "screen": (True, True),
    "both": (True, True),
    "tty": (True, True),
    "log": (False, True),
    "own_log": (False, False),
    "full": (True, True),
}
_END = signal.SIGINT, signal.SIGTERM, signal.SIGKILL


def _as_substitutions(value: float | SomeSubstitutionsType) -> list[Substitution]:
    """Return a number, or what makes one, as substitutions."""
    return normalize_to_list_of_substitutions(
        str(value) if isinstance(value, int | float) else value
    )


class ExecuteLocal(Action):
    """Runs a process that an `Executable` describes.

    Attributes:
        process_details: Its name, command and, once it runs, its `pid`.
    """

    says_when_done = True

    def __init__(
        self,
        *,
        process_description: Executable,
        shell: bool = False,
        sigterm_timeout: float | SomeSubstitutionsType = 5.0,
        sigkill_timeout: float | SomeSubstitutionsType = 5.0,
        output: SomeSubstitutionsType | Mapping[str, str] = "log",
        respawn: bool | SomeSubstitutionsType = False,
        respawn_delay: float | None = None,
        respawn_max_retries: int = -1,
        on_exit: Any = None,
        condition: Any = None,
        cached_output: bool = False,
        emulate_tty: bool | SomeSubstitutionsType = False,
        **unused: Any,
    ) -> None:
        known = {"log_cmd", "output_format"}
        if unused.keys() - known:
            raise TypeError(f"{type(self).__name__}: no {', '.join(sorted(unused.keys() - known))}")
        super().__init__(condition=condition)
        self.process_description = self.__process_description = given = process_description
        self.cmd = [
            normalize_to_list_of_substitutions(one)
            for one in (*given.cmd, *(given.arguments or ()))
        ]
        self.__shell, self.__emulate_tty, self._cached = shell, emulate_tty, cached_output
        is_text = not isinstance(output, Mapping)
        self.__output = normalize_to_list_of_substitutions(output) if is_text else output
        self.__respawn, self.__respawn_delay = respawn, respawn_delay
        self.__respawn_max_retries, self.__on_exit = respawn_max_retries, on_exit
        self.__sigterm_timeout = _as_substitutions(sigterm_timeout)
        self.__sigkill_timeout = _as_substitutions(sigkill_timeout)
        self.process_details: dict[str, Any] = {}
        self._written = {1: bytearray(), 2: bytearray()}
        self._process: asyncio.subprocess.Process | None = None
        self._ending, self._over = False, asyncio.Event()

    @property
    def name(self) -> str:
        return str(self.process_details.get("name", ""))

    @property
    def return_code(self) -> int | None:
        """Its exit code, once it has ended."""
        return None if self._process is None else self._process.returncode

    def get_stdout(self) -> str:
        """Return what it has written to standard output; with `cached_output` alone."""
        return self._written[1].decode("utf-8", "replace")

    def get_stderr(self) -> str:
        """Return what it has written to standard error; with `cached_output` alone."""
        return self._written[2].decode("utf-8", "replace")

    def words(self, context: LaunchContext) -> list[str]:
        found = [perform_substitutions(context, one) for one in self.cmd]
        known = context.launch_configurations
        chosen = re.match(known.get("launch-prefix-filter", ""), Path(found[0]).name)
        prefix = self.process_description.prefix or (
            known.get("launch-prefix", "") if chosen else ""
        )
        return [*shlex.split(perform_substitutions(context, prefix)), *found]

    def execute(self, context: LaunchContext) -> Entities | None:
        if context.is_shutdown:
            return None
        words = self.words(context)
        given = self.process_description
        wanted = perform_substitutions(context, given.name or words[0])
        env = dict(context.environment) if given.env is None else performed(context, given.env)
        env |= performed(context, given.additional_env or {})
        cwd = None if given.cwd is None else perform_substitutions(context, given.cwd)
        name = f"{Path(wanted.split(' ')[0]).name}-{next(_NUMBERS)}"
        self.process_details = {"name": name, "cmd": words, "cwd": cwd, "env": env}
        respawn = self.__respawn
        if not isinstance(respawn, bool):
            respawn = perform_substitutions(context, respawn).lower() in ("true", "1")
        handlers = [
            self._on(SignalProcess, lambda event, context: self.signal(event.signal)),
            self._on(ShutdownProcess, lambda event, context: self.end(context)),
        ]
        if self.__on_exit is not None:
            after = OnProcessExit(target_action=self, on_exit=self.__on_exit)
            after.configurations = dict(context.launch_configurations)
            handlers.append(after)
        for handler in handlers:
            context.register_event_handler(handler)
        context.on_end.append(partial(self.end, context))
        context.on_kill.append(partial(self.signal, signal.SIGKILL))
        context.start(self._live(context, bool(respawn), self._shown(context)))
        return None

    def _on(self, kind: type[Any], do: Any) -> EventHandler:
        def matches(event: Any) -> bool:
            return isinstance(event, kind) and bool(event.process_matcher(self))

        return EventHandler(matcher=matches, entities=do)

    def _shown(self, context: LaunchContext) -> tuple[bool, bool]:
        given = self.__output
        if isinstance(given, Mapping):
            pair = (given.get("stdout", given.get("both")), given.get("stderr", given.get("both")))
            return tuple(str(one) in ("screen", "both", "tty") for one in pair)  # type: ignore[return-value]
        override = context.environment.get("OVERRIDE_LAUNCH_PROCESS_OUTPUT")
        text = override or perform_substitutions(context, given)
        if text not in _SHOWN:
            raise RuntimeError(f"output '{text}' of {self.name}; valid: {', '.join(_SHOWN)}")
        return _SHOWN[text]

    async def _live(self, context: LaunchContext, respawn: bool, shown: tuple[bool, bool]) -> None:
        log, runs = get_logger(self.name), 0
        while True:
            runs += 1
            try:
                self._over.clear()
                self._process = process = await self._started()
            except OSError as error:
                context.problems.append(f"{self.name}: {error}")
                log.error(f"cannot be started: {error}")
                return
            details = {"action": self, **self.process_details, "pid": process.pid}
            self.process_details["pid"] = process.pid
            log.info(f"process started with pid [{process.pid}]")
            context.emit_event_sync(ProcessStarted(**details))
            if context.is_shutdown:  # asked for while it was started
                self.end(context)
            pipes = (process.stdout, process.stderr)
            await asyncio.gather(
                *(
                    self._follow(context, details, *pair)
                    for pair in zip(pipes, shown, (1, 2), strict=True)
                )
            )
            code = await process.wait()
            self._over.set()  # what it has started has let go of its output too
            self._say_end(process.pid, code)
            context.emit_event_sync(ProcessExited(returncode=code, **details))
            again = self.__respawn_max_retries < 0 or runs <= self.__respawn_max_retries
            if not respawn or not again or self._ending or context.is_shutdown:
                break
            await asyncio.sleep(self.__respawn_delay or 0.0)
            if context.is_shutdown:
                break
        self.say_done(context)

    async def _started(self) -> asyncio.subprocess.Process:
        from bringup.processes.fork import die_with

        details = self.process_details
        words = ["/bin/sh", "-c", " ".join(details["cmd"])] if self.__shell else details["cmd"]
        return await asyncio.create_subprocess_exec(
            *words,
            cwd=details["cwd"],
            env={"PYTHONUNBUFFERED": "1", **details["env"]},
            stdin=asyncio.subprocess.DEVNULL,
            stdout=asyncio.subprocess.PIPE,
            stderr=asyncio.subprocess.PIPE,
            start_new_session=True,
            preexec_fn=partial(die_with, os.getpid()),
            limit=_LONGEST,
        )

    async def _follow(
        self,
        context: LaunchContext,
        details: dict[str, Any],
        pipe: asyncio.StreamReader | None,
        shown: bool,
        number: int,
    ) -> None:
        kind = (ProcessStdout, ProcessStderr)[number - 1]
        out = (sys.stdout, sys.stderr)[number - 1]
        while pipe is not None:
            try:
                line = await pipe.readline()
            except ValueError:  # longer than any line
                continue
            if not line:
                return
            text = f"[{self.name}] {line.decode('utf-8', 'replace').rstrip()}"
            if shown:
                print(text, file=out, flush=True)
            write_to_file(text)
            if self._cached:
                self._written[number] += line
            context.emit_event_sync(kind(text=line, fd=number, **details))

    def _say_end(self, pid: int, code: int) -> None:
        log = get_logger(self.name)
        if code == 0:
            log.info(f"process has finished cleanly [pid {pid}]")
        elif self._ending and -code in (signal.SIGINT, signal.SIGTERM):
            log.info(f"process has ended by {signal.Signals(-code).name} [pid {pid}]")
        else:
            command = " ".join(self.process_details["cmd"])
            log.error(f"process has died [pid {pid}, exit code {code}, cmd '{command}'].")

    def signal(self, number: signal.Signals) -> None:
        """Send a signal to the process and what it has started."""
        if self._process is not None and not self._over.is_set():
            with suppress(ProcessLookupError):
                os.killpg(self._process.pid, number)

    def end(self, context: LaunchContext) -> None:
        """Have it end: by SIGINT, else by SIGTERM, else by force."""
        if self._process is None or self._over.is_set() or self._ending:
            return
        self._ending = True
        waits = [
            float(perform_substitutions(context, one))
            for one in (self.__sigterm_timeout, self.__sigkill_timeout)
        ]

        async def ending() -> None:
            for number, wait in zip(_END, (*waits, 1.0), strict=True):
                if number != signal.SIGINT:
                    get_logger(self.name).error(
                        f"process[{self.name}] failed to terminate: '{number.name}' follows"
                    )
                self.signal(number)
                with suppress(asyncio.TimeoutError):
                    await asyncio.wait_for(self._over.wait(), wait)
                    return

        context.start(ending())


class ExecuteProcess(ExecuteLocal):
    """Runs a process by its command."""

    def __init__(self, *, cmd: Iterable[SomeSubstitutionsType], **kwargs: Any) -> None:
        names = ("prefix", "name", "cwd", "env", "additional_env")
        about = {name: kwargs.pop(name, None) for name in names}
        super().__init__(process_description=Executable(cmd=cmd, **about), **kwargs)
