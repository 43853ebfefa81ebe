"""Obstacles below or above the lidar's plane: the robot sees them and drives round them."""

from __future__ import annotations

from pathlib import Path

import pytest

from arjuna_core.se2 import SE2
from arjuna_nav.costmap.costmap import LETHAL
from bringup.cli import parse
from bringup.client.goals import Goals
from bringup.parameters.inputs import gather
from bringup.stack import LOCAL_COSTMAP, NAVIGATION_GROUP, SLAM_GROUP
from tests.helpers.robots import Stack

pytestmark = [pytest.mark.ros, pytest.mark.system]
GOAL = SE2(3.0, 0.0)
BOX = """
<model name="{name}"><static>true</static><pose>1.5 {y} {z} 0 0 0</pose><link name="l">
  <collision name="c"><geometry><box><size>{size}</size></box></geometry></collision>
  <visual name="v"><geometry><box><size>{size}</size></box></geometry></visual>
</link></model>
"""
GROUND = """
<model name="ground"><static>true</static><link name="l">
  <collision name="c"><geometry><plane><size>20 20</size></plane></geometry></collision>
  <visual name="v"><geometry><plane><size>20 20</size></plane></geometry></visual>
</link></model>
"""


OTHER = {
    '<sensor name="depth" type="ray">': '<sensor name="depth" type="none">',
    '<sensor name="camera" type="camera">': '<sensor name="camera" type="depth">',
    "<width>640</width>": "<width>160</width>",
    "<height>480</height>": "<height>120</height>",
    "<camera_name>camera<": "<camera_name>eye<",
    'xyz="0 0 0.08"': 'xyz="0 0 0"',
}
"""A robot with a depth camera of its own topics, whose root is at its wheels' height."""


@pytest.mark.parametrize(
    ("low", "high", "changes"),
    [(0.0, 0.08, {}), (0.2, 0.26, {}), (0.0, 0.08, OTHER)],
    ids=["a low box", "a board at the mast", "a low box before another's camera"],
)
def test_it_drives_round_what_its_lidar_does_not_see(
    stack: Stack,
    tmp_path: Path,
    low: float,
    high: float,
    changes: dict[str, str],
) -> None:
    size, z = f"0.3 0.3 {high - low}", 0.5 * (low + high)
    wall = BOX.format(name="wall", y=-2.0, z=0.5, size="6 0.1 1")
    world = tmp_path / "low.world"
    models = GROUND + wall + BOX.format(name="thing", y=0.0, z=z, size=size)
    world.write_text(f'<sdf version="1.6"><world name="w">{models}</world></sdf>')
    file, text = tmp_path / "robot.urdf", Path("urdf/arjuna.urdf").read_text(encoding="utf-8")
    for old, new in changes.items():
        assert old in text
        text = text.replace(old, new)
    file.write_text(text, encoding="utf-8")
    words = ["demo", "--world", str(world), *(("--robot", str(file)) if changes else ())]
    robot = stack(SLAM_GROUP, NAVIGATION_GROUP, parameters=gather(parse(words)))
    robot.run(1.0)
    costs = robot.nodes[LOCAL_COSTMAP.name].layered.layers["voxel_layer"].data
    assert not (costs[:, : int(0.9 * costs.shape[1])] == LETHAL).any(), "the floor is no obstacle"
    assert Goals(robot).navigate(GOAL, 40.0).succeeded
    assert robot.sim.last.truth.pose.distance(GOAL) < 0.25
    assert robot.sim.contacts.log.total == 0
