"""The simulator: one robot in one world, advanced tick by tick."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from arjuna_core.se2 import IDENTITY, SE2
from arjuna_core.twist import Velocity
from arjuna_sim.config import SimulatorConfig
from arjuna_sim.devices.camera import Shot
from arjuna_sim.devices.further_sensors import Reading
from arjuna_sim.driven_robot import DrivenRobot
from arjuna_sim.files.urdf.robot_file import load_robot
from arjuna_sim.files.world_file import load_world
from arjuna_sim.model.robot import SOLO, Robot
from arjuna_sim.model.settings import CameraSettings, SensorSettings
from arjuna_sim.model.world import World
from arjuna_sim.observation import Observation
from arjuna_sim.physics.robot_motion import Truth
from arjuna_sim.simulation import Simulation, Start


class Simulator(Simulation):
    """A robot in a world: a simulation of one, beside which others may come.

    Args:
        robot: A robot, or its URDF file.
        world: A world, or its SDF file or map.
        config: Everything else.
        rng: Seeds the noise; `reset` rewinds it to its present state.
        spawn: Where the robot starts; the nearest free place if it is blocked.

    Raises:
        RobotError: The robot cannot be simulated.
        WorldError: The world cannot be simulated.
    """

    def __init__(
        self,
        robot: str | Path | Robot,
        world: str | Path | World,
        config: SimulatorConfig,
        rng: np.random.Generator,
        spawn: SE2 = IDENTITY,
    ) -> None:
        start = Start(robot if isinstance(robot, Robot) else load_robot(robot), spawn)
        world = world if isinstance(world, World) else load_world(world)
        super().__init__({SOLO: start}, world, config, rng)

    @property
    def _one(self) -> DrivenRobot:
        return self.robots[SOLO]

    @property
    def robot(self) -> Robot:
        """The robot as its file has it."""
        return self._one.robot

    @property
    def spawn(self) -> SE2:
        """Where the robot starts."""
        return self._one.spawn

    @property
    def told(self) -> Velocity:
        """What the robot's wheels are told to drive now."""
        return self._one.told

    def step(self, command: Velocity | None = None) -> Observation:
        """Advance one tick.

        Args:
            command: A new command, or None to go on with the last until it times out.

        Returns:
            What the robot's sensors and the world say at the tick's end.
        """
        return self.advance({SOLO: command})[SOLO]

    def truth(self) -> Truth:
        """Return where the robot is now."""
        return self._one.truth()

    def wheel_angles(self) -> tuple[float, ...]:
        """Return what the encoders count [rad]; see `DrivenRobot.wheel_angles`."""
        return self._one.wheel_angles()

    def picture(
        self, color: bool = True, depth: bool = False, camera: CameraSettings | None = None
    ) -> Shot:
        """Return what a camera of the robot sees now; see `DrivenRobot.picture`."""
        return self._one.picture(color, depth, camera)

    def sense(self, sensor: SensorSettings) -> Reading:
        """Return what one of the robot's further sensors says now."""
        return self._one.sense(sensor, self.time)

    def surfaces(self) -> NDArray[np.float64]:
        """Return the world's true surfaces at the lidar's height, `(N, 4) float64` [m]."""
        return self._one.surfaces()

    def obstacles_at(self, pose: SE2) -> tuple[str, ...]:
        """Return the names of what the robot would touch at a pose."""
        return self._one.obstacles_at(pose)

    def set_pose(self, pose: SE2) -> None:
        """Pick the robot up and put it down at rest; its odometry does not notice."""
        self._one.set_pose(pose)
