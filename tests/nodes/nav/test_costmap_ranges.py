"""Costmap nodes that listen to sonars instead of a lidar."""

from __future__ import annotations

import math

from geometry_msgs.msg import Quaternion, TransformStamped, Vector3
from sensor_msgs.msg import Range
from tf2_msgs.msg import TFMessage

from arjuna_core.ros import qos
from arjuna_core.ros.convert import header
from bringup.stack import LOCAL_COSTMAP
from tests.helpers.nav.costmaps import FREE, LETHAL, LOCAL, cost
from tests.helpers.nav.navigation import PlayedRobot


def made() -> PlayedRobot:
    layer = {
        "plugins": ["range_layer", "inflation_layer"],
        "range_layer.topics": ["/sonar"],
        "range_layer.no_readings_timeout": 0.8,
        "inflation_layer.enabled": False,
    }
    robot = PlayedRobot({f"{LOCAL}/{LOCAL}": layer})
    left = TransformStamped(child_frame_id="ear", header=header("base_link", 0.0))
    left.transform.translation = Vector3(x=0.1, y=0.0, z=0.1)
    left.transform.rotation = Quaternion(z=math.sqrt(0.5), w=math.sqrt(0.5))  # it looks to the left
    robot.bench.publish(TFMessage, "/tf_static", TFMessage(transforms=[left]), qos.TF_STATIC)
    robot.bring_up(LOCAL_COSTMAP)
    robot.send_map()
    robot.run(0.6)
    return robot


def hear(robot: PlayedRobot, distance: float, field_of_view: float = 0.3) -> None:
    """Send six readings."""
    for _ in range(6):
        reading = Range(
            header=header("ear", robot.now),
            field_of_view=field_of_view,
            min_range=0.1,
            max_range=3.0,
            range=distance,
        )
        robot.bench.publish(Range, "/sonar", reading, qos.SENSOR_PUBLISHER)
        robot.run(0.1)


def test_a_sonar_marks_what_it_hears_and_its_silence_is_reported(robot: PlayedRobot) -> None:
    hear(robot, 1.01)
    assert cost(robot, LOCAL, 0.12, 1.02) == LETHAL
    assert cost(robot, LOCAL, 0.12, 0.62) == FREE
    node = robot.nodes[f"{LOCAL}/{LOCAL}"]
    assert node.current(0.3) is not None
    robot.run(1.4)
    assert node.current(0.3) is None
    assert "no range on /sonar for" in node.why_not_current()


def test_a_sonar_without_a_cone_is_refused(robot: PlayedRobot) -> None:
    hear(robot, 1.01, field_of_view=0.0)
    assert cost(robot, LOCAL, 0.12, 1.02) == FREE
