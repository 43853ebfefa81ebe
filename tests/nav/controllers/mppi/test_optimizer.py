"""MPPI's optimizer against its definition, its commands against the published algorithm."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
import scipy
from numpy.typing import NDArray

from arjuna_core.config import load
from arjuna_core.se2 import SE2
from arjuna_core.twist import STILL, Velocity
from arjuna_nav.controllers.mppi.config import MppiConfig
from arjuna_nav.controllers.mppi.controller import Mppi
from arjuna_nav.controllers.mppi.optimizer import Optimizer
from arjuna_nav.controllers.mppi.rollouts import Limits, Rollouts
from arjuna_nav.costmap.footprint import Footprint
from tests.helpers.nav import mppi_peer
from tests.nav.worlds import Unicycle, costmap_of, grid_of

STEPS, BATCH, DT = 14, 10, 0.1
FREE = Limits(-9.0, 9.0, 9.0, 999.0, 999.0, 999.0, 9.0, 999.0, 999.0)
Floats = NDArray[Any]


def made_config(**changes: Any) -> MppiConfig:
    own = {"noise_time": 0.0, "gamma": 0.3, "temperature": 0.5, "seed": 4, **changes}
    return MppiConfig(time_steps=STEPS, batch_size=BATCH, model_dt=DT, **own)


def deviations_of(config: MppiConfig) -> Floats:
    side = [config.vy_std] if config.motion_model == "Omni" else []
    return np.array([config.vx_std, config.wz_std, *side])


def made_noise(config: MppiConfig, columns: int = BATCH) -> Floats:
    """Return the noise of speeds, yaw rates and speeds to the left, `(2 or 3, STEPS, columns)`.

    Of one step with the next it is correlated by exp(-dt / time), and its deviation is that of the
    parameters all along.
    """
    rng, deviations = np.random.default_rng(config.seed), deviations_of(config)
    shape = (len(deviations), STEPS, columns)
    white = rng.standard_normal(shape, dtype=np.float32).astype(np.float64)
    keep = math.exp(-DT / config.noise_time) if config.noise_time else 0.0
    white[:, 1:] *= math.sqrt(1.0 - keep**2)
    kept = scipy.signal.lfilter([1.0], [1.0, -keep], white, axis=1)
    noise: Floats = deviations[:, None, None] * kept
    return noise


def improved(config: MppiConfig, found: Floats, driven: Floats, costs: Floats) -> Floats:
    """Return better controls, `(2, STEPS)`, than those found, given what was driven before."""
    noise, keep = made_noise(config), 0.0
    if config.noise_time:
        keep = math.exp(-DT / config.noise_time)
    total = costs.astype(np.float64)
    for own, tried, deviation in zip(found, noise, deviations_of(config), strict=True):
        gamma = config.gamma * (1.0 - keep) / (1.0 + keep)
        total += gamma * own @ tried / deviation**2
    weights = np.exp(-(total - total.min()) / config.temperature)
    mean = found + noise @ (weights / weights.sum())
    padded = np.hstack((driven, mean, np.repeat(mean[:, -1:], 4, axis=1)))
    better: Floats = scipy.signal.savgol_filter(padded, 9, 2)[:, 4:-4]
    return better


def judged(costs: Floats) -> Any:
    return lambda rollouts: (costs.astype(np.float32), False)


@pytest.mark.parametrize(
    ("noise_time", "model"), [(0.0, "DiffDrive"), (0.3, "DiffDrive"), (0.3, "Omni")]
)
def test_commands_are_means_of_samples_weighed_by_costs(noise_time: float, model: str) -> None:
    config = made_config(noise_time=noise_time, motion_model=model, vy_std=0.3)
    optimizer, rng = Optimizer(config), np.random.default_rng(0)
    parts = len(deviations_of(config))
    found, driven = np.zeros((parts, STEPS)), np.zeros((parts, 4))
    for _ in range(6):
        costs = rng.uniform(0.0, 2.0, BATCH)
        assert optimizer.improve(STILL, FREE, judged(costs))
        found = improved(config, found, driven, costs)
        assert optimizer.controls == pytest.approx(found, abs=1e-5)
        command = optimizer.advance(0.5 * DT)
        middles = 0.5 * (found[:, :-1] + found[:, 1:])
        found = np.column_stack((middles, found[:, -1]))
        sent = (command.x, command.yaw_rate, command.y)[:parts]
        assert sent == pytest.approx(tuple(found[:, 0]), abs=1e-5)
        driven = np.column_stack((driven[:, 1:], found[:, 0]))


def within(
    controls: Floats, first: float, low: float, high: float, down: float, up: float
) -> Floats:
    """Return velocities from the first on that follow controls as far as limits allow."""
    found = [np.full(BATCH, first)]
    for row in controls[:-1]:
        wanted = np.clip(row, low, high)
        found.append(np.clip(wanted, found[-1] - down * DT, found[-1] + up * DT))
    return np.array(found)


@pytest.mark.parametrize("limits", [FREE, Limits(-0.1, 0.3, 0.4, 0.5, 0.8, 0.9, 0.2, 0.6, 0.7)])
def test_what_is_tried_is_rolled_out_from_the_velocity_driven(limits: Limits) -> None:
    seen: list[Rollouts] = []

    def judge(rollouts: Rollouts) -> tuple[Floats, bool]:
        seen.append(Rollouts(*(a.copy() for a in rollouts)))
        return np.zeros(BATCH, np.float32), False

    config = made_config(motion_model="Omni")
    Optimizer(config).improve(Velocity(0.2, y=0.3, yaw_rate=-0.1), limits, judge)
    v, w, side = made_noise(config)
    most, w_max, change = limits.side_max, limits.w_max, limits.accel_w
    v = within(v, 0.2, limits.v_min, limits.v_max, limits.decel, limits.accel)
    w = within(w, -0.1, -w_max, w_max, change, change)
    side = within(side, 0.3, -most, most, limits.side_decel, limits.side_accel)
    for found, expected in ((seen[0].v, v), (seen[0].w, w), (seen[0].side, side)):
        assert found == pytest.approx(expected, abs=1e-5)
    yaw = np.vstack((np.zeros(BATCH), np.cumsum(seen[0].w * DT, axis=0)))[:-1]
    at = np.cumsum((seen[0].v + 1j * seen[0].side) * DT * np.exp(1j * yaw), axis=0)
    assert seen[0].x + 1j * seen[0].y == pytest.approx(at, abs=1e-4)


def test_a_steered_robot_tries_no_circle_less_than_its_radius() -> None:
    seen: list[Rollouts] = []

    def judge(rollouts: Rollouts) -> tuple[Floats, bool]:
        seen.append(rollouts)
        return np.zeros(BATCH, np.float32), False

    limits = FREE._replace(radius=0.6)
    Optimizer(made_config(motion_model="Ackermann")).improve(Velocity(0.2), limits, judge)
    v, w = np.abs(seen[0].v), np.abs(seen[0].w)
    assert np.all(w <= v / 0.6 + 1e-6)
    assert np.any(w > 0.9 * v / 0.6)


def test_the_controls_keep_within_the_limits() -> None:
    optimizer = Optimizer(made_config(vx_std=3.0, wz_std=3.0, temperature=0.01))
    limits = Limits(-0.1, 0.2, 0.3, 999.0, 999.0, 999.0)
    assert optimizer.improve(STILL, limits, judged(np.arange(BATCH)))
    assert (optimizer.controls[0].min(), optimizer.controls[0].max()) == pytest.approx((-0.1, 0.2))
    assert (optimizer.controls[1].min(), optimizer.controls[1].max()) == pytest.approx((-0.3, 0.3))


def test_it_goes_no_further_where_all_collide_and_forgets_when_reset() -> None:
    config, costs = made_config(iteration_count=3), np.arange(BATCH)
    optimizer, rounds = Optimizer(config), []

    def judge(rollouts: Rollouts) -> tuple[Floats, bool]:
        rounds.append(rollouts)
        return costs.astype(np.float32), len(rounds) == 5

    assert optimizer.improve(STILL, FREE, judge)
    assert len(rounds) == 3
    optimizer.advance(DT)
    assert not optimizer.improve(STILL, FREE, judge)
    assert len(rounds) == 5
    optimizer.reset()
    optimizer.improve(STILL, FREE, judged(costs))
    fresh = Optimizer(config)
    fresh.improve(STILL, FREE, judged(costs))
    assert optimizer.controls.tolist() == fresh.controls.tolist()


def test_noise_of_its_own_for_each_command_is_a_part_of_thrice_as_much() -> None:
    config, tried = made_config(regenerate_noises=True), []

    def judge(rollouts: Rollouts) -> tuple[Floats, bool]:
        tried.append((rollouts.v[1:].copy(), rollouts.w[1:].copy()))
        return np.zeros(BATCH, np.float32), True

    optimizer = Optimizer(config)
    for _ in range(40):
        optimizer.improve(STILL, FREE, judge)
    found = []
    for of_all, parts in zip(made_noise(config, 3 * BATCH), zip(*tried, strict=True), strict=True):
        starts = [of_all[:-1, k : k + BATCH] for k in range(2 * BATCH)]
        at = [int(np.argmin([np.abs(part - s).max() for s in starts])) for part in parts]
        assert all(
            np.allclose(part, starts[k], atol=1e-5) for part, k in zip(parts, at, strict=True)
        )
        found.append(at)
    assert found[0] != found[1]
    assert all(max(at) > 1.5 * BATCH and min(at) < 0.5 * BATCH for at in found)


def test_commands_are_those_of_the_published_algorithm() -> None:
    library = mppi_peer.compiled()
    if library is None:
        pytest.skip("no C compiler")
    grid = grid_of(5.0, 5.0, (2.2, 1.7, 0.3, 0.3))
    costmap, along = costmap_of(grid), np.arange(0.5, 4.5, 0.0437)
    path = np.column_stack((along, np.full(len(along), 2.22), np.zeros(len(along))))
    off = []
    for seed in range(20):
        config = load(MppiConfig, {"batch_size": 200, "ax_max": 1.0, "ax_min": -1.0, "seed": seed})
        ours = Mppi(config, Footprint.circle(0.25), 0.2, 0.05)
        peer = mppi_peer.ArrayMppi(library, config)
        robot = Unicycle(SE2(0.5 + 0.15 * seed, 2.3, 0.6))
        for controller in (ours, peer):
            controller.set_path(path)
        for step in range(5):
            command = ours.compute(robot.pose, robot.velocity, costmap, 0.05 * step).velocity
            theirs = peer.compute(robot.pose, robot.velocity, costmap)
            assert theirs is not None
            off.append(max(abs(command.x - theirs.x), abs(command.yaw_rate - theirs.yaw_rate)))
            robot.drive(command)
        peer.close()
    # Where a rollout ends on the bound of a cell, rounding decides by which cell it is judged.
    assert np.quantile(off, 0.9) < 1e-5
    assert max(off) < 0.1
