"""Runs a file of tests: launches what it describes, with tests beside it and behind its end."""

from __future__ import annotations

import functools
import importlib.util
import inspect
import itertools
import re
import sys
import threading
import time
import unittest
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from types import ModuleType
from typing import Any

from launch import LaunchDescription, LaunchService
from launch.actions import RegisterEventHandler
from launch.event_handlers import OnProcessExit, OnProcessIO, OnProcessStart

from launch_testing.records import IoHandler, ProcInfoHandler

READY = 60.0  # [s] in which a description has to come to its ReadyToTest
_PATIENCE = 2.0  # [s] for tests to notice that all processes have ended
_NUMBERS = itertools.count(1)
_MODULE = re.compile(r"\blaunch_test_\d+\.")


class LaunchTestError(Exception):
    """A file of tests that cannot be run; the message says why."""


@dataclass
class Case:
    """The result of one test.

    Attributes:
        problem: What went wrong, empty where nothing did.
        kind: `passed`, `failed`, `error` or `skipped`.
    """

    name: str
    kind: str
    problem: str = ""
    duration: float = 0.0


@dataclass
class LaunchResult:
    """The results of one launch's tests."""

    name: str
    cases: list[Case] = field(default_factory=list)

    @property
    def succeeded(self) -> bool:
        """True if all passed, and there was at least one."""
        return bool(self.cases) and all(one.kind in ("passed", "skipped") for one in self.cases)

    def summary(self) -> str:
        """Return what went wrong, a test each."""
        wrong = [one for one in self.cases if one.kind in ("failed", "error")]
        return "\n".join(f"{one.name}: {one.kind}\n{one.problem}" for one in wrong) or "no tests"


class _Result(unittest.TestResult):
    """Collects cases."""

    def __init__(self, outcome: LaunchResult, tell: Callable[[Case], None]) -> None:
        super().__init__()
        self._outcome, self._tell, self._begun = outcome, tell, 0.0

    def startTest(self, test: unittest.TestCase) -> None:
        self._begun = time.monotonic()
        super().startTest(test)

    def _add(self, test: Any, kind: str, problem: str = "") -> None:
        name = _MODULE.sub("", test.id())
        case = Case(name, kind, problem, time.monotonic() - self._begun)
        self._outcome.cases.append(case)
        self._tell(case)

    def addSuccess(self, test: Any) -> None:
        self._add(test, "passed")

    def addFailure(self, test: Any, err: Any) -> None:
        self._add(test, "failed", self._text(err, test))

    def addError(self, test: Any, err: Any) -> None:
        self._add(test, "error", self._text(err, test))

    def addSkip(self, test: Any, reason: str) -> None:
        self._add(test, "skipped", reason)

    def addExpectedFailure(self, test: Any, err: Any) -> None:
        self._add(test, "passed")

    def addUnexpectedSuccess(self, test: Any) -> None:
        self._add(test, "failed", "it passed, though it is marked as expected to fail")

    def addSubTest(self, test: Any, subtest: Any, err: Any) -> None:
        if err is not None:
            kind = "failed" if issubclass(err[0], test.failureException) else "error"
            self._add(subtest, kind, self._text(err, test))

    def _text(self, err: Any, test: Any) -> str:
        text: str = self._exc_info_to_string(err, test)  # type: ignore[attr-defined]
        return text


def load(path: Path) -> ModuleType:
    """Import a file of tests.

    Raises:
        LaunchTestError: It describes nothing.
    """
    spec = importlib.util.spec_from_file_location(f"launch_test_{next(_NUMBERS)}", path)
    if spec is None or spec.loader is None:
        raise LaunchTestError(f"{path} is no Python file")
    module = importlib.util.module_from_spec(spec)
    sys.modules[module.__name__] = module
    sys.path.insert(0, str(path.resolve().parent))
    try:
        spec.loader.exec_module(module)
    finally:
        sys.path.pop(0)
    if not hasattr(module, "generate_test_description"):
        raise LaunchTestError(f"{path} has no function generate_test_description")
    return module


def runs_of(module: ModuleType) -> list[dict[str, Any]]:
    """Return the arguments of each launch that a file asks for, by `parametrize`."""
    return list(getattr(module.generate_test_description, "__parametrized__", [{}]))


class LaunchTest:
    """One launch of a file's description, with its tests.

    Args:
        module: Of `load`.
        given: Arguments of `generate_test_description`, one of `runs_of`.
        arguments: Launch arguments.
        tell: Called with each result as it comes.
    """

    def __init__(
        self,
        module: ModuleType,
        given: Mapping[str, Any],
        arguments: Mapping[str, str] | None = None,
        tell: Callable[[Case], None] = lambda case: None,
    ) -> None:
        self._module, self._given, self._tell = module, dict(given), tell
        self._arguments = dict(arguments or {})
        self._ready = threading.Event()
        self.name = "[" + "-".join(map(str, given.values())) + "]" if given else ""

    def describe(self) -> tuple[LaunchDescription, dict[str, Any]]:
        """Return the description, and what the file names for its tests."""
        describe = self._module.generate_test_description
        given = dict(self._given)
        if "ready_fn" in inspect.signature(describe).parameters:
            given["ready_fn"] = self._ready.set
        found = describe(**given)
        return found if isinstance(found, tuple) else (found, {})

    def run(self) -> LaunchResult:
        """Launch, and run the tests; the main thread launches, so that Ctrl-C ends all."""
        outcome, info, output = LaunchResult(self.name), ProcInfoHandler(), IoHandler()
        description, named = self.describe()
        service = LaunchService(argv=[f"{k}:={v}" for k, v in self._arguments.items()])
        service.context.launch_configurations.update(self._arguments)
        service.context.extend_locals({"is_ready": self._ready.set})
        service.include_launch_description(LaunchDescription(recorders(info, output)))
        service.include_launch_description(description)
        known = {"launch_service": service, "proc_info": info, "proc_output": output}
        known |= {"test_args": self._arguments, **self._given, **named}
        tests = threading.Thread(target=self._test, args=(service, known, outcome), daemon=True)
        tests.start()
        keep_alive = getattr(self._module.generate_test_description, "keep_alive", False)
        service.run(shutdown_when_idle=not keep_alive)
        self._ready.set()
        tests.join(_PATIENCE)
        if tests.is_alive():
            text = "all processes ended before the tests did (launch_testing.markers.keep_alive?)"
            self._note(outcome, Case("launch", "failed", text))
        else:
            self._suite(known, after=True).run(_Result(outcome, self._tell))
        return outcome

    def _note(self, outcome: LaunchResult, case: Case) -> None:
        outcome.cases.append(case)
        self._tell(case)

    def _test(self, service: LaunchService, known: dict[str, Any], outcome: LaunchResult) -> None:
        try:
            if self._ready.wait(READY):
                self._suite(known, after=False).run(_Result(outcome, self._tell))
            else:
                text = f"no ReadyToTest within {READY:g} s: has generate_test_description one?"
                self._note(outcome, Case("launch", "error", text))
        finally:
            service.shutdown()

    def _suite(self, known: Mapping[str, Any], after: bool) -> unittest.TestSuite:
        """Return the tests beside the launch or behind its end, with what they ask for by name."""
        found = unittest.TestSuite()
        for case in vars(self._module).values():
            if not (isinstance(case, type) and issubclass(case, unittest.TestCase)):
                continue
            if getattr(case, "__post_shutdown_test__", False) is not after:
                continue
            for name, value in known.items():
                setattr(case, name, value)
            _give(case, ("setUpClass", "tearDownClass"), known)
            for test in unittest.defaultTestLoader.loadTestsFromTestCase(case):
                _give(test, ("setUp", "tearDown", str(getattr(test, "_testMethodName", ""))), known)
                found.addTest(test)
        return found


def recorders(info: ProcInfoHandler, output: IoHandler) -> list[RegisterEventHandler]:
    """Return the actions that record what the processes launched behind them do."""
    return [
        RegisterEventHandler(OnProcessStart(on_start=lambda event, context: info.append(event))),
        RegisterEventHandler(OnProcessExit(on_exit=lambda event, context: info.append(event))),
        RegisterEventHandler(OnProcessIO(on_stdout=output.append, on_stderr=output.append)),
    ]


def _give(owner: Any, names: Iterable[str], known: Mapping[str, Any]) -> None:
    for name in names:
        function = getattr(owner, name)
        asked = {one: known[one] for one in inspect.signature(function).parameters if one in known}
        if asked:
            setattr(owner, name, functools.partial(function, **asked))
