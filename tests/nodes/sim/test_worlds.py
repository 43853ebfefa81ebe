"""Worlds of the simulator through a plain client."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from simulation_interfaces.msg import Resource, Result, SimulationState, SimulatorFeatures
from simulation_interfaces.srv import (
    GetAvailableWorlds,
    GetCurrentWorld,
    GetEntities,
    GetSimulationState,
    GetSimulatorFeatures,
    LoadWorld,
    ResetSimulation,
    SetSimulationState,
    UnloadWorld,
)

from arjuna_sim.nodes.sim import SimNode
from tests.helpers.ros import RosBench
from tests.nodes.sim.running import OK, names, run, spawn, start_sim

STATE = SimulationState
SCOPE = ResetSimulation.Request
CODES = LoadWorld.Response
WORLD = "<sdf version='1.7'><world name='w'>{}</world></sdf>"
MESH = (
    "<model name='m'><static>1</static><link name='l'><collision name='c'><geometry><mesh>"
    "<uri>none.stl</uri></mesh></geometry></collision></link></model>"
)


@pytest.fixture
def sim(bench: RosBench, tmp_path: Path) -> SimNode:
    return start_sim(bench, resource_folder=str(tmp_path))


def _set(bench: RosBench, state: int) -> Any:
    request = SetSimulationState.Request(state=STATE(state=state))
    return bench.call(SetSimulationState, "/set_simulation_state", request).result


def _state(bench: RosBench) -> int:
    request = GetSimulationState.Request()
    response = bench.call(GetSimulationState, "/get_simulation_state", request)
    return int(response.state.state)


def _reset(bench: RosBench, scope: int) -> Any:
    request = ResetSimulation.Request(scope=scope)
    return bench.call(ResetSimulation, "/reset_simulation", request).result


def _load(bench: RosBench, uri: str = "", text: str = "", **flags: bool) -> Any:
    resource = Resource(uri=uri, resource_string=text)
    request = LoadWorld.Request(world_resource=resource, **flags)
    return bench.call(LoadWorld, "/load_world", request)


def test_world_is_replaced_and_the_simulation_stopped(bench: RosBench, sim: SimNode) -> None:
    spawn(bench, "ball", "sphere:0.1", 1.0)
    run(bench, sim, 10)
    response = _load(bench, "worlds/empty.world")
    assert response.result.result == OK, response.result.error_message
    assert Path(response.world.world_resource.uri).name == "empty.world"
    assert names(bench) == ["arjuna"]
    assert (_state(bench), sim.simulator.time) == (STATE.STATE_STOPPED, 0.0)
    current = bench.call(GetCurrentWorld, "/get_current_world", GetCurrentWorld.Request())
    assert current.world == response.world
    assert _set(bench, STATE.STATE_PLAYING).result == OK
    run(bench, sim, 5)
    assert sim.simulator.time == 0.1


def test_world_can_be_sent_as_text(bench: RosBench, sim: SimNode) -> None:
    text = WORLD.format("")
    response = _load(bench, text=text)
    assert (response.result.result, response.world.name) == (OK, "w")
    assert response.world.world_resource.resource_string == text


@pytest.mark.parametrize(
    ("fields", "code", "words"),
    [
        ({}, CODES.NO_RESOURCE, "neither a uri"),
        ({"uri": "none.world"}, Result.RESULT_NOT_FOUND, "does not exist"),
        ({"uri": "../../../etc/x.world"}, Result.RESULT_OPERATION_FAILED, "lies outside"),
        ({"uri": "urdf/arjuna.urdf"}, CODES.UNSUPPORTED_FORMAT, "none of .world"),
        ({"text": "<mujoco/>"}, CODES.UNSUPPORTED_FORMAT, "holds no <sdf>"),
        ({"text": "<sdf><world>"}, CODES.RESOURCE_PARSE_ERROR, "broken XML"),
        ({"text": WORLD.format(MESH)}, CODES.MISSING_ASSETS, "none.stl"),
        (
            {"text": WORLD.format("<plugin name='p'/>"), "fail_on_unsupported_element": True},
            CODES.UNSUPPORTED_ELEMENTS,
            "plugin 'p'",
        ),
    ],
)
def test_impossible_world_has_its_code_and_changes_nothing(
    bench: RosBench, sim: SimNode, fields: dict[str, Any], code: int, words: str
) -> None:
    before = names(bench)
    response = _load(bench, **fields)
    assert response.result.result == code, response.result.error_message
    assert words in response.result.error_message
    assert (names(bench), _state(bench)) == (before, STATE.STATE_PLAYING)


def test_missing_assets_can_be_ignored(bench: RosBench, sim: SimNode) -> None:
    response = _load(bench, text=WORLD.format(MESH), ignore_missing_or_unsupported_assets=True)
    assert response.result.result == OK


def test_without_a_world_nothing_runs_until_one_is_loaded(bench: RosBench, sim: SimNode) -> None:
    def unload() -> int:
        response = bench.call(UnloadWorld, "/unload_world", UnloadWorld.Request())
        return int(response.result.result)

    assert unload() == OK
    assert unload() == UnloadWorld.Response.NO_WORLD_LOADED
    assert _state(bench) == STATE.STATE_NO_WORLD
    current = bench.call(GetCurrentWorld, "/get_current_world", GetCurrentWorld.Request())
    assert current.result.result == GetCurrentWorld.Response.NO_WORLD_LOADED
    assert _set(bench, STATE.STATE_PLAYING).result == Result.RESULT_INCORRECT_STATE
    assert _reset(bench, SCOPE.SCOPE_ALL).result == Result.RESULT_INCORRECT_STATE
    entities = bench.call(GetEntities, "/get_entities", GetEntities.Request())
    assert entities.result.result == Result.RESULT_INCORRECT_STATE
    run(bench, sim, 5)
    assert sim.simulator.time == 0.0
    assert _load(bench, "worlds/arjuna_room.world").result.result == OK
    assert "obstacle_red" in names(bench)


def test_available_worlds_can_be_loaded(bench: RosBench, sim: SimNode, tmp_path: Path) -> None:
    (tmp_path / "mine.world").write_text(WORLD.format(""))
    request = GetAvailableWorlds.Request()
    worlds = bench.call(GetAvailableWorlds, "/get_available_worlds", request).worlds
    names = {Path(world.world_resource.uri).name for world in worlds}
    assert {"mine.world", "empty.world", "arjuna_room.world", "arjuna_room.yaml"} <= names
    for world in worlds:
        assert _load(bench, world.world_resource.uri).result.result == OK


def test_features_name_what_is_served_and_nothing_else(bench: RosBench, sim: SimNode) -> None:
    request = GetSimulatorFeatures.Request()
    response = bench.call(GetSimulatorFeatures, "/get_simulator_features", request)
    named = set(response.features.features)
    assert {
        SimulatorFeatures.SPAWNING,
        SimulatorFeatures.DELETING,
        SimulatorFeatures.SIMULATION_RESET_TIME,
        SimulatorFeatures.STEP_SIMULATION_ACTION,
        SimulatorFeatures.WORLD_LOADING,
    } <= named
    assert SimulatorFeatures.NAMED_POSES not in named
    assert sorted(response.features.spawn_formats) == ["sdf", "urdf"]
    services = dict(bench.node.get_service_names_and_types())
    for name in ("spawn_entity", "delete_entity", "load_world", "get_entity_bounds"):
        assert f"/{name}" in services
    assert "/get_named_poses" not in services
