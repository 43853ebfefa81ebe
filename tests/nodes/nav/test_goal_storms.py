"""Storms of goals: whatever comes, each goal ends once, the robot stands, the next is reached."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from action_msgs.msg import GoalStatus
from nav2_msgs.action import NavigateThroughPoses, NavigateToPose

from arjuna_core.ros import qos
from arjuna_core.ros.local.actions import action_client
from arjuna_core.se2 import SE2
from arjuna_core.twist import STILL
from tests.helpers.nav.navigation import PlayedRobot
from tests.helpers.nav.navigator_goals import GOAL, IN_BOX, IN_RING, go, made, stamped

ENDED = {GoalStatus.STATUS_SUCCEEDED, GoalStatus.STATUS_CANCELED, GoalStatus.STATUS_ABORTED}
_ACTIONS = {"navigate_to_pose": NavigateToPose, "navigate_through_poses": NavigateThroughPoses}
_POSES = [
    *(lambda rng: stamped(SE2(*rng.uniform(-3.0, 1.5, 2))),) * 4,
    lambda rng: stamped(IN_BOX),
    lambda rng: stamped(SE2(90.0, 0.0)),
    lambda rng: stamped(IN_RING),
    lambda rng: stamped(GOAL, "moon"),
]


class Storm:
    """Clients that send, cancel and ask for results as chance has it.

    Args:
        robot: Whom they bother.
        seed: Of chance.
    """

    def __init__(self, robot: PlayedRobot, seed: int) -> None:
        self._robot = robot
        self._rng = np.random.default_rng(seed)
        deep = {f"{k}_service_qos_profile": qos.SERVICES for k in ("goal", "result", "cancel")}
        node = robot.bench.node
        self._clients = {k: action_client(node, t, k, **deep) for k, t in _ACTIONS.items()}
        self._sent: list[Any] = []
        self._results: dict[int, Any] = {}
        robot.bench.process.drain()

    def blow(self, actions: int) -> None:
        """Do something, several things at once or some time apart."""
        does: list[Callable[[], None]] = [*[self._send] * 5, self._cancel, self._ask, self._wait]
        for _ in range(actions):
            does[self._rng.integers(len(does))]()

    def _send(self) -> None:
        poses = [_POSES[self._rng.integers(len(_POSES))](self._rng) for _ in range(3)]
        if self._rng.random() < 0.75:
            goal: Any = NavigateToPose.Goal(pose=poses[0])
            self._sent.append(self._clients["navigate_to_pose"].send_goal_async(goal))
        else:
            goal = NavigateThroughPoses.Goal(poses=poses[: self._rng.integers(4)])
            self._sent.append(self._clients["navigate_through_poses"].send_goal_async(goal))

    def _accepted(self) -> dict[int, Any]:
        done = {k: sent.result() for k, sent in enumerate(self._sent) if sent.done()}
        return {k: handle for k, handle in done.items() if handle.accepted}

    def _cancel(self) -> None:
        for handle in self._accepted().values():
            if self._rng.random() < 0.3:
                handle.cancel_goal_async()

    def _ask(self) -> None:
        for k, handle in self._accepted().items():
            if k not in self._results:
                self._results[k] = handle.get_result_async()

    def _wait(self) -> None:
        self._robot.run(float(self._rng.uniform(0.0, 0.5)))

    def results(self) -> list[Any]:
        """Wait for the answers and return how each accepted goal ended."""
        self._robot.bench.process.drain()
        assert all(sent.done() for sent in self._sent)
        self._ask()
        for _ in range(40):
            self._robot.run(1.0)
            if all(result.done() for result in self._results.values()):
                break
        return [r.result() if r.done() else None for r in self._results.values()]


@pytest.mark.parametrize("seed", range(2))
def test_each_goal_of_a_storm_ends_once_and_the_next_is_reached(seed: int) -> None:
    robot = made(number_of_retries=0)
    storm = Storm(robot, seed)
    storm.blow(60)
    results = storm.results()
    assert len(results) > 15
    assert {answer and answer.status for answer in results} <= ENDED
    robot.run(0.5)
    assert robot.command == STILL
    robot.succeed(go(robot, GOAL), 40.0)


@pytest.mark.parametrize("name", ["bt_navigator", "planner_server", "controller_server"])
def test_goals_end_however_a_server_is_brought_down_and_up(name: str) -> None:
    robot = made(number_of_retries=0)
    storm = Storm(robot, 7)
    for transitions in (["deactivate"], ["deactivate", "cleanup", "configure"]) * 3:
        storm.blow(5)
        for transition in (*transitions, "activate"):
            robot.transition(name, transition)
        robot.run(0.2)
    forgotten = {GoalStatus.STATUS_UNKNOWN}  # by a server that was made again
    assert {answer and answer.status for answer in storm.results()} <= ENDED | forgotten
    robot.succeed(go(robot, GOAL), 40.0)
