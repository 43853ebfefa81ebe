"""States, steps and resets of the simulation through a plain client."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from action_msgs.msg import GoalStatus
from simulation_interfaces.action import SimulateSteps
from simulation_interfaces.msg import Result, SimulationState
from simulation_interfaces.srv import (
    DeleteEntity,
    GetSimulationState,
    ResetSimulation,
    SetSimulationState,
    StepSimulation,
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


@pytest.mark.parametrize(
    ("state", "steps", "code"),
    [
        (STATE.STATE_PLAYING, 1, Result.RESULT_INCORRECT_STATE),
        (STATE.STATE_STOPPED, 1, Result.RESULT_INCORRECT_STATE),
        (STATE.STATE_PAUSED, 0, Result.RESULT_OPERATION_FAILED),
        (STATE.STATE_PAUSED, 10**9, Result.RESULT_OPERATION_FAILED),
        (STATE.STATE_PAUSED, 7, OK),
    ],
)
def test_steps_need_a_pause_and_a_number(
    bench: RosBench, sim: SimNode, state: int, steps: int, code: int
) -> None:
    _set(bench, state)
    request = StepSimulation.Request(steps=steps)
    response = bench.call(StepSimulation, "/step_simulation", request)
    assert response.result.result == code
    assert sim.simulator.time == pytest.approx(0.14 if code == OK else 0.0)


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


def test_action_on_a_playing_simulation_fails_with_its_reason(
    bench: RosBench, sim: SimNode
) -> None:
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


@pytest.mark.parametrize("scope", [SCOPE.SCOPE_DEFAULT, SCOPE.SCOPE_ALL])
def test_full_reset_brings_the_world_back(bench: RosBench, sim: SimNode, scope: int) -> None:
    before = names(bench)
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
