"""The task of driving to a goal: what robots observe, what they earn, and how episodes end.

All functions take arrays whose first axis counts robots, so that one robot in MuJoCo and a batch
of a thousand learn the same. They keep no state and draw no random numbers but from `rng`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numba import njit

from arjuna_core.arrays import Bools, Floats, Singles
from arjuna_core.config import duration_param, length_param, param, speed_param, yaw_rate_param
from arjuna_core.errors import ConfigError
from arjuna_sim.model.geometry.walls import enclosure_of


@dataclass(frozen=True)
class TaskConfig:
    """Parameters of the task."""

    step: float = duration_param(0.1, "Time that one action holds.", minimum=0.001, maximum=2.0)
    time_limit: float = duration_param(60.0, "Length of an episode.", minimum=0.1)
    max_speed: float = speed_param(
        0.5, "Greatest speed of an action, if the robot can.", minimum=0.01
    )
    max_reverse: float = speed_param(
        0.0, "Greatest speed of an action backwards, if the robot can."
    )
    max_turn: float = yaw_rate_param(
        1.5, "Greatest turn rate of an action, if the robot can.", minimum=0.01
    )
    sectors: int = param(36, "Values of the scan, each of a sector.", minimum=4, maximum=3600)
    scan_reach: float = length_param(
        2.0, "How far the scan reaches from the robot's middle.", minimum=0.1
    )
    goal_reach: float = length_param(
        3.0, "A goal farther away is seen at this distance.", minimum=0.1
    )
    goal_tolerance: float = length_param(
        0.25, "Distance from the goal at which it is reached.", minimum=0.01
    )
    shortest: float = length_param(1.0, "Least distance from start to goal.")
    longest: float = length_param(10.0, "Greatest distance from start to goal.", minimum=0.1)
    clearance: float = length_param(
        0.2, "Room around the robot at starts and goals, at any heading."
    )
    margin: float = length_param(0.15, "Room around the robot, within which nearness costs.")
    progress_reward: float = param(1.0, "Reward of a metre towards the goal.")
    reached_reward: float = param(10.0, "Reward of the goal.")
    touch_reward: float = param(-10.0, "Reward of touching something.")
    near_reward: float = param(-1.0, "Reward of a second at the end of the margin, less before.")
    time_reward: float = param(-0.1, "Reward of a second.")


class Outcome(NamedTuple):
    """Results of one step, `(N,)` each: the rewards, and the ends that it brought.

    Attributes:
        reached: Whether the goal was reached: a terminal state, unless something was touched.
        touched: Whether something was touched: a terminal state.
        late: Whether the time is out: the episode is cut short there.
    """

    reward: Floats
    reached: Bools
    touched: Bools
    late: Bools


def beams_of(angles: Floats, T_base_sensor: Floats) -> tuple[Floats, Floats]:
    """Return where beams begin `(2,)` [m] and point `(B, 2)`, in the robot's frame.

    Args:
        angles: In the lidar's frame, `(B,)` [rad].
        T_base_sensor: The lidar's pose on the robot, seen from above, `(3,)` [m, m, rad].
    """
    turned = angles + T_base_sensor[2]
    return T_base_sensor[:2].copy(), np.column_stack((np.cos(turned), np.sin(turned)))


@njit(cache=True)
def scan_points(ranges: Floats, origin: Floats, directions: Floats) -> Floats:
    """Return where beams end in the robot's frame, `(N, B, 2)` [m]; inf where nothing was hit.

    Args:
        ranges: By REP 117, `(N, B)` [m]: what is too near to be measured is taken for touching
            the lidar.
        origin: As `directions` of `beams_of`.
    """
    count, beams = ranges.shape
    points = np.full((count, beams, 2), np.inf)
    for i in range(count):
        for j in range(beams):
            length = 0.0 if ranges[i, j] == -np.inf else ranges[i, j]
            if length < np.inf:
                points[i, j, 0] = origin[0] + length * directions[j, 0]
                points[i, j, 1] = origin[1] + length * directions[j, 1]
    return points


@njit(cache=True)
def sector_ranges(points: Floats, sectors: int, reach: float) -> Floats:
    """Return the distance to the nearest point of each sector, `(N, sectors)` [m].

    Sectors go counter-clockwise from straight behind; one without a point reads `reach`. The points
    may be a lidar's hits or a costmap's obstacles: the nearest of a sector is never hidden.

    Args:
        points: In the robot's frame, `(N, P, 2)` [m]; those that are not finite do not count.
    """
    count = len(points)
    nearest = np.full((count, sectors), reach)
    for i in range(count):
        for j in range(points.shape[1]):
            x, y = points[i, j, 0], points[i, j, 1]
            distance = math.hypot(x, y)
            if distance < reach:
                turn = (math.atan2(y, x) + math.pi) / (2.0 * math.pi)
                k = min(int(turn * sectors), sectors - 1)
                nearest[i, k] = min(nearest[i, k], distance)
    return nearest


def goals_seen(poses: Floats, goals: Floats, reach: float) -> Floats:
    """Return goals `(N, 2)` [m] seen from poses `(N, 3)`, those beyond the reach drawn in to it."""
    away = goals - poses[:, :2]
    c, s = np.cos(poses[:, 2]), np.sin(poses[:, 2])
    seen = np.column_stack((c * away[:, 0] + s * away[:, 1], c * away[:, 1] - s * away[:, 0]))
    distance = np.hypot(seen[:, 0], seen[:, 1])
    return np.asarray(seen * (reach / np.maximum(distance, reach))[:, None])


def observed(
    config: TaskConfig, points: Floats, goals: Floats, velocities: Floats, bounds: Floats
) -> dict[str, Singles]:
    """Return the observations.

    Args:
        points: Surfaces around the robots, as for `sector_ranges`.
        goals: As `goals_seen` returns them.
        velocities: As the wheels' odometry has it: v, w or v, vy, w, `(N, A)` [m/s, rad/s].
        bounds: Greatest values of the velocities, beyond which they are cut, `(A,)`.

    Returns:
        `scan` `(N, sectors)`: distance over `scan_reach`, from 0 to 1; `goal` `(N, 2)` [m];
        `velocity` `(N, A)`: in the actions' units.
    """
    ranges = sector_ranges(points, config.sectors, config.scan_reach)
    return {
        "scan": (ranges / config.scan_reach).astype(np.float32),
        "goal": goals.astype(np.float32),
        "velocity": np.clip(velocities, -bounds, bounds).astype(np.float32),
    }


def judged(
    config: TaskConfig,
    before: Floats,
    after: Floats,
    nearest: Floats,
    touched: Bools,
    elapsed: Floats,
    radius: float,
) -> Outcome:
    """Return what a step earned and ended.

    Args:
        before: Distances to the goals before the step, `(N,)` [m].
        after: And behind it.
        nearest: Distance of the nearest surface from the robot's middle, `(N,)` [m].
        touched: Whether the robot touched something in the step, `(N,)`.
        elapsed: Time since the episode began, `(N,)` [s].
        radius: Of the robot's farthest corner [m].
    """
    reached = (after <= config.goal_tolerance) & ~touched
    late = (elapsed >= config.time_limit - 1e-9) & ~reached & ~touched
    room = np.clip((nearest - radius) / max(config.margin, 1e-9), 0.0, 1.0)
    passing = config.time_reward + config.near_reward * (1.0 - room)
    reward = config.progress_reward * (before - after) + config.step * passing
    reward += config.reached_reward * reached + config.touch_reward * touched
    return Outcome(reward, reached, touched, late)


def drawn(config: TaskConfig, free: Floats, rng: np.random.Generator) -> tuple[Floats, Floats]:
    """Draw the start `(3,)` [m, m, rad] and the goal `(2,)` [m] of an episode.

    Args:
        free: Points at which the robot can stand at any heading, `(M, 2)` [m].

    Raises:
        ConfigError: None of 1000 pairs is as far apart as the configuration asks for.
    """
    for _ in range(1000):
        start, goal = free[rng.integers(len(free), size=2)]
        heading = rng.uniform(-math.pi, math.pi)
        if config.shortest <= math.hypot(*(goal - start)) <= config.longest:
            return np.array([*start, heading]), goal
    raise ConfigError(
        f"no start and goal lie {config.shortest:g} to {config.longest:g} m apart: the free space"
        " is {:.1f} x {:.1f} m".format(*np.ptp(free, axis=0))
    )


def free_points(surfaces: Floats, room: float, longest: float) -> Floats:
    """Return the points of a grid with room around them, connected with each other, `(M, 2)` [m].

    A world that walls do not enclose is cut to a square about its origin.

    Args:
        surfaces: What the lidar could hit, `(S, 4)` of `(x0, y0, x1, y1)` [m].
        room: Least distance to a surface [m].
        longest: The square's side [m].

    Raises:
        ConfigError: There are none.
    """
    enclosure = enclosure_of(surfaces, room)
    if enclosure is None:
        corners = longest / 2.0 * np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
        within = surfaces[(np.abs(surfaces) < longest / 2.0).all(axis=1)]
        fence = np.hstack((corners, np.roll(corners, -1, axis=0)))
        enclosure = enclosure_of(np.vstack((within, fence)), room)
    if enclosure is None:
        raise ConfigError(
            f"the world has no connected space that is {room:.2f} m from all walls; a smaller"
            " 'clearance' may find some"
        )
    cells = np.argwhere(enclosure.inside)[:, ::-1]
    return np.asarray((cells + 0.5) * enclosure.cell + enclosure.origin)
