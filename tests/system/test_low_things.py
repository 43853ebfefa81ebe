"""Obstacles below or above the lidar's plane: the robot sees them and drives round them."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

pytest.importorskip("rclpy", reason="no ROS here")

from arjuna_core.se2 import SE2
from bringup.client.goals import Goals
from bringup.stack import NAVIGATION_GROUP, SLAM_GROUP

if TYPE_CHECKING:
    from bringup.lockstep import LockStep

pytestmark = [pytest.mark.ros, pytest.mark.system]
GOAL = SE2(3.0, 0.0)
BOX = """
<model name="{name}"><static>true</static><pose>1.5 {y} {z} 0 0 0</pose><link name="l">
  <collision name="c"><geometry><box><size>{size}</size></box></geometry></collision>
</link></model>
"""
GROUND = """
<model name="ground"><static>true</static><link name="l"><collision name="c">
  <geometry><plane><normal>0 0 1</normal><size>20 20</size></plane></geometry>
</collision></link></model>
"""


@pytest.mark.parametrize(
    ("low", "high"), [(0.0, 0.08), (0.2, 0.26)], ids=["a low box", "a board at the mast"]
)
def test_it_drives_round_what_its_lidar_does_not_see(
    stack: Callable[..., LockStep], tmp_path: Path, low: float, high: float
) -> None:
    size, z = f"0.3 0.3 {high - low}", 0.5 * (low + high)
    wall = BOX.format(name="wall", y=-2.0, z=0.5, size="6 0.1 1")
    world = tmp_path / "low.world"
    models = GROUND + wall + BOX.format(name="thing", y=0.0, z=z, size=size)
    world.write_text(f'<sdf version="1.6"><world name="w">{models}</world></sdf>')
    robot = stack(SLAM_GROUP, NAVIGATION_GROUP, parameters={"sim": {"world": str(world)}})
    robot.run(1.0)
    assert Goals(robot).navigate(GOAL, 40.0).succeeded
    assert robot.sim.last.truth.pose.distance(GOAL) < 0.25
    assert robot.sim.contacts.log.total == 0
