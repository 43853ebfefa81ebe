"""Lock-step: the whole robot runs the same every time, and a goal is reached."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import closing
from pathlib import Path

import pytest
from rclpy.serialization import deserialize_message

from arjuna_core.bags.reader import Bag
from arjuna_core.ros.context import class_of
from arjuna_core.ros.local.cdr import to_cdr
from arjuna_core.ros.process import Transport
from arjuna_core.se2 import SE2
from bringup.client.goals import Goals
from bringup.lockstep import LockStep
from bringup.parameters.files import merged, shipped_parameters
from bringup.recording.recorder import demo_recorder
from bringup.stack import NAVIGATION_GROUP, SIM_GROUP, SLAM_GROUP
from tests.helpers.robots import Stack

pytestmark = [pytest.mark.ros, pytest.mark.system]
GOAL = SE2(0.8, 0.5, 0.5)


def drive(
    robot: LockStep, on_tick: Callable[[], None] = lambda: None
) -> tuple[bool, list[tuple[SE2, SE2 | None]]]:
    """Send a goal while mapping; return whether it succeeded, and truth and estimate a tick."""
    samples: list[tuple[SE2, SE2 | None]] = []

    def sample() -> None:
        on_tick()
        estimate = robot.process.transforms.try_lookup("map", "base_footprint")
        samples.append((robot.sim.last.truth.pose, estimate))

    robot.on_tick = sample
    robot.run(1.0)
    return Goals(robot).navigate(GOAL, 40.0).succeeded, samples


def test_a_goal_is_reached_and_one_seed_gives_one_run(stack: Stack) -> None:
    succeeded, first = drive(stack(SLAM_GROUP, NAVIGATION_GROUP, seed=3))
    assert succeeded
    assert first[-1][0].distance(GOAL) < 0.25
    assert drive(stack(SLAM_GROUP, NAVIGATION_GROUP, seed=3)) == (True, first)
    assert drive(stack(SLAM_GROUP, NAVIGATION_GROUP, seed=4))[1] != first


def test_a_run_is_the_same_through_the_middleware(tmp_path: Path) -> None:
    """Same trajectory, and the same messages recorded, but for what CDR's gaps hold."""
    runs, values = {}, merged(shipped_parameters(), {"sim": {"seed": 5}})
    transports: tuple[Transport, ...] = ("local", "dds")
    for transport in transports:
        path = tmp_path / f"{transport}.mcap"
        with (
            closing(LockStep(values, strict=True, transport=transport)) as robot,
            closing(demo_recorder(robot.process, path)) as recorder,
        ):
            robot.start(SIM_GROUP, SLAM_GROUP, NAVIGATION_GROUP)
            succeeded, samples = drive(robot, recorder.poll)
        assert succeeded
        runs[transport] = samples, messages(path)
    assert runs["local"] == runs["dds"]


def messages(path: Path) -> list[tuple[str, int, bytes]]:
    """Return a recording's messages, in order, with zeros in their gaps."""
    return [
        (
            each.topic.name,
            each.time,
            to_cdr(deserialize_message(each.data, class_of(each.topic.type_name))),
        )
        for each in Bag(path).messages()
    ]
