"""Any lidar: 90 to 360 degrees, 50 to 2880 beams, any direction and mount, counts that vary."""

from __future__ import annotations

import math

import numpy as np
import pytest

from arjuna_core.se2 import SE2
from arjuna_slam.slam import Slam
from tests.slam.slam_room import drive, room, scan_at

LOG = drive(seed=5, laps=0.6)
MIDDLE = SE2()


@pytest.mark.parametrize(
    ("beams", "degrees", "clockwise", "mount", "limit"),
    [
        ((50, 50), 90.0, False, MIDDLE, 0.05),
        ((50, 50), 360.0, True, MIDDLE, 0.02),
        ((181, 181), 180.0, False, SE2(0.3, -0.2, 2.5), 0.02),
        ((720, 720), 270.0, True, SE2(-0.5, 0.5, -3.0), 0.02),
        ((2880, 2880), 360.0, False, SE2(0.1, 0.0, math.pi / 2), 0.02),
        ((100, 400), 270.0, False, MIDDLE, 0.02),
    ],
)
def test_the_pose_is_kept_with_any_lidar(
    beams: tuple[int, int], degrees: float, clockwise: bool, mount: SE2, limit: float
) -> None:
    rng = np.random.default_rng(1)
    slam, gaps = Slam(), []
    for scan, odometry, truth in LOG:
        seen = scan_at(
            room(), truth, beams=int(rng.integers(beams[0], beams[1] + 1)),
            field_of_view=math.radians(degrees), sigma=0.01, rng=rng, stamp=scan.stamp,
            clockwise=clockwise, T_base_sensor=mount,
        )  # fmt: skip
        update = slam.process(seen, odometry)
        assert update is not None
        gaps.append((LOG[0][2] @ update.T_map_base).distance(truth))
    assert math.sqrt(np.mean(np.square(gaps))) < limit
    assert slam.map() is not None
