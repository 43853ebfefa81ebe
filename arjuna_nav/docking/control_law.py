"""The graceful control law with the parameters of Nav2's docking server, either way round."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from arjuna_core.config import param
from arjuna_core.se2 import SE2
from arjuna_core.twist import Velocity
from arjuna_nav.controllers.graceful import control_law


@dataclass(frozen=True)
class ControlLawConfig:
    """How sharply and how fast the approach is driven."""

    k_phi: float = param(3.0, "Rate of the heading's error per rate of the distance.", minimum=0.0)
    k_delta: float = param(2.0, "Gain of the steering's error.", minimum=0.0)
    beta: float = param(0.4, "How much bends slow down.", minimum=0.0)
    lambda_: float = param(2.0, "How sharply bends slow down.", minimum=1.0)
    v_linear_min: float = param(0.1, "Least speed.", unit="m/s", minimum=0.0)
    v_linear_max: float = param(0.25, "Greatest speed.", unit="m/s", minimum=0.01)
    v_angular_max: float = param(0.75, "Greatest yaw rate.", unit="rad/s", minimum=0.01)
    slowdown_radius: float = param(
        0.25, "Distance from the pose at which to slow down.", unit="m", minimum=0.01
    )


def steer(config: ControlLawConfig, T_base_target: SE2, backward: bool = False) -> Velocity:
    """Return what to drive towards a pose.

    Args:
        config: Gains and limits.
        T_base_target: The pose to end at, in the robot's base.
        backward: Whether to drive backwards.
    """
    x, y = T_base_target.x, T_base_target.y
    side = -1.0 if backward else 1.0  # backwards it is the law of a robot that faces about
    law = np.array([config.k_phi, config.k_delta, config.beta, config.lambda_])
    near = config.v_linear_max * math.hypot(x, y) / config.slowdown_radius
    limits = np.array([config.v_linear_min, config.v_linear_max, near, config.v_angular_max])
    v, w = control_law.steer(side * x, side * y, T_base_target.theta, law, limits)
    return Velocity(side * v, yaw_rate=w)


def foreseen(
    config: ControlLawConfig,
    pose: SE2,
    target: SE2,
    backward: bool,
    duration: float,
    step: float,
) -> NDArray[np.float64]:
    """Return where the law leads, `(N, 3) float64` [m, m, rad], the present pose first.

    Args:
        config: Gains and limits.
        pose: Where the robot is.
        target: The pose to end at, in the same frame.
        backward: Whether to drive backwards.
        duration: How far to look ahead [s]; it ends at the pose too.
        step: Time between two poses [s].
    """
    poses = [pose]
    for _ in range(math.ceil(duration / step)):
        T_base_target = poses[-1].inverse() @ target
        if math.hypot(T_base_target.x, T_base_target.y) < config.v_linear_max * step:
            break
        velocity = steer(config, T_base_target, backward)
        poses.append(poses[-1] @ SE2.exp(np.array([velocity.x, 0.0, velocity.yaw_rate]) * step))
    return np.array([each.array() for each in poses])
