"""RViz's files: fixed frame and displays, as ROS 1 and 2 write them, and as pages print them."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml

from arjuna_core.errors import InputFileError
from bringup.viewing.displays.base import DISPLAYS, Display, DisplaySpec
from bringup.viewing.displays.standard import STANDARD
from bringup.viewing.rviz_file import RvizFile, read_rviz, write_rviz

QOS = "Depth: 5, Durability Policy: Volatile, History Policy: Keep Last, Reliability Policy"
NAV2 = f"""
Panels:
  - {{Class: rviz_common/Displays, Tree Height: 287}}
  - {{Class: nav2_rviz_plugins/Navigation 2, Name: Navigation 2}}
  - {{Class: nav2_rviz_plugins/Docking, Name: Docking}}
  - {{Class: "slam_toolbox::SlamToolboxPlugin", Name: SlamToolboxPlugin}}
Visualization Manager:
  Class: ""
  Displays:
    - {{Class: rviz_default_plugins/Grid, Name: Grid, Enabled: true, Offset: {{X: 0, Y: 0}}}}
    - {{Class: rviz_default_plugins/RobotModel, Enabled: false, Name: RobotModel, Value: false,
       Description Topic: {{{QOS}: Reliable, Value: robot_description}}}}
    - {{Class: rviz_default_plugins/TF, Enabled: true, Name: TF, Show Names: false,
       Frames: {{All Enabled: false, base_link: {{Value: true}}}}, Tree: {{}}}}
    - {{Class: rviz_default_plugins/LaserScan, Name: LaserScan, Enabled: true, Value: true,
       Color Transformer: Intensity, Style: Points, Size (Pixels): 3, Size (m): 0.0099,
       Topic: {{{QOS}: Best Effort, Filter size: 10, Value: <robot_namespace>/front/scan}}}}
    - {{Class: rviz_default_plugins/PointCloud2, Name: Bumper Hit, Enabled: true,
       Color Transformer: "", Style: Spheres, Size (m): 0.08,
       Topic: {{{QOS}: Best Effort, Value: /hits}}}}
    - {{Class: own_plugins/StudentsOwn, Name: Student's own, Secret: 7}}
    - Class: rviz_common/Group
      Name: Controller
      Enabled: true
      Displays:
        - {{Class: rviz_default_plugins/Map, Name: Local, Enabled: true, Alpha: 0.7, Value: true,
           Color Scheme: costmap, Topic: {{{QOS}: Reliable, Value: local_costmap/costmap}},
           Update Topic: {{{QOS}: Reliable, Value: local_costmap/costmap_updates}}}}
        - {{Class: rviz_default_plugins/Path, Name: Local Plan, Enabled: true, Color: 0; 12; 255,
           Pose Style: None, Topic: {{{QOS}: Reliable, Value: local_plan}}}}
        - {{Class: nav2_rviz_plugins/ParticleCloud, Name: Swarm, Enabled: false,
           Topic: {{{QOS}: Best Effort, Value: particle_cloud}}}}
    - Class: rviz_common/Group
      Name: Realsense
      Enabled: false
      Displays:
        - {{Class: rviz_default_plugins/Image, Name: Camera, Enabled: true, Value: true,
           Topic: {{{QOS}: Reliable, Value: camera/image_raw}}}}
        - {{Class: own_plugins/Depth, Name: Depth, Enabled: true}}
        - {{Class: rviz_default_plugins/MarkerArray, Name: Routes, Enabled: true, Value: true,
           Namespaces: {{a: true, b: false}}, Topic: {{{QOS}: Reliable, Value: route_graph}}}}
    - {{Class: rviz_default_plugins/Odometry, Name: Odometry, Enabled: true, Keep: 100,
       Covariance: {{Position: {{Alpha: 0.3}}, Value: false}},
       Shape: {{Color: 255; 25; 0, Shaft Length: 1, Value: Arrow}}, Topic: /odom}}
  Global Options: {{Fixed Frame: odom, Frame Rate: 30}}
  Tools:
    - {{Class: rviz_default_plugins/SetInitialPose, Topic: {{{QOS}: Reliable, Value: initialpose}}}}
    - {{Class: nav2_rviz_plugins/GoalTool}}
    - {{Class: own_plugins/Lasso}}
  Views: {{Current: {{Class: rviz_default_plugins/TopDownOrtho, Scale: 54, Y: 0}}, Saved: ~}}
Window Geometry: {{Height: 893, QMainWindow State: 000000ff00000000fd00000004, X: 72}}
"""
KINDS = ["LaserScan", "Map", "Path", "PoseArray", "RobotModel", "TF", "Polygon", "Odometry"]


def _read(folder: Path, text: str) -> RvizFile:
    path = folder / "view.rviz"
    path.write_text(text, encoding="utf-8")
    return read_rviz(path)


def test_a_file_of_ros_2_is_read_with_its_groups(tmp_path: Path) -> None:
    found = _read(tmp_path, NAV2)
    assert found.fixed_frame == "odom"
    assert [(each.kind, each.topic) for each in found.displays if each.shown] == [
        ("TF", ""),
        ("LaserScan", "front/scan"),  # in the namespace of whoever looks
        ("PointCloud2", "/hits"),
        ("Map", "local_costmap/costmap"),
        ("Path", "local_plan"),
        ("Odometry", "/odom"),
    ]
    hidden = [each.kind for each in found.displays if not each.shown]
    assert hidden == ["RobotModel", "ParticleCloud", "Image", "MarkerArray"]
    assert found.unsupported == (
        "Student's own (own_plugins/StudentsOwn)",
        "panel Docking (nav2_rviz_plugins/Docking)",
        "panel SlamToolboxPlugin (slam_toolbox::SlamToolboxPlugin)",
        "tool own_plugins/Lasso",
    )


def test_settings_are_read_as_rviz_writes_them(tmp_path: Path) -> None:
    text = """Visualization Manager: {Displays: [
      {Class: rviz_default_plugins/PointCloud2, Size (m): 0.2, Color Transformer: AxisColor,
       Axis: Y},
      {Class: rviz_default_plugins/Path, Color: 1; 2; 300, Line Width: [lots]},
      {Class: rviz_default_plugins/LaserScan, Style: Points, Size (Pixels): 3, Size (m): 0.01,
       Decay Time: 10},
      {Class: rviz_default_plugins/Odometry, Covariance: {Value: true}, Shape: {Color: 1; 2; 3}},
      {Class: rviz_default_plugins/MarkerArray, Namespaces: {a: true, b: false}},
      {Class: rviz_default_plugins/Map, Topic: {Value: /map}, Color Scheme: raw}]}"""
    configs = (each.make().config for each in _read(tmp_path, text).displays)
    cloud, path, scan, odometry, markers, a_map = configs
    assert (cloud.size_m, cloud.color_transformer, cloud.axis) == (0.2, "AxisColor", "Y")
    assert path.color == (1, 2, 255)  # within the bounds
    assert path.line_width == 0.04  # no number: the default
    assert (scan.size_m, scan.decay_time) == (0.03, 10.0)  # 3 pixels are seen, 1 cm is not
    assert (odometry.covariance, odometry.color) == (True, (1, 2, 3))
    assert markers.namespaces == "b"  # what a file does not name is shown
    assert a_map.color_scheme == "map"


ORBIT = "{Class: rviz/Orbit, Distance: 2, Yaw: 3.141592653589793, Pitch: 0, Focal Point: {X: 1}}"
FIRST = "{Class: rviz_default_plugins/FPS, Position: {X: 1, Y: 2, Z: 3}, Yaw: 0, Pitch: 0}"


@pytest.mark.parametrize(
    ("current", "eye", "focus", "frame"),
    [
        (ORBIT, (-1, 0, 0), (1, 0, 0), ""),
        (FIRST[:-1] + ", Target Frame: base_link}", (1, 2, 3), (2, 2, 3), "base_link"),
        (FIRST[:-1] + ", Target Frame: <Fixed Frame>}", (1, 2, 3), (2, 2, 3), ""),
        (FIRST[:-1] + ", Target Frame: odom}", (1, 2, 3), (2, 2, 3), ""),
        ("{Class: x/TopDownOrtho, Scale: 100, X: 5, Y: .nan}", (5, 0, 5.21), (5, 0, 0), ""),
    ],
)
def test_a_file_says_from_where_it_looks(
    tmp_path: Path, current: str, eye: Any, focus: Any, frame: str
) -> None:
    parts = f"Views: {{Current: {current}}}, Global Options: {{Fixed Frame: odom}}"
    found = _read(tmp_path, f"Visualization Manager: {{{parts}}}")
    assert found.view is not None
    assert found.view.eye == pytest.approx(eye, abs=0.01)
    assert found.view.focus == pytest.approx(focus, abs=1e-9)
    assert found.view.frame == frame
    assert not found.unsupported


def test_a_top_view_is_turned_as_the_file_says(tmp_path: Path) -> None:
    current = "{Class: rviz_default_plugins/TopDownOrtho, Angle: -1.5708}"  # x points up
    view = _read(tmp_path, f"Visualization Manager: {{Views: {{Current: {current}}}}}").view
    assert view is not None
    assert view.eye[:2] == pytest.approx((-0.001, 0.0), abs=1e-6)


def test_tools_publish_where_the_file_says(tmp_path: Path) -> None:
    text = """Visualization Manager: {Tools: [
      {Class: rviz_default_plugins/SetGoal, Topic: {Value: /tb1/goal_pose}},
      {Class: rviz_default_plugins/SetInitialPose, Topic: {Value: <robot_namespace>/initialpose}},
      {Class: rviz_default_plugins/PublishPoint}, {Class: rviz_default_plugins/Measure}]}"""
    tools = {"SetGoal": "/tb1/goal_pose", "SetInitialPose": "initialpose"}
    assert _read(tmp_path, text).tools == tools
    text = "Visualization Manager: {Tools: [{Class: rviz/SetGoal, Topic: /move_base_simple/goal}]}"
    assert _read(tmp_path, text).tools == {"SetGoal": "goal_pose"}


def test_a_view_of_another_kind_is_said(tmp_path: Path) -> None:
    text = "Visualization Manager: {Views: {Current: {Class: own/Drone, Name: Current View}}}"
    found = _read(tmp_path, text)
    assert found.view is None
    assert found.unsupported == ("view Current View (own/Drone)",)


def test_frames_are_hidden_as_the_file_says(tmp_path: Path) -> None:
    text = """Visualization Manager: {Displays: [
      {Class: rviz_default_plugins/TF, Frames: {All Enabled: false, a: {Value: false},
       b: {Value: true}}},
      {Class: rviz_default_plugins/Axes, Reference Frame: b, Length: 0.5}]}"""
    found = _read(tmp_path, text)
    tree, axes = (each.make().config for each in found.displays)
    assert tree.frames == "a"
    assert (axes.reference_frame, axes.length) == ("b", 0.5)
    other = replace(found.displays[0], settings={"frames": "b"})
    manager = yaml.safe_load(write_rviz("map", [other, found.displays[1]], found))
    kept = manager["Visualization Manager"]["Displays"][0]["Frames"]
    assert kept == {"a": {"Value": True}, "b": {"Value": False}}


def test_a_picture_of_ros_1_has_its_topic(tmp_path: Path) -> None:
    text = "Visualization Manager: {Displays: [{Class: rviz/Image, Image Topic: /cam}]}"
    assert [each.topic for each in _read(tmp_path, text).displays] == ["/cam"]


def test_what_is_saved_is_read_again(tmp_path: Path) -> None:
    text = write_rviz("odom", STANDARD)
    found = _read(tmp_path, text)
    assert found.fixed_frame == "odom"
    assert [(s.name, s.shown) for s in found.displays] == [(s.name, s.shown) for s in STANDARD]
    for saved, spec in zip(found.displays, STANDARD, strict=True):
        assert saved.make().config == spec.make().config
        assert saved.make().name == spec.make().name


def _again(found: RvizFile, displays: list[DisplaySpec]) -> tuple[Any, dict[str, Any]]:
    """Return a saved file's document, and its displays and groups by name."""
    saved = yaml.safe_load(write_rviz(found.fixed_frame, displays, found))

    def below(parent: Any) -> dict[str, Any]:
        parts = {each["Name"]: each for each in parent.get("Displays", ())}
        return parts | {name: part for each in parts.values() for name, part in below(each).items()}

    return saved, below(saved["Visualization Manager"])


def test_saving_what_was_not_changed_changes_nothing(tmp_path: Path) -> None:
    found = _read(tmp_path, NAV2)
    assert _again(found, list(found.displays))[0] == yaml.safe_load(NAV2)


def test_saving_changes_what_was_changed_and_nothing_else(tmp_path: Path) -> None:
    found = _read(tmp_path, NAV2)
    before = _again(found, list(found.displays))[1]
    changes: dict[str, dict[str, Any]] = {
        "LaserScan": {"settings": {"size_m": 0.05}},
        "Local": {"topic": "other/costmap"},
        "Odometry": {"settings": {"color": (1, 2, 3), "covariance": True}},
        "Routes": {"shown": True, "settings": {"namespaces": "c"}},
    }
    changed = [replace(each, **changes.get(each.name, {})) for each in found.displays]
    saved, after = _again(found, [each for each in changed if each.name != "Local Plan"])
    assert before.keys() - after.keys() == {"Local Plan"}
    assert saved["Window Geometry"] == yaml.safe_load(NAV2)["Window Geometry"]
    assert after["LaserScan"]["Size (Pixels)"] == 5
    assert after["Local"]["Topic"] == {**before["Local"]["Topic"], "Value": "other/costmap"}
    assert after["Local"]["Update Topic"]["Value"] == "other/costmap_updates"
    assert after["Odometry"]["Covariance"] == {"Position": {"Alpha": 0.3}, "Value": True}
    assert after["Odometry"]["Shape"]["Color"] == "1; 2; 3"
    assert after["Routes"]["Namespaces"] == {"a": True, "b": True, "c": False}
    shown = [name for name in ("Realsense", "Routes", "Camera", "Depth") if after[name]["Enabled"]]
    assert shown == ["Realsense", "Routes"]  # of a group that was off, that one alone
    for name in ("TF", "Swarm", "Bumper Hit", "RobotModel", "Student's own"):
        assert after[name] == before[name]


def test_a_display_that_was_added_is_saved_with_a_qos_that_fits(tmp_path: Path) -> None:
    found = _read(tmp_path, NAV2)
    own = DisplaySpec("PointCloud2", "mine", "my/points")
    mine = _again(found, [*found.displays, own])[1]["mine"]
    assert mine["Class"] == "rviz_default_plugins/PointCloud2"
    assert mine["Topic"]["Reliability Policy"] == "Best Effort"
    assert mine["Topic"]["Value"] == "my/points"


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
    assert (flat.fixed_frame, flat.unsupported) == (whole.fixed_frame, whole.unsupported)
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
