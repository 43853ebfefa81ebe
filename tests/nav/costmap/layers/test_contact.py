"""What has stopped the robot is marked, where no sensor sees it."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from arjuna_core.arrays import Floats
from arjuna_core.scan import Scan
from arjuna_core.se2 import IDENTITY, SE2
from arjuna_core.twist import Velocity
from arjuna_nav.costmap import LETHAL, LayeredCostmap, PlacedScan
from tests.helpers.nav.layers import costmap_config, see

BOX = "[[0.2, 0.1], [0.2, -0.1], [-0.2, -0.1], [-0.2, 0.1]]"
START = SE2(3.02, 3.01, 0.5)


def costmap(**values: Any) -> LayeredCostmap:
    config = costmap_config(
        width=6,
        height=6,
        resolution=0.05,
        footprint=BOX,
        footprint_padding=0.0,
        plugins=("obstacle_layer", "contact_layer"),
        contact_layer=values,
    )
    return LayeredCostmap(config)


def drive(
    layered: LayeredCostmap,
    command: Velocity,
    pose: SE2 = START,
    step: SE2 = IDENTITY,
    since: float = 0.0,
    seconds: float = 4.0,
) -> float:
    """Command for some time, while the robot moves by a step a second; return the time [s]."""
    layered.group.start(since)
    for k in range(1, round(2.0 * seconds) + 1):
        pose = pose @ SE2.exp(0.5 * step.array())
        layered.receive("contact_layer", "commands", command)
        layered.update(pose, since + 0.5 * k)
    return since + seconds


def marks(layered: LayeredCostmap, pose: SE2 = START) -> Floats:
    """Return what is lethal, in the robot's frame `(N, 2)` [m]."""
    costs = layered.costmap
    return pose.inverse().apply(costs.frame.to_points(np.argwhere(costs.data == LETHAL)))


@pytest.mark.parametrize(
    ("command", "axis", "reach"),
    [
        (Velocity(0.2), 0, 0.2),
        (Velocity(-0.2), 0, -0.2),
        (Velocity(y=0.2), 1, 0.1),
    ],
)
def test_what_stops_the_robot_is_marked_ahead(command: Velocity, axis: int, reach: float) -> None:
    layered = costmap()
    drive(layered, command)
    found = marks(layered)
    assert len(found) >= 3
    ahead = found[:, axis] * np.sign(reach)
    assert np.abs(ahead - abs(reach) - 0.025).max() < 0.07
    assert np.ptp(found[:, 1 - axis]) > 0.8 * (0.2 if axis == 0 else 0.4) - 0.05


@pytest.mark.parametrize(
    ("command", "step"),
    [
        (Velocity(0.2), SE2(0.1)),  # it moves, though less than is commanded
        (Velocity(0.2), SE2(0.0, 0.0, 0.3)),  # it turns
        (Velocity(0.05), SE2()),  # it was not commanded to move far
        (Velocity(yaw_rate=0.5), SE2()),
    ],
)
def test_nothing_is_marked_where_nothing_stops_it(command: Velocity, step: SE2) -> None:
    layered = costmap()
    drive(layered, command, step=step)
    assert not len(marks(layered))


def test_back_and_forth_is_no_contact() -> None:
    layered = costmap()
    for k in range(20):
        layered.receive("contact_layer", "commands", Velocity(0.3 if k % 2 else -0.3))
        layered.update(START, 0.5 * k)
    assert not len(marks(layered))


def test_known_obstacle_ahead_is_what_stops_it() -> None:
    layered = costmap()
    scan = Scan(np.full(9, 0.22), -0.2, 0.05, 0.1, 10.0)
    see(layered, START, 0.0, [PlacedScan(scan, START)])
    before = marks(layered)
    drive(layered, Velocity(0.2))
    assert len(before)
    assert np.array_equal(marks(layered), before)


def test_contacts_outlive_clearing_and_fade() -> None:
    layered = costmap(memory=60.0)
    end = drive(layered, Velocity(0.2))
    found = marks(layered)
    layered.clear_entirely()
    layered.group.start(end)
    assert np.array_equal(marks(layered), found)
    layered.update(START, end + 50.0)
    assert np.array_equal(marks(layered), found)
    layered.update(START, end + 61.0)
    assert not len(marks(layered))


def test_contacts_of_a_later_time_are_those_of_another_run() -> None:
    layered = costmap(memory=60.0)
    drive(layered, Velocity(0.2), since=100.0)
    assert len(marks(layered))
    layered.group.start(50.0)
    layered.update(START, 51.0)
    assert not len(marks(layered))


def test_contacts_stay_in_the_fixed_frame_as_odometry_drifts() -> None:
    """The wheels turn and slip: only on the map does the robot stand still."""
    T_map_odom = [SE2()]
    config = costmap_config(
        global_frame="odom",
        rolling_window=True,
        width=6,
        height=6,
        resolution=0.05,
        footprint=BOX,
        footprint_padding=0.0,
        plugins=("contact_layer",),
    )
    layered = LayeredCostmap(config, lambda target, source: T_map_odom[0])
    layered.group.start(0.0)
    for k in range(1, 9):
        slipped = START @ SE2(0.1 * k)
        T_map_odom[0] = START @ slipped.inverse()
        layered.receive("contact_layer", "commands", Velocity(0.2))
        layered.update(slipped, 0.5 * k)
    found = marks(layered, slipped)
    assert len(found) >= 3
    assert np.abs(found[:, 0] - 0.225).max() < 0.07


def test_what_was_commanded_on_the_way_to_a_place_stops_it_not_there() -> None:
    """The clock stood still while it drove on."""
    layered, pose = costmap(), START
    layered.group.start(0.0)
    for now in (0.1, 4.1):
        layered.receive("contact_layer", "commands", Velocity(0.45))
        layered.update(pose, now)
        pose = pose @ SE2(0.2)
    assert not len(marks(layered))
