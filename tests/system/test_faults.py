"""Claims: where a topic fails the robot stands or drives rightly, and is whole again after."""

from __future__ import annotations

import numpy as np
import pytest
from nav2_msgs.action import NavigateToPose
from nav2_msgs.srv import LoadMap
from std_msgs.msg import String

from arjuna_core.files.shipped import shipped_file
from arjuna_core.ros import qos
from arjuna_core.se2 import SE2
from bringup.client.goals import Goals
from bringup.lockstep import LockStep
from tests.helpers.faults import Fault, Faults
from tests.helpers.nav.faults import BLIND, DEAD, TOLERATED
from tests.helpers.robots import Stack, send, to_pose, truth
from tests.helpers.ros import RosBench
from tests.system.test_navigation import on_map

pytestmark = [pytest.mark.ros, pytest.mark.system]
FAR = SE2(1.2, 0.6, 0.5)
STILL = 0.001  # a tick [m]


class Drive:
    """A robot driving to a goal, at full speed."""

    def __init__(self, robot: LockStep) -> None:
        self.robot = robot
        nodes = [*robot.process.nodes, robot.process.node]
        self.faults = Faults(nodes, np.random.default_rng(1), lambda: robot.now)
        self.moved: list[tuple[float, float]] = []
        self._last = truth(robot)
        robot.on_tick = self._tick
        goal = send(robot, NavigateToPose, "navigate_to_pose", to_pose(FAR))
        self.result = goal.get_result_async()
        robot.run(2.0)

    def _tick(self) -> None:
        self.faults.run_due()
        pose = truth(self.robot)
        self.moved.append((self.robot.now, pose.distance(self._last)))
        self._last = pose


@pytest.mark.parametrize("kind", BLIND)
def test_a_robot_that_is_blind_stands_and_drives_when_it_is_over(stack: Stack, kind: str) -> None:
    drive = Drive(on_map(stack))
    robot = drive.robot
    assert drive.moved[-1][1] > STILL
    start = robot.now
    trial = BLIND[kind]
    drive.faults.put(trial.topic, trial.fault)
    robot.run(3.0)
    assert trial.stands_within is not None
    assert max(now for now, moved in drive.moved if moved > STILL) - start < trial.stands_within
    drive.faults.clear()
    robot.run_until(drive.result.done, 60.0, "the goal")
    assert drive.result.result().result.error_code == 0
    assert truth(robot).distance(FAR) < 0.3
    assert robot.sim.contacts.log.total == 0


def test_on_another_buildings_map_the_robot_stands_until_its_own_returns(stack: Stack) -> None:
    drive = Drive(on_map(stack))
    robot = drive.robot

    def load(name: str) -> None:
        request = LoadMap.Request(map_url=str(shipped_file(f"maps/{name}.yaml")))
        assert robot.call(LoadMap, "map_server/load_map", request).result == 0

    start = robot.now
    load("warehouse")
    robot.run(5.0)
    assert max(now for now, moved in drive.moved if moved > STILL) - start < 0.8
    load("arjuna_room")
    robot.run(2.0)
    assert Goals(robot).navigate(FAR, 60.0).succeeded
    assert robot.sim.contacts.log.total == 0


@pytest.mark.parametrize("kind", TOLERATED)
def test_a_robot_that_hears_enough_reaches_its_goal(stack: Stack, kind: str) -> None:
    drive = Drive(on_map(stack))
    drive.faults.put(TOLERATED[kind].topic, TOLERATED[kind].fault)
    drive.robot.run_until(drive.result.done, 60.0, "the goal")
    assert drive.result.result().result.error_code == 0
    assert truth(drive.robot).distance(FAR) < 0.3
    assert drive.robot.sim.contacts.log.total == 0


def test_a_fault_of_a_topic_that_nobody_publishes_is_refused(stack: Stack) -> None:
    robot = stack()
    faults = Faults(robot.process.nodes, np.random.default_rng(0), lambda: robot.now)
    with pytest.raises(ValueError, match=r"nobody publishes '/scna'; valid: .*/scan"):
        faults.put("/scna", DEAD)


def test_late_messages_come_in_their_time_and_health_returns() -> None:
    bench = RosBench()
    received = bench.collect(String, "word")
    publisher = bench.node.create_publisher(String, "word", qos.DEFAULT)
    faults = Faults([bench.node], np.random.default_rng(0), lambda: bench.process.now)
    try:
        faults.put("/word", Fault(delay=0.1, duplicate=1.0))
        publisher.publish(String(data="late"))
        bench.advance(0.08)
        faults.run_due()
        bench.process.drain()
        assert received == []
        bench.advance(0.04)
        faults.run_due()
        bench.process.drain()
        assert [message.data for message in received] == ["late", "late"]
        faults.clear()
        bench.publish(String, "word", String(data="well"))
        assert [message.data for message in received] == ["late", "late", "well"]
    finally:
        bench.close()
