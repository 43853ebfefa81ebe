"""The simulation: robots in one world, advanced tick by tick."""

from __future__ import annotations

import zlib
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from arjuna_core.se2 import IDENTITY, SE2
from arjuna_core.twist import Velocity
from arjuna_sim.config import SimulatorConfig
from arjuna_sim.devices.driving.joints import JointControllers
from arjuna_sim.driven_robot import DrivenRobot, Observation
from arjuna_sim.model.entities import BlockedPoseError
from arjuna_sim.model.notes import gathered
from arjuna_sim.model.robot import SOLO, RobotModel
from arjuna_sim.model.world import World
from arjuna_sim.physics.stage import Stage
from arjuna_sim.staged_sensors import StagedSensors


@dataclass(frozen=True)
class Start:
    """A robot and its start pose; the nearest free one if that is blocked.

    None asks for none: that is the origin, or where the robot has room to turn beside it.
    """

    robot: RobotModel
    pose: SE2 | None = None


def solo(robot: RobotModel, pose: SE2 | None = None) -> dict[str, Start]:
    """Return the start of a robot that has a simulation for its own."""
    return {SOLO: Start(robot, pose)}


class Simulation:
    """Robots in a world. The same seed and commands give the same observations, bit by bit.

    Args:
        starts: The robots by name; a single one may be called `SOLO`.
        rng: Seeds the noise; `reset` rewinds it to its present state.

    Attributes:
        fixed: The world's own sensors.

    Raises:
        RobotError: A robot cannot be simulated.
        WorldError: The world cannot be simulated.
    """

    def __init__(
        self,
        starts: Mapping[str, Start],
        world: World,
        config: SimulatorConfig,
        rng: np.random.Generator,
    ) -> None:
        self._seeds = rng.bit_generator.random_raw(4)
        staged = {name: start.robot.below(name) for name, start in starts.items()}
        self.stage = Stage(staged, world, config.servo, config.physics_timestep)
        self.config = _paced(config, self.stage)
        self._substeps, self._tick = self.config.substeps, round(self.config.tick * 1e9)
        self._first = {name: self._made(name, start) for name, start in starts.items()}
        self.robots = dict(self._first)
        self.fixed = StagedSensors(self.stage, self.config, int(self._seeds[0]))
        self.stage.on_rebuild = self._rebind
        self._choose_spawns()
        self.reset()

    def _made(self, name: str, start: Start) -> DrivenRobot:
        seeds = self._seeds_of(name)
        return DrivenRobot(name, start.robot, self.stage, self.config, seeds, start.pose)

    def _seeds_of(self, name: str) -> NDArray[np.uint64]:
        if name == SOLO:
            return self._seeds
        # A robot's noise is its own, whoever else is there.
        own = np.random.default_rng([*map(int, self._seeds), zlib.crc32(name.encode())])
        return own.bit_generator.random_raw(4)

    @property
    def robot(self) -> DrivenRobot:
        """The robot that has the simulation for its own."""
        return self.robots[SOLO]

    @property
    def time(self) -> float:
        """Simulated time since the start or the last reset [s]."""
        return self._ticks * self._tick / 1_000_000_000

    @property
    def world(self) -> World:
        """The world as it was read."""
        return self.stage.world

    @property
    def notes(self) -> tuple[str, ...]:
        """Parts of the robots' and the world's files that the simulation leaves out."""
        of_robots = (
            f"{name}: {note}" if name else note
            for name, robot in self.robots.items()
            for note in robot.notes
        )
        return (*of_robots, *gathered(self.world.notes))

    def add(self, name: str, start: Start) -> None:
        """Put a robot of a new name into the world.

        Raises:
            RobotError: It cannot be simulated; nothing has changed.
            BlockedPoseError: It would stand in something; nothing has changed.
        """
        before = dict(self.stage.robots)
        self.stage.set_robots({**before, name: start.robot.below(name)})
        robot = self._made(name, start)
        if touched := robot.obstacles_at(robot.spawn):
            self.stage.set_robots(before)
            raise BlockedPoseError(f"'{name}' would stand in {', '.join(touched)} there")
        robot.set_pose(robot.spawn)
        self.robots[name] = robot

    def remove(self, name: str) -> None:
        """Take a robot out of the world."""
        self._keep({key: robot for key, robot in self.robots.items() if key != name})

    def clear_spawned(self) -> None:
        """Take out all robots and entities that came after the start."""
        first = self._first.items()
        self._keep({name: robot for name, robot in first if self.robots.get(name) is robot})
        self.stage.clear_spawned()

    def _keep(self, robots: dict[str, DrivenRobot]) -> None:
        if robots == self.robots:
            return
        for robot in self.robots.values():
            if robot not in robots.values():
                robot.close()
        self.robots = robots
        self.stage.set_robots({name: robot.model.below(name) for name, robot in robots.items()})

    def step(self, commands: Mapping[str, Velocity | None]) -> dict[str, Observation]:
        """Advance one tick; a robot without a new command keeps its last until that times out."""
        for name, robot in self.robots.items():
            robot.drive(commands.get(name))
        faster = [robot for robot in self.robots.values() if robot.is_imu_faster]
        self._run(self._substeps if faster else 1, faster)
        self._ticks += 1
        now = self.time
        return {name: robot.observe(now) for name, robot in self.robots.items()}

    def drive(self, command: Velocity | None = None) -> Observation:
        """Advance one tick with a command of the only robot, and return its observation."""
        return self.step({SOLO: command})[SOLO]

    def _run(self, slices: int, faster: list[DrivenRobot]) -> None:
        """Run a tick's physics; robots whose IMU is faster read it after each slice."""
        steps, start, tick = self._substeps // slices, self.time, self.config.tick
        for i in range(1, slices + 1):
            self.stage.advance(steps)
            self.stage.settle()
            for robot in faster if i < slices else ():
                robot.feel(start + i * tick / slices)

    def adjust(self, config: SimulatorConfig) -> None:
        """Take new limits of the drives and noises of the odometry, while it runs."""
        self.config = replace(config, tick=self.config.tick)
        for robot in self.robots.values():
            robot.adjust(self.config)

    def reset(self, rng: np.random.Generator | None = None) -> None:
        """Return to the start: time 0, the world as it was read, noise rewound.

        Args:
            rng: Seeds other noise of the robots that were there at the start.
        """
        if rng is not None:
            self._seeds = rng.bit_generator.random_raw(4)
            for name, robot in self._first.items():
                robot.seeds = self._seeds_of(name)
        self._ticks = 0
        self._keep(dict(self._first))
        self.stage.restore()
        self.fixed.begin()
        for robot in self.robots.values():
            robot.begin()
        self._return_to_start()

    def reset_time(self) -> None:
        """Set the time to 0, and leave everything where it is."""
        self._ticks = 0

    def reset_state(self) -> None:
        """Put the robots and all entities that are there to their starts; time continues."""
        self.stage.rewind()
        self._return_to_start()

    def resume(self, time: float, poses: Mapping[str, tuple[SE2, SE2]]) -> None:
        """Continue at a time [s], robots at rest.

        Args:
            poses: By robot, where it stands and its odometry's pose; others are at their start.
        """
        self._ticks = round(time * 1e9 / self._tick)
        self._lift_all()
        for name, robot in self.robots.items():
            pose, odometry = poses.get(name, (robot.spawn, IDENTITY))
            robot.resume(pose, odometry)

    def load_world(self, world: World) -> None:
        """Replace the world and return to the start.

        Raises:
            RobotError: MuJoCo refuses the world; nothing has changed.
        """
        self.stage.load(world)
        self._keep(dict(self._first))
        self._choose_spawns()
        self.reset()

    def _choose_spawns(self) -> None:
        self._lift_all()
        for robot in self.robots.values():
            robot.choose_spawn()
            robot.set_pose(robot.spawn)

    def _return_to_start(self) -> None:
        self._lift_all()
        for robot in self.robots.values():
            robot.return_to_start()

    def _lift_all(self) -> None:
        """Lift robots, so that none blocks those that are put down before it."""
        for i, robot in enumerate(self.robots.values() if len(self.robots) > 1 else ()):
            # [m] Waiting robots are out of reach of the world and of each other.
            robot.lift(1000.0 * (i + 1))

    def _rebind(self) -> None:
        self.fixed.rebind()
        for robot in self.robots.values():
            robot.rebind()

    def close(self) -> None:
        """Free what the cameras hold."""
        self.fixed.close()
        for robot in self.robots.values():
            robot.close()


def _paced(config: SimulatorConfig, stage: Stage) -> SimulatorConfig:
    """Return the time steps: short ones where a robot is held upright, or pushed, from outside."""
    is_held = any(
        stage.scene.robots[name].support.balances or JointControllers(robot).is_pushed
        for name, robot in stage.robots.items()
    )
    if not is_held or config.tick != SimulatorConfig.tick:
        return config
    return replace(config, tick=config.physics_timestep)
