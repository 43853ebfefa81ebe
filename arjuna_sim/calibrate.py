"""Calibrating a robot in simulation."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from arjuna_core.twist import Velocity
from arjuna_sim.config import SimulatorConfig
from arjuna_sim.devices.calibration import Calibration, CalibrationError, Measurement, calibrate
from arjuna_sim.devices.drive import Kinematics
from arjuna_sim.files.robots.robot_file import load_robot
from arjuna_sim.files.world_file import load_world
from arjuna_sim.model.robot import RobotModel
from arjuna_sim.model.settings import DriveKind
from arjuna_sim.model.world import World
from arjuna_sim.simulation import Simulation, solo


def calibrate_robot(robot_path: Path, world_path: Path) -> Calibration:
    """Find a robot's effective track width and wheel radius by driving it in simulation.

    Args:
        world_path: A world with 4 m of free space around its origin.

    Raises:
        CalibrationError: The robot has no wheels, does not move, or bumps into something.
    """
    robot = load_robot(robot_path)
    world = load_world(world_path)
    drive, config = robot.drive, SimulatorConfig()
    if drive.kind is not DriveKind.SIDES or not drive.left or not drive.right:
        raise CalibrationError(f"{robot.urdf.path}: has no wheels to calibrate")
    nominal = Kinematics(drive.separation, drive.radius)
    return calibrate(
        lambda kinematics: SimulatedVehicle(robot, world, config, kinematics),
        nominal,
        config.odometry,
    )


class SimulatedVehicle:
    """A simulated robot, to be calibrated."""

    def __init__(
        self, robot: RobotModel, world: World, config: SimulatorConfig, kinematics: Kinematics
    ) -> None:
        drive = replace(
            config.drive,
            effective_track_width=kinematics.track,
            effective_wheel_radius=kinematics.radius,
        )
        rng = np.random.default_rng(0)
        self._simulator = Simulation(solo(robot), world, replace(config, drive=drive), rng)

    @property
    def tick(self) -> float:
        """The time for which a command is held [s]."""
        return self._simulator.config.tick

    def drive(self, velocity: Velocity) -> None:
        """Hold a velocity for a tick.

        Raises:
            CalibrationError: The robot bumps into something.
        """
        touched = self._simulator.drive(velocity).contacts
        if touched:
            problem = f"bumped into {touched[0]}; valid: a world with 4 m of free space"
            raise CalibrationError(f"{self._simulator.world.path}: the robot {problem}")

    def observe(self) -> Measurement:
        """Return the encoders' angles and the true pose."""
        left, right = self._simulator.robot.wheel_angles()
        return Measurement((left, right), self._simulator.robot.truth().pose)
