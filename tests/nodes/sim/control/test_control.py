"""An arm moves by the topics, actions and services of ros2_control and Gazebo."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from action_msgs.msg import GoalStatus
from control_msgs.action import FollowJointTrajectory, GripperCommand
from control_msgs.msg import JointTolerance
from controller_manager_msgs.srv import (
    ListControllers,
    ListHardwareComponents,
    ListHardwareInterfaces,
    LoadController,
    SwitchController,
    UnloadController,
)
from rclpy.action import ActionClient
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64, Float64MultiArray
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

from arjuna_core.files.shipped import shipped_file
from arjuna_core.ros.convert import duration_msg
from arjuna_core.ros.local.actions import LocalActionClient
from arjuna_sim.nodes.sim import SimNode
from tests.helpers.ros import RosBench
from tests.nodes.sim.running import run, start_sim
from tests.sim.arms import CONTROLLERS, JOINTS, write_arm

RESULT = FollowJointTrajectory.Result
POINTS = ((1.0, (1.0, 0.8, -0.5)), (2.5, (-1.2, 1.5, 1.0)), (4.0, (0.0, 0.0, 0.0)))


def start_arm(bench: RosBench, folder: Path, extra: str = "", managed: bool = True) -> SimNode:
    path = write_arm(folder, CONTROLLERS if managed else None, extra)
    world = str(shipped_file("worlds/empty.world"))
    return start_sim(bench, robot=str(path), world=world)


def trajectory(points: Any = POINTS, joints: Any = JOINTS, **fields: Any) -> JointTrajectory:
    made = [
        JointTrajectoryPoint(positions=at, time_from_start=duration_msg(time), **fields)
        for time, at in points
    ]
    return JointTrajectory(joint_names=joints, points=made)


class Follower:
    """Sends goals to the arm and waits for what becomes of them."""

    def __init__(self, bench: RosBench, sim: SimNode, action: Any, name: str) -> None:
        self._bench, self._sim = bench, sim
        kind: Any = ActionClient if bench.process.transport is None else LocalActionClient
        self._client = kind(bench.node, action, name)
        bench.process.drain()

    def send(self, goal: Any) -> Any:
        future = self._client.send_goal_async(goal)
        self._bench.process.drain()
        return future.result()

    def outcome(self, goal: Any, ticks: int = 300) -> tuple[int, Any]:
        handle = self.send(goal)
        assert handle.accepted
        result = handle.get_result_async()
        for _ in range(ticks):
            run(self._bench, self._sim, 1)
            if result.done():
                return result.result().status, result.result().result
        raise AssertionError("no result came")


def follower(bench: RosBench, sim: SimNode) -> Follower:
    return Follower(bench, sim, FollowJointTrajectory, "/arm_controller/follow_joint_trajectory")


def switch(bench: RosBench, on: list[str], off: list[str], strictness: int = 2) -> Any:
    request = SwitchController.Request(
        activate_controllers=on, deactivate_controllers=off, strictness=strictness
    )
    return bench.call(SwitchController, "/controller_manager/switch_controller", request)


def states(bench: RosBench) -> dict[str, str]:
    request = ListControllers.Request()
    answer = bench.call(ListControllers, "/controller_manager/list_controllers", request)
    return {one.name: one.state for one in answer.controller}


def at(messages: list[JointState]) -> dict[str, float]:
    return dict(zip(messages[-1].name, messages[-1].position, strict=True))


def test_trajectory_passes_each_point_within_a_hundredth(bench: RosBench, tmp_path: Path) -> None:
    sim = start_arm(bench, tmp_path)
    seen = bench.collect(JointState, "/joint_states")
    client = follower(bench, sim)
    begin = sim.now
    speeds = np.zeros(3)
    goal = FollowJointTrajectory.Goal(trajectory=trajectory(velocities=speeds))
    status, result = client.outcome(goal)
    assert (status, result.error_code) == (GoalStatus.STATUS_SUCCEEDED, RESULT.SUCCESSFUL)
    for time, wanted in POINTS:
        stamps = [m.header.stamp.sec + m.header.stamp.nanosec / 1e9 - begin for m in seen]
        message = seen[int(np.argmin(np.abs(np.array(stamps) - time)))]
        found = dict(zip(message.name, message.position, strict=True))
        assert [found[name] for name in JOINTS] == pytest.approx(wanted, abs=0.01)


def test_goals_that_cannot_be_followed_are_rejected(bench: RosBench, tmp_path: Path) -> None:
    client = follower(bench, start_arm(bench, tmp_path))
    one = ((1.0, (0.5,)),)
    for refused in (
        trajectory(one, ("shoulder",)),
        trajectory(((1.0, (0.1,) * 4),), (*JOINTS, "nobody")),
        trajectory(((1.0, (0.0,) * 3), (0.5, (0.0,) * 3))),
        trajectory(()),
        trajectory(((1.0, (float("nan"),) * 3),)),
    ):
        assert not client.send(FollowJointTrajectory.Goal(trajectory=refused)).accepted


def test_tolerances_end_a_goal(bench: RosBench, tmp_path: Path) -> None:
    client = follower(bench, start_arm(bench, tmp_path))
    goal = FollowJointTrajectory.Goal(trajectory=trajectory(((0.1, (2.0, 0.0, 0.0)),)))
    tolerance = JointTolerance(name="shoulder", position=0.05)
    goal.path_tolerance = [tolerance]
    status, result = client.outcome(goal)
    assert status == GoalStatus.STATUS_ABORTED
    assert result.error_code == RESULT.PATH_TOLERANCE_VIOLATED
    assert "shoulder" in result.error_string
    goal = FollowJointTrajectory.Goal(trajectory=trajectory(((0.5, (0.0, 9.0, 0.0)),)))
    status, result = client.outcome(goal)  # beyond the elbow's limit
    assert result.error_code == RESULT.GOAL_TOLERANCE_VIOLATED


def test_newer_goal_and_cancel_end_the_running_one(bench: RosBench, tmp_path: Path) -> None:
    sim = start_arm(bench, tmp_path)
    client = follower(bench, sim)
    first = client.send(FollowJointTrajectory.Goal(trajectory=trajectory()))
    ended = first.get_result_async()
    run(bench, sim, 20)
    second = client.send(FollowJointTrajectory.Goal(trajectory=trajectory()))
    run(bench, sim, 20)
    assert ended.result().status == GoalStatus.STATUS_ABORTED
    cancelled = second.get_result_async()
    second.cancel_goal_async()
    run(bench, sim, 5)
    assert cancelled.result().status == GoalStatus.STATUS_CANCELED
    seen = bench.collect(JointState, "/joint_states")
    run(bench, sim, 20)
    before = at(seen)
    run(bench, sim, 50)
    assert at(seen) == pytest.approx(before, abs=1e-3)


def test_a_goal_ends_where_its_joints_are_taken(bench: RosBench, tmp_path: Path) -> None:
    sim = start_arm(bench, tmp_path)
    running = follower(bench, sim).send(FollowJointTrajectory.Goal(trajectory=trajectory()))
    ended = running.get_result_async()
    run(bench, sim, 10)
    assert not switch(bench, ["positions", "nobody"], []).ok  # nothing has changed
    run(bench, sim, 10)
    assert not ended.done()
    assert switch(bench, ["positions"], []).ok
    run(bench, sim, 2)
    assert ended.result().status == GoalStatus.STATUS_ABORTED
    late = trajectory(POINTS[:1])
    late.header.stamp.nanosec = 1
    assert switch(bench, ["arm_controller"], ["positions"]).ok
    run(bench, sim, 100)
    _, result = follower(bench, sim).outcome(FollowJointTrajectory.Goal(trajectory=late))
    assert result.error_code == RESULT.OLD_HEADER_TIMESTAMP


def test_a_newer_trajectory_begins_with_the_motion(bench: RosBench, tmp_path: Path) -> None:
    sim = start_arm(bench, tmp_path)
    seen = bench.collect(JointState, "/joint_states")
    for position in (1.0, 2.0):
        path = trajectory(((2.0 * position, (position, 0.25, 0.0)),), velocities=[0.0] * 3)
        bench.publish(JointTrajectory, "/arm_controller/joint_trajectory", path)
        run(bench, sim, 50)
    speeds = [message.velocity[message.name.index("shoulder")] for message in seen[40:60]]
    assert min(speeds) > 0.5
    assert np.abs(np.diff(speeds)).max() < 0.1


def test_topic_moves_it_without_an_action(bench: RosBench, tmp_path: Path) -> None:
    sim = start_arm(bench, tmp_path)
    seen = bench.collect(JointState, "/joint_states")
    run(bench, sim, 1)
    assert at(seen)["elbow"] == pytest.approx(0.25, abs=1e-3)  # its initial_value
    bench.publish(JointTrajectory, "/arm_controller/joint_trajectory", trajectory(POINTS[:1]))
    run(bench, sim, 60)
    assert [at(seen)[name] for name in JOINTS] == pytest.approx(POINTS[0][1], abs=0.01)


def test_gripper_closes_and_its_other_finger_follows(bench: RosBench, tmp_path: Path) -> None:
    sim = start_arm(bench, tmp_path)
    seen = bench.collect(JointState, "/joint_states")
    gripper = Follower(bench, sim, GripperCommand, "/gripper/gripper_cmd")
    goal = GripperCommand.Goal()
    goal.command.position = 0.03
    status, result = gripper.outcome(goal)
    assert (status, result.reached_goal) == (GoalStatus.STATUS_SUCCEEDED, True)
    run(bench, sim, 30)
    assert (at(seen)["finger"], at(seen)["follower"]) == pytest.approx((0.03, 0.03), abs=1e-3)
    goal.command.position = 0.5  # beyond its limit: it stalls
    status, result = gripper.outcome(goal)
    assert (status, result.stalled) == (GoalStatus.STATUS_ABORTED, True)


def test_manager_lists_and_switches(bench: RosBench, tmp_path: Path) -> None:
    sim = start_arm(bench, tmp_path)
    first = states(bench)
    assert first == {
        **dict.fromkeys(CONTROLLERS, "active"),
        **dict.fromkeys(("positions", "speeds", "efforts"), "inactive"),
    }
    assert switch(bench, ["positions"], []).ok  # the arm's was only active for want of a choice
    assert states(bench) == first | {"positions": "active", "arm_controller": "inactive"}
    refused = switch(bench, ["arm_controller"], [])
    assert not refused.ok
    assert "positions" in refused.message
    assert states(bench)["positions"] == "active"
    seen = bench.collect(JointState, "/joint_states")
    command = Float64MultiArray(data=[0.5, -0.4, 0.3])
    bench.publish(Float64MultiArray, "/positions/commands", command)
    run(bench, sim, 60)
    assert [at(seen)[name] for name in JOINTS] == pytest.approx((0.5, -0.4, 0.3), abs=1e-3)
    assert switch(bench, ["speeds"], [], SwitchController.Request.FORCE_AUTO).ok
    assert (states(bench)["positions"], states(bench)["speeds"]) == ("inactive", "active")
    bench.publish(Float64MultiArray, "/speeds/commands", Float64MultiArray(data=[0.2, 0.0, 0.0]))
    run(bench, sim, 50)
    assert at(seen)["shoulder"] == pytest.approx(0.7, abs=0.01)
    assert not switch(bench, ["nobody"], []).ok
    assert switch(bench, ["nobody", "positions"], ["speeds"], 1).ok  # the best it can


def test_effort_lets_a_joint_fall_and_pushes_it(bench: RosBench, tmp_path: Path) -> None:
    sim = start_arm(bench, tmp_path)
    assert switch(bench, ["efforts"], ["arm_controller"]).ok
    seen = bench.collect(JointState, "/joint_states")
    run(bench, sim, 100)
    assert at(seen)["elbow"] == pytest.approx(0.25, abs=1e-3)  # nobody commands it: it holds
    assert abs(at(seen)["wrist"]) > 1.0
    bench.publish(Float64MultiArray, "/efforts/commands", Float64MultiArray(data=[5.0]))
    run(bench, sim, 50)
    assert at(seen)["wrist"] == pytest.approx(2.5, abs=0.1)


def test_controllers_are_unloaded_and_loaded(bench: RosBench, tmp_path: Path) -> None:
    start_arm(bench, tmp_path)

    def ask(kind: Any, name: str) -> bool:
        verb = {UnloadController: "unload", LoadController: "load"}[kind]
        service = f"/controller_manager/{verb}_controller"
        return bool(bench.call(kind, service, kind.Request(name=name)).ok)

    assert not ask(UnloadController, "arm_controller")  # it is active
    assert switch(bench, [], ["arm_controller"]).ok
    assert ask(UnloadController, "arm_controller")
    assert "arm_controller" not in states(bench)
    assert ask(LoadController, "arm_controller")
    assert states(bench)["arm_controller"] == "unconfigured"
    assert not ask(LoadController, "nobody")


def test_hardware_is_listed_with_what_is_claimed(bench: RosBench, tmp_path: Path) -> None:
    start_arm(bench, tmp_path)
    name = "/controller_manager/list_hardware_interfaces"
    answer = bench.call(ListHardwareInterfaces, name, ListHardwareInterfaces.Request())
    claimed = {one.name: one.is_claimed for one in answer.command_interfaces}
    assert claimed == {f"{joint}/position": True for joint in (*JOINTS, "finger")}
    name = "/controller_manager/list_hardware_components"
    answer = bench.call(ListHardwareComponents, name, ListHardwareComponents.Request())
    (component,) = answer.component
    assert component.name == "arm_system"
    assert component.plugin_name == "gz_ros2_control/GazeboSimSystem"


GZ = (
    "<gazebo><plugin filename='gz-sim-{file}-system' name='gz::sim::systems::{name}'>"
    "{tags}</plugin></gazebo>"
)


@pytest.mark.parametrize(
    ("name", "tags", "topic", "value", "ticks", "wanted"),
    [
        ("JointPositionController", "", "/model/arm/joint/elbow/_0/cmd_pos", 0.8, 60, 0.8),
        ("JointPositionController", "<topic>lift</topic>", "/lift", -0.8, 60, -0.8),
        ("JointController", "<sub_topic>go</sub_topic>", "/model/arm/go", 0.5, 100, 1.0),
    ],
)
def test_gazebos_plugins_move_a_joint(
    bench: RosBench,
    tmp_path: Path,
    name: str,
    tags: str,
    topic: str,
    value: float,
    ticks: int,
    wanted: float,
) -> None:
    tags = f"<joint_name>elbow</joint_name>{tags}"
    sim = start_arm(bench, tmp_path, GZ.format(file="x", name=name, tags=tags), managed=False)
    seen = bench.collect(JointState, "/joint_states")
    bench.publish(Float64, topic, Float64(data=value))
    run(bench, sim, ticks)
    assert at(seen)["elbow"] == pytest.approx(wanted, abs=0.02)


def test_gazebos_trajectories_and_forces_move_joints(bench: RosBench, tmp_path: Path) -> None:
    names = "".join(f"<joint_name>{name}</joint_name>" for name in JOINTS[:2])
    extra = GZ.format(file="joint-trajectory-controller", name="X", tags=names)
    force = "<joint_name>wrist</joint_name>"
    extra += GZ.format(file="apply-joint-force", name="X", tags=force)
    sim = start_arm(bench, tmp_path, extra, managed=False)
    seen = bench.collect(JointState, "/joint_states")
    message = trajectory(((1.0, (0.5, 0.2)),), JOINTS[:2])
    bench.publish(JointTrajectory, "/model/arm/joint_trajectory", message)
    bench.publish(Float64, "/model/arm/joint/wrist/cmd_force", Float64(data=-5.0))
    run(bench, sim, 350)  # of 4 ms: a force is a client's loop
    assert (at(seen)["shoulder"], at(seen)["elbow"]) == pytest.approx((0.5, 0.2), abs=0.01)
    assert at(seen)["wrist"] == pytest.approx(-2.5, abs=0.1)


def test_joint_states_are_those_that_the_file_lists(bench: RosBench, tmp_path: Path) -> None:
    tags = "<joint_name>wrist</joint_name><joint_name>elbow</joint_name>"
    tags += "<joint_name>foot</joint_name><update_rate>10</update_rate>"
    extra = GZ.format(file="joint-state-publisher", name="JointStatePublisher", tags=tags)
    sim = start_arm(bench, tmp_path, extra, managed=False)
    assert any("joint 'foot' does not move" in note for note in sim.simulator.notes)
    seen = bench.collect(JointState, "/joint_states")
    run(bench, sim, 50)
    assert [list(message.name) for message in seen] == [["wrist", "elbow"]] * 10
