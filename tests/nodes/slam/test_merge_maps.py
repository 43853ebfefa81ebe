"""Saved graphs are put beside each other by hand, and become one map."""

from __future__ import annotations

from pathlib import Path

import pytest
from nav_msgs.msg import OccupancyGrid
from slam_toolbox.srv import AddSubmap, MergeMaps, SerializePoseGraph
from tf2_msgs.msg import TFMessage
from visualization_msgs.msg import InteractiveMarkerFeedback
from visualization_msgs.srv import GetInteractiveMarkers

from arjuna_core.ros import qos
from arjuna_core.ros.convert import grid_from_msg, pose_msg, se2_from_pose
from arjuna_core.se2 import SE2
from arjuna_slam.nodes.merge_maps import MergeMapsNode
from tests.helpers.slam_robot import Robot, started


def test_saved_graphs_become_one_map(robot: Robot, tmp_path: Path) -> None:
    mapper = started(robot, maps_folder=str(tmp_path))
    robot.drive(40)
    robot.call(SerializePoseGraph, "serialize_map", filename="room")
    mapper.trigger_deactivate()
    mapper.trigger_cleanup()
    bench = robot.bench
    node = MergeMapsNode(bench.process, {"maps_folder": str(tmp_path)})
    node.trigger_configure()
    node.trigger_activate()
    merged, second = (
        bench.collect(OccupancyGrid, name, qos.LATCHED) for name in ("/map", "/map_2")
    )
    frames = bench.collect(TFMessage, "/tf", qos.TF)
    robot.call(MergeMaps, "merge_submaps")
    for name in ("room", "nothing", "room.posegraph"):
        robot.call(AddSubmap, "add_submap", filename=name)
    assert second[-1].header.frame_id == "map_2"
    asked = GetInteractiveMarkers.Request()
    tool = "merge_maps_tool/get_interactive_markers"
    markers = bench.call(GetInteractiveMarkers, tool, asked).markers
    assert [one.name for one in markers] == ["1", "2"]
    robot.call(MergeMaps, "merge_submaps")
    above, walls = grid_from_msg(merged[-1]), list(second[-1].data).count(100)
    assert abs(above.frame.width - second[-1].info.width) <= 1
    beside = SE2(30.0, 0.0) @ se2_from_pose(markers[1].pose)
    moved = InteractiveMarkerFeedback(marker_name="2", pose=pose_msg(beside))
    moved.event_type = InteractiveMarkerFeedback.MOUSE_UP
    bench.publish(InteractiveMarkerFeedback, "merge_maps_tool/feedback", moved)
    bench.advance(0.2)
    placed = {one.child_frame_id: one.transform for one in frames[-1].transforms}
    assert placed["map_2"].translation.x - placed["map_1"].translation.x == pytest.approx(30.0)
    robot.call(MergeMaps, "merge_submaps")
    both = grid_from_msg(merged[-1])
    assert int((both.data == 100).sum()) == pytest.approx(2 * walls, rel=0.02)
    assert both.frame.width > above.frame.width + 25.0 / both.frame.resolution
