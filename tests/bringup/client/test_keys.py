"""Driving by keys: both layouts, speeds, quitting."""

from __future__ import annotations

import pytest

from arjuna_core.twist import STILL, Velocity
from bringup.client.keys import Driving


@pytest.mark.parametrize(
    ("key", "velocity"),
    [("w", (0.3, 0.0)), ("s", (-0.3, 0.0)), ("a", (0.0, 0.5)), ("d", (0.0, -0.5)), ("x", (0, 0))],
)
def test_wasd_drives_as_the_first_guide_says(key: str, velocity: tuple[float, float]) -> None:
    assert Driving().pressed(key).velocity == Velocity(velocity[0], yaw_rate=velocity[1])


@pytest.mark.parametrize(
    ("key", "signs"),
    [
        *[("u", (1, 1)), ("i", (1, 0)), ("o", (1, -1)), ("j", (0, 1)), ("k", (0, 0))],
        *[("l", (0, -1)), ("m", (-1, -1)), (",", (-1, 0)), (".", (-1, 1))],
    ],
)
def test_the_twist_layout_is_that_of_teleop_twist_keyboard(
    key: str, signs: tuple[int, int]
) -> None:
    driven = Driving("twist", 0.5, 1.0).pressed(key)
    assert driven.velocity == Velocity(0.5 * signs[0], yaw_rate=1.0 * signs[1])


@pytest.mark.parametrize(
    ("key", "signs"),
    [
        *[("U", (1, 1)), ("I", (1, 0)), ("O", (1, -1)), ("J", (0, 1)), ("K", (0, 0))],
        *[("L", (0, -1)), ("M", (-1, 1)), ("<", (-1, 0)), (">", (-1, -1))],
    ],
)
def test_with_shift_its_keys_drive_sideways(key: str, signs: tuple[int, int]) -> None:
    driven = Driving("twist", 0.5, 1.0).pressed("u").pressed(key)
    assert driven.velocity == Velocity(0.5 * signs[0], y=0.5 * signs[1])


@pytest.mark.parametrize(
    ("key", "speed", "turn"),
    [
        *[("q", 0.55, 1.1), ("z", 0.45, 0.9), ("w", 0.55, 1.0), ("x", 0.45, 1.0)],
        *[("e", 0.5, 1.1), ("c", 0.5, 0.9)],
    ],
)
def test_speed_keys_change_what_the_robot_does_now(key: str, speed: float, turn: float) -> None:
    forward = Driving("twist", 0.5, 1.0).pressed("u").pressed(key)
    assert forward.velocity.x == pytest.approx(speed)
    assert forward.velocity.yaw_rate == pytest.approx(turn)


@pytest.mark.parametrize("layout", ["wasd", "twist"])
def test_an_unknown_key_stops(layout: str) -> None:
    assert Driving(layout, shares=Velocity(1.0, yaw_rate=1.0)).pressed("7").velocity == STILL


@pytest.mark.parametrize(("layout", "key"), [("wasd", "q"), ("wasd", "\x03"), ("twist", "\x03")])
def test_quitting_asks_for_a_stop(layout: str, key: str) -> None:
    end = Driving(layout, shares=Velocity(1.0)).pressed(key)
    assert end.done
    assert end.velocity == STILL
