"""A batch of robots in MuJoCo Warp: its pace, and how it agrees with the simulation."""

from __future__ import annotations

import argparse
import math
import time
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from arjuna_core.se2 import SE2, wrap
from arjuna_core.twist import Velocity
from arjuna_sim.config import SimulatorConfig
from arjuna_sim.devices.sensors.lidar import LidarConfig, LidarSettings
from arjuna_sim.files.robots.robot_file import load_robot
from arjuna_sim.files.world_file import load_world
from arjuna_sim.model.robot import RobotModel
from arjuna_sim.model.world import World
from arjuna_sim.simulation import Simulation, solo
from tests.sim.builders import ROBOT, ROOM, ROOT, first

ROBOTS = (
    *("arjuna.urdf", "diffbot.urdf", "burger.urdf", "udacity_bot.xacro"),
    "fusion_description/urdf/fusion.xacro",
)
STARTS = {"pillar_arena": SE2(-2.0, -0.5, 0.0)}
"""Where a robot starts in a world; else at the origin, or the free pose nearest to that."""
NEAR = 0.01
"""Ranges of a beam that differ by less agree [m]."""


class Agreement(NamedTuple):
    """The greatest differences of a batch from the simulation, over the same commands.

    Attributes:
        position: [m].
        heading: [rad].
        beams: Part of the beams that agree, each cast from where its own robot is.
        beams_there: The same, both cast from where the batch's robot is.
        touched: Ticks in which only one of both touches something.
    """

    position: float
    heading: float
    beams: float
    beams_there: float
    touched: int


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add this benchmark's options."""
    parser.add_argument("--robots", type=int, default=1024, metavar="N", help="(%(default)s)")
    parser.add_argument("--device", default="cpu", help="cpu or cuda (%(default)s)")
    parser.add_argument(
        "--seconds", type=float, default=2.0, metavar="S", help="simulated time (%(default)s)"
    )
    parser.add_argument(
        "--agreement",
        type=float,
        default=0.0,
        metavar="S",
        help="compare with the simulation for so long, each shipped robot in each shipped world",
    )


def run(arguments: argparse.Namespace) -> dict[str, Any]:
    """Measure the shipped robot, lidar of 360 beams at 10 Hz and all, in the shipped room.

    Returns:
        `robot_steps_per_second`: ticks of 20 ms times robots a second, `scan_share`: the lidars'
        part of that time, `simulation_steps_per_second`: the ticks of the simulation of one robot
        on one core, of CPU time, and `agreement` by robot and world where that is asked for.
    """
    robots, device = arguments.robots, arguments.device
    pace, share = measure_pace(robots, arguments.seconds, device)
    alone = _alone(arguments.seconds)
    print(f"{robots} robots on {device}: {pace:,.0f} robot-steps/s, {share:.0%} of it for scans")
    print(f"the simulation, one robot on one core: {alone:,.0f} steps/s")
    compared = {}
    if arguments.agreement > 0.0:
        print(
            f"{'robot':<18}{'world':<14}{'mm':>9}{'deg':>9}{'beams':>10}{'there':>10}{'touched':>9}"
        )
        for robot in ROBOTS:
            for world in sorted((ROOT / "worlds").glob("*.world")):
                found = _shipped(robot, world, arguments.agreement, device)
                compared[f"{Path(robot).stem} {world.stem}"] = found._asdict()
    return {
        "robots": robots,
        "device": device,
        "robot_steps_per_second": pace,
        "scan_share": share,
        "simulation_steps_per_second": alone,
        "agreement": compared,
    }


def measure_pace(robots: int, seconds: float, device: str) -> tuple[float, float]:
    """Return robots times ticks a second, of CPU time on a CPU, and the part that scans take."""
    from arjuna_sim.batch.batch import Batch

    starts = np.zeros((robots, 3))
    starts[:, 2] = np.linspace(-math.pi, math.pi, robots)
    batch = Batch(load_robot(ROBOT), load_world(ROOM), starts, device=device)
    ticks, scanning = round(seconds / batch.config.tick), 0.0
    batch.scan()  # compiles
    clock = time.process_time if device == "cpu" else time.perf_counter
    begin = clock()
    for i in range(ticks):
        batch.step(np.tile(_command(i), (robots, 1)))
        if i % 5 == 0:  # 10 Hz
            before = clock()
            batch.scan()
            scanning += clock() - before
    passed = clock() - begin
    return robots * ticks / passed, scanning / passed


def _alone(seconds: float) -> float:
    sim = Simulation(
        solo(load_robot(ROBOT)), load_world(ROOM), SimulatorConfig(), np.random.default_rng(0)
    )
    ticks, begin = round(seconds / sim.config.tick), time.process_time()
    for i in range(ticks):
        sim.drive(_velocity(_command(i)))
    return ticks / (time.process_time() - begin)


def _shipped(robot: str, world: Path, seconds: float, device: str) -> Agreement:
    start = STARTS.get(world.stem, SE2(0.0, 0.0, 0.0))
    found = agreement(
        load_robot(ROOT / "urdf" / robot), load_world(world), seconds, start, device=device
    )
    print(
        f"{Path(robot).stem:<18}{world.stem:<14}{1e3 * found.position:9.3f}"
        f"{math.degrees(found.heading):9.4f}{found.beams:10.3%}{found.beams_there:10.3%}"
        f"{found.touched:9}",
        flush=True,
    )
    return found


def agreement(
    robot: RobotModel, world: World, seconds: float, start: SE2, device: str = "cpu"
) -> Agreement:
    """Drive a robot in the simulation and in a batch by the same commands; return the greatest.

    The lidar is without noise, which is drawn otherwise in a batch.
    """
    from arjuna_sim.batch.batch import Batch

    config = SimulatorConfig(lidar=LidarConfig(noise=0.0))
    sim, there = (
        Simulation(solo(robot, start), world, config, np.random.default_rng(0)) for _ in range(2)
    )
    lidar = first(robot, LidarSettings)
    batch = Batch(robot, world, sim.robot.spawn.array()[None], config, device=device)
    away, turned, touched, agree = [0.0], [0.0], 0, np.zeros((0, 2))
    for i in range(round(seconds / config.tick)):
        command = _command(i)
        seen, state = sim.drive(_velocity(command)), batch.step(command[None])
        x, y, yaw = state.poses[0].tolist()
        pose = seen.truth.pose
        away.append(math.hypot(x - pose.x, y - pose.y))
        turned.append(abs(wrap(yaw - pose.theta)))
        touched += bool(seen.contacts) != bool(state.touched[0])
        if seen.scan is not None:
            there.stage.data.qpos[:] = batch.qpos[0]
            there.stage.settle()
            expected = (seen.scan.ranges, there.robot.sense(lidar, 0.0).ranges)
            near = [_agree(batch.scan()[0], ranges) for ranges in expected]
            agree = np.vstack((agree, np.column_stack(near)))
    beams, beams_there = agree.mean(axis=0).tolist()
    return Agreement(max(away), max(turned), beams, beams_there, touched)


def _agree(ranges: NDArray[np.float32], expected: NDArray[np.float64]) -> NDArray[np.bool_]:
    with np.errstate(invalid="ignore"):  # inf - inf, which are equal
        return np.asarray((np.abs(ranges - expected) < NEAR) | (ranges == expected))


def _command(i: int) -> NDArray[np.float64]:
    """Drive forward, backward and round, within a metre or so of the start."""
    return np.array([0.1 + 0.3 * math.cos(i / 60), 0.0, 0.8 * math.sin(i / 90)])


def _velocity(command: NDArray[np.float64]) -> Velocity:
    return Velocity(float(command[0]), yaw_rate=float(command[2]))
