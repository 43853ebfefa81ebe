"""Fixtures: a whole robot in lock-step; and what may run beside what."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import ExitStack, closing
from typing import TYPE_CHECKING, Any

import pytest

if TYPE_CHECKING:
    from arjuna_core.ros.process import Transport
    from bringup.lockstep import LockStep
    from bringup.stack import Group

_REAL_TIME = ("tests/system/", "tests/nodes/bringup/ros2/")


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config: pytest.Config, log: Any) -> Any:
    """Run a file's tests in one process, and in one those that start real processes.

    Side by side those would make each other late. Not by xdist's marks: where pytest is 9.2, xdist
    3.8 loses them without a word.
    """
    from xdist.scheduler import LoadScopeScheduling

    class ByFile(LoadScopeScheduling):
        """Hands out files, so that one process compiles and makes what the tests of each need.

        The folders of real processes come whole, and first: they take longest.
        """

        def _split_scope(self, nodeid: str) -> str:
            folder = next((folder for folder in _REAL_TIME if nodeid.startswith(folder)), None)
            return folder or nodeid.partition("::")[0]

        def _assign_work_unit(self, node: Any) -> None:
            for folder in _REAL_TIME:
                if folder in self.workqueue:
                    self.workqueue.move_to_end(folder, last=False)
            super()._assign_work_unit(node)

    return ByFile(config, log)


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
