"""Outlines of robots: all that can touch something, wheels that are steered among it."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial import ConvexHull

from arjuna_core.pose3 import Pose3
from arjuna_sim.files.robots.robot_file import load_robot
from arjuna_sim.model.geometry.shapes import points_of
from arjuna_sim.model.robot import footprint
from tests.sim.drive_cases import Robot, car, steered_all_round, tricycle

STEERED = [car("gz"), tricycle(), tricycle(classic=True), steered_all_round("control")]


@pytest.mark.parametrize("made", STEERED)
def test_an_outline_holds_its_wheels_wherever_they_are_steered(made: Robot, tmp_path: Path) -> None:
    """A car's wheels stood out of it by 6 cm: it saw them with its camera, and kept off them."""
    robot = load_robot(made.write(tmp_path))
    urdf, drive = robot.urdf, robot.drive
    hull = ConvexHull(footprint(robot, urdf.root)).equations
    limit = min(drive.steering_limit, math.pi)
    carried = {
        name: joint
        for name in urdf.links
        for joint in urdf.above(name)
        if joint.name in drive.steering
    }
    assert carried
    for name, joint in carried.items():
        points = points_of(urdf.links[name].collisions, urdf.T_root(name))
        T_pivot = Pose3(urdf.T_root(joint.child).position)
        for angle in np.linspace(-limit, limit, 41).tolist():
            turn = Pose3.from_rpy((0.0, 0.0, 0.0), (0.0, 0.0, angle))
            seen = (T_pivot @ turn @ T_pivot.inverse()).apply(points)[:, :2]
            assert (hull[:, :2] @ seen.T + hull[:, 2:]).max(initial=0.0) < 0.006
