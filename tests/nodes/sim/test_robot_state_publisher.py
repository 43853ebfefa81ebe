"""The node robot_state_publisher: the description, fixed frames and turning wheels."""

from __future__ import annotations

import math

import pytest
from rclpy.parameter import Parameter
from sensor_msgs.msg import JointState
from std_msgs.msg import String
from tf2_msgs.msg import TFMessage

from arjuna_core.ros import qos
from arjuna_core.ros.convert import header
from arjuna_sim.nodes.robot_state_publisher import RobotStatePublisherNode
from tests.helpers.ros import RosBench
from tests.nodes.sim.running import run, start, start_sim


def test_description_and_fixed_frames_are_latched(bench: RosBench) -> None:
    description = bench.collect(String, "/robot_description", qos.LATCHED)
    static = bench.collect(TFMessage, "/tf_static", qos.TF_STATIC)
    start(bench, RobotStatePublisherNode(bench.process))
    assert description[0].data.startswith("<?xml")
    children = {t.child_frame_id: t for t in static[0].transforms}
    links = ["base_link", "camera_link", "imu_link", "lidar_link"]
    assert sorted(children) == sorted([*links, "camera_link_optical_frame"])
    optical = children["camera_link_optical_frame"]
    assert optical.header.frame_id == "camera_link"
    q = optical.transform.rotation
    assert (q.x, q.y, q.z, q.w) == pytest.approx((-0.5, 0.5, -0.5, 0.5))
    assert children["lidar_link"].header.frame_id == "base_link"
    assert children["lidar_link"].transform.translation.z == pytest.approx(0.2)


def test_wheels_turn_in_tf_at_most_at_the_publish_frequency(bench: RosBench) -> None:
    sim = start_sim(bench)
    start(bench, RobotStatePublisherNode(bench.process))
    messages = bench.collect(TFMessage, "/tf")
    run(bench, sim, 50)
    wheels = [m for m in messages if m.transforms[0].child_frame_id.endswith("_wheel")]
    assert 18 <= len(wheels) <= 21
    assert len(wheels[0].transforms) == 4
    rotation = wheels[0].transforms[0].transform.rotation
    assert rotation.x == pytest.approx(-math.sqrt(0.5), abs=0.01)


def test_whole_tree_connects_odom_to_the_lidar(bench: RosBench) -> None:
    sim = start_sim(bench)
    start(bench, RobotStatePublisherNode(bench.process))
    run(bench, sim, 5)
    assert bench.process.transforms.try_lookup("odom", "lidar_link") is not None


ARM = """<robot name="arm"><link name="base"/><link name="a"/><link name="b"/>
  <joint name="j" type="continuous"><parent link="base"/><child link="a"/>
    <axis xyz="0 0 1"/></joint>
  <joint name="k" type="continuous"><parent link="a"/><child link="b"/><axis xyz="0 0 1"/>
    <mimic joint="j" multiplier="2"/></joint>
</robot>"""


def test_a_descriptions_text_a_prefix_and_mimic_joints(bench: RosBench) -> None:
    description = bench.collect(String, "/robot_description", qos.LATCHED)
    moving = bench.collect(TFMessage, "/tf")
    values = {"robot_description": ARM, "frame_prefix": "left/"}
    node = start(bench, RobotStatePublisherNode(bench.process, values))
    bench.publish(JointState, "joint_states", JointState(name=["j"], position=[math.pi / 2]))
    assert description[-1].data == ARM
    children = {t.child_frame_id: t for t in moving[-1].transforms}
    assert sorted(children) == ["left/a", "left/b"]
    assert children["left/b"].header.frame_id == "left/a"
    assert abs(children["left/b"].transform.rotation.z) == pytest.approx(1.0)
    (result,) = node.set_parameters([Parameter("robot_description", value="<robot/>")])
    assert not result.successful
    (result,) = node.set_parameters([Parameter("robot_description", value=ARM + "\n")])
    assert result.successful, result.reason
    bench.process.drain()
    assert description[-1].data == ARM + "\n"


SDF = """<?xml version="1.0"?><sdf version="1.8"><model name="arm"><link name="base"/>
  <link name="fixed"><pose>1 0 0.5 0 0 0</pose></link><link name="a"><pose>0 2 0 0 0 0</pose></link>
  <joint name="f" type="fixed"><parent>base</parent><child>fixed</child></joint>
  <joint name="j" type="revolute"><parent>base</parent><child>a</child>
    <axis><xyz>0 0 1</xyz><limit><lower>-inf</lower><upper>inf</upper></limit></axis></joint>
</model></sdf>"""


def test_the_description_may_be_an_sdf_model(bench: RosBench) -> None:
    description = bench.collect(String, "/robot_description", qos.LATCHED)
    static = bench.collect(TFMessage, "/tf_static", qos.TF_STATIC)
    moving = bench.collect(TFMessage, "/tf")
    start(bench, RobotStatePublisherNode(bench.process, {"robot_description": SDF}))
    bench.publish(JointState, "joint_states", JointState(name=["j"], position=[math.pi]))
    assert description[-1].data == SDF
    (fixed,), (turned,) = static[-1].transforms, moving[-1].transforms
    assert (fixed.header.frame_id, fixed.child_frame_id) == ("base", "fixed")
    assert (fixed.transform.translation.x, fixed.transform.translation.z) == (1.0, 0.5)
    assert (turned.child_frame_id, turned.transform.translation.y) == ("a", 2.0)
    assert abs(turned.transform.rotation.z) == pytest.approx(1.0)


@pytest.mark.parametrize(("ignore", "count"), [(False, 1), (True, 2)])
def test_older_joint_states_are_dropped(bench: RosBench, ignore: bool, count: int) -> None:
    moving = bench.collect(TFMessage, "/tf")
    values = {"robot_description": ARM, "ignore_timestamp": ignore, "publish_frequency": 1000.0}
    start(bench, RobotStatePublisherNode(bench.process, values))
    for stamp in (2.0, 1.0):
        message = JointState(header=header("", stamp), name=["j"], position=[0.0])
        bench.publish(JointState, "joint_states", message)
    assert len(moving) == count


def test_the_frame_of_the_ground_truth_is_in_the_tree(bench: RosBench) -> None:
    static = bench.collect(TFMessage, "/tf_static", qos.TF_STATIC)
    start_sim(bench)
    (transform,) = static[0].transforms
    assert (transform.header.frame_id, transform.child_frame_id) == ("world", "map")
