"""Which beams of a scan the filter looks at, where they end, and that a mount may be turned."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from arjuna_core.scan import Scan
from arjuna_core.se2 import SE2
from arjuna_slam.amcl.config import AmclConfig
from arjuna_slam.amcl.recovery import MapMatcher
from arjuna_slam.amcl.scan_view import ScanView
from arjuna_slam.matching.map_field import MapField
from tests.slam.amcl.room import RANGE_MAX, ranges_at, room_map

CONFIG = AmclConfig()
MATCHER = MapMatcher(CONFIG, MapField(room_map(), 2.0))
MOUNTS = [SE2(), SE2(0.3, -0.2, 2.5), SE2(-0.1, 0.2, math.pi)]


def rising(count: int) -> Scan:
    """Return a scan whose ranges number their beams."""
    return Scan(np.linspace(2.0, 3.0, count), -math.pi, math.tau / count, 0.1, 10.0, 3.0)


@pytest.mark.parametrize(
    ("count", "beams", "step", "stride"),
    [
        (360, 60, 6, 2),  # 359 // 59, as nav2_amcl has it
        (119, 60, 2, 1),
        (118, 60, 1, 1),
        (10, 60, 1, 1),
        (180, 31, 5, 1),
        (181, 31, 6, 2),
        (361, 2, 360, 3),
        (1, 2, 1, 1),
    ],
)
def test_beams_are_taken_at_even_steps(count: int, beams: int, step: int, stride: int) -> None:
    scan = rising(count)
    view = ScanView.of(scan, AmclConfig(max_beams=beams))
    np.testing.assert_array_equal(view.few.ranges, scan.ranges[::step])
    np.testing.assert_array_equal(view.many.ranges, scan.ranges[::stride])
    assert view.many.returned.all()
    assert (view.stamp, view.range_max) == (3.0, 10.0)
    assert view.blind is (len(scan.ranges[::stride]) < 10)


@pytest.mark.parametrize(
    ("least", "most", "kept", "returned"),
    [
        (-1.0, 100.0, [0.1, 0.5, 3.0, 10.0, 10.0], 3),  # the scan's own limits
        (0.5, 100.0, [0.5, 3.0, 10.0, 10.0], 2),
        (0.05, -1.0, [0.1, 0.5, 3.0, 10.0, 10.0], 3),
        (-1.0, 3.0, [0.1, 0.5, 3.0, 3.0, 3.0], 2),  # what is at the limit did not return
        (-1.0, 0.0, [], 0),
    ],
)
def test_ranges_are_those_within_limits(
    least: float, most: float, kept: list[float], returned: int
) -> None:
    ranges = np.array([math.nan, 0.09, 0.1, 0.5, 3.0, 10.0, math.inf, -1.0])
    scan = Scan(ranges, 0.0, 0.1, 0.1, 10.0)
    config = AmclConfig(laser_min_range=least, laser_max_range=most)
    beams = ScanView.of(scan, config).many
    assert beams.ranges.tolist() == kept
    assert beams.returned.tolist() == [k < returned for k in range(len(kept))]
    assert len(beams.endpoints) == returned
    assert len(beams.directions) == len(kept)


@pytest.mark.parametrize("mount", MOUNTS)
@pytest.mark.parametrize("motion", [SE2(), SE2(0.2, 0.05, 0.3)])
def test_ends_lie_where_each_beam_ended_seen_from_the_base_at_the_first(
    mount: SE2, motion: SE2
) -> None:
    scan = replace(rising(50), T_base_sensor=mount, motion=motion)
    beams = ScanView.of(scan, CONFIG).many
    for k, range_ in enumerate(scan.ranges.tolist()):
        base = SE2.exp(motion.log() * k / 49)
        angle = scan.angle_min + k * scan.angle_increment
        end = (base @ mount @ SE2(range_ * math.cos(angle), range_ * math.sin(angle))).array()
        assert beams.endpoints[k] == pytest.approx(end[:2], abs=1e-9)
        seen = np.array([mount.x, mount.y]) + beams.ranges[k] * beams.directions[k]
        assert seen == pytest.approx(end[:2], abs=1e-9)


@pytest.mark.parametrize("mount", MOUNTS)
def test_a_lidar_may_be_mounted_anywhere_and_turned(mount: SE2) -> None:
    pose = SE2(0.5, 1.0, 0.3)
    scan = Scan(
        ranges_at(pose @ mount, 360), -math.pi, math.tau / 360, 0.1, RANGE_MAX, T_base_sensor=mount
    )
    view = ScanView.of(scan, CONFIG)
    assert MATCHER.agreement(pose, view) > 0.95
    assert MATCHER.agreement(pose @ SE2(0.0, 0.0, 0.5), view) < 0.7
    found = MATCHER.refined(pose @ SE2(0.1, -0.1, 0.05), view)
    assert found.distance(pose) < 0.03
    assert abs(math.remainder(found.theta - pose.theta, math.tau)) < 0.02
