"""A robot whose middle lies on a lethal cell stands, or backs out to where the costmap is free."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from scipy.ndimage import distance_transform_edt

from arjuna_core.config import load
from arjuna_core.se2 import SE2
from arjuna_core.twist import Velocity
from arjuna_nav.behaviors.base import BehaviorConfig
from arjuna_nav.behaviors.motions import AssistedTeleop, DriveOnHeading, Spin
from arjuna_nav.controllers.follower import FollowerConfig, PathFollower
from arjuna_nav.costmap import Costmap
from arjuna_nav.costmap.costmap import LETHAL
from arjuna_nav.costmap.footprint import Footprint
from tests.helpers.nav.controllers import PARAMETERS, make
from tests.nav.worlds import block, costmap_of, empty_grid, polyline

SEEDS = (1, 2)  # the box, and the circle where unknown space is tracked
ROUND, BOX = "[]", "[[0.3, 0.2], [-0.3, 0.2], [-0.3, -0.2], [0.3, -0.2]]"
CONFIG = BehaviorConfig()
MIDDLE = SE2(3.0, 3.0)
PERIOD = 0.1
Drive = Callable[[SE2, float], Velocity]
"""Returns what is driven at a pose and a time [s]."""


def scene(kind: str, seed: int) -> tuple[Costmap, SE2, Footprint]:
    """Return a generated costmap, a robot and where it stands: its middle on a lethal cell, its
    edge, or all of it."""
    rng = np.random.default_rng(seed)
    grid, text = empty_grid(6.0, 6.0), (ROUND, BOX)[seed % 2]
    for _ in range(3):
        x, y = rng.uniform(0.2, 4.8, 2)
        if math.hypot(x + 0.2 - 3.0, y + 0.2 - 3.0) > 1.2:
            block(grid, x, y, *rng.uniform(0.1, 0.5, 2))
    width, height = rng.choice([0.05, 0.1, 0.3, 0.6], 2)
    if kind == "middle":
        block(grid, 3.0 - rng.uniform(0.0, 1.0) * (width - 0.05), 3.0, width, height)
    elif kind == "edge":
        block(grid, 3.2, 2.9, width, height)
    else:
        block(grid, 1.5, 1.5, 3.0, 3.0)
    pose = SE2(3.02, 3.02, float(rng.uniform(-math.pi, math.pi)) if kind != "edge" else 0.0)
    costmap = costmap_of(grid, track_unknown=bool(seed % 3 == 2), footprint=text)
    return costmap, pose, Footprint.parse(text, 0.25, 0.0)


def clearances(costmap: Costmap) -> Any:
    """Return how far each cell is from the nearest lethal one; below 0 in it, from a free one."""
    lethal = costmap.data == LETHAL
    return distance_transform_edt(~lethal) - distance_transform_edt(lethal)


def check(kind: str, costmap: Costmap, pose: SE2, drive: Drive, seconds: float = 6.0) -> None:
    """Drive, and fail where a robot that is buried, or touches, does anything but go out."""
    field, lethal = clearances(costmap), costmap.data == LETHAL
    start = pose
    for k in range(round(seconds / PERIOD)):
        velocity = drive(pose, k * PERIOD)
        after = pose @ SE2.exp(np.array([velocity.x, 0.0, velocity.yaw_rate]) * PERIOD)
        row, column = costmap.frame.to_cell(pose.x, pose.y)
        if lethal[row, column]:
            assert velocity.x != 0.0 or velocity.yaw_rate == 0.0, (
                f"it turns on the spot after {k} ticks"
            )
            there = costmap.frame.to_cell(after.x, after.y)
            assert field[there] >= field[row, column], f"it drives deeper after {k} ticks"
        pose = after
    if kind == "whole":
        assert pose == start, "no free place is in reach, yet it drives"


def behaviors(footprint: Footprint) -> dict[str, Any]:
    return {
        "spin": Spin(1.57, CONFIG, footprint, 0.0),
        "spin back": Spin(-3.0, CONFIG, footprint, 0.0),
        "drive_on_heading": DriveOnHeading(1.0, 0.2, CONFIG, footprint, 0.0),
        "backup": DriveOnHeading(-0.4, -0.1, CONFIG, footprint, 0.0),
    }


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("kind", ["middle", "edge", "whole"])
@pytest.mark.parametrize("name", behaviors(Footprint.circle(0.25)))
def test_behaviours_go_nowhere_but_out(name: str, kind: str, seed: int) -> None:
    costmap, pose, footprint = scene(kind, seed)
    behavior = behaviors(footprint)[name]
    check(kind, costmap, pose, lambda at, now: behavior.tick(at, costmap, now).velocity)


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("kind", ["middle", "edge", "whole"])
@pytest.mark.parametrize(("v", "w"), [(0.3, 0.0), (-0.3, 0.8), (0.05, 0.8), (0.0, 0.8)])
def test_teleoperation_goes_nowhere_but_out(v: float, w: float, kind: str, seed: int) -> None:
    costmap, pose, footprint = scene(kind, seed)
    teleop = AssistedTeleop(CONFIG, footprint, 0.0)

    def drive(at: SE2, now: float) -> Velocity:
        teleop.take(Velocity(v, yaw_rate=w), now)
        return teleop.tick(at, costmap, now).velocity

    check(kind, costmap, pose, drive)


def path_from(seed: int) -> Any:
    """Return a path that leads from the middle to somewhere."""
    bearing = float(np.random.default_rng(100 + seed).uniform(-math.pi, math.pi))
    end = 3.0 + 2.0 * math.cos(bearing), 3.0 + 2.0 * math.sin(bearing)
    return polyline([(3.02, 3.02), end], bearing)


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("kind", ["middle", "edge", "whole"])
@pytest.mark.parametrize("name", PARAMETERS)
def test_controllers_go_nowhere_but_out(name: str, kind: str, seed: int) -> None:
    costmap, pose, footprint = scene(kind, seed)
    controller, last = make(name, footprint, PERIOD), Velocity()
    controller.set_path(path_from(seed))

    def drive(at: SE2, now: float) -> Velocity:
        nonlocal last
        last = controller.compute(at, last, costmap, now).velocity
        return last

    check(kind, costmap, pose, drive, 3.0)


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("kind", ["middle", "edge", "whole"])
@pytest.mark.parametrize("name", ["pure pursuit", "dwb", "graceful"])
@pytest.mark.parametrize("at_goal", [False, True])
def test_following_goes_nowhere_but_out(name: str, kind: str, seed: int, at_goal: bool) -> None:
    """With the follower's own: the last stretch, detours, passages, straight off."""
    costmap, pose, footprint = scene(kind, seed)
    values = {f"FollowPath.{key}": value for key, value in PARAMETERS[name].items()}
    values["failure_tolerance"] = -1.0
    follower, last = PathFollower(load(FollowerConfig, values), footprint), Velocity()
    path = path_from(seed)
    follower.start(path[:5] if at_goal else path, 0.0)

    def drive(at: SE2, now: float) -> Velocity:
        nonlocal last
        last = follower.tick(at, last, costmap, now).velocity
        return last

    check(kind, costmap, pose, drive, 4.0)


@pytest.mark.parametrize("heading", [0.0, 0.5, 0.8, 2.5, math.pi, -2.4, -0.6])
def test_it_backs_out_of_the_side_it_came_in_by(heading: float) -> None:
    """At the near side of a wide block, it may drive off it, and neither on nor turn."""
    grid, robot = empty_grid(6.0, 6.0), Footprint.circle(0.25)
    block(grid, 3.0, 0.0, 2.0, 6.0)
    costmap, pose = costmap_of(grid), SE2(3.02, 3.02, heading)
    out = math.copysign(0.2, -math.cos(heading))
    for speed, goes in ((out, out), (-out, 0.0)):
        straight = DriveOnHeading(speed, speed, CONFIG, robot, 0.0)
        assert straight.tick(pose, costmap, 0.0).velocity == Velocity(goes)
    assert Spin(1.0, CONFIG, robot, 0.0).tick(pose, costmap, 0.0).velocity == Velocity()


def test_what_is_not_known_is_no_exit() -> None:
    grid = empty_grid(6.0, 6.0)
    grid.data[:, 61:] = -1
    block(grid, 3.0, 0.0, 0.05, 6.0)
    costmap = costmap_of(grid, track_unknown=True)
    for speed, free in ((0.2, False), (-0.2, True)):
        behaviour = DriveOnHeading(speed, speed, CONFIG, Footprint.circle(0.25), 0.0)
        velocity = behaviour.tick(SE2(3.02, 3.02), costmap, 0.0).velocity
        assert velocity == (Velocity(speed) if free else Velocity())
