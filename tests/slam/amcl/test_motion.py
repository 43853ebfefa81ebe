"""Claims: sampled motion has the means and deviations that the model's formulas state."""

from __future__ import annotations

import math

import numpy as np
import pytest

from arjuna_core.arrays import Floats
from arjuna_core.errors import ConfigError
from arjuna_core.se2 import IDENTITY, SE2, wrap
from arjuna_slam.amcl.config import (
    DIFFERENTIAL,
    MOTION_MODELS,
    OMNIDIRECTIONAL,
    SKID_STEER,
    AmclConfig,
)
from arjuna_slam.amcl.motion import MotionModel, differential, omnidirectional

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
