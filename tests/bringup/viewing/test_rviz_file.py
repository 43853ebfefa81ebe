"""RViz's files: fixed frame and displays, as ROS 1 and 2 write them, and as pages print them."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml

from arjuna_core.errors import InputFileError
from bringup.viewing.drawing.values import LAYERS
from bringup.viewing.rviz_file import RvizFile, read_rviz

NAV2 = """
Visualization Manager:
  Displays:
    - {Class: rviz_default_plugins/Grid, Name: Grid, Enabled: true}
    - {Class: rviz_default_plugins/RobotModel, Enabled: true,
       Description Topic: {Value: /robot_description}}
    - {Class: rviz_default_plugins/LaserScan, Enabled: true, Topic: {Depth: 5, Value: /front/scan}}
    - {Class: rviz_default_plugins/PointCloud2, Name: Bumper, Enabled: true, Topic: {Value: /hits}}
    - Class: rviz_common/Group
      Name: Controller
      Enabled: true
      Displays:
        - {Class: rviz_default_plugins/Map, Enabled: true, Topic: {Value: /local_costmap/costmap}}
        - {Class: rviz_default_plugins/Path, Enabled: true, Topic: {Value: /local_plan}}
        - {Class: nav2_rviz_plugins/ParticleCloud, Enabled: false, Topic: {Value: /particle_cloud}}
  Global Options: {Fixed Frame: odom}
"""
KINDS = ["LaserScan", "Map", "Path", "PoseArray", "RobotModel", "TF", "Polygon", "Odometry"]


def _read(folder: Path, text: str) -> RvizFile:
    path = folder / "view.rviz"
    path.write_text(text, encoding="utf-8")
    return read_rviz(path)


def test_a_file_of_ros_2_is_read_with_its_groups(tmp_path: Path) -> None:
    found = _read(tmp_path, NAV2)
    assert found.fixed_frame == "odom"
    assert found.layers == {"robot", "scan", "local_costmap", "local_path"}
    assert found.topics["scan"] == "front/scan"
    assert found.left_out == ("Bumper",)


def _displays(rng: np.random.Generator) -> list[dict[str, Any]]:
    """Return displays of ROS 1, as many and as they come."""
    topics = ["/map", "/scan", "/move_base/local_costmap/costmap", "/move_base/NavfnROS/plan"]
    return [
        {
            "Alpha": float(rng.random()),
            "Class": f"rviz/{rng.choice(KINDS)}",
            "Color": "25; 255; 0",
            "Enabled": bool(rng.random() < 0.8),
            "Name": f"Display {number}",
            "Offset": {"X": 0, "Y": 0, "Z": 0},
            "Topic": str(rng.choice(topics)),
            "Value": True,
        }
        for number in range(int(rng.integers(1, 9)))
    ]


@pytest.mark.parametrize("seed", range(20))
def test_a_file_whose_indentation_is_lost_says_the_same(seed: int, tmp_path: Path) -> None:
    displays = _displays(np.random.default_rng(seed))
    manager = {"Displays": displays, "Global Options": {"Fixed Frame": "base_footprint"}}
    panels = [{"Class": "rviz/Displays", "Name": "Displays"}]
    text = yaml.safe_dump({"Panels": panels, "Visualization Manager": manager})
    whole = _read(tmp_path, text)
    flat = _read(tmp_path, "\n".join(line.strip() for line in text.splitlines()))
    assert flat == whole
    assert whole.fixed_frame == "base_footprint"
    assert whole.layers <= set(LAYERS)


def test_topics_below_move_base_are_ours(tmp_path: Path) -> None:
    display = "{Class: rviz/Map, Enabled: true, Topic: /move_base/local_costmap/costmap}"
    found = _read(tmp_path, f"Visualization Manager: {{Displays: [{display}]}}")
    assert found.layers == frozenset({"local_costmap"})
    assert not found.topics


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ("a: [", "is no YAML|line 1"),
        ("a: 1", "has no 'Visualization Manager'; valid: a file that RViz saved"),
    ],
)
def test_what_is_no_configuration_is_refused(text: str, problem: str, tmp_path: Path) -> None:
    with pytest.raises(InputFileError, match=problem):
        _read(tmp_path, text)
