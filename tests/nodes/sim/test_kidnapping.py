"""The robot is put elsewhere through a plain client, or that is refused."""

from __future__ import annotations

import math

import pytest
from geometry_msgs.msg import Quaternion
from simulation_interfaces.msg import Result
from simulation_interfaces.srv import (
    GetEntityState,
    SetEntityState,
)

from arjuna_core.se2 import SE2
from arjuna_sim.model.robot import SOLO
from tests.helpers.ros import RosBench
from tests.nodes.sim.running import OK, run, spawn, start_in, start_sim


def test_kidnap_by_set_entity_state_shows_in_truth_and_scan_only(bench: RosBench) -> None:
    sim = start_sim(bench)
    run(bench, sim, 5)
    request = SetEntityState.Request(entity="arjuna", set_pose=True)
    request.state.pose.position.x, request.state.pose.position.y = 1.0, 2.0
    response = bench.call(SetEntityState, "/set_entity_state", request)
    assert response.result.result == Result.RESULT_OK
    run(bench, sim, 1)
    state = bench.call(GetEntityState, "/get_entity_state", GetEntityState.Request(entity="robot"))
    assert state.result.result == Result.RESULT_OK
    assert (state.state.pose.position.x, state.state.pose.position.y) == pytest.approx(
        (1.0, 2.0), abs=1e-3
    )
    assert sim.last is not None
    assert sim.last.odometry.T_odom_base.distance(SE2()) < 1e-3


@pytest.mark.parametrize(
    ("entity", "x", "flags", "code", "words"),
    [
        (
            "nobody",
            0.0,
            {"set_pose": True},
            Result.RESULT_NOT_FOUND,
            "valid: arjuna, obstacle_blue",
        ),
        ("arjuna", 2.5, {"set_pose": True}, 101, "blocked by obstacle_red"),
        ("arjuna", math.nan, {"set_pose": True}, 101, "not finite"),
        ("arjuna", 1.0, {"set_twist": True}, Result.RESULT_FEATURE_UNSUPPORTED, "is a robot"),
        ("obstacle_red", 1.0, {"set_twist": True}, Result.RESULT_FEATURE_UNSUPPORTED, "freely"),
        (
            "arjuna",
            1.0,
            {"set_acceleration": True},
            Result.RESULT_FEATURE_UNSUPPORTED,
            "valid: set",
        ),
        ("arjuna", 1.0, {}, Result.RESULT_FEATURE_UNSUPPORTED, "valid: set_pose"),
    ],
)
def test_impossible_kidnap_is_refused_and_moves_nothing(
    bench: RosBench, entity: str, x: float, flags: dict[str, bool], code: int, words: str
) -> None:
    sim = start_sim(bench)
    request = SetEntityState.Request(entity=entity, **flags)
    request.state.pose.position.x = x
    response = bench.call(SetEntityState, "/set_entity_state", request)
    assert response.result.result == code
    assert words in response.result.error_message
    assert sim.simulator.robots[SOLO].truth().pose.distance(SE2()) < 1e-6


def test_what_moves_freely_is_given_a_velocity(bench: RosBench) -> None:
    """In the frame that is named, here that of something turned by a right angle."""
    sim = start_in(bench)
    turned = Quaternion(w=math.sqrt(0.5), z=math.sqrt(0.5))
    for name, uri, x in (("sign", "box:.1,.1,1", 4.0), ("ball", "sphere:0.2", 2.0)):
        spawn(bench, name, f"{uri}?mass=1" if name == "ball" else uri, x=x)
    request = SetEntityState.Request(entity="sign", set_pose=True)
    request.state.pose.position.x, request.state.pose.orientation = 4.0, turned
    assert bench.call(SetEntityState, "/set_entity_state", request).result.result == OK
    request = SetEntityState.Request(entity="ball", set_twist=True)
    request.state.header.frame_id = "sign"
    request.state.twist.linear.x, request.state.twist.angular.z = 1.0, 2.0
    response = bench.call(SetEntityState, "/set_entity_state", request)
    assert response.result.result == OK, response.result.error_message
    motion = sim.simulator.stage.motion("ball")
    assert motion.linear == pytest.approx((0.0, 1.0, 0.0), abs=1e-9)
    assert motion.angular == pytest.approx((0.0, 0.0, 2.0), abs=1e-9)
    run(bench, sim, 25)
    assert sim.simulator.stage.motion("ball").pose.position[1] > 0.1
