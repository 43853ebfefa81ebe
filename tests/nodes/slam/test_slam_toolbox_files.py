"""Graphs are saved, loaded and resumed as by slam_toolbox's services."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import pytest
from geometry_msgs.msg import Pose2D, PoseWithCovariance, PoseWithCovarianceStamped
from nav_msgs.srv import GetMap
from rclpy.lifecycle import TransitionCallbackReturn
from slam_toolbox.srv import DeserializePoseGraph, Reset, SaveMap, SerializePoseGraph
from std_msgs.msg import String
from std_srvs.srv import Empty

from arjuna_core.files.maps import load_map
from arjuna_core.ros.convert import pose_msg
from arjuna_core.se2 import SE2
from arjuna_slam.localization import Localizer
from arjuna_slam.nodes.slam_toolbox import SlamToolboxNode
from tests.helpers.slam_robot import LOG, Robot, started

OK = SerializePoseGraph.Response.RESULT_SUCCESS
FAILED = SerializePoseGraph.Response.RESULT_FAILED_TO_WRITE_FILE
Request = DeserializePoseGraph.Request


@pytest.fixture
def saved(robot: Robot, tmp_path: Path) -> SlamToolboxNode:
    """A node that has mapped and saved `room.posegraph`; the robot stands elsewhere by now."""
    node = started(robot, maps_folder=str(tmp_path))
    robot.drive(70)
    assert robot.call(SerializePoseGraph, "serialize_map", filename="room").result == OK
    return node


def again(robot: Robot, k: int) -> None:
    """Carry the robot back to a place of its drive."""
    robot.k = k
    robot.poses.clear()


def test_a_graph_is_saved_inside_the_open_folders_only(robot: Robot, tmp_path: Path) -> None:
    started(robot, maps_folder=str(tmp_path / "maps"))
    assert robot.call(SerializePoseGraph, "serialize_map", filename="a").result == FAILED
    robot.drive(5)
    assert robot.call(SerializePoseGraph, "serialize_map", filename="../a").result == FAILED
    assert list(tmp_path.rglob("*.posegraph")) == []
    assert robot.call(SerializePoseGraph, "serialize_map", filename="sub/a").result == OK
    assert (tmp_path / "maps/sub/a.posegraph").is_file()
    assert robot.call(SerializePoseGraph, "serialize_map", filename="").result == OK
    assert (tmp_path / "maps/.posegraph").is_file()  # as slam_toolbox has it


@pytest.fixture
def home(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The user's home, with a working folder in it."""
    (tmp_path / "home/work").mkdir(parents=True)
    monkeypatch.setenv("HOME", str(tmp_path / "home"))
    monkeypatch.chdir(tmp_path / "home/work")
    return tmp_path / "home"


@pytest.mark.parametrize("name", ["{home}/maps/room", "~/room", "../room", "room", "a.b/room"])
def test_maps_and_graphs_go_to_any_path_of_the_home(robot: Robot, home: Path, name: str) -> None:
    node = started(robot)
    robot.drive(20)
    name = name.format(home=home)
    for _ in range(2):  # over what was saved before, too
        saved = robot.call(SaveMap, "save_map", name=String(data=name)).result
        assert saved == SaveMap.Response.RESULT_SUCCESS
        assert robot.call(SerializePoseGraph, "serialize_map", filename=name).result == OK
    (map_file,) = home.rglob("room.yaml")
    assert (load_map(map_file).data == 100).sum() > 100
    count = len(node.slam.graph)
    robot.call(Reset, "reset")
    fields = {"filename": name, "match_type": Request.START_AT_FIRST_NODE}
    robot.call(DeserializePoseGraph, "deserialize_map", **fields)
    assert len(node.slam.graph) == count


def test_a_map_without_a_name_is_named_as_map_saver_does(robot: Robot, home: Path) -> None:
    started(robot)
    robot.drive(20)
    assert robot.call(SaveMap, "save_map").result == SaveMap.Response.RESULT_SUCCESS
    assert sorted(path.name for path in (home / "work").iterdir()) == ["map_2.pgm", "map_2.yaml"]
    robot.call(DeserializePoseGraph, "deserialize_map", match_type=Request.START_AT_FIRST_NODE)
    robot.drive(5)
    assert robot.error() < 0.03


@pytest.mark.parametrize("name", ["/etc/room", "{home}/../room", "~/.config/room", "~/link/room"])
def test_nothing_is_saved_elsewhere(robot: Robot, home: Path, name: str) -> None:
    (home / "link").symlink_to(home.parent)
    before = sorted(home.parent.rglob("*"))
    started(robot)
    robot.drive(5)
    name = name.format(home=home)
    refused = SaveMap.Response.RESULT_UNDEFINED_FAILURE
    assert robot.call(SaveMap, "save_map", name=String(data=name)).result == refused
    assert robot.call(SerializePoseGraph, "serialize_map", filename=name).result == FAILED
    assert sorted(home.parent.rglob("*")) == before


@pytest.mark.parametrize("ending", ["yaml", "pgm", "posegraph"])
def test_a_file_of_something_else_is_not_overwritten(robot: Robot, home: Path, ending: str) -> None:
    (home / f"notes.{ending}").write_text("name: mine\n")
    started(robot)
    robot.drive(5)
    saved = robot.call(SaveMap, "save_map", name=String(data="~/notes")).result
    graph = robot.call(SerializePoseGraph, "serialize_map", filename="~/notes").result
    assert (saved == SaveMap.Response.RESULT_UNDEFINED_FAILURE) == (ending != "posegraph")
    assert (graph == FAILED) == (ending == "posegraph")
    assert (home / f"notes.{ending}").read_text() == "name: mine\n"


@pytest.mark.parametrize(
    ("match_type", "at", "pose"),
    [
        (Request.START_AT_FIRST_NODE, 1, SE2()),
        (Request.START_AT_GIVEN_POSE, 50, LOG[0][2].inverse() @ LOG[50][2] @ SE2(0.3, 0.2, 0.2)),
        (Request.LOCALIZE_AT_POSE, 50, LOG[0][2].inverse() @ LOG[50][2] @ SE2(0.3, 0.2, 0.2)),
        (Request.UNSET, 30, SE2()),
    ],
)
def test_each_match_type_finds_the_robot(
    robot: Robot, saved: SlamToolboxNode, match_type: int, at: int, pose: SE2
) -> None:
    nodes = len(saved.slam.graph)
    initial = Pose2D(x=pose.x, y=pose.y, theta=pose.theta)
    assert robot.call(Reset, "reset").result == 0
    again(robot, at)
    fields = {"filename": "room", "match_type": match_type, "initial_pose": initial}
    robot.call(DeserializePoseGraph, "deserialize_map", **fields)
    assert len(saved.slam.graph) == nodes
    robot.drive(15)
    assert len(robot.poses) == 15
    assert robot.error() < 0.03
    localizes = match_type == Request.LOCALIZE_AT_POSE
    assert isinstance(saved.slam, Localizer) == localizes
    assert (len(saved.slam.graph) > nodes) != localizes
    assert 100 in robot.call(GetMap, "dynamic_map").map.data


def test_slam_toolbox_needs_a_start(robot: Robot, saved: SlamToolboxNode, tmp_path: Path) -> None:
    saved.trigger_deactivate()
    saved.trigger_cleanup()
    again(robot, 20)
    node = started(robot, maps_folder=str(tmp_path), start_anywhere=False)
    before = node.slam
    robot.call(DeserializePoseGraph, "deserialize_map", filename="room", match_type=Request.UNSET)
    assert node.slam is before


def test_localization_buffers_clear(robot: Robot, saved: SlamToolboxNode, tmp_path: Path) -> None:
    saved.trigger_deactivate()
    saved.trigger_cleanup()
    again(robot, 0)
    files = {"maps_folder": str(tmp_path), "map_file_name": "room", "map_start_at_dock": True}
    node = started(robot, mode="localization", scan_buffer_size=5, **files)
    plain = node.slam.session()
    robot.drive(60)
    shown = np.array(robot.maps[-1].data).tobytes()
    robot.call(Empty, "clear_localization_buffer")
    robot.drive(1)
    robot.bench.advance(1.5)
    assert np.array(robot.maps[-1].data).tobytes() != shown
    assert node.slam.session() is plain


@pytest.mark.parametrize("filename", ["none", "../room", "broken", "pipe", "zero", "hole"])
def test_a_graph_that_cannot_be_loaded_changes_nothing(
    robot: Robot, saved: SlamToolboxNode, tmp_path: Path, filename: str
) -> None:
    (tmp_path / "broken.posegraph").write_bytes((tmp_path / "room.posegraph").read_bytes()[:-9])
    os.mkfifo(tmp_path / "pipe.posegraph")
    (tmp_path / "zero.posegraph").symlink_to("/dev/zero")
    (tmp_path / "hole.posegraph").touch()
    os.truncate(tmp_path / "hole.posegraph", 100 << 30)
    before = saved.slam
    fields = {"filename": filename, "match_type": Request.START_AT_FIRST_NODE}
    robot.call(DeserializePoseGraph, "deserialize_map", **fields)
    robot.call(DeserializePoseGraph, "deserialize_map", filename="room", match_type=9)
    assert saved.slam is before
    robot.drive(5)
    assert robot.error() < 0.03


def test_a_graph_may_be_a_parameter(robot: Robot, saved: SlamToolboxNode, tmp_path: Path) -> None:
    saved.trigger_deactivate()
    saved.trigger_cleanup()
    again(robot, 20)
    pose = LOG[0][2].inverse() @ LOG[20][2]
    node = started(
        robot,
        mode="localization",
        maps_folder=str(tmp_path),
        map_file_name="room",
        map_start_pose=(pose.x, pose.y, pose.theta),
    )
    robot.drive(10)
    assert isinstance(node.slam, Localizer)
    assert robot.error() < 0.03
    again(robot, 60)
    placed = LOG[0][2].inverse() @ LOG[60][2] @ SE2(0.2, 0.2, -0.2)
    message = PoseWithCovarianceStamped(pose=PoseWithCovariance(pose=pose_msg(placed)))
    robot.bench.publish(PoseWithCovarianceStamped, "/initialpose", message)
    robot.drive(5)
    assert robot.error() < 0.03
    robot.call(Empty, "clear_localization_buffer")
    assert robot.call(SerializePoseGraph, "serialize_map", filename="same").result == OK
    same, first = tmp_path / "same.posegraph", tmp_path / "room.posegraph"
    assert same.read_bytes() == first.read_bytes()


def test_missing_graphs_are_refused(robot: Robot, saved: SlamToolboxNode, tmp_path: Path) -> None:
    for values in (
        {"map_file_name": "none"},
        {"map_file_name": "room", "map_start_pose": (1.0, 2.0)},
    ):
        node = SlamToolboxNode(robot.bench.process, {"maps_folder": str(tmp_path), **values})
        assert node.trigger_configure() == TransitionCallbackReturn.FAILURE


def test_the_map_saver_is_offered_unless_unwanted(robot: Robot, tmp_path: Path) -> None:
    started(robot, use_map_saver=False, maps_folder=str(tmp_path))
    robot.drive(2)
    with pytest.raises(AssertionError, match="did not answer"):
        robot.call(SaveMap, "save_map", name=String(data="room"))
