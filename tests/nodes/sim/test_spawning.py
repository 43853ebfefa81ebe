"""Spawning things and moving the robot."""

from __future__ import annotations

import math
from typing import Any

import pytest
from geometry_msgs.msg import Quaternion
from sensor_msgs.msg import LaserScan
from simulation_interfaces.msg import Resource, Result
from simulation_interfaces.msg import SpawnEntity as SpawnRequest
from simulation_interfaces.srv import (
    DeleteEntity,
    GetEntityState,
    GetSpawnables,
    SetEntityState,
    SpawnEntities,
    SpawnEntity,
)

from arjuna_core.ros import qos
from arjuna_core.se2 import SE2
from arjuna_sim.model.robot import SOLO
from tests.helpers.ros import RosBench
from tests.nodes.sim.running import OK, names, run, spawn, start_in, start_sim, state

CODES = SpawnEntity.Response
CRATE = """<sdf version="1.7"><model name="crate"><static>true</static><link name="l">
<collision name="c"><geometry><box><size>0.4 0.4 0.4</size></box></geometry></collision>
</link></model></sdf>"""


def test_resource_string_and_frames_of_other_entities_work(bench: RosBench) -> None:
    start_in(bench)
    assert spawn(bench, "one", uri="", text=CRATE).result.result == OK
    assert spawn(bench, "two", uri="", text=CRATE, x=1.0, frame="one").result.result == OK
    assert state(bench, "two").state.pose.position.x == pytest.approx(3.0)


def test_free_body_is_put_on_the_ground_not_into_it(bench: RosBench) -> None:
    sim = start_in(bench)
    text = CRATE.replace("<static>true</static>", "")  # its origin is its middle
    assert spawn(bench, "crate", uri="", text=text).result.result == OK
    assert state(bench, "crate").state.pose.position.z == pytest.approx(0.2)
    request = SetEntityState.Request(entity="crate", set_pose=True)
    request.state.pose.position.x = 3.0
    assert bench.call(SetEntityState, "/set_entity_state", request).result.result == OK
    run(bench, sim, 50)
    position = state(bench, "crate").state.pose.position
    assert (position.x, position.z) == pytest.approx((3.0, 0.2), abs=2e-3)


def test_names_are_unique_or_made_so(bench: RosBench) -> None:
    start_in(bench)
    assert spawn(bench, "crate").entity_name == "crate"
    assert spawn(bench, "crate", allow_renaming=True).entity_name == "crate_1"
    assert spawn(bench, "", allow_renaming=True).entity_name == "box"
    assert spawn(bench, "", uri="", text=CRATE, allow_renaming=True).entity_name == "crate_2"


IMPOSSIBLE: list[tuple[dict[str, Any], int, str]] = [
    ({"name": ""}, CODES.NAME_INVALID, "the name is empty"),
    ({"name": "a b"}, CODES.NAME_INVALID, "letters, digits"),
    ({"name": "arjuna"}, CODES.NAME_NOT_UNIQUE, "'arjuna' is taken"),
    ({"name": "a", "uri": ""}, CODES.NO_RESOURCE, "neither a uri"),
    ({"name": "a", "uri": "", "text": "mjcf"}, CODES.UNSUPPORTED_FORMAT, "neither <sdf>"),
    ({"name": "a", "uri": "a.usd"}, Result.RESULT_NOT_FOUND, "does not exist"),
    ({"name": "a", "uri": "/etc/passwd"}, Result.RESULT_OPERATION_FAILED, "lies outside"),
    ({"name": "a", "uri": "box:1"}, CODES.RESOURCE_PARSE_ERROR, "needs 3 finite"),
    ({"name": "a", "entity_namespace": "1/-"}, CODES.NAMESPACE_INVALID, "namespace '1/-'"),
    ({"name": "a", "x": math.nan}, CODES.INVALID_POSE, "not finite"),
    ({"name": "a", "x": 1e9}, CODES.INVALID_POSE, "farther than"),
    ({"name": "a", "x": 0.1}, CODES.INVALID_POSE, "would stand in the robot"),
    ({"name": "a", "frame": "mars"}, CODES.INVALID_POSE, "frame 'mars' is unknown"),
]


def test_impossible_spawns_have_their_codes_and_change_nothing(bench: RosBench) -> None:
    sim = start_in(bench)
    for fields, code, words in IMPOSSIBLE:
        response = spawn(bench, **fields)
        assert response.result.result == code
        assert words in response.result.error_message
    request = SpawnEntity.Request(name="a", entity_resource=Resource(uri="sphere:0.2"))
    request.initial_pose.pose.orientation.w = 0.0
    response = bench.call(SpawnEntity, "/spawn_entity", request)
    assert response.result.result == CODES.INVALID_POSE
    assert "is no rotation" in response.result.error_message
    assert names(bench) == ["arjuna"]
    run(bench, sim, 1)
    assert sim.simulator.time == 0.02


def test_several_are_spawned_at_once_each_with_its_result(bench: RosBench) -> None:
    start_in(bench)
    good = SpawnRequest(name="a", entity_resource=Resource(uri="sphere:0.2"))
    good.initial_pose.pose.position.x = 2.0
    bad = [SpawnRequest(name=name) for name in "bc"]
    request = SpawnEntities.Request(spawn_requests=[good, *bad])
    response = bench.call(SpawnEntities, "/spawn_entities", request)
    assert response.result.result == SpawnEntities.Response.ENTITIES_SPAWN_FAILED
    assert "2 of 3 entities were not spawned" in response.result.error_message
    assert [r.result.result for r in response.results] == [OK, *[CODES.NO_RESOURCE] * 2]
    assert names(bench) == ["arjuna", "a"]


def test_spawnables_can_all_be_spawned(bench: RosBench) -> None:
    start_in(bench)
    response = bench.call(GetSpawnables, "/get_spawnables", GetSpawnables.Request())
    assert response.result.result == OK
    for i, spawnable in enumerate(response.spawnables):
        uri = spawnable.entity_resource.uri
        assert spawn(bench, f"e{i}", uri=uri, x=3.0 + 2.0 * i).result.result == OK
    assert len(response.spawnables) >= 4


def test_same_requests_give_the_same_scans() -> None:
    def scans() -> list[bytes]:
        bench = RosBench()
        try:
            sim = start_in(bench, "arjuna_room.world")
            found = bench.collect(LaserScan, "/scan", qos.SENSOR_SUBSCRIPTION)
            for i in range(3):
                spawn(bench, f"e{i}", uri="box:0.3,0.3,0.5?mass=1", x=1.2 + i * 0.1)
                run(bench, sim, 10)
                request = DeleteEntity.Request(entity=f"e{i}")
                bench.call(DeleteEntity, "/delete_entity", request)
            return [bytes(scan.ranges) for scan in found]
        finally:
            bench.close()

    assert scans() == scans()


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


def test_impossible_kidnaps_are_refused_and_move_nothing(bench: RosBench) -> None:
    sim = start_sim(bench)
    unsupported = Result.RESULT_FEATURE_UNSUPPORTED
    for entity, x, flags, code, words in (
        ("nobody", 0.0, {"set_pose": True}, Result.RESULT_NOT_FOUND, "valid: arjuna, obstacle_bl"),
        ("arjuna", 2.5, {"set_pose": True}, 101, "blocked by obstacle_red"),
        ("arjuna", math.nan, {"set_pose": True}, 101, "not finite"),
        ("arjuna", 1.0, {"set_twist": True}, unsupported, "is a robot"),
        ("obstacle_red", 1.0, {"set_twist": True}, unsupported, "freely"),
        ("arjuna", 1.0, {"set_acceleration": True}, unsupported, "valid: set"),
        ("arjuna", 1.0, {}, unsupported, "valid: set_pose"),
    ):
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
