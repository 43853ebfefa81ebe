"""Several robots of one simulator: each has topics of its own, and they come and go."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from geometry_msgs.msg import Twist
from nav_msgs.msg import Odometry
from rcl_interfaces.srv import GetParameters
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import LaserScan
from simulation_interfaces.srv import DeleteEntity, ResetSimulation, SpawnEntity
from std_msgs.msg import String
from tf2_msgs.msg import TFMessage

from arjuna_core.errors import ConfigError
from arjuna_core.ros import qos
from arjuna_core.ros.convert import seconds
from arjuna_sim.inputs import named_robot
from arjuna_sim.nodes.sim import SimNode
from tests.helpers.ros import RosBench
from tests.nodes.sim.running import OK, names, run, spawn, start_sim, state

CODES = SpawnEntity.Response
ROOT = Path(__file__).resolve().parents[3]
WORLD = str(ROOT / "worlds" / "empty.world")
BURGER = (ROOT / "urdf" / "burger.urdf").read_text(encoding="utf-8")
TWO = {"namespaces": ["a", "fleet/b"], "starts": [0.0, 0.0, 0.0, 2.0, 0.0, 3.0], "world": WORLD}


def start_two(bench: RosBench, **values: Any) -> SimNode:
    """Start two robots, 2 m apart."""
    return start_sim(bench, **{**TWO, **values})


def topics(bench: RosBench) -> set[str]:
    """Return the names of all topics that someone publishes."""
    found = {name for name, _ in bench.node.get_topic_names_and_types()}
    return {name for name in found if bench.node.count_publishers(name) > 0}


def delete(bench: RosBench, name: str) -> Any:
    """Ask to take an entity away; return the response."""
    return bench.call(DeleteEntity, "/delete_entity", DeleteEntity.Request(entity=name))


def test_each_robot_has_its_topics_below_its_namespace_alone(bench: RosBench) -> None:
    start_two(bench)
    found = topics(bench)
    own = {"scan", "odom", "imu/data", "joint_states", "tf", "tf_static", "robot_description"}
    for name in (*own, "clock", "ground_truth/odom", "ground_truth/contacts"):
        assert {f"/a/{name}", f"/fleet/b/{name}"} <= found
        assert f"/{name}" not in found - {"/clock"}
    assert bench.node.count_subscribers("/a/cmd_vel") == 1
    assert bench.node.count_subscribers("/cmd_vel") == 0


def test_a_tick_has_one_time_for_all(bench: RosBench) -> None:
    sim = start_two(bench)
    received = [
        bench.collect(Clock, f"{name}/clock", qos.LATEST) for name in ("", "/a", "/fleet/b")
    ]
    run(bench, sim, 3)
    assert [[seconds(c.clock) for c in clocks] for clocks in received] == [[0.02, 0.04, 0.06]] * 3


def test_a_command_moves_its_robot_and_its_transform_alone(bench: RosBench) -> None:
    sim = start_two(bench)
    moved = bench.collect(TFMessage, "/fleet/b/tf")
    stood = bench.collect(TFMessage, "/a/tf")
    for _ in range(50):
        bench.publish(Twist, "/fleet/b/cmd_vel", _forward(0.3), qos.LATEST)
        run(bench, sim, 1)
    last = {t.child_frame_id: t.transform.translation.x for m in moved for t in m.transforms}
    assert last["base_footprint"] > 0.15
    last = {t.child_frame_id: t.transform.translation.x for m in stood for t in m.transforms}
    assert abs(last["base_footprint"]) < 1e-3
    run(bench, sim, 50)  # the watchdog
    assert abs(sim.simulator.robots["fleet/b"].truth().v) < 1e-3


def _forward(speed: float) -> Twist:
    message = Twist()
    message.linear.x = speed
    return message


def test_the_robots_scans_show_each_other(bench: RosBench) -> None:
    sim = start_two(bench)
    scans = [bench.collect(LaserScan, f"/{name}/scan", qos.TF) for name in ("a", "fleet/b")]
    run(bench, sim, 10)
    for found in scans:
        assert found
        assert 1.5 < np.nanmin(np.array(found[-1].ranges)) < 2.0


def test_fused_odometry_is_each_robots_own(bench: RosBench) -> None:
    sim = start_two(bench, fused_odometry=True)
    odom = bench.collect(Odometry, "/a/odom")
    run(bench, sim, 10)
    assert {"/a/wheel_odom", "/fleet/b/wheel_odom"} <= topics(bench)
    assert len(odom) > 5
    assert (odom[-1].header.frame_id, odom[-1].child_frame_id) == ("odom", "base_footprint")


@pytest.mark.parametrize(("own", "fused"), [("way", "way"), ("wheel_odom", "odom")])
def test_fused_odometry_has_the_topic_of_the_robots_file(
    bench: RosBench, own: str, fused: str
) -> None:
    sim = start_sim(bench, world=WORLD, fused_odometry=True)
    renamed = f"<ros><remapping>odom:={own}</remapping></ros><left_joint>"
    text = BURGER.replace("<left_joint>", renamed, 1)
    assert spawn(bench, "bob", uri="", text=text, entity_namespace="/bob").result.result == OK
    odom = bench.collect(Odometry, f"/bob/{fused}")
    run(bench, sim, 10)
    assert "/bob/wheel_odom" in topics(bench)
    assert len(odom) > 5


def test_a_driving_robot_that_is_spawned_has_topics_until_it_is_deleted(bench: RosBench) -> None:
    sim = start_sim(bench, world=WORLD)
    before = topics(bench)
    answer = spawn(bench, "bob", uri="", text=BURGER, entity_namespace="/r/bob")
    assert answer.result.result == OK, answer.result.error_message
    described = bench.latched(String, "/r/bob/robot_description")
    odom = bench.collect(Odometry, "/r/bob/odom")
    bench.publish(Twist, "/r/bob/cmd_vel", _forward(0.2), qos.LATEST)
    run(bench, sim, 10)
    assert names(bench) == ["arjuna", "bob"]
    assert [seconds(message.header.stamp) for message in odom] == [0.04, 0.08, 0.1, 0.14, 0.18, 0.2]
    assert "burger" in described[0].data
    assert state(bench, "bob").state.pose.position.x > 2.005
    assert delete(bench, "bob").result.result == OK
    run(bench, sim, 5)
    assert len(odom) == 6
    assert topics(bench) - before == {"/r/bob/cmd_vel"}  # the test's own
    assert names(bench) == ["arjuna"]


@pytest.mark.parametrize("fused", [False, True])
def test_frames_that_a_file_puts_a_name_before_are_in_all_robots_transforms(
    fused: bool, bench: RosBench
) -> None:
    """As its robot_state_publisher's are, which has that name for a `frame_prefix`."""
    sim = start_sim(bench, world=WORLD, fused_odometry=fused)
    bench.node.create_publisher(String, "/bob/robot_description", qos.LATCHED)
    prefixed = BURGER.replace("<odometry_frame>odom", "<odometry_frame>bob/odom")
    prefixed = prefixed.replace("<robot_base_frame>base", "<robot_base_frame>bob/base")
    assert spawn(bench, "bob", uri="", text=prefixed).result.result == OK
    odom = bench.collect(Odometry, "/bob/odom")
    heard = [bench.collect(TFMessage, topic, qos.TF) for topic in ("/tf", "/bob/tf")]
    run(bench, sim, 5)
    assert odom[-1].child_frame_id == "bob/base_footprint"
    for found in heard:
        frames = {(t.header.frame_id, t.child_frame_id) for m in found for t in m.transforms}
        assert ("bob/odom", "bob/base_footprint") in frames


@pytest.mark.parametrize("shape", ['box size="0 0 0"', 'mesh filename="lost.stl"'])
def test_what_a_driving_robot_s_file_lacks_is_left_out_as_at_the_start(
    bench: RosBench, shape: str, capfd: pytest.CaptureFixture[str]
) -> None:
    """Of two robots of a launch file the one that was spawned first started, the other not."""
    start_sim(bench, world=WORLD)
    lacking = f'<link name="eye"><collision><geometry><{shape}/></geometry></collision></link>'
    joint = '<joint name="e" type="fixed"><parent link="base_link"/><child link="eye"/></joint>'
    text = BURGER.replace("</robot>", f"{lacking}{joint}</robot>")
    assert spawn(bench, "bob", uri="", text=text).result.result == OK
    assert "'bob': link 'eye' collision" in capfd.readouterr().err


def test_a_spawned_robot_s_file_can_be_asked_for(bench: RosBench) -> None:
    start_sim(bench, world=WORLD)
    assert spawn(bench, "bob", uri="", text=BURGER).result.result == OK
    asked = GetParameters.Request(names=["robot"])
    (value,) = bench.call(GetParameters, "/bob/simulated_robot/get_parameters", asked).values
    assert named_robot(value.string_value, "").urdf.name == "burger"


@pytest.mark.parametrize("described", [True, False])
def test_a_robot_of_the_start_is_described_as_it_is_said(described: bool, bench: RosBench) -> None:
    """A process that has just begun had not seen who describes it, and its frames were doubled."""
    start_sim(bench, world=WORLD, namespaces=("a", "b"), frames_of_file=described)
    assert spawn(bench, "bob", uri="", text=BURGER).result.result == OK
    wanted = {"a": not described, "b": not described, "bob": True}
    topics = {name: f"/{name}/robot_description" for name in wanted}
    assert {n: bool(bench.node.count_publishers(t)) for n, t in topics.items()} == wanted


@pytest.mark.parametrize(("described", "frame"), [(True, "base_scan"), (False, "base_scan_lds")])
def test_who_describes_a_robot_decides_its_frames(
    described: bool, frame: str, bench: RosBench
) -> None:
    """A robot_state_publisher of a launch file knows the frames of the file alone."""
    sim = start_sim(bench, world=WORLD)
    if described:
        bench.node.create_publisher(String, "/bob/robot_description", qos.LATCHED)
    raised = BURGER.replace('type="ray">', 'type="ray"><pose>0 0 0.1 0 0 0</pose>')
    assert spawn(bench, "bob", uri="", text=raised).result.result == OK
    assert bench.node.count_publishers("/bob/robot_description") == 1
    scans = bench.collect(LaserScan, "/bob/scan", qos.TF)
    run(bench, sim, 15)
    assert scans[-1].header.frame_id == frame


def test_a_robots_name_is_its_namespace_where_none_is_given(bench: RosBench) -> None:
    start_sim(bench, world=WORLD)
    assert spawn(bench, "bob", uri="", text=BURGER).result.result == OK
    assert "/bob/scan" in topics(bench)
    response = spawn(bench, "bob-2", uri="", text=BURGER, x=4.0)
    assert response.result.result == CODES.NAMESPACE_INVALID
    assert "'bob-2' cannot be one" in response.result.error_message
    response = spawn(bench, "eve", uri="", text=BURGER, x=4.0, entity_namespace="bob")
    assert response.result.result == CODES.NAMESPACE_INVALID
    assert "'/bob' is that of robot 'bob'" in response.result.error_message
    assert names(bench) == ["arjuna", "bob"]


def test_a_robot_is_not_spawned_into_another(bench: RosBench) -> None:
    sim = start_sim(bench, world=WORLD)
    response = spawn(bench, "bob", uri="", text=BURGER, x=0.1)
    assert response.result.result == CODES.INVALID_POSE
    assert "'bob' would stand in arjuna" in response.result.error_message
    assert "/bob/scan" not in topics(bench)
    run(bench, sim, 1)


def test_a_model_without_a_drive_is_a_thing_and_no_robot(bench: RosBench) -> None:
    start_sim(bench, world=WORLD)
    box = "<inertial><mass value='1'/></inertial><collision><geometry><box size='1 1 1'/>"
    urdf = f"<robot name='r'><link name='l'>{box}</geometry></collision></link></robot>"
    before = topics(bench)
    assert spawn(bench, "crate", uri="", text=urdf).result.result == OK
    assert topics(bench) == before


def test_robots_of_the_start_are_deleted_and_return_with_a_reset(bench: RosBench) -> None:
    sim = start_two(bench)
    spawn(bench, "bob", uri="", text=BURGER, x=4.0)
    assert delete(bench, "a").result.result == OK
    run(bench, sim, 2)
    assert names(bench) == ["fleet/b", "bob"]
    assert "/a/scan" not in topics(bench)
    reset = ResetSimulation.Request(scope=ResetSimulation.Request.SCOPE_ALL)
    assert bench.call(ResetSimulation, "/reset_simulation", reset).result.result == OK
    clocks = bench.collect(Clock, "/a/clock", qos.LATEST)
    run(bench, sim, 2)
    assert names(bench) == ["a", "fleet/b"]
    assert "/bob/scan" not in topics(bench)
    assert seconds(clocks[-1].clock) == 0.04


def test_two_robots_that_one_comes_to_repeat_themselves() -> None:
    def given() -> bytes:
        bench = RosBench()
        try:
            sim = start_two(bench)
            received = [
                bench.collect(kind, f"/{name}/{topic}", qos.TF)
                for name in ("a", "fleet/b", "bob")
                for kind, topic in ((LaserScan, "scan"), (Odometry, "odom"), (TFMessage, "tf"))
            ]
            for i in range(30):
                if i == 10:
                    assert spawn(bench, "bob", uri="", text=BURGER, x=4.0).result.result == OK
                if i == 20:
                    delete(bench, "a")
                for name in ("a", "fleet/b", "bob"):
                    bench.publish(Twist, f"/{name}/cmd_vel", _forward(0.2), qos.LATEST)
                run(bench, sim, 1)
            assert all(received)
            return repr(received).encode()
        finally:
            bench.close()

    assert given() == given()


@pytest.mark.parametrize(
    ("values", "problem"),
    [
        ({"namespaces": ["a", "/a/"]}, "namespace 'a' is given 2 times"),
        ({"namespaces": ["a", "1"]}, "'1' is no namespace; valid: as a or a/b"),
        ({"namespaces": ["a"], "robots": ["x", "y"]}, "2 robots and 1 namespaces"),
        ({"robots": ["x", "y"]}, "2 robots and 0 namespaces are given"),
        ({"namespaces": ["a"], "starts": [1.0]}, "1 numbers for the starts of 1 robots"),
    ],
)
def test_namespaces_must_be_unique(bench: RosBench, values: dict[str, Any], problem: str) -> None:
    with pytest.raises(ConfigError, match=problem):
        SimNode(bench.process, values)
