"""The velocity smoother: limits, timeout, deadband."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from arjuna_core.config import load
from arjuna_core.errors import ConfigError
from arjuna_core.twist import Velocity
from arjuna_nav.safety.velocity_smoother import SmoothingConfig, VelocitySmoother
from bringup.parameters.files import for_node, shipped_parameters

PERIOD = 0.05
LIMITS = {
    "max_velocity": (0.5, 0.0, 2.5),
    "min_velocity": (-0.5, 0.0, -2.5),
    "max_accel": (2.5, 0.0, 3.2),
    "max_decel": (-2.5, 0.0, -3.2),
}
STILL = Velocity()


def driven(
    command: Velocity, count: int, measured: Velocity = STILL, **parameters: Any
) -> list[Velocity | None]:
    """Return what is said each period after one command."""
    smoother = VelocitySmoother(load(SmoothingConfig, LIMITS | parameters))
    smoother.take(command, 0.0)
    return [smoother.tick(measured, k * PERIOD) for k in range(count)]


def said(velocities: list[Velocity | None]) -> np.ndarray:
    return np.array([(each.x, each.yaw_rate) for each in velocities if each is not None])


def test_speed_grows_by_no_more_than_the_acceleration() -> None:
    speeds = said(driven(Velocity(0.4, yaw_rate=1.0), 10))
    assert np.abs(np.diff(speeds[:, 0], prepend=0.0)).max() <= 2.5 * PERIOD + 1e-9
    assert np.abs(np.diff(speeds[:, 1], prepend=0.0)).max() <= 3.2 * PERIOD + 1e-9
    assert speeds[-1] == pytest.approx((0.4, 1.0))


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_starting_takes_the_acceleration_turning_round_the_braking(side: float) -> None:
    limits: dict[str, Any] = {"max_accel": (0.5, 0.7, 1.0), "max_decel": (-2.0, -1.5, -3.0)}
    limits |= {"max_velocity": (0.5, 0.5, 2.5), "min_velocity": (-0.5, -0.5, -2.5)}
    there, back = (Velocity(v * 0.4, y=v * 0.3, yaw_rate=v * 0.6) for v in (side, -side))
    started = driven(there, 1, **limits)[0]
    smoother = VelocitySmoother(load(SmoothingConfig, limits))
    for k in range(40):
        smoother.take(there, k * PERIOD)
        smoother.tick(STILL, k * PERIOD)
    smoother.take(back, 2.0)
    turned = smoother.tick(STILL, 2.0)
    assert started is not None
    assert turned is not None
    assert (started.x, started.y, started.yaw_rate) == pytest.approx(
        np.multiply((0.5, 0.7, 1.0), PERIOD * side)
    )
    assert (turned.x, turned.y, turned.yaw_rate) == pytest.approx(
        np.multiply((0.4 - 2.0 * PERIOD, 0.3 - 1.5 * PERIOD, 0.6 - 3.0 * PERIOD), side)
    )


def test_commands_beyond_the_greatest_speeds_are_cut() -> None:
    assert said(driven(Velocity(9.0, yaw_rate=-9.0), 18))[-1] == pytest.approx((0.5, -2.5))
    assert said(driven(Velocity(-9.0, yaw_rate=9.0), 18))[-1] == pytest.approx((-0.5, 2.5))


@pytest.mark.parametrize(("v", "w"), [(0.4, 2.0), (-0.4, -2.0), (0.5, 0.1), (-0.5, 0.1)])
def test_scaling_keeps_the_arc(v: float, w: float) -> None:
    command = Velocity(v, yaw_rate=w)
    scaled = said(driven(command, 20, scale_velocities=True))
    assert scaled[:, 1] / scaled[:, 0] == pytest.approx(command.yaw_rate / command.x)
    assert np.hypot(*scaled[-1]) == pytest.approx(np.hypot(v, w))
    plain = said(driven(command, 3))
    assert plain[0, 1] / plain[0, 0] != pytest.approx(command.yaw_rate / command.x)


def test_the_sideways_part_has_limits_and_a_deadband_of_its_own() -> None:
    own: dict[str, Any] = {
        "max_velocity": (0.5, 0.3, 2.5),
        "min_velocity": (-0.5, -0.2, -2.5),
        "max_accel": (2.5, 1.0, 3.2),
        "max_decel": (-2.5, -2.0, -3.2),
        "deadband_velocity": (0.0, 0.12, 0.0),
    }
    left, right = driven(Velocity(y=9.0), 20, **own), driven(Velocity(y=-9.0), 20, **own)
    assert [each.y for each in left[:4] if each] == pytest.approx([0.0, 0.0, 0.15, 0.2])
    assert [each.y if each else None for each in (left[-1], right[-1])] == pytest.approx(
        [0.3, -0.2]
    )
    assert driven(Velocity(0.4, y=0.1), 9)[-1] == Velocity(0.4)


def test_a_command_that_ceases_brings_the_robot_to_rest_and_then_silence() -> None:
    velocities = driven(Velocity(0.4), 40)
    speeds = said(velocities)
    assert speeds[20, 0] == pytest.approx(0.4)  # 1 s: the command still holds
    assert speeds[-1] == pytest.approx((0.0, 0.0))
    assert 22 <= len(speeds) <= 26
    assert velocities[len(speeds) :] == [None] * (40 - len(speeds))


def test_by_default_it_limits_as_nav2_and_the_shipped_robot_by_nothing() -> None:
    assert SmoothingConfig() == load(SmoothingConfig, LIMITS)
    shipped = for_node(shipped_parameters(), "velocity_smoother")
    smoother = VelocitySmoother(load(SmoothingConfig, {key: shipped[key] for key in LIMITS}))
    for k, v in enumerate((3.0, -3.0, 0.0)):
        smoother.take(Velocity(v, yaw_rate=2.0 * v), k * PERIOD)
        assert smoother.tick(STILL, k * PERIOD) == Velocity(v, yaw_rate=2.0 * v)


def test_of_commands_at_one_time_the_last_counts() -> None:
    smoother = VelocitySmoother(load(SmoothingConfig, LIMITS))
    for v in (0.4, -0.4):
        smoother.take(Velocity(v), 0.0)
        said = smoother.tick(STILL, 0.0)
    assert said == Velocity(pytest.approx(-2.5 * PERIOD))  # type: ignore[arg-type]


def test_commands_come_as_often_as_they_like() -> None:
    smoother = VelocitySmoother(load(SmoothingConfig, LIMITS))
    for k in range(10):
        smoother.take(Velocity(0.5), 0.01 * k)
        said = smoother.tick(STILL, 0.01 * k)
    assert said is not None
    assert said.x == pytest.approx(2.5 * (PERIOD + 0.09))


def test_nothing_is_said_before_the_first_command() -> None:
    assert VelocitySmoother(SmoothingConfig()).tick(STILL, 5.0) is None


def test_speeds_within_the_deadband_are_zero_but_not_forgotten() -> None:
    speeds = said(driven(Velocity(0.4), 10, deadband_velocity=(0.2, 0.0, 0.0)))
    assert speeds[0, 0] == 0.0
    assert speeds[-1, 0] == pytest.approx(0.4)


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("max_velocity", (0.5, 0.0)),
        ("max_accel", (-1.0, 0.0, 1.0)),
        ("max_decel", (1.0, 0.0, -1.0)),
        ("min_velocity", (0.1, 0.0, 0.0)),
    ],
)
def test_limits_that_make_no_sense_are_refused(name: str, value: tuple[float, ...]) -> None:
    with pytest.raises(ConfigError, match=f"'{name}' is .* valid: \\[x, y, theta\\]"):
        load(SmoothingConfig, {name: value})


@pytest.mark.parametrize(
    ("first", "then"),
    [
        (Velocity(0.4, yaw_rate=0.6), STILL),
        (Velocity(0.4, yaw_rate=0.6), Velocity(-0.4, yaw_rate=0.6)),
        (Velocity(0.4, yaw_rate=-0.6), Velocity(0.2, yaw_rate=2.0)),
        (STILL, Velocity(yaw_rate=1.0)),
    ],
)
def test_a_steered_robot_is_never_bent_too_tightly(first: Velocity, then: Velocity) -> None:
    smoother = VelocitySmoother(load(SmoothingConfig, {**LIMITS, "min_turning_radius": 0.6}))
    velocities = []
    for k in range(30):
        smoother.take(first if k < 12 else then, k * PERIOD)
        velocities.append(smoother.tick(STILL, k * PERIOD))
    speeds = said(velocities)
    assert (np.abs(speeds[:, 1]) <= np.abs(speeds[:, 0]) / 0.6 + 1e-9).all()
    assert speeds[11] == pytest.approx((first.x, first.yaw_rate))
    most = min(abs(then.yaw_rate), abs(then.x) / 0.6)
    assert speeds[-1] == pytest.approx((then.x, most))


@pytest.mark.parametrize("shaping", [{"scale_velocities": True}, {"min_turning_radius": 0.4}])
def test_what_is_measured_on_an_axis_that_is_not_driven_holds_nothing_back(
    shaping: dict[str, Any],
) -> None:
    rng = np.random.default_rng(3)
    values = {**LIMITS, **shaping, "feedback": "CLOSED_LOOP"}
    smoother = VelocitySmoother(load(SmoothingConfig, values))
    measured = STILL
    for k in range(40):
        smoother.take(Velocity(0.4, yaw_rate=0.5), k * PERIOD)
        measured = smoother.tick(measured, k * PERIOD) or STILL
        measured = Velocity(measured.x, y=rng.normal(0.0, 0.01), yaw_rate=measured.yaw_rate)
    assert (measured.x, measured.yaw_rate) == pytest.approx((0.4, 0.5))
    for k in range(40, 90):
        stopping = smoother.tick(measured, k * PERIOD) or STILL
        measured = Velocity(stopping.x, y=rng.normal(0.0, 0.01), yaw_rate=stopping.yaw_rate)
    assert (measured.x, measured.yaw_rate) == (0.0, 0.0)
