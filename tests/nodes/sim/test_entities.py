"""Entities through a plain client: moved, listed, filtered and deleted."""

from __future__ import annotations

import math
import time

import pytest
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from geometry_msgs.msg import Twist, Vector3
from sensor_msgs.msg import LaserScan
from simulation_interfaces.msg import (
    Bounds,
    EntityCategory,
    EntityFilters,
    EntityInfo,
    Result,
    TagsFilter,
)
from simulation_interfaces.srv import (
    DeleteEntity,
    GetEntities,
    GetEntitiesStates,
    GetEntityBounds,
    GetEntityInfo,
    GetEntityState,
    SetEntityInfo,
    SetEntityState,
)

from arjuna_core.ros import qos
from arjuna_sim.model.entities import Category
from tests.helpers.ros import RosBench
from tests.nodes.sim.running import OK, names, run, spawn, start_in, state


def test_box_is_spawned_seen_moved_and_deleted(bench: RosBench) -> None:
    sim = start_in(bench)
    scans = bench.collect(LaserScan, "/scan", qos.SENSOR_SUBSCRIPTION)

    def ahead() -> float:
        run(bench, sim, 5)
        return float(scans[-1].ranges[180])

    assert math.isinf(ahead())
    response = spawn(bench, "crate")
    assert (response.result.result, response.entity_name) == (OK, "crate")
    seen = ahead()
    assert 1.5 < seen < 2.0
    assert names(bench) == ["arjuna", "crate"]
    request = SetEntityState.Request(entity="crate", set_pose=True)
    request.state.pose.position.x = 3.0
    assert bench.call(SetEntityState, "/set_entity_state", request).result.result == OK
    assert ahead() == pytest.approx(seen + 1.0, abs=0.1)
    found = state(bench, "crate").state
    assert (found.header.frame_id, found.pose.position.x) == ("world", 3.0)
    gone = bench.call(DeleteEntity, "/delete_entity", DeleteEntity.Request(entity="crate"))
    assert gone.result.result == OK
    assert math.isinf(ahead())
    assert names(bench) == ["arjuna"]


def test_categories_have_the_interfaces_numbers() -> None:
    numbers = {each.name: getattr(EntityCategory, f"CATEGORY_{each.name}") for each in Category}
    assert numbers == {each.name: each.value for each in Category}


def test_filters_by_name_category_tags_and_bounds(bench: RosBench) -> None:
    start_in(bench, "arjuna_room.world")
    spawn(bench, "near", uri="sphere:0.1", x=1.0)
    assert names(bench, EntityFilters(filter="^obstacle_(red|blue)$")) == [
        "obstacle_red",
        "obstacle_blue",
    ]
    robots = EntityFilters(categories=[EntityCategory(category=EntityCategory.CATEGORY_ROBOT)])
    assert names(bench, robots) == ["arjuna"]
    info = EntityInfo(description="a ball", tags=["toy", "round"])
    request = SetEntityInfo.Request(entity="near", info=info)
    assert bench.call(SetEntityInfo, "/set_entity_info", request).result.result == OK
    both = TagsFilter(tags=["toy", "red"], filter_mode=TagsFilter.FILTER_MODE_ALL)
    assert names(bench, EntityFilters(tags=TagsFilter(tags=["toy", "red"]))) == ["near"]
    assert names(bench, EntityFilters(tags=both)) == []
    ball = Bounds(type=Bounds.TYPE_SPHERE, points=[Vector3(x=1.0), Vector3(x=0.2)])
    assert names(bench, EntityFilters(bounds=ball)) == ["near"]
    got = bench.call(GetEntityInfo, "/get_entity_info", GetEntityInfo.Request(entity="near"))
    assert got.info.description == "a ball"


def test_impossible_filters_are_refused(bench: RosBench) -> None:
    start_in(bench)
    hull, corners = Bounds(type=Bounds.TYPE_CONVEX_HULL), Bounds(type=Bounds.TYPE_BOX)
    failed = Result.RESULT_OPERATION_FAILED
    for filters, code, words in (
        (EntityFilters(filter="("), failed, "no regular expression"),
        (EntityFilters(filter=r"(a)\1"), failed, "invalid escape"),
        (EntityFilters(bounds=hull), Result.RESULT_FEATURE_UNSUPPORTED, "valid: 1 (box), 3 (sph"),
        (EntityFilters(bounds=corners), failed, "need 2 finite points"),
    ):
        for service, name in (
            (GetEntities, "/get_entities"),
            (GetEntitiesStates, "/get_entities_states"),
        ):
            response = bench.call(service, name, service.Request(filters=filters))
            assert response.result.result == code
            assert words in response.result.error_message


def test_an_endless_search_ends(bench: RosBench) -> None:
    start_in(bench)
    spawn(bench, "a" * 200 + "b", x=2.5)
    start = time.process_time()
    response = bench.call(
        GetEntities, "/get_entities", GetEntities.Request(filters=EntityFilters(filter="^(a+)+$"))
    )
    assert time.process_time() - start < 0.5
    assert not response.entities


def test_states_and_bounds_come_by_name_and_unknown_names_are_refused(bench: RosBench) -> None:
    start_in(bench)
    spawn(bench, "crate", x=2.5)
    response = bench.call(GetEntitiesStates, "/get_entities_states", GetEntitiesStates.Request())
    assert list(response.entities) == ["arjuna", "crate"]
    assert [s.pose.position.x for s in response.states] == pytest.approx([0.0, 2.5], abs=1e-6)
    for name, size in (("crate", 0.4), ("arjuna", None)):
        request = GetEntityBounds.Request(entity=name)
        bounds = bench.call(GetEntityBounds, "/get_entity_bounds", request).bounds
        assert bounds.type == Bounds.TYPE_BOX
        upper, lower = bounds.points
        assert upper.x > 0.0 > lower.x
        assert size is None or upper.x - lower.x == pytest.approx(size)
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
    response = bench.call(DeleteEntity, "/delete_entity", DeleteEntity.Request(entity="arjuna"))
    assert response.result.result == Result.RESULT_OPERATION_FAILED
    assert "cannot be deleted" in response.result.error_message


def test_what_follows_a_path_is_not_moved_by_hand(bench: RosBench) -> None:
    sim = start_in(bench)
    text = (
        "<sdf version='1.7'><actor name='walker'><script><trajectory id='0' type='walk'>"
        "<waypoint><time>0</time><pose>0 0 0 0 0 0</pose></waypoint>"
        "<waypoint><time>4</time><pose>0 2 0 0 0 0</pose></waypoint>"
        "</trajectory></script></actor></sdf>"
    )
    assert spawn(bench, "walker", uri="", text=text, x=3.0).result.result == OK
    run(bench, sim, 50)
    found = state(bench, "walker").state
    assert (found.pose.position.x, found.pose.position.y) == pytest.approx((3.0, 0.5))
    assert found.twist.linear.y == pytest.approx(0.5)
    request = SetEntityState.Request(entity="walker", set_pose=True)
    response = bench.call(SetEntityState, "/set_entity_state", request)
    assert response.result.result == Result.RESULT_OPERATION_FAILED
    assert "follows its path" in response.result.error_message


def test_contacts_are_counted_and_named(bench: RosBench) -> None:
    sim = start_in(bench)
    messages = bench.collect(DiagnosticArray, "/ground_truth/contacts", qos.LATCHED)
    spawn(bench, "crate", x=0.8)
    command = Twist()
    for speed, ticks in ((0.5, 80), (-0.5, 40), (0.5, 80)):
        command.linear.x = speed
        for _ in range(ticks):
            bench.publish(Twist, "/cmd_vel", command)
            run(bench, sim, 1)
    (status,) = messages[-1].status
    values = {item.key: item.value for item in status.values}
    assert values == {"count": "2", "crate": "2"}
    assert (status.level, status.message) == (DiagnosticStatus.WARN, "crate")
    assert messages[-1].header.frame_id == "world"
    assert sim.contacts.log.total == 2
