"""Entities through a plain client: spawned, moved, listed and deleted, with the right codes."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import pytest

pytest.importorskip("rclpy", reason="no ROS here")

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from geometry_msgs.msg import Twist, Vector3
from sensor_msgs.msg import LaserScan
from simulation_interfaces.msg import (
    Bounds,
    EntityCategory,
    EntityFilters,
    EntityInfo,
    Resource,
    Result,
    TagsFilter,
)
from simulation_interfaces.msg import SpawnEntity as SpawnRequest
from simulation_interfaces.srv import (
    DeleteEntity,
    GetEntities,
    GetEntitiesStates,
    GetEntityBounds,
    GetEntityInfo,
    GetEntityState,
    GetSpawnables,
    SetEntityInfo,
    SetEntityState,
    SpawnEntities,
    SpawnEntity,
)

from arjuna_core.files.shipped import resource
from arjuna_core.ros import qos
from arjuna_sim.nodes.sim import SimNode
from tests.helpers.ros import RosBench

pytestmark = pytest.mark.ros
OK = Result.RESULT_OK
CODES = SpawnEntity.Response
CRATE = """<sdf version="1.7"><model name="crate"><static>true</static><link name="l">
<collision name="c"><geometry><box><size>0.4 0.4 0.4</size></box></geometry></collision>
</link></model></sdf>"""


@pytest.fixture
def bench() -> Iterator[RosBench]:
    bench = RosBench()
    yield bench
    bench.close()


def _sim(bench: RosBench, world: str = "empty.world") -> SimNode:
    node = SimNode(bench.process, {"world": str(resource(f"worlds/{world}"))})
    node.trigger_configure()
    node.trigger_activate()
    bench.process.drain()
    return node


def _run(bench: RosBench, sim: SimNode, ticks: int) -> None:
    for _ in range(ticks):
        sim.tick()
        bench.process.drain()


def _spawn(
    bench: RosBench,
    name: str,
    uri: str = "box:0.4,0.4,1",
    x: float = 2.0,
    text: str = "",
    frame: str = "",
    **fields: Any,
) -> Any:
    request = SpawnEntity.Request(name=name, **fields)
    request.entity_resource = Resource(uri=uri, resource_string=text)
    request.initial_pose.header.frame_id = frame
    request.initial_pose.pose.position.x = x
    return bench.call(SpawnEntity, "/spawn_entity", request)


def _names(bench: RosBench, filters: EntityFilters | None = None) -> list[str]:
    request = GetEntities.Request(filters=filters or EntityFilters())
    response = bench.call(GetEntities, "/get_entities", request)
    assert response.result.result == OK, response.result.error_message
    return list(response.entities)


def _state(bench: RosBench, name: str) -> Any:
    request = GetEntityState.Request(entity=name)
    return bench.call(GetEntityState, "/get_entity_state", request)


def test_box_is_spawned_seen_moved_and_deleted(bench: RosBench) -> None:
    sim = _sim(bench)
    scans = bench.collect(LaserScan, "/scan", qos.SENSOR_SUBSCRIPTION)

    def ahead() -> float:
        _run(bench, sim, 5)
        return float(scans[-1].ranges[180])

    assert math.isinf(ahead())
    response = _spawn(bench, "crate")
    assert (response.result.result, response.entity_name) == (OK, "crate")
    seen = ahead()
    assert 1.5 < seen < 2.0
    assert _names(bench) == ["arjuna", "crate"]
    request = SetEntityState.Request(entity="crate", set_pose=True)
    request.state.pose.position.x = 3.0
    assert bench.call(SetEntityState, "/set_entity_state", request).result.result == OK
    assert ahead() == pytest.approx(seen + 1.0, abs=0.1)
    state = _state(bench, "crate").state
    assert (state.header.frame_id, state.pose.position.x) == ("world", 3.0)
    gone = bench.call(DeleteEntity, "/delete_entity", DeleteEntity.Request(entity="crate"))
    assert gone.result.result == OK
    assert math.isinf(ahead())
    assert _names(bench) == ["arjuna"]


def test_resource_string_and_frames_of_other_entities_work(bench: RosBench) -> None:
    _sim(bench)
    assert _spawn(bench, "one", uri="", text=CRATE).result.result == OK
    assert _spawn(bench, "two", uri="", text=CRATE, x=1.0, frame="one").result.result == OK
    assert _state(bench, "two").state.pose.position.x == pytest.approx(3.0)


def test_free_body_is_put_on_the_ground_not_into_it(bench: RosBench) -> None:
    sim = _sim(bench)
    text = CRATE.replace("<static>true</static>", "")  # its origin is its middle
    assert _spawn(bench, "crate", uri="", text=text).result.result == OK
    assert _state(bench, "crate").state.pose.position.z == pytest.approx(0.2)
    request = SetEntityState.Request(entity="crate", set_pose=True)
    request.state.pose.position.x = 3.0
    assert bench.call(SetEntityState, "/set_entity_state", request).result.result == OK
    _run(bench, sim, 50)
    position = _state(bench, "crate").state.pose.position
    assert (position.x, position.z) == pytest.approx((3.0, 0.2), abs=2e-3)


def test_names_are_unique_or_made_so(bench: RosBench) -> None:
    _sim(bench)
    assert _spawn(bench, "crate").entity_name == "crate"
    assert _spawn(bench, "crate", allow_renaming=True).entity_name == "crate_1"
    assert _spawn(bench, "", allow_renaming=True).entity_name == "box"
    assert _spawn(bench, "", uri="", text=CRATE, allow_renaming=True).entity_name == "crate_2"


@pytest.mark.parametrize(
    ("fields", "code", "words"),
    [
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
        ({"name": "a", "x": 1e9}, CODES.INVALID_POSE, "farther than 10000 m"),
        ({"name": "a", "x": 0.1}, CODES.INVALID_POSE, "would stand in the robot"),
        ({"name": "a", "frame": "mars"}, CODES.INVALID_POSE, "frame 'mars' is unknown"),
    ],
)
def test_impossible_spawn_has_its_code_and_changes_nothing(
    bench: RosBench, fields: dict[str, Any], code: int, words: str
) -> None:
    sim = _sim(bench)
    response = _spawn(bench, **fields)
    assert response.result.result == code
    assert words in response.result.error_message
    assert _names(bench) == ["arjuna"]
    _run(bench, sim, 1)
    assert sim.simulator.time == 0.02


def test_zero_quaternion_is_an_invalid_pose(bench: RosBench) -> None:
    _sim(bench)
    request = SpawnEntity.Request(name="a", entity_resource=Resource(uri="sphere:0.2"))
    request.initial_pose.pose.orientation.w = 0.0
    response = bench.call(SpawnEntity, "/spawn_entity", request)
    assert response.result.result == CODES.INVALID_POSE
    assert "is no rotation" in response.result.error_message


def test_several_are_spawned_at_once_each_with_its_result(bench: RosBench) -> None:
    _sim(bench)
    good = SpawnRequest(name="a", entity_resource=Resource(uri="sphere:0.2"))
    good.initial_pose.pose.position.x = 2.0
    request = SpawnEntities.Request(spawn_requests=[good, SpawnRequest(name="b")])
    response = bench.call(SpawnEntities, "/spawn_entities", request)
    assert response.result.result == SpawnEntities.Response.ENTITIES_SPAWN_FAILED
    assert [r.result.result for r in response.results] == [OK, CODES.NO_RESOURCE]
    assert _names(bench) == ["arjuna", "a"]


def test_filters_by_name_category_tags_and_bounds(bench: RosBench) -> None:
    _sim(bench, "arjuna_room.world")
    _spawn(bench, "near", uri="sphere:0.1", x=1.0)
    assert _names(bench, EntityFilters(filter="^obstacle_(red|blue)$")) == [
        "obstacle_red",
        "obstacle_blue",
    ]
    robots = EntityFilters(categories=[EntityCategory(category=EntityCategory.CATEGORY_ROBOT)])
    assert _names(bench, robots) == ["arjuna"]
    info = EntityInfo(description="a ball", tags=["toy", "round"])
    request = SetEntityInfo.Request(entity="near", info=info)
    assert bench.call(SetEntityInfo, "/set_entity_info", request).result.result == OK
    both = TagsFilter(tags=["toy", "red"], filter_mode=TagsFilter.FILTER_MODE_ALL)
    assert _names(bench, EntityFilters(tags=TagsFilter(tags=["toy", "red"]))) == ["near"]
    assert _names(bench, EntityFilters(tags=both)) == []
    ball = Bounds(type=Bounds.TYPE_SPHERE, points=[Vector3(x=1.0), Vector3(x=0.2)])
    assert _names(bench, EntityFilters(bounds=ball)) == ["near"]
    got = bench.call(GetEntityInfo, "/get_entity_info", GetEntityInfo.Request(entity="near"))
    assert got.info.description == "a ball"


@pytest.mark.parametrize(
    ("filters", "code", "words"),
    [
        (EntityFilters(filter="("), Result.RESULT_OPERATION_FAILED, "no regular expression"),
        (
            EntityFilters(bounds=Bounds(type=Bounds.TYPE_CONVEX_HULL)),
            Result.RESULT_FEATURE_UNSUPPORTED,
            "valid: 1 (box), 3 (sphere)",
        ),
        (
            EntityFilters(bounds=Bounds(type=Bounds.TYPE_BOX)),
            Result.RESULT_OPERATION_FAILED,
            "need 2 finite points",
        ),
    ],
)
def test_impossible_filter_is_refused(
    bench: RosBench, filters: EntityFilters, code: int, words: str
) -> None:
    _sim(bench)
    for service, name in (
        (GetEntities, "/get_entities"),
        (GetEntitiesStates, "/get_entities_states"),
    ):
        response = bench.call(service, name, service.Request(filters=filters))
        assert response.result.result == code
        assert words in response.result.error_message


def test_states_come_with_their_names(bench: RosBench) -> None:
    _sim(bench)
    _spawn(bench, "crate", x=2.5)
    response = bench.call(GetEntitiesStates, "/get_entities_states", GetEntitiesStates.Request())
    assert list(response.entities) == ["arjuna", "crate"]
    assert [s.pose.position.x for s in response.states] == pytest.approx([0.0, 2.5], abs=1e-6)


def test_bounds_are_a_box_in_the_entity_s_own_frame(bench: RosBench) -> None:
    _sim(bench)
    _spawn(bench, "crate")
    for name, size in (("crate", 0.4), ("arjuna", None)):
        request = GetEntityBounds.Request(entity=name)
        bounds = bench.call(GetEntityBounds, "/get_entity_bounds", request).bounds
        assert bounds.type == Bounds.TYPE_BOX
        upper, lower = bounds.points
        assert upper.x > 0.0 > lower.x
        assert size is None or upper.x - lower.x == pytest.approx(size)


def test_unknown_entities_are_not_found(bench: RosBench) -> None:
    _sim(bench)
    _spawn(bench, "crate")
    for service, name in (
        (GetEntityState, "/get_entity_state"),
        (SetEntityState, "/set_entity_state"),
        (GetEntityInfo, "/get_entity_info"),
        (SetEntityInfo, "/set_entity_info"),
        (GetEntityBounds, "/get_entity_bounds"),
        (DeleteEntity, "/delete_entity"),
    ):
        response = bench.call(service, name, service.Request(entity="crates"))
        assert response.result.result == Result.RESULT_NOT_FOUND
        assert "did you mean 'crate'?" in response.result.error_message


def test_robot_cannot_be_deleted(bench: RosBench) -> None:
    _sim(bench)
    response = bench.call(DeleteEntity, "/delete_entity", DeleteEntity.Request(entity="arjuna"))
    assert response.result.result == Result.RESULT_OPERATION_FAILED
    assert "cannot be deleted" in response.result.error_message


def test_what_follows_a_path_is_not_moved_by_hand(bench: RosBench) -> None:
    sim = _sim(bench)
    text = (
        "<sdf version='1.7'><actor name='walker'><script><trajectory id='0' type='walk'>"
        "<waypoint><time>0</time><pose>0 0 0 0 0 0</pose></waypoint>"
        "<waypoint><time>4</time><pose>0 2 0 0 0 0</pose></waypoint>"
        "</trajectory></script></actor></sdf>"
    )
    assert _spawn(bench, "walker", uri="", text=text, x=3.0).result.result == OK
    _run(bench, sim, 50)
    state = _state(bench, "walker").state
    assert (state.pose.position.x, state.pose.position.y) == pytest.approx((3.0, 0.5))
    assert state.twist.linear.y == pytest.approx(0.5)
    request = SetEntityState.Request(entity="walker", set_pose=True)
    response = bench.call(SetEntityState, "/set_entity_state", request)
    assert response.result.result == Result.RESULT_OPERATION_FAILED
    assert "follows its path" in response.result.error_message


def test_spawnables_can_all_be_spawned(bench: RosBench) -> None:
    _sim(bench)
    response = bench.call(GetSpawnables, "/get_spawnables", GetSpawnables.Request())
    assert response.result.result == OK
    for i, spawnable in enumerate(response.spawnables):
        uri = spawnable.entity_resource.uri
        assert _spawn(bench, f"e{i}", uri=uri, x=3.0 + 2.0 * i).result.result == OK
    assert len(response.spawnables) >= 4


def test_contacts_are_counted_and_named(bench: RosBench) -> None:
    sim = _sim(bench)
    messages = bench.collect(DiagnosticArray, "/ground_truth/contacts", qos.LATCHED)
    _spawn(bench, "crate", x=0.8)
    command = Twist()
    for speed, ticks in ((0.5, 80), (-0.5, 40), (0.5, 80)):
        command.linear.x = speed
        for _ in range(ticks):
            bench.publish(Twist, "/cmd_vel", command)
            _run(bench, sim, 1)
    (status,) = messages[-1].status
    values = {item.key: item.value for item in status.values}
    assert values == {"count": "2", "crate": "2"}
    assert (status.level, status.message) == (DiagnosticStatus.WARN, "crate")
    assert messages[-1].header.frame_id == "world"
    assert sim.contacts.log.total == 2


def test_same_requests_give_the_same_scans() -> None:
    def scans() -> list[bytes]:
        bench = RosBench()
        try:
            sim = _sim(bench, "arjuna_room.world")
            found = bench.collect(LaserScan, "/scan", qos.SENSOR_SUBSCRIPTION)
            for i in range(3):
                _spawn(bench, f"e{i}", uri="box:0.3,0.3,0.5?mass=1", x=1.2 + i * 0.1)
                _run(bench, sim, 10)
                request = DeleteEntity.Request(entity=f"e{i}")
                bench.call(DeleteEntity, "/delete_entity", request)
            return [bytes(scan.ranges) for scan in found]
        finally:
            bench.close()

    assert scans() == scans()
