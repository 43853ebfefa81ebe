"""Lifecycle managers: order, refusals, and Nav2's services."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from types import SimpleNamespace
from typing import Any

import pytest
from bond.msg import Status
from nav2_msgs.srv import ManageLifecycleNodes
from rclpy.task import Future
from std_srvs.srv import Trigger

from arjuna_core.config import param
from arjuna_core.errors import ConfigError
from arjuna_core.ros.node import ManagedNode
from bringup.processes.lifecycle import manager
from bringup.processes.lifecycle.manager import LifecycleManager, LifecycleManagerConfig
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

    def __init__(
        self,
        refuse: str = "",
        autostart: bool = False,
        commandable: bool = True,
        **parameters: Any,
    ) -> None:
        self.bench = RosBench(transport="dds")
        self.diary: list[str] = []
        for name, refused in (("first", ""), ("second", refuse)):
            self.add(name, refused)
        names = ["first", "second"]
        config = LifecycleManagerConfig(autostart=autostart, **parameters)
        self.manager = LifecycleManager(self.bench.process, NAME, names, config, commandable)

    def add(self, name: str, refuse: str = "") -> FakeNode:
        """Make a node with the diary of all."""
        node = FakeNode(self.bench.process, {"refuse": refuse}, name=name)
        node.diary = self.diary
        return node

    def lose(self, node: FakeNode) -> None:
        """End a node as a crash does."""
        self.bench.process.executor.remove_node(node)
        self.bench.process.nodes.remove(node)
        node.destroy_node()

    def spin(self, duration: float) -> None:
        """Spin for a duration [s, wall]."""
        self.bench.process.spin(duration)

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


Make = Callable[..., Managed]


@pytest.fixture
def managed() -> Iterator[Make]:
    """Return a maker of managed benches."""
    made: list[Managed] = []

    def make(**options: Any) -> Managed:
        made.append(Managed(**options))
        return made[-1]

    yield make
    for each in made:
        each.close()


def test_autostart_configures_all_then_activates_all(managed: Make) -> None:
    system = managed(autostart=True)
    system.spin_until(lambda: system.manager.system_active)
    assert system.diary == [
        "first configure",
        "second configure",
        "first activate",
        "second activate",
    ]
    assert system.is_active()


def test_two_managers_may_bring_up_the_same_nodes(managed: Make) -> None:
    system = managed()
    config = LifecycleManagerConfig(autostart=False)
    process, names = system.bench.process, ["first", "second"]
    other = LifecycleManager(process, f"{NAME}_other", names, config, commandable=False)
    ended: list[bool] = []
    for one in (system.manager, other):
        one.submit(Command.STARTUP, ended.append)
    system.spin_until(lambda: len(ended) == 2)
    assert ended == [True, True]
    assert sorted(system.diary) == [
        *("first activate", "first configure", "second activate", "second configure")
    ]
    other.destroy_node()


def test_without_autostart_nothing_happens_until_startup(managed: Make) -> None:
    system = managed()
    assert not system.is_active()
    assert system.diary == []
    assert system.manage(Command.STARTUP)
    assert system.is_active()


def test_manage_nodes_answers_when_the_command_is_done(managed: Make) -> None:
    system = managed()
    assert system.manage(Command.STARTUP)
    assert system.diary[-1] == "second activate"
    assert system.manage(Command.PAUSE)
    assert system.diary[-2:] == ["second deactivate", "first deactivate"]
    assert not system.is_active()
    assert system.manage(Command.RESUME)
    assert system.is_active()


def test_reset_and_startup_work_again_and_again(managed: Make) -> None:
    system = managed(autostart=True)
    for _ in range(3):
        assert system.manage(Command.RESET)
        assert system.diary[-2:] == ["second cleanup", "first cleanup"]
        assert system.manage(Command.STARTUP)
        assert system.is_active()


def test_a_node_that_cannot_configure_stops_the_bring_up(managed: Make) -> None:
    system = managed(refuse="configure")
    assert not system.manage(Command.STARTUP)
    assert system.diary == ["first configure", "second configure"]
    assert not system.is_active()


def test_a_node_that_cannot_rest_lets_the_others_down(managed: Make) -> None:
    system = managed(refuse="deactivate", autostart=True)
    system.spin_until(lambda: system.manager.system_active)
    assert not system.manage(Command.PAUSE)
    assert system.diary[-2:] == ["second deactivate", "first deactivate"]
    assert not system.is_active()


def test_commands_wait_for_the_running_one(managed: Make) -> None:
    system = managed()
    answers: list[tuple[str, bool]] = []
    for command in (Command.STARTUP, Command.RESET, Command.CONFIGURE):
        system.manager.submit(command, lambda ok, c=command: answers.append((c.name, ok)))  # type: ignore[misc]
    system.spin_until(lambda: len(answers) == 3)
    assert answers == [("STARTUP", True), ("RESET", True), ("CONFIGURE", True)]


def test_a_command_that_does_not_exist_fails(managed: Make) -> None:
    assert not managed().manage(99)


def test_a_manager_without_commands_reports_its_state(managed: Make) -> None:
    system = managed(autostart=True, commandable=False)
    system.spin_until(lambda: system.manager.system_active)
    assert system.is_active()
    offered = dict(system.bench.node.get_service_names_and_types())
    assert ["nav2_msgs/srv/ManageLifecycleNodes"] not in offered.values()


def test_only_the_world_takes_no_commands() -> None:
    groups = (*(group for groups in STACKS.values() for group in groups), EXPLORER_GROUP)
    assert [group.name for group in groups if not group.commandable] == ["sim"]


def with_own(managed: Make, **parameters: Any) -> tuple[Managed, FakeNode]:
    """Return a bench whose manager has brought up a node of a user's own, too."""
    names = {"node_names": ("first", "/own"), "bond_timeout": 0.7, **parameters}
    system = managed(autostart=True, **names)
    own = system.add("own")
    system.spin_until(lambda: system.manager.system_active)
    return system, own


def test_nodes_of_ones_own_come_up_behind_the_process_s(managed: Make) -> None:
    system, _ = with_own(managed)
    names = ["first", "second", "own"]
    steps = ("configure", "activate")
    assert system.diary == [f"{name} {step}" for step in steps for name in names]
    assert system.manager.get_parameter("node_names").value == ["first", "second", "/own"]


def _long_awaited(managed: Make, monkeypatch: pytest.MonkeyPatch) -> Managed:
    """Return a bench whose manager waits for a node of a user's own since five minutes."""
    system = managed(autostart=True, node_names=("/own",))
    waited: list[str] = []
    monkeypatch.setattr(system.manager, "_on_wait", waited.append)
    system.spin_until(lambda: "/own, to offer its lifecycle services" in waited)
    later = SimpleNamespace(monotonic=lambda: time.monotonic() + 300.0)
    monkeypatch.setattr(manager, "time", later)
    system.spin(0.5)
    return system


def test_one_that_starts_minutes_later_is_told_and_comes_up_too(
    managed: Make, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    system = _long_awaited(managed, monkeypatch)
    assert "Waiting for service /own/get_state..." in capfd.readouterr().err
    system.add("own")
    system.spin_until(lambda: system.manager.system_active)


def test_one_that_does_not_start_holds_up_no_other_command(
    managed: Make, monkeypatch: pytest.MonkeyPatch
) -> None:
    system = _long_awaited(managed, monkeypatch)
    monkeypatch.setattr(manager, "SERVICE_DEADLINE", 0.5)
    system.manager.submit(Command.RESET, lambda success: None)
    system.spin_until(lambda: "first cleanup" in system.diary)


@pytest.mark.parametrize("back", [True, False])
def test_losing_a_users_node_restarts_all(managed: Make, back: bool) -> None:
    system, own = with_own(managed, attempt_respawn_reconnection=back)
    system.lose(own)
    system.spin_until(lambda: not system.manager.system_active)
    system.spin_until(lambda: system.diary[-1] == "first cleanup")
    system.add("own")
    if back:
        system.spin_until(lambda: system.manager.system_active)
        assert system.diary[-1] == "own activate"
    else:
        system.spin(2.0)
        assert system.diary[-1] == "first cleanup"


def test_a_busy_node_without_a_heartbeat_is_not_lost(
    managed: Make, monkeypatch: pytest.MonkeyPatch
) -> None:
    system, _ = with_own(managed)
    unanswered = SimpleNamespace(service_is_ready=lambda: True, call_async=lambda asked: Future())
    monkeypatch.setitem(system.manager._bonds._states, "/own", unanswered)
    system.spin(3.0)
    assert system.manager.system_active


@pytest.mark.parametrize("values", [{"bond_timeout": 0.0}, {"bond_timeout": 30.0}])
def test_a_lost_node_is_tolerated_for_the_timeout(managed: Make, values: dict[str, float]) -> None:
    system, own = with_own(managed, **values)
    system.lose(own)
    system.spin(2.0)
    assert system.manager.system_active


def test_a_node_that_comes_back_too_late_is_left_alone(managed: Make) -> None:
    system, own = with_own(managed, bond_respawn_max_duration=0.2)
    system.lose(own)
    system.spin_until(lambda: system.diary[-1] == "first cleanup")
    system.spin(1.5)
    system.add("own")
    system.spin(1.5)
    assert system.diary[-1] == "first cleanup"


def test_heartbeats_of_a_bond_are_answered(managed: Make) -> None:
    system, own = with_own(managed)
    answers = system.bench.collect(Status, "/bond")
    heartbeat = Status(id="own", instance_id="its", active=True, heartbeat_timeout=4.0)
    system.lose(own)  # it answers no get_state any more
    for _ in range(8):
        system.bench.publish(Status, "/bond", heartbeat)
        system.spin(0.25)
    assert system.manager.system_active
    others = [each for each in answers if each.instance_id != "its"]
    assert {(each.id, each.active) for each in others} == {("own", True)}
    system.spin_until(lambda: not system.manager.system_active)
