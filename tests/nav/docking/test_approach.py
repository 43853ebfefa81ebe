"""The drive to a dock: the law near the pose, its limits, and the motion that is foreseen."""

from __future__ import annotations

import numpy as np
import pytest

from arjuna_core.se2 import IDENTITY, SE2
from arjuna_core.twist import STILL, Velocity
from arjuna_nav.docking.approach import ApproachConfig, at_the_end, foreseen, steer

DOCK = SE2(2.0, 1.0, 0.6)


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
    poses = foreseen(config, DOCK, DOCK @ SE2(1.0, 0.3, 0.2), False)
    assert len(poses) == 11
    pose = DOCK
    for expected in poses:
        assert pose.array() == pytest.approx(expected)
        velocity = steer(config, pose.inverse() @ DOCK @ SE2(1.0, 0.3, 0.2))
        pose = pose @ SE2.exp((0.1 * velocity.x, 0.0, 0.1 * velocity.yaw_rate))
    assert len(foreseen(config, IDENTITY, SE2(0.024), False)) == 1, "it is there"
    assert len(foreseen(config, IDENTITY, SE2(0.026), False)) == 2
    assert steer(ApproachConfig(), IDENTITY) != STILL  # the pose itself is no division by zero
