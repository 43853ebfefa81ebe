"""Claims: no value that a client can give a parameter of any node ends or stalls the stack."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from itertools import zip_longest
from typing import Any

import pytest
from rcl_interfaces.srv import SetParameters
from rclpy.parameter import Parameter

from arjuna_core.se2 import SE2
from bringup.client.goals import Goals
from bringup.lockstep import LockStep
from bringup.stack import LOCALIZATION_GROUP, NAVIGATION_GROUP, SLAM_GROUP, Group
from tests.helpers.robots import ON_MAP, Stack

pytestmark = [pytest.mark.ros, pytest.mark.system]
NO_NUMBERS = (math.nan, math.inf, -math.inf, 1e308, -1e308)
NO_COUNTS = (2**63 - 1, -(2**63))
STALLED = 3.0
"""How much of a core's time one tick may take [s]."""
STACKS = {"nav": (LOCALIZATION_GROUP, NAVIGATION_GROUP), "slam": (SLAM_GROUP,)}
DRIVING = ("controller_server", "planner_server", "smoother_server", "amcl")
"""Nodes whose values are tried while the robot drives."""


def lenient(stack: Stack, *groups: Group) -> LockStep:
    """Return a robot whose callbacks' exceptions are counted, so that all of them are seen."""
    robot = stack(*groups, parameters=ON_MAP)
    robot.process.guard.strict = False
    return robot


def numbers(node: Any) -> Iterator[tuple[str, Any, Any]]:
    """Yield name, value and descriptor of each parameter that is a number."""
    for name, parameter in sorted(node._parameters.items()):
        if parameter.type_ in (Parameter.Type.DOUBLE, Parameter.Type.INTEGER):
            yield name, parameter.value, node.describe_parameter(name)


def taken(robot: LockStep, node: Any, name: str, value: Any) -> bool:
    """Set a parameter as a client does; return whether it was taken."""
    request = SetParameters.Request(parameters=[Parameter(name, value=value).to_parameter_msg()])
    service = f"{node.get_fully_qualified_name()}/set_parameters"
    return bool(robot.call(SetParameters, service, request).results[0].successful)


def failures(robot: LockStep) -> dict[str, str]:
    """Return what callbacks raised."""
    tallies = robot.process.guard.tallies.items()
    return {f"{node} {source}": t.reason for (node, source), t in tallies if t.kind == "failed"}


@pytest.mark.parametrize("groups", STACKS.values(), ids=STACKS)
def test_every_number_is_finite_and_bounded(stack: Stack, groups: tuple[Group, ...]) -> None:
    robot = lenient(stack, *groups)
    accepted, count = [], 0
    for node_name, node in robot.nodes.items():
        for name, value, descriptor in numbers(node):
            count += 1
            seed = name.endswith("seed")  # any is as good
            bad = NO_NUMBERS if isinstance(value, float) else () if seed else NO_COUNTS
            accepted += [
                f"{node_name} {name} {each}" for each in bad if taken(robot, node, name, each)
            ]
            ranges = [*descriptor.floating_point_range, *descriptor.integer_range]
            assert len(ranges) == 1, f"{node_name} {name} has no bounds"
            assert node.get_parameter(name).value == value
    assert not accepted
    assert count > 50
    assert not failures(robot)


@contextmanager
def quick(what: str, slow: list[str]) -> Iterator[None]:
    """Note what takes too much of a core's time."""
    start = time.process_time()
    yield
    spent = time.process_time() - start
    if spent > STALLED:
        slow.append(f"{what}: {spent:.1f} s")


def at_extremes(
    robot: LockStep, names: Iterable[str], step: Callable[[int], None]
) -> tuple[str, str]:
    """Set one number of each node at a time to its bounds, and back; return faults.

    All nodes at once: that is far quicker than one after the other.

    Args:
        robot: The robot.
        names: Of the nodes.
        step: Lets some time pass at the bound, whose row is given.

    Returns:
        The steps that took too much of a core's time, a line each, and numbers not set back.
    """
    slow: list[str] = []
    stuck: list[str] = []
    each_node = [
        [(robot.nodes[name], *one) for one in numbers(robot.nodes[name])] for name in names
    ]
    for row, items in enumerate(zip_longest(*each_node)):
        changed = [number for number in items if number is not None]
        for end in ("from_value", "to_value"):
            what = ", ".join(f"{node.get_name()} {name}" for node, name, _, _ in changed)
            with quick(f"{end} of {what}", slow):
                for node, name, _, descriptor in changed:
                    spans = [*descriptor.floating_point_range, *descriptor.integer_range]
                    taken(robot, node, name, getattr(spans[0], end))
                step(row)
            with quick(f"back from {end} of {what}", slow):
                for node, name, value, descriptor in changed:
                    if not taken(robot, node, name, value) and not descriptor.read_only:
                        stuck.append(f"{node.get_name()} {name}")
                robot.step()
    return "\n".join(slow), ", ".join(stuck)


@pytest.mark.parametrize("groups", STACKS.values(), ids=STACKS)
def test_the_greatest_and_least_values_stall_nothing(
    stack: Stack, groups: tuple[Group, ...]
) -> None:
    robot = lenient(stack, *groups)
    robot.run(1.0)
    rest = robot.nodes.keys() - set(DRIVING)
    assert at_extremes(robot, sorted(rest), lambda row: robot.run(0.2)) == ("", "")
    assert not failures(robot)


def test_a_goal_is_reached_after_every_extreme(stack: Stack) -> None:
    robot = lenient(stack, *STACKS["nav"])
    robot.run(1.0)
    goals = Goals(robot)

    def drive(row: int) -> None:
        goals.navigate(SE2(1.0, 0.5 if row % 2 else -0.5), 0.1)

    assert at_extremes(robot, DRIVING, drive) == ("", "")
    assert not failures(robot)
    robot.run(1.0)
    assert goals.navigate(SE2(1.5, 1.0, 0.5), 60.0).succeeded
