"""Docking and undocking: a point robot that drives, and orders that are ticked by hand."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from arjuna_core.grid import GridFrame
from arjuna_core.se2 import IDENTITY, SE2, wrap
from arjuna_core.twist import STILL
from arjuna_nav.costmap.costmap import LETHAL, Costmap
from arjuna_nav.costmap.footprint import Footprint
from arjuna_nav.docking.approach import ApproachConfig
from arjuna_nav.docking.dock_types import DockSenses, DockType
from arjuna_nav.docking.docking import (
    Docking,
    DockingConfig,
    DockingError,
    DockingPhase,
    DockingState,
    DockingStep,
    Undocking,
    docked_pose,
)
from tests.nav.docking.test_dock_types import DOCK, UNSEEN, kind

DT = 0.02
FOOTPRINT = Footprint.circle(0.25)
STAGING = DOCK @ SE2(-0.7, 0.0, 0.0)
FINE = DockingConfig(
    undock_linear_tolerance=0.02,
    undock_angular_tolerance=0.03,
    controller=ApproachConfig(v_linear_min=0.03, v_linear_max=0.2),
)
CONFIG = DockingConfig(
    initial_perception_timeout=2.0,
    wait_charge_timeout=3.0,
    dock_approach_timeout=4.0,
    dock_prestaging_tolerance=0.5,
    max_retries=1,
)


class World:
    """A robot that moves as commanded, a dock, and what can be wrong."""

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

    def run(self, order: Docking | Undocking, limit: float = 300.0) -> tuple[DockingError, str]:
        while self.now < limit:
            if isinstance(order, Docking):
                step = order.tick(self.state(), self.nominal)
                self.phases += [order.phase] if self.phases[-1:] != [order.phase] else []
            else:
                step = order.tick(self.state())
            if step.ended is not None:
                return step.ended, step.message
            if step.stage:
                self.pose, self.staged = STAGING, True
            if step.velocity is not None:
                motion = np.array([step.velocity.x, 0.0, step.velocity.yaw_rate])
                self.pose = self.pose @ SE2.exp(motion * DT)
            self.now += DT
        raise AssertionError(f"no end within {limit} s")


def docking(config: DockingConfig = FINE, navigate: bool = False, **values: Any) -> Docking:
    return Docking(
        config, kind(**{"docking_threshold": 0.02, **values}), FOOTPRINT, navigate, 100.0
    )


@pytest.mark.parametrize("backward", [False, True])
@pytest.mark.parametrize("aside", [-0.15, 0.0, 0.2])
@pytest.mark.parametrize("turned", [-0.3, 0.0, 0.4])
def test_it_docks_from_near_the_staging_pose(aside: float, turned: float, backward: bool) -> None:
    """With Nav2's gains, from poses that navigation reaches."""
    offset = SE2(-0.8, aside, turned) if not backward else SE2(0.8, aside, turned)
    world = World(DOCK @ offset)
    world.nominal = docked_pose(DOCK, backward)
    config = replace(FINE, dock_backwards=backward)
    assert world.run(docking(config)) == (DockingError.NONE, "")
    assert world.pose.distance(DOCK) < 0.02
    assert abs(wrap(world.pose.theta - DOCK.theta)) < math.radians(3.0)


def test_it_drives_to_the_staging_pose_where_that_is_far() -> None:
    world = World(IDENTITY)
    assert world.run(docking(navigate=True))[0] is DockingError.NONE
    assert world.phases == list(DockingPhase)[:4]


def test_a_dock_lost_from_sight_is_tried_again() -> None:
    world = World(STAGING)
    world.sees = lambda now: not 2.0 < now < 2.5
    order = docking()
    assert world.run(order)[0] is DockingError.NONE
    assert order.retries == 1
    assert DockingPhase.RETRY in world.phases


def test_without_charge_it_gives_up_after_its_retries() -> None:
    world = World(STAGING)
    world.current = lambda distance: 0.0
    order = docking()
    error, message = world.run(order)
    assert (error, order.retries) == (DockingError.FAILED_TO_CHARGE, 3)
    assert "5 s after contact" in message


def test_who_charges_already_stays() -> None:
    world = World(DOCK)
    assert world.run(docking())[0] is DockingError.NONE
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
    error, message = world.run(docking(replace(FINE, max_retries=0)))
    assert error is DockingError.FAILED_TO_CONTROL
    assert "collision ahead" in message
    world = World(DOCK @ SE2(-0.9, 0.0, 0.0))
    world.costmap = _wall()
    wide = replace(FINE, controller=replace(FINE.controller, dock_collision_threshold=1.0))
    assert world.run(docking(wide))[0] is DockingError.NONE


@pytest.mark.parametrize(("server", "own"), [(True, "forward"), (False, "backward")])
def test_a_kind_of_docks_says_itself_how_the_robot_enters(server: bool, own: str) -> None:
    backward = own == "backward"
    world = World(DOCK @ SE2(0.8 if backward else -0.8))
    world.nominal = docked_pose(DOCK, backward)
    order = docking(replace(FINE, dock_backwards=server), dock_direction=own)
    assert world.run(order) == (DockingError.NONE, "")
    assert world.pose.distance(DOCK) < 0.02


@pytest.mark.parametrize(
    ("server", "own"), [(False, ""), (True, ""), (True, "forward"), (False, "backward")]
)
def test_it_undocks_straight_to_the_staging_pose(server: bool, own: str) -> None:
    config, backward = (
        replace(FINE, dock_backwards=server),
        own == "backward" or (server and not own),
    )
    dock = kind(staging_yaw_offset=math.pi if backward else 0.0, dock_direction=own)
    world = World(DOCK)
    assert world.run(Undocking(config, dock, FOOTPRINT, 30.0)) == (DockingError.NONE, "")
    away = DOCK @ SE2(0.7 if backward else -0.7, 0.0, 0.0)
    assert world.pose.distance(away) < 0.025
    assert abs(wrap(world.pose.theta - DOCK.theta)) < math.radians(2.0)


def test_undocking_fails_where_it_lasts_or_the_battery_still_charges() -> None:
    world = World(DOCK)
    error, message = world.run(Undocking(FINE, kind(), FOOTPRINT, 1.0))
    assert (error, "1 s" in message) == (DockingError.FAILED_TO_CONTROL, True)
    world = World(DOCK)
    world.current = lambda distance: 2.0
    error, message = world.run(Undocking(FINE, kind(), FOOTPRINT, 30.0))
    assert (error, "still charges" in message) == (DockingError.FAILED_TO_CONTROL, True)


def test_who_is_in_no_dock_need_not_undock() -> None:
    world = World(IDENTITY)
    assert Undocking(FINE, kind(), FOOTPRINT, 30.0).tick(world.state()).ended is DockingError.NONE
    order = Undocking(FINE, kind(), FOOTPRINT, 30.0, docked=True)  # it rolled on a little
    assert order.tick(world.state()).ended is None


class Ordered:
    """An order to dock that is ticked by hand."""

    def __init__(
        self, dock: DockType | None = None, config: DockingConfig = CONFIG, navigate: bool = False
    ) -> None:
        self.docking = Docking(config, dock or kind(), Footprint.circle(0.25), navigate, 9.0)

    def tick(
        self, now: float, pose: SE2 = STAGING, dock: SE2 | None = DOCK, **fields: Any
    ) -> DockingStep:
        senses = fields.pop("senses", UNSEEN)
        return self.docking.tick(DockingState(now, pose, dock, senses, None, **fields), DOCK)

    @property
    def phase(self) -> DockingPhase:
        return self.docking.phase

    def approaching(self, now: float = 0.0) -> Ordered:
        for _ in range(2):
            assert self.tick(now) == DockingStep()
        assert self.phase is DockingPhase.CONTROLLING
        return self


def test_it_drives_to_the_staging_pose_only_from_far_and_if_it_is_to() -> None:
    near, far = STAGING @ SE2(0.49), STAGING @ SE2(-0.51)
    for pose, navigate, drives in ((far, True, True), (near, True, False), (far, False, False)):
        order = Ordered(navigate=navigate)
        step = order.tick(0.0, pose)
        assert step == (DockingStep(None, stage=True) if drives else DockingStep())
        perceives = order.phase is DockingPhase.INITIAL_PERCEPTION
        assert perceives is not drives


@pytest.mark.parametrize(
    ("now", "staged", "message"),
    [
        (9.0, None, None),
        (9.1, None, "driving to the staging pose took over 9 s"),
        (1.0, False, "driving to the staging pose failed"),
    ],
)
def test_staging_times_out_or_fails(now: float, staged: bool | None, message: str | None) -> None:
    order = Ordered(navigate=True)
    order.tick(0.0, IDENTITY)
    step = order.tick(now, IDENTITY, staged=staged)
    if message is None:
        assert step == DockingStep(velocity=None)
        assert order.tick(now, IDENTITY, staged=True) == DockingStep()
        assert order.phase is DockingPhase.INITIAL_PERCEPTION
    else:
        assert (step.ended, step.message) == (DockingError.FAILED_TO_STAGE, message)


def test_the_dock_is_looked_for_for_a_time() -> None:
    order = Ordered()
    order.tick(1.0, dock=None)
    assert order.tick(3.0, dock=None) == DockingStep()
    step = order.tick(3.1, dock=None)
    assert step.ended is DockingError.FAILED_TO_DETECT_DOCK
    assert step.message == "the dock was not seen within 2 s"


@pytest.mark.parametrize(
    ("now", "fields", "why"),
    [
        (4.0, {}, None),
        (4.1, {}, (DockingError.FAILED_TO_CONTROL, "no contact within 4 s")),
        (1.0, {"dock": None}, (DockingError.FAILED_TO_DETECT_DOCK, "the dock was lost from sight")),
        (1.0, {"pose": DOCK @ SE2(0.049, 0.2)}, None),
        (
            1.0,
            {"pose": DOCK @ SE2(0.06, 0.2)},
            (DockingError.FAILED_TO_CONTROL, "passed the dock by 0.06 m"),
        ),
    ],
)
def test_an_approach_that_fails_is_tried_again_and_then_given_up(
    now: float, fields: dict[str, Any], why: tuple[DockingError, str] | None
) -> None:
    order = Ordered().approaching()
    step = order.tick(now, **fields)
    if why is None:
        assert step.velocity != STILL
        assert order.phase is DockingPhase.CONTROLLING
        return
    assert step == DockingStep()
    assert (order.phase, order.docking.retries) == (DockingPhase.RETRY, 1)
    spent = Ordered(config=replace(CONFIG, max_retries=0)).approaching()
    assert spent.tick(now, **fields) == DockingStep(ended=why[0], message=why[1])


def test_a_robot_that_docks_backwards_passes_the_dock_ahead() -> None:
    config = replace(CONFIG, dock_backwards=True, max_retries=0)
    past, before = (docked_pose(DOCK, True) @ SE2(x, 0.2) for x in (-0.06, 0.3))
    assert Ordered(config=config).approaching().tick(1.0, past).ended is not None
    velocity = Ordered(config=config).approaching().tick(1.0, before).velocity
    assert velocity is not None
    assert velocity.x < 0.0


def test_after_contact_it_waits_for_the_current_or_has_done() -> None:
    contact = DockSenses(distance=0.01, current=0.0)
    order = Ordered().approaching()
    assert order.tick(1.0, DOCK, senses=contact) == DockingStep()
    assert order.phase is DockingPhase.WAIT_FOR_CHARGE
    assert order.tick(4.0, DOCK, senses=contact) == DockingStep()
    charged = replace(contact, current=1.0)
    assert order.tick(4.1, DOCK, senses=charged) == DockingStep(ended=DockingError.NONE)
    late = Ordered(config=replace(CONFIG, max_retries=0)).approaching()
    late.tick(1.0, DOCK, senses=contact)
    step = late.tick(4.1, DOCK, senses=contact)
    assert step.ended is DockingError.FAILED_TO_CHARGE
    assert step.message == "the battery does not charge 3 s after contact"
    plain = Ordered(kind(charges=False)).approaching()
    assert plain.tick(1.0, DOCK, senses=contact) == DockingStep(ended=DockingError.NONE)


def test_to_try_again_it_drives_back_and_looks_again_or_says_what_had_failed() -> None:
    order = Ordered().approaching()
    order.tick(4.1, DOCK @ SE2(-0.2))
    back = order.tick(4.2, DOCK @ SE2(-0.2)).velocity
    assert back is not None
    assert back.x < 0.0
    stuck = order.tick(8.2, DOCK @ SE2(-0.2))
    assert stuck.ended is DockingError.FAILED_TO_CONTROL
    assert stuck.message == "no path back to the staging pose, after: no contact within 4 s"
    order = Ordered().approaching()
    order.tick(4.1, DOCK @ SE2(-0.2))
    assert order.tick(5.0, STAGING) == DockingStep()
    assert order.phase is DockingPhase.INITIAL_PERCEPTION
    assert order.docking.retries == 1
