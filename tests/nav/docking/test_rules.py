"""Docking's rules one by one: what shows contact and charge, what waits how long, what fails."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import pytest

from arjuna_core.config import load
from arjuna_core.se2 import IDENTITY, SE2
from arjuna_core.twist import STILL, Velocity
from arjuna_nav.costmap.footprint import Footprint
from arjuna_nav.docking.approach import ApproachConfig, at_the_end, foreseen, steer
from arjuna_nav.docking.dock_types import DOCK_TYPES, DockSenses, DockType
from arjuna_nav.docking.docking import (
    Docking,
    DockingConfig,
    DockingError,
    DockingPhase,
    DockingState,
    DockingStep,
    docked_pose,
)

STALLS = {
    "use_stall_detection": True,
    "stall_joint_names": ["left"],
    "stall_velocity_threshold": 0.5,
    "stall_effort_threshold": 2.0,
}
CONFIG = DockingConfig(
    initial_perception_timeout=2.0,
    wait_charge_timeout=3.0,
    dock_approach_timeout=4.0,
    dock_prestaging_tolerance=0.5,
    max_retries=1,
)
DOCK, STAGING = SE2(2.0, 1.0, 0.6), SE2(2.0, 1.0, 0.6) @ SE2(-0.7, 0.0, 0.0)
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
def test_contact_shows_by_distance_or_by_joints_that_push_in_vain(
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


def test_a_robot_stages_before_the_dock_and_stands_in_it_either_way_round() -> None:
    dock = kind(staging_x_offset=-0.9, staging_yaw_offset=0.3)
    assert dock.staging_pose(DOCK).array() == pytest.approx((DOCK @ SE2(-0.9, 0.0, 0.3)).array())
    assert docked_pose(DOCK, False) == DOCK
    turned = docked_pose(DOCK, True)
    assert turned.array() == pytest.approx([2.0, 1.0, 0.6 - math.pi])
    assert docked_pose(turned, True).array() == pytest.approx(DOCK.array())


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
def test_so_near_the_end_it_goes_straight_on_until_it_is_level(
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
    poses = foreseen(config, DOCK, DOCK @ SE2(1.0, 0.3, 0.2), False)
    assert len(poses) == 11
    pose = DOCK
    for expected in poses:
        assert pose.array() == pytest.approx(expected)
        velocity = steer(config, pose.inverse() @ DOCK @ SE2(1.0, 0.3, 0.2))
        pose = pose @ SE2.exp((0.1 * velocity.x, 0.0, 0.1 * velocity.yaw_rate))
    assert len(foreseen(config, IDENTITY, SE2(0.024), False)) == 1, "it is there"
    assert len(foreseen(config, IDENTITY, SE2(0.026), False)) == 2


class Ordered:
    """An order to dock that is ticked by hand."""

    def __init__(
        self, dock: DockType | None = None, config: DockingConfig = CONFIG, navigate: bool = False
    ) -> None:
        self.docking = Docking(config, dock or kind(), Footprint.circle(0.25), navigate, 9.0)

    def tick(
        self, now: float, pose: SE2 = STAGING, dock: SE2 | None = DOCK, **told: Any
    ) -> DockingStep:
        senses = told.pop("senses", UNSEEN)
        return self.docking.tick(DockingState(now, pose, dock, senses, None, **told), DOCK)

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
def test_staging_ends_by_its_time_or_failure(
    now: float, staged: bool | None, message: str | None
) -> None:
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
    ("now", "told", "why"),
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
    now: float, told: dict[str, Any], why: tuple[DockingError, str] | None
) -> None:
    order = Ordered().approaching()
    step = order.tick(now, **told)
    if why is None:
        assert step.velocity != STILL
        assert order.phase is DockingPhase.CONTROLLING
        return
    assert step == DockingStep()
    assert (order.phase, order.docking.retries) == (DockingPhase.RETRY, 1)
    spent = Ordered(config=replace(CONFIG, max_retries=0)).approaching()
    assert spent.tick(now, **told) == DockingStep(ended=why[0], message=why[1])


def test_a_robot_that_docks_backwards_passes_the_dock_the_other_way() -> None:
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


def test_to_try_again_it_drives_back_and_looks_anew_or_says_what_had_failed() -> None:
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
