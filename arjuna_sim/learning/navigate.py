"""Gymnasium's environment `arjuna/Navigate-v0`: a robot in MuJoCo that drives to goals."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
from gymnasium import spaces

from arjuna_core.arrays import Floats, Singles
from arjuna_core.config import load
from arjuna_core.errors import ConfigError, RobotError
from arjuna_core.se2 import SE2
from arjuna_core.twist import Velocity
from arjuna_sim.config import SimulatorConfig
from arjuna_sim.devices.device import mounted
from arjuna_sim.devices.sensors.lidar import LidarSettings
from arjuna_sim.inputs import moves_sideways, named_robot, named_world
from arjuna_sim.learning.task import (
    TaskConfig,
    beams_of,
    drawn,
    free_points,
    goals_seen,
    judged,
    observed,
    scan_points,
)
from arjuna_sim.model.robot import RobotModel, footprint
from arjuna_sim.model.world import World
from arjuna_sim.simulation import Simulation, solo

Observed = dict[str, Singles]


class Navigate(gymnasium.Env[Observed, Singles]):
    """Drive from a random start to a random goal, and touch nothing.

    An action is v and w [m/s, rad/s], of robots that move sideways v, vy and w, held for `step`.
    The robot's base limits and ramps it, as it does everywhere.

    Observations (`float32`):
        scan `(sectors,)`: distance from the robot's middle to what its first lidar sees nearest in
            each sector, counter-clockwise from straight behind, over `scan_reach`; 1 for nothing.
        goal `(2,)`: x and y in the robot's frame [m], drawn in to `goal_reach`.
        velocity: as an action, by the wheels' odometry, cut at twice the actions' bounds.

    The goal is seen from where the robot truly is; who drives by it elsewhere takes a path or goal
    and localization. All else is what the robot measures, with noise.

    Rewards: `progress_reward` a metre nearer to the goal, `reached_reward`, `touch_reward`,
    `time_reward` a second, and `near_reward` a second, the more of it the deeper something is in
    the `margin` around the robot's farthest corner.

    Ends: `terminated` within `goal_tolerance` of the goal or where something is touched, which
    `info["is_success"]` and `info["touched"]` distinguish; `truncated` after `time_limit`.

    `reset(seed=...)` makes all that follows the same, bit by bit: starts, goals and noise. Its
    options `start` `(x, y, yaw)` and `goal` `(x, y)` choose an episode.

    Args:
        world: A world, or what `--world` takes: an SDF file's or a map's path; "" for the room.
        robot: A robot, or its URDF, xacro or SDF file's path; "" for the shipped one.
        simulator: Time steps and errors of the devices.
        task: Values of `TaskConfig` that differ from its defaults.

    Attributes:
        config: The task.
        simulation: The robot in its world.
        ticks: Of the simulation, in a step.
        radius: Of the robot's farthest corner [m].
        beams: Of its lidar, as `beams_of` returns them.
        bounds: Greatest observed velocities, `(A,)` [m/s, rad/s].

    Raises:
        ConfigError: A value of the task is wrong, or nothing is free.
        RobotError: The robot cannot be simulated, or has no lidar.
        WorldError: The world cannot be simulated.
    """

    def __init__(
        self,
        world: World | str | Path = "",
        robot: RobotModel | str | Path = "",
        simulator: SimulatorConfig | None = None,
        **task: Any,
    ) -> None:
        self.config = load(TaskConfig, task, "arjuna/Navigate-v0")
        simulator = simulator or SimulatorConfig()
        self.ticks = _whole(self.config.step, simulator.tick)
        if not isinstance(robot, RobotModel):
            robot = named_robot(str(robot), "")
        world = world if isinstance(world, World) else named_world(str(world))
        lidar = robot.settings.first(LidarSettings)
        if lidar is None:
            raise RobotError(robot.urdf.path, "has no lidar, which the robot would learn to use")
        # It is read once a step, and never by itself; nothing else is.
        self._lidar = replace(lidar, rate=1e-9)
        robot = replace(robot, settings=replace(robot.settings, sensors=(self._lidar,)))
        self.simulation = Simulation(solo(robot), world, simulator, np.random.default_rng(0))
        self.radius = float(np.hypot(*footprint(robot, robot.urdf.root).T).max(initial=0.0))
        self._free = free_points(
            self.simulation.robot.surfaces(),
            self.radius + self.config.clearance,
            self.config.longest,
        )
        angles = np.linspace(lidar.angle_min, lidar.angle_max, lidar.samples)
        self.beams = beams_of(angles, mounted(robot, lidar).planar().array())
        self._sideways = moves_sideways(robot)
        self._make_spaces()

    def _make_spaces(self) -> None:
        config, limits = self.config, self.simulation.robot.limits
        ahead = min(config.max_speed, limits.forward.value)
        back = min(config.max_reverse, limits.reverse.value)
        turn = min(config.max_turn, limits.turn.value)
        aside = [ahead] if self._sideways else []
        low = np.array([0.0 - back, *(-value for value in aside), -turn], np.float32)
        high = np.array([ahead, *aside, turn], np.float32)
        self.action_space = spaces.Box(low, high)
        fastest = 2.0 * np.maximum(-low, high)
        self.bounds, reach = fastest.astype(np.float64), np.float32(config.goal_reach)
        self.observation_space: Any = spaces.Dict(
            {
                "scan": spaces.Box(0.0, 1.0, (config.sectors,)),
                "goal": spaces.Box(-reach, reach, (2,)),
                "velocity": spaces.Box(-fastest, fastest),
            }
        )

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observed, dict[str, Any]]:
        """Begin an episode; see the class."""
        super().reset(seed=seed)
        given = dict(options or {})
        start, self._goal = self.draw(self.np_random)
        start, self._goal = numbers_of(given, "start", start), numbers_of(given, "goal", self._goal)
        if given:
            raise ConfigError(f"options {sorted(given)} are unknown; valid: 'start' and 'goal'")
        self.simulation.robot.spawn = SE2.from_array(start)
        self.simulation.reset(self.np_random)
        self._velocity = np.zeros((1, len(self.bounds)))
        self._pose, self._elapsed = start[None], 0
        self._distance = self._away()
        return self._look(), {"is_success": False, "touched": False}

    def draw(self, rng: np.random.Generator) -> tuple[Floats, Floats]:
        """Draw a start and a goal at which the robot touches nothing, seen by the lidar or not."""
        for _ in range(100):
            start, goal = drawn(self.config, self._free, rng)
            ends = SE2.from_array(start), SE2(goal[0], goal[1], 0.0)
            if not any(self.simulation.robot.obstacles_at(pose) for pose in ends):
                return start, goal
        raise ConfigError("none of 100 starts and goals is free; a smaller 'longest' may find some")

    def step(self, action: Singles) -> tuple[Observed, float, bool, bool, dict[str, Any]]:
        """Drive for `step`; see the class."""
        v, *aside, w = (float(value) for value in action)
        command, touched = Velocity(v, y=sum(aside), yaw_rate=w), False
        for _ in range(self.ticks):
            last = self.simulation.drive(command)
            touched |= bool(last.contacts)
        self._elapsed += 1
        moved = last.odometry
        aside = [moved.side] if self._sideways else []
        self._velocity[0] = moved.v, *aside, moved.w
        self._pose = last.truth.pose.array()[None]
        before, self._distance = self._distance, self._away()
        seen = self._look()
        out = judged(
            self.config,
            before,
            self._distance,
            seen["scan"].min(keepdims=True) * self.config.scan_reach,
            np.array([touched]),
            np.array([self._elapsed * self.config.step]),
            self.radius,
        )
        reached = bool(out.reached[0])
        info = {"is_success": reached, "touched": touched}
        return seen, float(out.reward[0]), reached or touched, bool(out.late[0]), info

    def _away(self) -> Floats:
        away: Floats = self._goal - self._pose[:, :2]
        return np.hypot(away[:, 0], away[:, 1])

    def _look(self) -> Observed:
        """Return what the robot observes now."""
        scan = self.simulation.robot.sense(self._lidar, self.simulation.time)
        points = scan_points(scan.ranges[None], *self.beams)
        goals = goals_seen(self._pose, self._goal[None], self.config.goal_reach)
        seen = observed(self.config, points, goals, self._velocity, self.bounds)
        return {name: values[0] for name, values in seen.items()}

    def close(self) -> None:
        """Free what the simulation holds."""
        self.simulation.close()


def _whole(step: float, tick: float) -> int:
    """Return how many ticks make a step.

    Raises:
        ConfigError: They do not divide it.
    """
    ticks = round(step / tick)
    if ticks < 1 or not math.isclose(ticks * tick, step, rel_tol=1e-6):
        raise ConfigError(f"'step' is {step:g} s; valid: a whole number of ticks of {tick:g} s")
    return ticks


def numbers_of(given: dict[str, Any], name: str, default: Floats) -> Floats:
    """Take numbers out of options, of the default's shape.

    Raises:
        ConfigError: They are of another, or not finite.
    """
    row = np.array(given.pop(name, default), np.float64)
    if row.shape != default.shape or not np.isfinite(row).all():
        shape = " x ".join(map(str, default.shape))
        raise ConfigError(f"option '{name}' is {row.tolist()}; valid: {shape} numbers")
    return row
