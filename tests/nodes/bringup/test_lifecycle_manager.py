"""Lifecycle managers: order, refusals, and Nav2's services."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import pytest
from nav2_msgs.srv import ManageLifecycleNodes
from std_srvs.srv import Trigger

from arjuna_core.config import param
from arjuna_core.errors import ConfigError
from arjuna_core.ros.node import ManagedNode
from bringup.processes.lifecycle.manager import LifecycleManager
from bringup.processes.lifecycle.plan import Command
from bringup.stack import EXPLORER_GROUP, STACKS
from tests.helpers.ros import RosBench

NAME = "lifecycle_manager_test"


@dataclass(frozen=True)
class FakeConfig:
    """A fake node's parameters."""

    refuse: str = param("", "The step to refuse")


class FakeNode(ManagedNode):
    """A node that keeps a diary, and refuses the step of its parameter."""

    Config = FakeConfig
    DEFAULT_NAME = "fake"
    diary: list[str]

    def _note(self, step: str) -> None:
        self.diary.append(f"{self.get_name()} {step}")
        if self.config.refuse == step:
            raise ConfigError(f"refuses to {step}")

    def configure(self) -> None:
        """Note it."""
        self._note("configure")

    def activate(self) -> None:
        """Note it."""
        self._note("activate")

    def deactivate(self) -> None:
        """Note it."""
        self._note("deactivate")

    def cleanup(self) -> None:
        """Note it."""
        self._note("cleanup")


class Managed:
    """A bench with two fake nodes under a manager."""

    def __init__(self, refuse: str = "", autostart: bool = False, commandable: bool = True) -> None:
        self.bench = RosBench(transport="dds")
        self.diary: list[str] = []
        for name, refused in (("first", ""), ("second", refuse)):
            node = FakeNode(self.bench.process, {"refuse": refused}, name=name)
            node.diary = self.diary
        names = ["first", "second"]
        self.manager = LifecycleManager(self.bench.process, NAME, names, autostart, commandable)

    def spin_until(self, done: Callable[[], bool]) -> None:
        """Spin until something is so."""
        self.bench.until(done, ("what was asked; diary", self.diary))

    def call(self, service_type: Any, service: str, request: Any) -> Any:
        """Call one of the manager's services."""
        client = self.bench.node.create_client(service_type, f"{NAME}/{service}")
        self.spin_until(client.service_is_ready)
        future = client.call_async(request)
        self.spin_until(future.done)
        return future.result()

    def manage(self, command: int) -> bool:
        """Send a command and return its success."""
        request = ManageLifecycleNodes.Request(command=command)
        return bool(self.call(ManageLifecycleNodes, "manage_nodes", request).success)

    def is_active(self) -> bool:
        """Ask whether all nodes are active."""
        return bool(self.call(Trigger, "is_active", Trigger.Request()).success)

    def close(self) -> None:
        """Leave the graph."""
        self.manager.destroy_node()
        self.bench.close()


@pytest.fixture
def managed() -> Iterator[Callable[..., Managed]]:
    """Return a maker of managed benches."""
    made: list[Managed] = []

    def make(**options: Any) -> Managed:
        made.append(Managed(**options))
        return made[-1]

    yield make
    for each in made:
        each.close()


def test_autostart_configures_all_then_activates_all(managed: Callable[..., Managed]) -> None:
    system = managed(autostart=True)
    system.spin_until(lambda: system.manager.system_active)
    assert system.diary == [
        "first configure",
        "second configure",
        "first activate",
        "second activate",
    ]
    assert system.is_active()


def test_without_autostart_nothing_happens_until_startup(managed: Callable[..., Managed]) -> None:
    system = managed()
    assert not system.is_active()
    assert system.diary == []
    assert system.manage(Command.STARTUP)
    assert system.is_active()


def test_manage_nodes_answers_only_when_the_command_is_done(
    managed: Callable[..., Managed],
) -> None:
    system = managed()
    assert system.manage(Command.STARTUP)
    assert system.diary[-1] == "second activate"
    assert system.manage(Command.PAUSE)
    assert system.diary[-2:] == ["second deactivate", "first deactivate"]
    assert not system.is_active()
    assert system.manage(Command.RESUME)
    assert system.is_active()


def test_reset_and_startup_work_again_and_again(managed: Callable[..., Managed]) -> None:
    system = managed(autostart=True)
    for _ in range(3):
        assert system.manage(Command.RESET)
        assert system.diary[-2:] == ["second cleanup", "first cleanup"]
        assert system.manage(Command.STARTUP)
        assert system.is_active()


def test_a_node_that_refuses_to_configure_stops_the_bring_up(
    managed: Callable[..., Managed],
) -> None:
    system = managed(refuse="configure")
    assert not system.manage(Command.STARTUP)
    assert system.diary == ["first configure", "second configure"]
    assert not system.is_active()


def test_a_node_that_refuses_to_rest_does_not_keep_the_others_up(
    managed: Callable[..., Managed],
) -> None:
    system = managed(refuse="deactivate", autostart=True)
    system.spin_until(lambda: system.manager.system_active)
    assert not system.manage(Command.PAUSE)
    assert system.diary[-2:] == ["second deactivate", "first deactivate"]
    assert not system.is_active()


def test_commands_that_come_while_one_runs_wait_their_turn(
    managed: Callable[..., Managed],
) -> None:
    system = managed()
    answers: list[tuple[str, bool]] = []
    for command in (Command.STARTUP, Command.RESET, Command.CONFIGURE):
        system.manager.submit(command, lambda ok, c=command: answers.append((c.name, ok)))  # type: ignore[misc]
    system.spin_until(lambda: len(answers) == 3)
    assert answers == [("STARTUP", True), ("RESET", True), ("CONFIGURE", True)]


def test_a_command_that_does_not_exist_fails(managed: Callable[..., Managed]) -> None:
    assert not managed().manage(99)


def test_a_manager_that_takes_no_commands_still_reports_its_state(
    managed: Callable[..., Managed],
) -> None:
    system = managed(autostart=True, commandable=False)
    system.spin_until(lambda: system.manager.system_active)
    assert system.is_active()
    offered = dict(system.bench.node.get_service_names_and_types())
    assert ["nav2_msgs/srv/ManageLifecycleNodes"] not in offered.values()


def test_only_the_world_takes_no_commands() -> None:
    groups = (*(group for groups in STACKS.values() for group in groups), EXPLORER_GROUP)
    assert [group.name for group in groups if not group.commandable] == ["sim"]
