"""RViz's files: fixed frame and displays, as ROS 1 and 2 write them, and as pages print them."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml

from arjuna_core.errors import InputFileError
from bringup.viewing.displays.base import DISPLAYS, Display
from bringup.viewing.displays.standard import STANDARD
from bringup.viewing.rviz_file import RvizFile, read_rviz, write_rviz

NAV2 = """
Panels: [{Class: rviz_common/Displays}]
Visualization Manager:
  Displays:
    - {Class: rviz_default_plugins/Grid, Name: Grid, Enabled: true}
    - {Class: rviz_default_plugins/RobotModel, Enabled: true,
       Description Topic: {Value: /robot_description}}
    - {Class: rviz_default_plugins/LaserScan, Enabled: true, Topic: {Depth: 5, Value: /front/scan}}
    - {Class: rviz_default_plugins/PointCloud2, Name: Bumper, Enabled: true, Topic: {Value: /hits}}
    - {Class: own_plugins/StudentsOwn, Name: Student's own, Secret: 7}
    - Class: rviz_common/Group
      Name: Controller
      Enabled: true
      Displays:
        - {Class: rviz_default_plugins/Map, Enabled: true, Topic: {Value: /local_costmap/costmap}}
        - {Class: rviz_default_plugins/Path, Enabled: true, Topic: {Value: /local_plan}}
        - {Class: nav2_rviz_plugins/ParticleCloud, Enabled: false, Topic: {Value: /particle_cloud}}
  Global Options: {Fixed Frame: odom}
  Views: {Current: {Class: rviz_default_plugins/Orbit}}
"""
KINDS = ["LaserScan", "Map", "Path", "PoseArray", "RobotModel", "TF", "Polygon", "Odometry"]


def _read(folder: Path, text: str) -> RvizFile:
    path = folder / "view.rviz"
    path.write_text(text, encoding="utf-8")
    return read_rviz(path)


def test_a_file_of_ros_2_is_read_with_its_groups(tmp_path: Path) -> None:
    found = _read(tmp_path, NAV2)
    assert found.fixed_frame == "odom"
    shown = [(each.kind, each.topic) for each in found.displays if each.shown]
    assert shown == [
        ("RobotModel", "robot_description"),
        ("LaserScan", "front/scan"),
        ("PointCloud2", "hits"),
        ("Map", "local_costmap/costmap"),
        ("Path", "local_plan"),
    ]
    assert [each.kind for each in found.displays if not each.shown] == ["ParticleCloud"]
    assert found.left_out == ("Student's own",)


def test_settings_are_read_as_rviz_writes_them(tmp_path: Path) -> None:
    text = """Visualization Manager: {Displays: [
      {Class: rviz_default_plugins/PointCloud2, Size (m): 0.2, Color Transformer: AxisColor,
       Axis: Y},
      {Class: rviz_default_plugins/Path, Color: 1; 2; 300, Line Width: lots},
      {Class: rviz_default_plugins/MarkerArray, Namespaces: {a: true, b: false}},
      {Class: rviz_default_plugins/Map, Topic: {Value: /map}, Color Scheme: raw}]}"""
    cloud, path, markers, a_map = (each.make().config for each in _read(tmp_path, text).displays)
    assert (cloud.size_m, cloud.color_transformer, cloud.axis) == (0.2, "AxisColor", "Y")
    assert path.color == (1, 2, 255)  # within the bounds
    assert path.line_width == 0.04  # no number: the default
    assert markers.namespaces == "a"
    assert a_map.color_scheme == "map"


def test_what_is_saved_is_read_again(tmp_path: Path) -> None:
    text = write_rviz("odom", STANDARD)
    found = _read(tmp_path, text)
    assert found.fixed_frame == "odom"
    assert [(s.name, s.shown) for s in found.displays] == [(s.name, s.shown) for s in STANDARD]
    for saved, spec in zip(found.displays, STANDARD, strict=True):
        assert saved.make().config == spec.make().config
        assert saved.make().name == spec.make().name


def test_saving_keeps_what_only_rviz_knows(tmp_path: Path) -> None:
    found = _read(tmp_path, NAV2)
    one, *others = found.displays
    changed = [replace(one, shown=False), *others]
    saved = yaml.safe_load(write_rviz("map", changed, found))
    assert saved["Panels"] == [{"Class": "rviz_common/Displays"}]
    manager = saved["Visualization Manager"]
    assert manager["Views"] == {"Current": {"Class": "rviz_default_plugins/Orbit"}}
    by_class = {each["Class"].rpartition("/")[2]: each for each in manager["Displays"]}
    assert by_class["StudentsOwn"]["Secret"] == 7
    assert by_class["LaserScan"]["Topic"] == {"Depth": 5, "Value": "/front/scan"}
    assert not by_class["RobotModel"]["Enabled"]


def test_a_class_of_one_s_own_is_a_display(tmp_path: Path) -> None:
    text = f"Visualization Manager: {{Displays: [{{Class: '{__name__}:Own', Name: mine}}]}}"
    (own,) = _read(tmp_path, text).displays
    assert isinstance(own.make(), Own)


class Own(Display):
    """A user's display."""

    types = ("std_msgs/msg/String",)


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
    said = ([replace(each, rviz={}) for each in found.displays] for found in (flat, whole))
    assert next(said) == next(said)
    assert (flat.fixed_frame, flat.left_out) == (whole.fixed_frame, whole.left_out)
    assert whole.fixed_frame == "base_footprint"
    assert all(each.kind in DISPLAYS.types for each in whole.displays)


@pytest.mark.parametrize(
    ("kind", "topic", "ours"),
    [
        ("Map", "/move_base/local_costmap/costmap", "local_costmap/costmap"),
        ("Path", "/move_base/TrajectoryPlannerROS/local_plan", "local_plan"),
        ("Path", "/move_base/NavfnROS/plan", "plan"),
        ("PoseArray", "/particlecloud", "particle_cloud"),
    ],
)
def test_what_ros_1_publishes_elsewhere_is_ours(
    kind: str, topic: str, ours: str, tmp_path: Path
) -> None:
    display = f"{{Class: rviz/{kind}, Enabled: true, Topic: {topic}}}"
    (found,) = _read(tmp_path, f"Visualization Manager: {{Displays: [{display}]}}").displays
    assert found.make().name == ours


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
