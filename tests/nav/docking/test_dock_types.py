"""Types of docks and the approach to them."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from arjuna_core.config import load
from arjuna_core.errors import ConfigError, InputFileError
from arjuna_core.se2 import IDENTITY, SE2
from arjuna_core.twist import STILL, Velocity
from arjuna_nav.docking.approach import ApproachConfig, at_the_end, foreseen, steer
from arjuna_nav.docking.dock_types import (
    DOCK_TYPES,
    DockSenses,
    DockType,
    read_docks,
    unknown_types,
)
from arjuna_nav.docking.docking import docked_pose

STALLS = {
    "use_stall_detection": True,
    "stall_joint_names": ["left"],
    "stall_velocity_threshold": 0.5,
    "stall_effort_threshold": 2.0,
}
DOCK = SE2(2.0, 1.0, 0.6)
UNSEEN = DockSenses()


def kind(charges: bool = True, **values: Any) -> DockType:
    name = "SimpleChargingDock" if charges else "SimpleNonChargingDock"
    cls = DOCK_TYPES.resolve(f"opennav_docking::{name}")
    made: DockType = cls(load(cls.Config, values))
    return made


@pytest.mark.parametrize(
    ("values", "senses", "docked"),
    [
        ({"docking_threshold": 0.04}, DockSenses(distance=0.039), True),
        ({"docking_threshold": 0.04}, DockSenses(distance=0.04), False),
        ({}, UNSEEN, False),
        (STALLS, DockSenses(distance=9.0, effort=2.1, speed=0.4), True),
        (STALLS, DockSenses(distance=0.0, effort=2.0, speed=0.4), False),
        (STALLS, DockSenses(distance=0.0, effort=2.1, speed=0.5), False),
        (STALLS, DockSenses(distance=0.0, effort=2.1), False),
        (STALLS, DockSenses(distance=0.0, speed=0.1), False),
    ],
)
def test_contact_shows_by_distance_or_by_joints_that_push_without_moving(
    values: dict[str, Any], senses: DockSenses, docked: bool
) -> None:
    for charges in (True, False):
        assert kind(charges, **values).is_docked(senses) is docked
    assert kind(use_battery_status=False, **values).is_charging(senses) is docked
    assert kind(charges=False, **values).is_charging(senses) is False


@pytest.mark.parametrize(("current", "charges"), [(0.6, True), (0.5, False), (None, False)])
def test_a_battery_charges_above_a_current(current: float | None, charges: bool) -> None:
    senses = DockSenses(distance=0.0, current=current)
    assert kind(charging_threshold=0.5).is_charging(senses) is charges
    assert kind().charges
    assert not kind(charges=False).charges


def test_a_robot_stages_before_the_dock_and_stands_in_it_forwards_or_backwards() -> None:
    dock = kind(staging_x_offset=-0.9, staging_yaw_offset=0.3)
    assert dock.staging_pose(DOCK).array() == pytest.approx((DOCK @ SE2(-0.9, 0.0, 0.3)).array())
    assert docked_pose(DOCK, False) == DOCK
    turned = docked_pose(DOCK, True)
    assert turned.array() == pytest.approx([2.0, 1.0, 0.6 - math.pi])
    assert docked_pose(turned, True).array() == pytest.approx(DOCK.array())


def test_stall_detection_needs_joints() -> None:
    with pytest.raises(ConfigError, match="stall_joint_names"):
        kind(False, use_stall_detection=True)


def test_docks_are_read_from_a_file(tmp_path: Path) -> None:
    file = tmp_path / "docks.yaml"
    text = "docks: {home: {type: a, frame: odom, pose: [1, 2.0, 0.5], typ: b}}"
    file.write_text(text, encoding="utf-8")
    warned: list[str] = []
    docks = read_docks(file, warned.append)
    assert warned == [f"{file}: home: unknown parameter 'typ'; the nearest is 'type'"]
    assert docks["home"].docked == SE2(1.0, 2.0, 0.5)
    assert unknown_types(docks, ["a", "b"]) == []
    assert "valid: b" in unknown_types(docks, ["b"])[0]


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("docks: [1]", "expected 'docks"),
        ("{}", "expected 'docks"),
        ("docks: {home: {type: a}}", "pose' is missing"),
        ("docks: {home: {pose: [1, 2]}}", "has 2 numbers"),
        ("docks: {home: {pose: [.nan, 2, 3]}}", "not a number"),
    ],
)
def test_a_file_without_docks_says_what_is_wrong(tmp_path: Path, text: str, says: str) -> None:
    file = tmp_path / "docks.yaml"
    file.write_text(text, encoding="utf-8")
    with pytest.raises(InputFileError, match=says):
        read_docks(file, lambda sentence: None)


AT = SE2(2.0, 1.0, 0.6)


@pytest.mark.parametrize("seed", range(5))
def test_the_law_keeps_its_limits_and_is_the_same_mirrored(seed: int) -> None:
    config = ApproachConfig()
    rng = np.random.default_rng(seed)
    for x, y, theta in rng.uniform(-2.0, 2.0, (200, 3)):
        target = SE2(float(x), float(y), float(theta))
        drive = steer(config, target)
        assert abs(drive.yaw_rate) <= config.v_angular_max + 1e-12
        assert 0.0 <= drive.x <= config.v_linear_max + 1e-12
        mirrored = steer(config, SE2(target.x, -target.y, -target.theta))
        assert (mirrored.x, mirrored.yaw_rate) == pytest.approx((drive.x, -drive.yaw_rate))
        back = steer(config, SE2(-target.x, target.y, -target.theta), backward=True)
        assert (back.x, back.yaw_rate) == pytest.approx((-drive.x, -drive.yaw_rate), abs=1e-9)


@pytest.mark.parametrize("backward", [False, True])
@pytest.mark.parametrize(
    ("ahead", "left", "turned", "drives"),
    [
        (0.05, 0.0, 0.0, "on"),
        (0.08, 0.05, 0.19, "on"),
        (0.08, 0.07, 0.0, None),  # 0.106 m off
        (0.05, 0.0, 0.21, None),
        (0.05, 0.0, -0.2, None),
        (0.0, 0.05, 0.0, "stands"),
        (-0.3, 0.05, 0.0, "stands"),  # gone past it
        (-0.3, 0.11, 0.0, None),
        (-0.3, 0.0, 0.3, None),
    ],
)
def test_so_near_the_end_it_drives_straight_until_it_is_level(
    backward: bool, ahead: float, left: float, turned: float, drives: str | None
) -> None:
    config, side = ApproachConfig(v_linear_min=0.03), -1.0 if backward else 1.0
    target = SE2(side * ahead, left, turned)
    expected = {"on": Velocity(side * 0.03), "stands": STILL, None: None}[drives]
    assert at_the_end(config, IDENTITY, target, (0.1, 0.2), backward) == expected


def test_the_law_slows_down_near_the_pose_and_what_is_foreseen_is_what_it_drives() -> None:
    config = ApproachConfig(
        v_linear_min=0.02, v_linear_max=0.25, slowdown_radius=0.5, projection_time=1.0
    )
    for distance, v in ((0.6, 0.25), (0.5, 0.25), (0.2, 0.1), (0.01, 0.02)):
        assert steer(config, SE2(distance)) == Velocity(pytest.approx(v))  # type: ignore[arg-type]
        assert steer(config, SE2(-distance), backward=True).x == pytest.approx(-v)
    poses = foreseen(config, AT, AT @ SE2(1.0, 0.3, 0.2), False)
    assert len(poses) == 11
    pose = AT
    for expected in poses:
        assert pose.array() == pytest.approx(expected)
        velocity = steer(config, pose.inverse() @ AT @ SE2(1.0, 0.3, 0.2))
        pose = pose @ SE2.exp((0.1 * velocity.x, 0.0, 0.1 * velocity.yaw_rate))
    assert len(foreseen(config, IDENTITY, SE2(0.024), False)) == 1, "it is there"
    assert len(foreseen(config, IDENTITY, SE2(0.026), False)) == 2
    assert steer(ApproachConfig(), IDENTITY) != STILL  # the pose itself is no division by zero
