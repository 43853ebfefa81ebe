"""States, steps, resets and worlds of the simulation through a plain client."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from action_msgs.msg import GoalStatus
from simulation_interfaces.action import SimulateSteps
from simulation_interfaces.msg import Resource, Result, SimulationState, SimulatorFeatures
from simulation_interfaces.srv import (
    DeleteEntity,
    GetAvailableWorlds,
    GetCurrentWorld,
    GetEntities,
    GetSimulationState,
    GetSimulatorFeatures,
    LoadWorld,
    ResetSimulation,
    SetSimulationState,
    StepSimulation,
    UnloadWorld,
)
from std_msgs.msg import Float64

from arjuna_core.ros.local.actions import action_client
from arjuna_sim.nodes.sim import SimNode
from tests.helpers.ros import RosBench
from tests.nodes.sim.running import OK, names, run, spawn, start_sim

STATE = SimulationState
SCOPE = ResetSimulation.Request


@pytest.fixture
def sim(bench: RosBench, tmp_path: Path) -> SimNode:
    return start_sim(bench, resource_folder=str(tmp_path))


def _state(bench: RosBench) -> int:
    request = GetSimulationState.Request()
    response = bench.call(GetSimulationState, "/get_simulation_state", request)
    return int(response.state.state)


def _set(bench: RosBench, state: int) -> Any:
    request = SetSimulationState.Request(state=STATE(state=state))
    return bench.call(SetSimulationState, "/set_simulation_state", request).result


def _reset(bench: RosBench, scope: int) -> Any:
    request = ResetSimulation.Request(scope=scope)
    return bench.call(ResetSimulation, "/reset_simulation", request).result


def _goal(bench: RosBench, steps: int, feedback: list[Any] | None = None) -> Any:
    client = action_client(bench.node, SimulateSteps, "/simulate_steps")
    bench.process.drain()
    seen = [] if feedback is None else feedback
    future = client.send_goal_async(
        SimulateSteps.Goal(steps=steps), feedback_callback=lambda m: seen.append(m.feedback)
    )
    bench.process.drain()
    return future.result()


def test_playing_pausing_and_stopping(bench: RosBench, sim: SimNode) -> None:
    assert _state(bench) == STATE.STATE_PLAYING
    run(bench, sim, 5)
    assert _set(bench, STATE.STATE_PAUSED).result == OK
    already = _set(bench, STATE.STATE_PAUSED)
    assert already.result == SetSimulationState.Response.ALREADY_IN_TARGET_STATE
    run(bench, sim, 5)
    assert sim.simulator.time == 0.1
    spawn(bench, "ball", "sphere:0.1", 1.0)
    assert _set(bench, STATE.STATE_STOPPED).result == OK
    assert (_state(bench), sim.simulator.time, bench.process.now) == (STATE.STATE_STOPPED, 0.0, 0.0)
    assert "ball" not in names(bench)
    assert _set(bench, STATE.STATE_PLAYING).result == OK
    run(bench, sim, 1)
    assert sim.simulator.time == 0.02
    unknown = _set(bench, STATE.STATE_LOADING_WORLD)
    assert unknown.result == Result.RESULT_FEATURE_UNSUPPORTED
    assert "cannot be entered" in unknown.error_message


def test_quitting_ends_the_process_that_hosts_it(bench: RosBench, sim: SimNode) -> None:
    assert not sim.quitting
    assert _set(bench, STATE.STATE_QUITTING).result == OK
    assert sim.quitting
    run(bench, sim, 2)
    assert sim.simulator.time == 0.0


def test_steps_need_a_pause_and_a_number(bench: RosBench, sim: SimNode) -> None:
    wrong, failed = Result.RESULT_INCORRECT_STATE, Result.RESULT_OPERATION_FAILED
    for state, steps, code, time in (
        (STATE.STATE_PLAYING, 1, wrong, 0.0),
        (STATE.STATE_PAUSED, 0, failed, 0.0),
        (STATE.STATE_PAUSED, 10**9, failed, 0.0),
        (STATE.STATE_PAUSED, 7, OK, 0.14),
        (STATE.STATE_STOPPED, 1, wrong, 0.0),
    ):
        _set(bench, state)
        request = StepSimulation.Request(steps=steps)
        response = bench.call(StepSimulation, "/step_simulation", request)
        assert response.result.result == code
        assert sim.simulator.time == pytest.approx(time)


def test_action_steps_with_progress_and_stays_paused(bench: RosBench, sim: SimNode) -> None:
    _set(bench, STATE.STATE_PAUSED)
    feedback: list[Any] = []
    handle = _goal(bench, 4, feedback)
    result = handle.get_result_async()
    assert sim.realtime_due(0.0) == 0.0  # the host is to call tick at once
    run(bench, sim, 10)
    assert result.result().status == GoalStatus.STATUS_SUCCEEDED
    assert result.result().result.result.result == OK
    assert [(f.completed_steps, f.remaining_steps) for f in feedback] == [
        (1, 3), (2, 2), (3, 1), (4, 0)
    ]  # fmt: skip
    assert sim.simulator.time == 0.08
    assert _state(bench) == STATE.STATE_PAUSED


def test_action_can_be_cancelled_and_refuses_a_second_goal(bench: RosBench, sim: SimNode) -> None:
    _set(bench, STATE.STATE_PAUSED)
    first = _goal(bench, 100)
    done = first.get_result_async()
    run(bench, sim, 3)
    second = _goal(bench, 5).get_result_async()
    bench.process.drain()
    assert second.result().status == GoalStatus.STATUS_ABORTED
    assert "other steps" in second.result().result.result.error_message
    blocked = _set(bench, STATE.STATE_PLAYING)
    assert blocked.result == SetSimulationState.Response.STATE_TRANSITION_ERROR
    first.cancel_goal_async()
    bench.process.drain()
    run(bench, sim, 5)
    assert done.result().status == GoalStatus.STATUS_CANCELED
    assert sim.simulator.time == 0.06


def test_an_action_on_a_playing_simulation_fails(bench: RosBench, sim: SimNode) -> None:
    result = _goal(bench, 5).get_result_async()
    bench.process.drain()
    assert result.result().status == GoalStatus.STATUS_ABORTED
    assert "pause it first" in result.result().result.result.error_message


def test_scopes_reset_time_state_and_spawned_apart(bench: RosBench, sim: SimNode) -> None:
    spawn(bench, "ball", "sphere:0.1", 1.0)
    run(bench, sim, 10)
    assert _reset(bench, SCOPE.SCOPE_STATE).result == OK
    assert (sim.simulator.time, "ball" in names(bench)) == (0.2, True)
    assert _reset(bench, SCOPE.SCOPE_TIME).result == OK
    assert (sim.simulator.time, bench.process.now) == (0.0, 0.0)
    assert "ball" in names(bench)
    run(bench, sim, 10)
    assert _reset(bench, SCOPE.SCOPE_SPAWNED).result == OK
    assert (sim.simulator.time, "ball" in names(bench)) == (0.2, False)
    assert _reset(bench, 64).result == Result.RESULT_FEATURE_UNSUPPORTED
    assert sim.simulator.time == 0.2


def test_full_resets_bring_the_world_back(bench: RosBench, sim: SimNode) -> None:
    before = names(bench)
    for scope in (SCOPE.SCOPE_DEFAULT, SCOPE.SCOPE_ALL):
        spawn(bench, "ball", "sphere:0.1", 1.0)
        request = DeleteEntity.Request(entity="obstacle_red")
        assert bench.call(DeleteEntity, "/delete_entity", request).result.result == OK
        assert _reset(bench, scope).result == OK
        assert names(bench) == before


def test_achieved_factor_is_published_once_a_wall_second(
    bench: RosBench, sim: SimNode, capfd: pytest.CaptureFixture[str]
) -> None:
    factors = bench.collect(Float64, "/real_time_factor")
    for i in range(201):  # a machine that makes two ticks of 20 ms in 80 ms
        sim.realtime_due(i * 0.08)
        run(bench, sim, 2)
    assert len(factors) == 15
    assert [f.data for f in factors] == pytest.approx([0.5] * 15, abs=1e-6)
    sim.trigger_deactivate()
    assert "real-time factor 0.50" in capfd.readouterr().err


def test_lock_step_publishes_no_wall_time(bench: RosBench, sim: SimNode) -> None:
    factors = bench.collect(Float64, "/real_time_factor")
    run(bench, sim, 100)
    assert factors == []


CODES = LoadWorld.Response
WORLD = "<sdf version='1.7'><world name='w'>{}</world></sdf>"
MESH = (
    "<model name='m'><static>1</static><link name='l'><collision name='c'><geometry><mesh>"
    "<uri>none.stl</uri></mesh></geometry></collision></link></model>"
)


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


def test_a_world_is_sent_as_text_or_without_assets(bench: RosBench, sim: SimNode) -> None:
    text = WORLD.format("")
    response = _load(bench, text=text)
    assert (response.result.result, response.world.name) == (OK, "w")
    assert response.world.world_resource.resource_string == text
    response = _load(bench, text=WORLD.format(MESH), ignore_missing_or_unsupported_assets=True)
    assert response.result.result == OK


def test_impossible_worlds_change_nothing(bench: RosBench, sim: SimNode) -> None:
    before = names(bench)
    plugin = {"text": WORLD.format("<plugin name='p'/>"), "fail_on_unsupported_element": True}
    cases: list[tuple[dict[str, Any], int, str]] = [
        ({}, CODES.NO_RESOURCE, "neither a uri"),
        ({"uri": "none.world"}, Result.RESULT_NOT_FOUND, "does not exist"),
        ({"uri": "../../../etc/x.world"}, Result.RESULT_OPERATION_FAILED, "lies outside"),
        ({"uri": "urdf/arjuna.urdf"}, CODES.UNSUPPORTED_FORMAT, "none of .world"),
        ({"text": "<mujoco/>"}, CODES.UNSUPPORTED_FORMAT, "holds no <sdf>"),
        ({"text": "<sdf><world>"}, CODES.RESOURCE_PARSE_ERROR, "broken XML"),
        ({"text": WORLD.format(MESH)}, CODES.MISSING_ASSETS, "none.stl"),
        (plugin, CODES.UNSUPPORTED_ELEMENTS, "plugin 'p'"),
    ]
    for fields, code, words in cases:
        response = _load(bench, **fields)
        assert response.result.result == code, response.result.error_message
        assert words in response.result.error_message
        assert (names(bench), _state(bench)) == (before, STATE.STATE_PLAYING)


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
