"""Fixtures: a whole robot in lock-step; and the order in which files run on several cores."""

from __future__ import annotations

import gc
import os
import signal
import sys
from collections.abc import Callable, Iterator
from contextlib import ExitStack, closing
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

if TYPE_CHECKING:
    from arjuna_core.ros.process import Transport
    from bringup.lockstep import LockStep
    from bringup.stack import Group

_REAL_TIME = {
    **dict.fromkeys(
        (
            f"tests/system/test_{name}.py"
            for name in (
                "interactive",
                "real_robot",
                "recording",
                "playback",
                "simulator_commands",
                "view",
            )
        ),
        "real processes",
    ),
    "tests/nodes/bringup/ros2/": "ros2",
}
"""Files and folders whose tests start processes in real time, and the unit they are run in."""
_LONG = tuple(
    f"tests/{name}.py"
    for name in (
        *("nodes/bringup/test_notebooks", "nodes/bringup/homework/test_grading"),
        *("sim/test_drives", "system/test_kernels", "nav/test_benches"),
        *("nodes/bringup/homework/test_classroom", "system/test_parameter_extremes"),
        *("sim/physics/test_placing", "nodes/bringup/test_python_page", "system/test_faults"),
        *("fuzz/test_messages", "fuzz/test_attacks", "foreign/nav2/test_system"),
    )
)
"""Files of 12 s of CPU time and more, the longest first: none must be the last on one core."""


def pytest_configure() -> None:
    """Take Ctrl-C, which a script's background job ignores, and so would what tests start."""
    signal.signal(signal.SIGINT, signal.default_int_handler)


def pytest_ignore_collect(collection_path: Path) -> bool | None:
    """Leave out files whose `pytestmark` says that they need ROS where there is none."""
    if collection_path.suffix != ".py" or find_spec("rclpy"):
        return None
    marks = collection_path.read_text(encoding="utf-8").partition("\npytestmark = ")[2]
    return "pytest.mark.ros" in marks.partition("\n\n")[0] or None


def pytest_collectstart() -> None:
    """Leave no garbage to look for while modules are imported, which leave none."""
    gc.disable()


def pytest_collection_finish() -> None:
    """Spare the collector of garbage all modules and tests, which took an eighth of the time."""
    gc.freeze()
    gc.enable()


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_auto_num_workers(config: pytest.Config) -> int:
    """Return one process more than cores: the one with real processes mostly waits for them."""
    return (os.cpu_count() or 1) + 1


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config: pytest.Config, log: Any) -> Any:
    """Run a file's tests in one process, and in one those that start real processes.

    Side by side those would make each other late. Not by xdist's marks: where pytest is 9.2, xdist
    3.8 loses them without a word.
    """
    from xdist.scheduler import LoadScopeScheduling

    class ByFile(LoadScopeScheduling):
        """Hands out files, so that one process compiles and makes what the tests of each need.

        Real processes come whole, and first: they take longest.
        """

        def _split_scope(self, nodeid: str) -> str:
            units = (unit for start, unit in _REAL_TIME.items() if nodeid.startswith(start))
            return next(units, nodeid.partition("::")[0])

        def _assign_work_unit(self, node: Any) -> None:
            for unit in reversed((*dict.fromkeys(_REAL_TIME.values()), *_LONG)):
                if unit in self.workqueue:
                    self.workqueue.move_to_end(unit, last=False)
            super()._assign_work_unit(node)

    return ByFile(config, log)


@pytest.fixture(autouse=True)
def _log_level_given_back() -> Iterator[None]:
    """Give the level back that a command or a benchmark sets for the whole process."""
    yield
    logging = sys.modules.get("rclpy.logging")
    if logging is not None:
        logging.set_logger_level("", logging.LoggingSeverity.INFO)


@pytest.fixture
def stack() -> Iterator[Callable[..., LockStep]]:
    """Return a maker of lock-step robots: `stack(*groups, seed=0, parameters={}, transport)`.

    The simulator runs always, with the groups beside it. All are closed at the end. What a
    callback raises fails the test.
    """
    pytest.importorskip("rclpy", reason="no ROS here")
    from bringup.lockstep import LockStep
    from bringup.parameters.files import merged, shipped_parameters
    from bringup.stack import SIM_GROUP

    with ExitStack() as opened:

        def make(
            *groups: Group,
            seed: int = 0,
            parameters: dict[str, dict[str, Any]] | None = None,
            transport: Transport = "local",
        ) -> LockStep:
            overrides = merged(parameters or {}, {"sim": {"seed": seed}})
            values = merged(shipped_parameters(), overrides)
            robot = LockStep(values, strict=True, transport=transport)
            opened.enter_context(closing(robot))
            robot.start(SIM_GROUP, *groups)
            return robot

        yield make
