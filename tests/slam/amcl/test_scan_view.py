"""AMCL's view of a scan, and its motion models."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from arjuna_core.arrays import Floats
from arjuna_core.errors import ConfigError
from arjuna_core.scan import Scan
from arjuna_core.se2 import IDENTITY, SE2, wrap
from arjuna_slam.amcl.config import (
    DIFFERENTIAL,
    MOTION_MODELS,
    OMNIDIRECTIONAL,
    SKID_STEER,
    AmclConfig,
)
from arjuna_slam.amcl.motion import MotionModel, differential, omnidirectional
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
        (-1.0, 0.0, [0.1, 0.5, 3.0, 10.0, 10.0], 3),
    ],
)
def test_ranges_are_those_within_limits(
    least: float, most: float, kept: list[float], returned: int
) -> None:
    ranges = np.array([math.nan, 0.09, 0.1, 0.5, 3.0, 10.0, math.inf, -1.0])
    scan = Scan(ranges, 0.0, 0.1, 0.1, 10.0)
    config = AmclConfig(laser_min_range=least, laser_max_range=most)
    view = ScanView.of(scan, config)
    assert view.range_max == (most if 0.0 < most < 10.0 else 10.0)
    beams = view.many
    assert beams.ranges.tolist() == kept
    assert beams.returned.tolist() == [k < returned for k in range(len(kept))]
    assert len(beams.endpoints) == returned
    assert len(beams.directions) == len(kept)


@pytest.mark.parametrize("mount", MOUNTS)
@pytest.mark.parametrize("motion", [SE2(), SE2(0.2, 0.05, 0.3)])
def test_beams_end_where_seen_from_the_base_at_the_first(mount: SE2, motion: SE2) -> None:
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


COUNT = 100_000
A1, A2, A3, A4, A5 = 0.02, 0.03, 0.04, 0.05, 0.06


def assert_distributed(samples: Floats, mean: float, deviation: float) -> None:
    """Mean and deviation lie within 5 standard errors of theory."""
    standard_error = deviation / math.sqrt(len(samples))
    assert abs(samples.mean() - mean) <= 5.0 * standard_error + 1e-12
    assert abs(samples.std() - deviation) <= 5.0 * standard_error / math.sqrt(2.0) + 1e-12


def draws(name: str, delta: SE2, start: SE2 = IDENTITY) -> Floats:
    particles = np.tile(start.array(), (COUNT, 1))
    config = AmclConfig(alpha1=A1, alpha2=A2, alpha3=A3, alpha4=A4, alpha5=A5)
    model: MotionModel = MOTION_MODELS.resolve(name)
    return model(config, particles, delta, np.random.default_rng(5))


@pytest.mark.parametrize("start", [SE2(), SE2(2.0, -1.0, 2.5)])
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_differential_straight_motion_forwards_and_backwards(start: SE2, sign: float) -> None:
    moved = draws(DIFFERENTIAL, SE2(0.5 * sign, 0.0, 0.0), start)
    local = start.inverse().apply(moved[:, :2])
    drive = np.hypot(local[:, 0], local[:, 1])
    assert_distributed(drive, 0.5, math.sqrt(A3 * 0.25))
    bearing = np.arctan2(local[:, 1] * sign, local[:, 0] * sign)
    assert_distributed(bearing, 0.0, math.sqrt(A2 * 0.25))
    turn = wrap(moved[:, 2] - start.theta)
    assert_distributed(turn, 0.0, math.sqrt(2.0 * A2 * 0.25))


def test_differential_turn_on_the_spot() -> None:
    moved = draws(DIFFERENTIAL, SE2(0.0, 0.0, 0.8))
    assert_distributed(moved[:, 2], 0.8, math.sqrt(A1) * 0.8)
    assert_distributed(moved[:, 0], 0.0, math.sqrt(A4) * 0.8)


def test_differential_move_below_a_centimetre_has_no_first_turn() -> None:
    moved = draws(DIFFERENTIAL, SE2(0.0, 0.009, 0.0))
    assert np.abs(moved[:, 2]).max() < 0.05  # not the pi/2 of turning to the side and back
    moved = draws(DIFFERENTIAL, SE2(0.0, 0.011, 0.0))
    assert np.abs(moved[:, 2]).max() > 0.5


@pytest.mark.parametrize("turn", [0.0, 0.6])
def test_omnidirectional_motion_sideways(turn: float) -> None:
    moved = draws(OMNIDIRECTIONAL, SE2(0.0, 0.5, turn))
    assert_distributed(moved[:, 1], 0.5, math.sqrt(A3 * 0.25 + A1 * turn**2))
    assert_distributed(moved[:, 0], 0.0, math.sqrt(A5 * 0.25 + A1 * turn**2))
    assert_distributed(moved[:, 2], turn, math.sqrt(A4 * turn**2 + A2 * 0.25))


def test_skid_steer_errs_across_when_it_turns_and_not_when_it_drives() -> None:
    moved = draws(SKID_STEER, SE2(0.5, 0.0, 0.6))
    assert_distributed(moved[:, 0], 0.5, math.sqrt(A3 * 0.25 + A4 * 0.36))
    assert_distributed(moved[:, 1], 0.0, math.sqrt(A5) * 0.6)
    assert_distributed(moved[:, 2], 0.6, math.sqrt(A1 * 0.36 + A2 * 0.25))
    straight = draws(SKID_STEER, SE2(0.5, 0.0, 0.0))
    assert np.abs(straight[:, 1]).max() < 1e-9


@pytest.mark.parametrize("name", MOTION_MODELS.types)
def test_every_model_without_noise_composes(name: str) -> None:
    config = AmclConfig(alpha1=0.0, alpha2=0.0, alpha3=0.0, alpha4=0.0, alpha5=0.0)
    start, delta = SE2(1.0, 2.0, 3.0), SE2(0.3, -0.2, 0.5)
    particles = np.tile(start.array(), (3, 1))
    moved = MOTION_MODELS.resolve(name)(config, particles, delta, np.random.default_rng(0))
    np.testing.assert_allclose(moved, np.tile((start @ delta).array(), (3, 1)), atol=1e-12)
    np.testing.assert_array_equal(particles, np.tile(start.array(), (3, 1)))  # not in place


def test_models_are_chosen_by_nav2s_names() -> None:
    assert MOTION_MODELS.resolve(AmclConfig().robot_model_type) is differential
    assert MOTION_MODELS.resolve("nav2_amcl::OmniMotionModel") is omnidirectional
    with pytest.raises(ConfigError, match="no motion model 'omni'"):
        AmclConfig(robot_model_type="omni")
