"""Random driving at full speed in a room of thin walls.

With 60 N at each rim and rubber's friction a wheel can climb a wall that it rubs along; a robot
that tips over is put back on its wheels.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from arjuna_core.se2 import SE2
from arjuna_core.twist import Velocity
from arjuna_sim.config import SimulatorConfig
from arjuna_sim.devices.drive import DriveConfig
from tests.sim.builders import saved_world, simulator, static

_HALF = 2.0  # [m] from the middle of the room to its walls' inner faces
_THICKNESS = 0.05
_FAST = SimulatorConfig(drive=DriveConfig(max_linear_velocity=1.5))


def _room(folder: Path) -> Path:
    """Write a room of 4 m x 4 m with walls of 5 cm and a partition that reaches into it."""
    outer = _HALF + _THICKNESS / 2
    walls = [
        (outer, 0.0, _THICKNESS, 2 * _HALF + 0.1),
        (-outer, 0.0, _THICKNESS, 2 * _HALF + 0.1),
        (0.0, outer, 2 * _HALF + 0.1, _THICKNESS),
        (0.0, -outer, 2 * _HALF + 0.1, _THICKNESS),
        (0.0, 1.3, _THICKNESS, 1.4),
    ]
    models = "".join(
        static(f"wall_{i}", f"<box><size>{dx} {dy} 0.5</size></box>", f"{x} {y} 0.25 0 0 0")
        for i, (x, y, dx, dy) in enumerate(walls)
    )
    return saved_world(folder, models)


def endure(folder: Path, seconds: float, seed: int) -> tuple[float, int, int]:
    """Drive at random and check each tick; return top speed [m/s], ticks in contact, tumbles."""
    sim = simulator(_room(folder), _FAST, seed=seed)
    rng = np.random.default_rng(seed)
    fastest, touching, tumbles, command, before = 0.0, 0, 0, Velocity(), SE2()
    for i in range(round(seconds / sim.config.tick)):
        if i % 40 == 0:
            command = Velocity(
                float(rng.choice((-1.5, 1.5, 1.0))), yaw_rate=float(rng.normal(0.0, 1.0))
            )
        last = sim.drive(command)
        truth, pose = last.truth, last.truth.pose
        values = [*pose.array(), truth.z, truth.roll, truth.pitch, truth.v, truth.w]
        values += [*last.odometry.T_odom_base.array(), *last.odometry.covariance.ravel()]
        assert np.isfinite(values).all(), last.time
        assert max(abs(pose.x), abs(pose.y)) < _HALF, (last.time, truth)
        assert pose.x * before.x > 0.0 or pose.y < 0.7, (last.time, truth)  # the partition
        fastest, touching = max(fastest, abs(truth.v)), touching + bool(last.contacts)
        before = pose
        if max(abs(truth.roll), abs(truth.pitch)) > 0.7:
            sim.robot.set_pose(SE2())
            before, tumbles = SE2(), tumbles + 1
    return fastest, touching, tumbles


def test_a_minute_of_random_driving_into_thin_walls_passes_through_none(tmp_path: Path) -> None:
    fastest, touching, tumbles = endure(tmp_path, 60.0, seed=1)
    assert fastest > 1.4
    assert touching > 100
    assert tumbles < 10
