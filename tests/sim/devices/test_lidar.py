"""The lidar against exact geometry, at rest and on the move, and its errors' statistics."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from arjuna_core.pose3 import Pose3
from arjuna_core.scan import Scan
from arjuna_core.se2 import SE2
from arjuna_core.twist import Velocity
from arjuna_sim.config import SimulatorConfig
from arjuna_sim.devices.sensors.lidar import LidarConfig, LidarSettings
from arjuna_sim.physics.robot_motion import Truth
from arjuna_sim.simulation import Simulation
from tests.sim.builders import ROBOT, ROOM, edited, first, run, saved_world, simulator, static

NOISELESS = SimulatorConfig(lidar=LidarConfig(noise=0.0))
SWEEPING = SimulatorConfig(lidar=LidarConfig(noise=0.0, sweep=True))


def _scan(sim: Simulation, command: Velocity | None = None) -> Scan:
    while True:
        scan = sim.drive(command).scan
        if scan is not None:
            return scan


@dataclass(frozen=True)
class Solid:
    """A box (edges), a cylinder (radius, length) or a sphere (radius), cut by algebra."""

    kind: str
    size: tuple[float, ...]
    xyz: tuple[float, float, float]
    rpy: tuple[float, float, float] = (0.0, 0.0, 0.0)

    def sdf(self, name: str) -> str:
        tags = {"box": ("size",), "cylinder": ("radius", "length"), "sphere": ("radius",)}
        values = [self.size] if self.kind == "box" else [(value,) for value in self.size]
        inner = "".join(
            f"<{tag}>{' '.join(map(str, value))}</{tag}>"
            for tag, value in zip(tags[self.kind], values, strict=True)
        )
        pose = " ".join(map(str, (*self.xyz, *self.rpy)))
        return static(name, f"<{self.kind}>{inner}</{self.kind}>", pose)

    def distances(
        self, start: NDArray[np.float64], rays: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        """Return how far rays `(N, 3)` go from a point until they hit, inf where they miss."""
        inverse = Pose3.from_rpy(self.xyz, self.rpy).inverse()
        start, rays = inverse.apply(start[None])[0], rays @ inverse.rotation().T
        with np.errstate(divide="ignore", invalid="ignore"):
            if self.kind == "box":
                near, far = _slabs(start, rays, np.array(self.size) / 2)
            elif self.kind == "sphere":
                near, far = _quadratic(start, rays, self.size[0])
            else:
                near, far = _quadratic(start[:2], rays[:, :2], self.size[0])
                ends = _slabs(start[2:], rays[:, 2:], np.array([self.size[1] / 2]))
                near, far = np.maximum(near, ends[0]), np.minimum(far, ends[1])
        return np.where((near <= far) & (near > 0.0), near, np.inf)


def _slabs(
    start: NDArray[np.float64], rays: NDArray[np.float64], half: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    one, two = (-half - start) / rays, (half - start) / rays
    return np.minimum(one, two).max(axis=1), np.maximum(one, two).min(axis=1)


def _quadratic(
    start: NDArray[np.float64], rays: NDArray[np.float64], radius: float
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    a, b = (rays * rays).sum(axis=1), rays @ start
    root = np.sqrt(b * b - a * (start @ start - radius**2))  # NaN where the line misses
    return (-b - root) / a, (-b + root) / a


SOLIDS = (
    Solid("box", (4.0, 0.1, 2.0), (2.5, 1.0, 0.5), (0.0, 0.0, 0.6)),
    Solid("box", (0.2, 6.0, 3.0), (-4.0, 0.0, 0.2), (0.0, 0.5, 0.2)),  # a leaning wall
    Solid("box", (0.4, 0.4, 0.4), (0.5, -2.0, 0.3), (0.3, 0.4, 0.5)),
    Solid("cylinder", (0.35, 1.0), (1.5, -1.5, 0.5)),
    Solid("cylinder", (0.2, 3.0), (-1.5, 2.5, 0.4), (1.2, 0.0, 0.9)),  # a fallen pillar
    Solid("sphere", (0.6,), (-2.0, -1.8, 0.3)),
)


def _world(folder: Path) -> Path:
    return saved_world(folder, "".join(solid.sdf(f"m{i}") for i, solid in enumerate(SOLIDS)))


def _exact(
    sim: Simulation, positions: NDArray[np.float64], bearings: NDArray[np.float64]
) -> list[float]:
    """Return each beam's true distance from the robot's pose (x, y, z, roll, pitch, yaw)."""
    mount = sim.robot.model.urdf.T_root(first(sim.robot.model, LidarSettings).link).position
    ranges = []
    for point, bearing in zip(positions, bearings, strict=True):
        x, y, z, roll, pitch, yaw = point.tolist()
        T = Pose3.from_rpy((x, y, z), (roll, pitch, yaw))
        ray = T.rotation() @ (math.cos(bearing), math.sin(bearing), 0.0)
        start = T.apply(np.array([mount]))[0]
        ranges.append(min(float(s.distances(start, ray[None])[0]) for s in SOLIDS))
    return ranges


def _position(truth: Truth) -> list[float]:
    return [truth.pose.x, truth.pose.y, truth.z, truth.roll, truth.pitch, truth.pose.theta]


def _worst(scan: Scan, exact: list[float]) -> float:
    """Return the worst error, but for the few beams that graze an edge and see either side."""
    true = np.array(exact)
    both = np.isfinite(true) & np.isfinite(scan.ranges)
    assert both.sum() > 100
    assert (np.isfinite(true) != np.isfinite(scan.ranges)).sum() <= 4
    return float(np.sort(np.abs(scan.ranges[both] - true[both]))[-5])


@pytest.mark.parametrize("pose", [SE2(0.0, 0.0, 0.0), SE2(-0.8, 0.3, 2.5), SE2(0.4, -0.7, -0.4)])
def test_walls_at_angles_cylinders_and_spheres_are_exact_to_a_millimetre(
    tmp_path: Path, pose: SE2
) -> None:
    sim = simulator(_world(tmp_path), NOISELESS, spawn=pose)
    run(sim, 0.5)
    scan = _scan(sim)
    assert (
        _worst(scan, _exact(sim, np.array([_position(sim.robot.truth())] * 360), scan.angles))
        < 1e-3
    )


@pytest.mark.parametrize(
    "command", [Velocity(yaw_rate=2.0), Velocity(1.0), Velocity(0.4, yaw_rate=-1.5)]
)
def test_each_beam_of_a_sweep_is_cast_from_where_the_robot_was(
    tmp_path: Path, command: Velocity
) -> None:
    sim = simulator(_world(tmp_path), SWEEPING, spawn=SE2(-0.8, 0.0, -0.7))
    observations = [sim.drive(command) for _ in range(40)]
    scan = observations[-1].scan
    assert scan is not None
    instants = scan.stamp + scan.time_increment * np.arange(360)
    assert (instants[0], instants[-1]) == pytest.approx((0.7, 0.8))
    times = [o.time for o in observations]
    path = np.unwrap(np.array([_position(o.truth) for o in observations]), axis=0)
    positions = np.column_stack([np.interp(instants, times, values) for values in path.T])
    # Beams share an origin over a millimetre of the path: more on a wall that they graze.
    assert _worst(scan, _exact(sim, positions, scan.angles)) < 2e-3
    at_once = np.isclose(scan.ranges, _exact(sim, path[-1:].repeat(360, 0), scan.angles), atol=0.01)
    assert at_once.mean() < 0.9


def test_a_narrow_view_is_swept_in_a_part_of_the_period(tmp_path: Path) -> None:
    robot = edited(ROBOT, tmp_path, "<min_angle>-3.14159265<", "<min_angle>-0.785398163<")
    robot = edited(robot, tmp_path, "<max_angle>3.14159265<", "<max_angle>0.785398163<")
    scan = _scan(simulator(ROOM, SWEEPING, robot=robot))
    assert scan.time_increment * 359 == pytest.approx(0.1 / 4)
    assert scan.stamp == pytest.approx(0.1 - 0.1 / 4)


def test_a_kidnap_in_mid_sweep_leaves_no_beam_of_the_journey() -> None:
    sim = simulator(ROOM, SWEEPING)
    run(sim, 0.16)
    sim.robot.set_pose(SE2(-3.0, 3.5, 2.0))
    jumped = _scan(sim)
    rested = _scan(sim)
    assert np.abs(jumped.ranges - rested.ranges).max() < 1e-3


def test_sweep_of_a_resting_robot_equals_a_scan_at_once() -> None:
    scans = [_scan(simulator(ROOM, config)) for config in (NOISELESS, SWEEPING)]
    assert np.abs(scans[0].ranges - scans[1].ranges).max() < 1e-3


def test_dropouts_read_plus_inf_as_often_as_configured() -> None:
    sim = simulator(ROOM, SimulatorConfig(lidar=LidarConfig(dropout=0.1)))
    ranges = np.concatenate([_scan(sim).ranges for _ in range(30)])
    assert np.isposinf(ranges).mean() == pytest.approx(0.1, rel=0.1)
    assert not np.isnan(ranges).any()


@pytest.mark.parametrize("sigma", [0.003, 0.03])
def test_sigma_is_what_the_parameter_says_within_five_per_cent(sigma: float) -> None:
    clean = _scan(simulator(ROOM, NOISELESS)).ranges
    noisy = simulator(ROOM, SimulatorConfig(lidar=LidarConfig(noise=sigma)))
    errors = np.concatenate([_scan(noisy).ranges - clean for _ in range(40)])
    errors = errors[np.abs(errors) < 6.0 * sigma]
    assert errors.std() == pytest.approx(sigma, rel=0.05)
    assert abs(errors.mean()) < 0.05 * sigma
