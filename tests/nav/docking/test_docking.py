"""Docking and undocking of a robot that is a point: where it ends, and how it fails."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from arjuna_core.config import load
from arjuna_core.errors import ConfigError, InputFileError
from arjuna_core.grid import GridFrame
from arjuna_core.se2 import IDENTITY, SE2, wrap
from arjuna_core.twist import STILL
from arjuna_nav.costmap.costmap import LETHAL, Costmap
from arjuna_nav.costmap.footprint import Footprint
from arjuna_nav.docking.approach import ApproachConfig, foreseen, steer
from arjuna_nav.docking.database import DOCKS, read_docks, unknown_types
from arjuna_nav.docking.dock_types import DOCK_TYPES, DockSenses, DockType
from arjuna_nav.docking.docking import (
    Docking,
    DockingConfig,
    DockingError,
    DockingPhase,
    DockingState,
    Undocking,
    docked_pose,
)

DT = 0.02
DOCK = SE2(2.0, 1.0, 0.6)
FOOTPRINT = Footprint.circle(0.25)
FINE = DockingConfig(
    undock_linear_tolerance=0.02,
    undock_angular_tolerance=0.03,
    controller=ApproachConfig(v_linear_min=0.03, v_linear_max=0.2),
)


def kind(charges: bool = True, **values: object) -> DockType:
    names = {True: "SimpleChargingDock", False: "SimpleNonChargingDock"}
    cls = DOCK_TYPES.resolve(f"opennav_docking::{names[charges]}")
    made: DockType = cls(load(cls.Config, {"docking_threshold": 0.02, **values}))
    return made


class World:
    """A robot that moves as it is told, a dock, and what can be wrong."""

    def __init__(self, pose: SE2) -> None:
        self.pose = pose
        self.nominal = DOCK
        self.now = 0.0
        self.sees: Callable[[float], bool] = lambda now: True
        self.current: Callable[[float], float] = lambda distance: float(distance < 0.02)
        self.costmap: Costmap | None = None
        self.staged: bool | None = None
        self.phases: list[DockingPhase] = []

    def state(self) -> DockingState:
        distance = self.pose.distance(DOCK)
        senses = DockSenses(distance=distance, current=self.current(distance))
        dock = self.nominal if self.sees(self.now) else None
        return DockingState(self.now, self.pose, dock, senses, self.costmap, self.staged)

    def move(self, velocity: object) -> None:
        if velocity is not None:
            v, w = velocity.x, velocity.yaw_rate  # type: ignore[attr-defined]
            self.pose = self.pose @ SE2.exp(np.array([v, 0.0, w]) * DT)
        self.now += DT

    def dock(self, docking: Docking, limit: float = 300.0) -> tuple[DockingError, str]:
        while self.now < limit:
            step = docking.tick(self.state(), self.nominal)
            self.phases += [docking.phase] if self.phases[-1:] != [docking.phase] else []
            if step.ended is not None:
                return step.ended, step.message
            if step.stage:
                self.pose, self.staged = DOCK @ SE2(-0.7, 0.0, 0.0), True
            self.move(step.velocity)
        raise AssertionError(f"no end within {limit} s")

    def undock(self, undocking: Undocking, limit: float = 60.0) -> tuple[DockingError, str]:
        while self.now < limit:
            step = undocking.tick(self.state())
            if step.ended is not None:
                return step.ended, step.message
            self.move(step.velocity)
        raise AssertionError(f"no end within {limit} s")


def docking(config: DockingConfig = FINE, navigate: bool = False, **values: object) -> Docking:
    return Docking(config, kind(**values), FOOTPRINT, navigate, 100.0)  # type: ignore[arg-type]


@pytest.mark.parametrize("backward", [False, True])
@pytest.mark.parametrize("aside", [-0.15, 0.0, 0.2])
@pytest.mark.parametrize("turned", [-0.3, 0.0, 0.4])
def test_it_docks_from_near_the_staging_pose(aside: float, turned: float, backward: bool) -> None:
    """With Nav2's gains, from places as navigation leaves the robot at."""
    offset = SE2(-0.8, aside, turned) if not backward else SE2(0.8, aside, turned)
    world = World(DOCK @ offset)
    world.nominal = docked_pose(DOCK, backward)
    config = replace(FINE, dock_backwards=backward)
    assert world.dock(docking(config)) == (DockingError.NONE, "")
    assert world.pose.distance(DOCK) < 0.02
    assert abs(wrap(world.pose.theta - DOCK.theta)) < math.radians(3.0)


def test_it_drives_to_the_staging_pose_where_that_is_far() -> None:
    world = World(IDENTITY)
    assert world.dock(docking(navigate=True))[0] is DockingError.NONE
    assert world.phases == list(DockingPhase)[:4]


def test_a_staging_pose_that_is_not_reached_ends_it() -> None:
    world, order = World(IDENTITY), docking(navigate=True)
    assert order.tick(world.state(), DOCK).stage
    world.staged = False
    assert order.tick(world.state(), DOCK).ended is DockingError.FAILED_TO_STAGE
    world, order = World(IDENTITY), docking(navigate=True)
    order.tick(world.state(), DOCK)
    world.now = 100.5
    step = order.tick(world.state(), DOCK)
    assert (step.ended, step.message[-15:]) == (DockingError.FAILED_TO_STAGE, "took over 100 s")


def test_a_dock_that_is_not_seen_is_waited_for_and_no_longer() -> None:
    world = World(DOCK @ SE2(-0.7, 0.0, 0.0))
    world.sees = lambda now: now > 3.0
    assert world.dock(docking())[0] is DockingError.NONE
    world = World(DOCK @ SE2(-0.7, 0.0, 0.0))
    world.sees = lambda now: False
    error, message = world.dock(docking())
    assert (error, "5 s" in message) == (DockingError.FAILED_TO_DETECT_DOCK, True)
    assert world.pose == DOCK @ SE2(-0.7, 0.0, 0.0)


def test_a_dock_lost_from_sight_is_tried_again() -> None:
    world = World(DOCK @ SE2(-0.7, 0.0, 0.0))
    world.sees = lambda now: not 2.0 < now < 2.5
    order = docking()
    assert world.dock(order)[0] is DockingError.NONE
    assert order.retries == 1
    assert DockingPhase.RETRY in world.phases


def test_without_charge_it_gives_up_after_its_retries() -> None:
    world = World(DOCK @ SE2(-0.7, 0.0, 0.0))
    world.current = lambda distance: 0.0
    order = docking()
    error, message = world.dock(order)
    assert (error, order.retries) == (DockingError.FAILED_TO_CHARGE, 3)
    assert "5 s after contact" in message


def test_who_charges_already_stays() -> None:
    world = World(DOCK)
    assert world.dock(docking())[0] is DockingError.NONE
    assert world.now == 0.0


def _wall() -> Costmap:
    """Return a costmap with a wall between the staging pose and the dock."""
    frame = GridFrame(0.05, 80, 80, SE2(0.0, -1.0, 0.0))
    data = np.zeros((80, 80), dtype=np.uint8)
    wall = DOCK @ SE2(-0.5, 0.0, 0.0)
    row, column = frame.to_cell(wall.x, wall.y)
    data[row - 1 : row + 2, column - 1 : column + 2] = LETHAL
    return Costmap(frame, data)


def test_it_stops_before_obstacles_but_not_before_the_dock() -> None:
    world = World(DOCK @ SE2(-0.9, 0.0, 0.0))
    world.costmap = _wall()
    error, message = world.dock(docking(replace(FINE, max_retries=0)))
    assert error is DockingError.FAILED_TO_CONTROL
    assert "collision ahead" in message
    world = World(DOCK @ SE2(-0.9, 0.0, 0.0))
    world.costmap = _wall()
    wide = replace(FINE, controller=replace(FINE.controller, dock_collision_threshold=1.0))
    assert world.dock(docking(wide))[0] is DockingError.NONE


def test_stalled_joints_show_contact() -> None:
    values = {"use_stall_detection": True, "stall_joint_names": ["left"]}
    stalls = kind(False, **values)
    assert stalls.is_docked(DockSenses(distance=1.0, effort=2.0, speed=0.1))
    assert not stalls.is_docked(DockSenses(distance=0.0, effort=0.5, speed=0.1))
    assert not stalls.is_docked(DockSenses(distance=0.0))
    with pytest.raises(ConfigError, match="stall_joint_names"):
        kind(False, use_stall_detection=True)


@pytest.mark.parametrize("backward", [False, True])
def test_it_undocks_straight_to_the_staging_pose(backward: bool) -> None:
    config = replace(FINE, dock_backwards=backward)
    dock = kind(staging_yaw_offset=math.pi if backward else 0.0)
    world = World(DOCK)
    assert world.undock(Undocking(config, dock, FOOTPRINT, 30.0)) == (DockingError.NONE, "")
    away = DOCK @ SE2(0.7 if backward else -0.7, 0.0, 0.0)
    assert world.pose.distance(away) < 0.025
    assert abs(wrap(world.pose.theta - DOCK.theta)) < math.radians(2.0)


def test_undocking_fails_where_it_lasts_or_the_battery_still_charges() -> None:
    world = World(DOCK)
    error, message = world.undock(Undocking(FINE, kind(), FOOTPRINT, 1.0))
    assert (error, "1 s" in message) == (DockingError.FAILED_TO_CONTROL, True)
    world = World(DOCK)
    world.current = lambda distance: 2.0
    error, message = world.undock(Undocking(FINE, kind(), FOOTPRINT, 30.0))
    assert (error, "still charges" in message) == (DockingError.FAILED_TO_CONTROL, True)


def test_who_is_in_no_dock_need_not_undock() -> None:
    world = World(IDENTITY)
    assert Undocking(FINE, kind(), FOOTPRINT, 30.0).tick(world.state()).ended is DockingError.NONE
    order = Undocking(FINE, kind(), FOOTPRINT, 30.0, docked=True)  # it rolled on a little
    assert order.tick(world.state()).ended is None


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


def test_what_is_foreseen_ends_at_the_pose() -> None:
    poses = foreseen(ApproachConfig(projection_time=30.0), IDENTITY, SE2(1.0, 0.2, 0.0), False)
    assert poses[0] == pytest.approx([0.0, 0.0, 0.0])
    assert math.hypot(poses[-1, 0] - 1.0, poses[-1, 1] - 0.2) < 0.03
    assert steer(ApproachConfig(), IDENTITY) != STILL  # the pose itself is no division by zero


def test_docks_are_read_from_a_file(tmp_path: Path) -> None:
    file = tmp_path / "docks.yaml"
    text = "docks: {home: {type: a, frame: odom, pose: [1, 2.0, 0.5], typ: b}}"
    file.write_text(text, encoding="utf-8")
    warned: list[str] = []
    docks = read_docks(file, warned.append)
    assert warned == [f"{file}: home: unknown parameter 'typ'; the nearest is 'type'"]
    assert docks["home"].pose == SE2(1.0, 2.0, 0.5)
    assert unknown_types(docks, ["a", "b"]) == []
    assert "valid: b" in unknown_types(docks, ["b"])[0]
    assert DOCKS.resolve("opennav_docking::Dock").Config().frame == "map"


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
