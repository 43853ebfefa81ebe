"""Two robots in one simulated world: each has its own stack, and reaches its own goals."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator
from contextlib import ExitStack, closing, contextmanager
from typing import Any

import pytest
from action_msgs.msg import GoalStatus
from nav2_msgs.action import NavigateToPose
from sensor_msgs.msg import LaserScan

from arjuna_core.ros import qos
from arjuna_core.ros.local.actions import action_client
from arjuna_core.se2 import SE2
from bringup.lockstep import LockStep
from bringup.parameters.files import merged, shipped_parameters
from bringup.stack import LOCALIZATION_GROUP, NAVIGATION_GROUP, WORLD_GROUP
from tests.helpers.robots import ON_MAP, REACHED, owners, to_pose

pytestmark = [pytest.mark.ros, pytest.mark.system]
_OF_ALL = ("/rosout", "/parameter_events", "/tf", "/tf_static")
STARTS = {"red": SE2(-1.0, 0.0, 0.0), "blue": SE2(1.0, 2.0, 3.14)}
GOALS = {"red": SE2(0.5, -1.0, -0.5), "blue": SE2(-0.5, 2.0, 3.0)}
TIMEOUT = 30.0
WORLD = {
    "sim": {
        "namespaces": list(STARTS),
        "starts": [number for pose in STARTS.values() for number in (pose.x, pose.y, pose.theta)],
    }
}


def on_map(pose: SE2) -> dict[str, dict[str, Any]]:
    """Return the parameters of a robot that knows the map, and where it starts."""
    start = dict(zip(("x", "y", "yaw"), (pose.x, pose.y, pose.theta), strict=True))
    return merged(ON_MAP, {"amcl": {f"initial_pose.{key}": value for key, value in start.items()}})


@contextmanager
def fleet(**sim: Any) -> Iterator[tuple[LockStep, dict[str, LockStep]]]:
    """Start a world with two robots, each with localization and navigation."""
    with ExitStack() as opened:
        parameters = merged(shipped_parameters(), WORLD, {"sim": sim})
        world = LockStep(parameters, strict=True)
        opened.enter_context(closing(world))
        world.start(WORLD_GROUP)
        robots = {}
        for name, pose in STARTS.items():
            own = merged(shipped_parameters(), on_map(pose))
            robots[name] = LockStep(own, name, strict=True, beside=world)
            opened.enter_context(closing(robots[name]))
            robots[name].start(LOCALIZATION_GROUP, NAVIGATION_GROUP)
        yield world, robots


def send(world: LockStep, robots: dict[str, LockStep]) -> dict[str, Any]:
    """Send each robot its goal at once; return the futures of the answers."""
    world.run(1.0)
    answers = {}
    for name, robot in robots.items():
        client = action_client(robot.client, NavigateToPose, "navigate_to_pose")
        answers[name] = client.send_goal_async(to_pose(GOALS[name]))
    return answers


def drive(world: LockStep, robots: dict[str, LockStep]) -> dict[str, int]:
    """Let each robot drive to its goal; return how each ended, by its GoalStatus."""
    answers = send(world, robots)
    world.run_until(lambda: all(a.done() for a in answers.values()), 5.0, "an answer")
    ends = {name: answer.result().get_result_async() for name, answer in answers.items()}
    world.run_until(lambda: all(end.done() for end in ends.values()), TIMEOUT, "the goals")
    return {name: end.result().status for name, end in ends.items()}


def test_each_reaches_its_own_goal_and_no_topic_is_shared() -> None:
    with fleet() as (world, robots):
        ends = drive(world, robots)
        assert ends == dict.fromkeys(GOALS, GoalStatus.STATUS_SUCCEEDED)
        for name, robot in world.sim.simulator.robots.items():
            assert robot.truth().pose.distance(GOALS[name]) < REACHED
            assert world.sim.fleet.nodes(name).interface.contacts.log.total == 0
            estimate = robots[name].process.transforms.try_lookup("map", "base_footprint")
            assert estimate is not None
            assert estimate.distance(robot.truth().pose) < 0.1
        _check_graph(world)


def _check_graph(world: LockStep) -> None:
    """Check that whoever has an end of a robot's topic lives in its namespace."""
    client = world.client
    for topic, _ in client.get_topic_names_and_types():
        owner = topic.split("/")[1]
        if owner in STARTS:
            assert owners(client, topic) == {owner}, f"{topic} is shared"
        else:
            assert topic in _OF_ALL or owners(client, topic) == {""}, topic


def test_one_seed_gives_one_run() -> None:
    def report() -> str:
        digest = hashlib.sha256()
        with fleet(seed=3) as (world, robots):
            for robot in robots.values():
                robot.client.create_subscription(
                    LaserScan,
                    "scan",
                    lambda scan: digest.update(bytes(scan.ranges)),
                    qos.SENSOR_SUBSCRIPTION,
                )
            send(world, robots)
            world.run(2.0)
            assert all(abs(r.truth().v) > 0.1 for r in world.sim.simulator.robots.values())
        return digest.hexdigest()

    assert report() == report()
