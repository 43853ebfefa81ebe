"""Claims: parameters, the lifecycle and the clock do to the amcl node what they say."""

from __future__ import annotations

import numpy as np
import pytest

pytest.importorskip("rclpy")
pytest.importorskip("nav2_msgs")

from rclpy.lifecycle import TransitionCallbackReturn
from rclpy.parameter import Parameter

from arjuna_core.errors import ConfigError
from arjuna_core.ros.convert import se2_from_pose
from arjuna_core.se2 import SE2
from arjuna_slam.nodes.amcl import AmclNode
from tests.helpers.amcl_room import Room, started
from tests.helpers.ros import RosBench
from tests.slam.amcl.room import Robot

pytestmark = pytest.mark.ros


def test_the_lifecycle_can_be_run_through_twice(room: Room) -> None:
    node = started(room)
    room.drive(2)
    for step in ("deactivate", "cleanup", "configure", "activate"):
        assert getattr(node, f"trigger_{step}")() == TransitionCallbackReturn.SUCCESS
        room.bench.process.drain()
    room.publish_map()
    count = len(room.poses)
    room.drive(3)
    assert len(room.poses) > count
    assert room.error[0] < 0.06


def test_an_inactive_node_neither_publishes_nor_broadcasts(room: Room) -> None:
    node = started(room)
    room.drive(2)
    node.trigger_deactivate()
    poses, transforms = len(room.poses), len(room.transforms)
    room.drive(5)
    assert (len(room.poses), len(room.transforms)) == (poses, transforms)
    node.trigger_activate()
    room.drive(30)
    assert room.error[0] < 0.08


def test_crossed_particle_limits_are_refused_at_the_start_and_at_run_time(room: Room) -> None:
    with pytest.raises(ConfigError, match="must not exceed max_particles"):
        AmclNode(room.bench.process, {"min_particles": 3000})
    node = started(room)
    (result,) = node.set_parameters([Parameter("min_particles", value=3000)])
    assert "min_particles (3000) must not exceed max_particles (2000)" in result.reason
    assert node.config.min_particles == node.get_parameter("min_particles").value == 500


def test_parameters_change_at_run_time_and_the_pose_stays(room: Room) -> None:
    node = started(room)
    room.drive(3)
    (result,) = node.set_parameters([Parameter("max_particles", value=800)])
    assert result.successful
    room.drive(3)
    assert room.error[0] < 0.06
    assert node.config.max_particles == 800
    (result,) = node.set_parameters([Parameter("laser_model_type", value="sonar")])
    assert not result.successful
    assert "likelihood_field" in result.reason


def test_after_the_clock_is_set_back_it_finds_itself_again(room: Room) -> None:
    started(room)
    room.drive(5)
    room.robot = Robot(np.random.default_rng(11))
    room.bench._ticks = 0
    room.drive(5)
    assert room.error[0] < 0.06


@pytest.mark.parametrize("mode", ["auto", "always", "never"])
def test_the_search_at_the_start_is_as_configured(room: Room, mode: str) -> None:
    wrong = {"x": 2.0, "y": -4.0, "yaw": 1.0}
    started(
        room,
        global_localization_at_start=mode,
        set_initial_pose=True,
        initial_pose=wrong,
        relocalize_patience=100.0,
    )
    room.drive(2)
    assert (room.error[0] < 0.06) == (mode == "always")


def test_the_pose_is_saved_at_its_rate_and_a_later_start_goes_on_from_there(room: Room) -> None:
    node = started(room, save_pose_rate=2.0, set_initial_pose=False)
    room.drive(12)
    saved = node.config.initial_pose
    assert SE2(saved.x, saved.y).distance(room.robot.pose) < 0.5
    belief = node._filter
    room.drive(6)
    assert node._filter is belief  # saving builds nothing anew
    assert (saved.x, saved.y) != (node.config.initial_pose.x, node.config.initial_pose.y)


def test_parameters_can_give_the_initial_pose(room: Room) -> None:
    pose = room.robot.pose
    start = {"x": pose.x, "y": pose.y, "yaw": pose.theta}
    started(room, set_initial_pose=True, initial_pose=start, relocalize=False)
    room.drive(2)
    assert room.error[0] < 0.06


def test_tf_broadcast_can_be_switched_off(room: Room) -> None:
    started(room, tf_broadcast=False)
    room.drive(3)
    assert room.transforms == []
    assert room.poses


def newest_pose(room: Room) -> SE2:
    return se2_from_pose(room.poses[-1].pose.pose)


def test_two_runs_are_the_same_to_the_byte() -> None:
    def trace() -> bytes:
        bench = RosBench()
        room = Room(bench)
        started(room)
        room.drive(20)
        values = np.array([newest_pose(room).array(), room.poses[-1].pose.covariance[:3]])
        bench.close()
        return values.tobytes()

    assert trace() == trace()
