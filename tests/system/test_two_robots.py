"""Two robots in one ROS domain, each below its namespace: neither hears of the other."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import ExitStack, closing

import pytest
from nav2_msgs.action import NavigateToPose

from arjuna_core.ros.local.actions import action_client
from arjuna_core.se2 import SE2
from bringup.lockstep import LockStep
from bringup.parameters.files import merged, shipped_parameters
from bringup.stack import LOCALIZATION_GROUP, NAVIGATION_GROUP, SIM_GROUP
from tests.helpers.robots import ON_MAP, REACHED, owners, to_pose, truth

pytestmark = [pytest.mark.ros, pytest.mark.system]
GOALS = {"robot1": SE2(0.8, 0.5, 0.5), "robot2": SE2(-0.6, -0.6, 0.0)}
OF_ROS = {"/rosout", "/parameter_events", "/tf", "/tf_static"}


@pytest.fixture
def robots(monkeypatch: pytest.MonkeyPatch) -> Iterator[dict[str, LockStep]]:
    """Two robots that see each other's processes."""
    monkeypatch.setenv("ROS_DOMAIN_ID", "92")
    monkeypatch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
    parameters = merged(shipped_parameters(), ON_MAP)
    with ExitStack() as opened:
        made = {name: LockStep(parameters, name, isolated=False) for name in GOALS}
        for robot in made.values():
            opened.enter_context(closing(robot))
            robot.start(SIM_GROUP, LOCALIZATION_GROUP, NAVIGATION_GROUP)
        yield made


def step(robots: dict[str, LockStep], times: int) -> None:
    """Let both robots advance, tick by tick in turn."""
    for _ in range(times):
        for robot in robots.values():
            robot.step()


def test_each_reaches_its_own_goal_and_shares_no_topic(robots: dict[str, LockStep]) -> None:
    step(robots, 50)
    ahead = robots["robot1"]
    for _ in range(50):
        ahead.step()
    assert ahead.now == pytest.approx(robots["robot2"].now + 1.0)  # each has its own clock
    results = {}
    for name, robot in robots.items():
        client = action_client(robot.client, NavigateToPose, "navigate_to_pose")
        sent = client.send_goal_async(to_pose(GOALS[name]))
        step(robots, 10)
        results[name] = sent.result().get_result_async()
    for _ in range(40):
        step(robots, 50)
        if all(result.done() for result in results.values()):
            break
    for name, robot in robots.items():
        assert truth(robot).distance(GOALS[name]) < REACHED
    _check_graph(robots)


def _check_graph(robots: dict[str, LockStep]) -> None:
    client = robots["robot1"].client
    topics = {topic for topic, _ in client.get_topic_names_and_types()} - OF_ROS
    assert {f"/{name}/{topic}" for name in robots for topic in ("tf", "clock", "scan")} <= topics
    for topic in topics:
        assert len(owners(client, topic)) <= 1, f"{topic} is shared"
        assert topic.split("/")[1] in robots, f"{topic} is no robot's"
