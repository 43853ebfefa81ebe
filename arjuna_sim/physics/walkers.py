"""Walkers: all that follows a trajectory, moved at once; how hard they push."""

from __future__ import annotations

import math
from typing import Any

import mujoco
import numpy as np
from numba import njit

from arjuna_core.arrays import Bools, Floats, Ints
from arjuna_sim.model.world import Trajectory
from arjuna_sim.physics.contacts import any_of
from arjuna_sim.physics.ground import Ground


class Walkers:
    """Puts mocap bodies where their trajectories say, as `Trajectory.pose` does one by one.

    Args:
        ground: What they walk on.
    """

    def __init__(self, bodies: list[int], trajectories: list[Trajectory], ground: Ground) -> None:
        followed = [_on_ground(each, ground) for each in trajectories]
        longest = max((len(times) for times, _ in followed), default=0)
        self._bodies = np.array(bodies, np.int64)
        self._delay = np.array([each.delay for each in trajectories])
        self._round = np.array([_round(each) for each in trajectories])
        self._times = np.array([_filled(times, longest, np.inf) for times, _ in followed])
        self._poses = np.array([_filled(poses, longest) for _, poses in followed])

    def __len__(self) -> int:
        return len(self._bodies)

    def put(self, data: Any, elapsed: Floats) -> None:
        """Put each where it is at a time after its start [s], `(N,) float64`."""
        ways = self._round, self._delay, self._times, self._poses
        put_bodies(elapsed, *ways, self._bodies, data.mocap_pos, data.mocap_quat)


@njit(cache=True)
def put_bodies(
    elapsed: Floats,
    rounds: Floats,
    delays: Floats,
    times: Floats,
    poses: Floats,
    bodies: Ints,
    positions: Floats,
    quaternions: Floats,
) -> None:
    """Put each where it is, in place; NumPy took a twelfth of a run among two people for it."""
    for k in range(len(bodies)):
        now = np.fmod(elapsed[k], rounds[k]) - delays[k]
        passed = np.searchsorted(times[k], now, side="right")
        before, after = max(passed - 1, 0), min(passed, times.shape[1] - 1)
        length = times[k, after] - times[k, before]
        ratio = max(now - times[k, before], 0.0) / length if 0.0 < length < np.inf else 0.0
        a, b = poses[k, before], poses[k, after]
        turn = b[2] - a[2]
        theta = a[2] + ratio * math.atan2(math.sin(turn), math.cos(turn))
        for i, j in ((0, 0), (1, 1), (2, 3)):
            positions[bodies[k], i] = a[j] + ratio * (b[j] - a[j])
        quaternions[bodies[k]] = 0.0
        quaternions[bodies[k], 0] = math.cos(0.5 * theta)
        quaternions[bodies[k], 3] = math.sin(0.5 * theta)


class Manners:
    """Keeps walkers from pressing what they meet into a wall, as nothing else holds them back.

    Who would have to push harder than makes a robot slide stands, and steps over it where it stays.

    Args:
        model: The `mujoco.MjModel`, whose walkers' contacts become light while they step over.
    """

    def __init__(self, model: Any, bodies: list[int], timestep: float) -> None:
        # A walker steps over what blocks it after 2 s.
        self._model, self._patience = model, round(2.0 / timestep)
        # A push is averaged over 0.05 s: to set something moving takes more.
        self._share, self._pushes = timestep / 0.05, np.zeros(len(bodies))
        walkers = [int(np.flatnonzero(model.body_mocapid == body)[0]) for body in bodies]
        self._geoms = [np.flatnonzero(model.geom_bodyid == body) for body in walkers]
        self._who = np.full(model.ngeom, -1)
        for k, geoms in enumerate(self._geoms):
            self._who[geoms] = k
        self._is_walkers = self._who >= 0
        self._mass = model.body_subtreemass[model.body_rootid[model.geom_bodyid]]
        self._usual = model.geom_solref[:, 0].copy()
        self._waited, self._pushing = np.zeros(len(bodies), np.int64), False

    def stopped(self, data: Any) -> Ints:
        """Return who goes no farther in the next step."""
        pairs = data.contact.geom[: data.ncon]
        if not (self._pushing or any_of(pairs, self._is_walkers)):
            return np.empty(0, np.int64)
        who = self._who[pairs].max(axis=1)
        self._release(~np.isin(np.arange(len(self._waited)), who))
        self._pushes *= 1.0 - self._share
        force = np.zeros(6)
        for i in np.flatnonzero(who >= 0).tolist():
            mujoco.mj_contactForce(self._model, data, i, force)
            self._pushes[who[i]] += self._share * force[0] / self._mass[pairs[i]].max()
        self._pushing = bool(self._pushes.any())
        # A walker halts at a push of 50 N per kg of what it meets: twice what tyres hold.
        halts = self._pushes > 50.0
        self._waited[halts | (self._waited > 0)] += 1
        for k in np.flatnonzero(self._waited == self._patience).tolist():
            # [s] A contact so slow hardly presses; the time constant of others is 0.02 s.
            self._model.geom_solref[self._geoms[k], 0] = 1.0
        return np.flatnonzero(halts & (self._waited < self._patience))

    def _release(self, free: Bools) -> None:
        """Let those who meet nothing walk as if they never had."""
        for k in np.flatnonzero(free & (self._waited > 0)).tolist():
            self._model.geom_solref[self._geoms[k], 0] = self._usual[self._geoms[k]]
        self._waited[free], self._pushes[free] = 0, 0.0


def _round(trajectory: Trajectory) -> float:
    """Return the period of a trajectory, infinity for one that does not [s]."""
    whole = trajectory.delay + trajectory.times[-1]
    return whole if trajectory.loop and whole > 0.0 else np.inf


def _on_ground(trajectory: Trajectory, ground: Ground) -> tuple[Floats, Floats]:
    """Return times and `(x, y, yaw, z)` of waypoints that follow the ground."""
    times = np.array(trajectory.times)
    poses = np.array([(pose.x, pose.y, pose.theta, 0.0) for pose in trajectory.poses])
    if ground.is_level and ground.stood_on(*poses[0, :2].tolist()) == 0.0:
        return times, poses
    lengths = np.hypot(*np.diff(poses[:, :2], axis=0).T)
    # [m] The ground bends little over so short a distance.
    counts = np.maximum(np.ceil(lengths / 0.25), 1.0).astype(np.int64)
    at = np.append(
        np.concatenate([i + np.arange(n) / n for i, n in enumerate(counts)] or [[]]), len(counts)
    )
    whole = np.arange(len(times))
    poses[:, 2] = np.unwrap(poses[:, 2])
    dense = np.column_stack([np.interp(at, whole, column) for column in poses.T])
    dense[:, 3] = [ground.stood_on(x, y) for x, y in dense[:, :2].tolist()]
    return np.interp(at, whole, times), dense


def _filled(values: Any, count: int, last: float | None = None) -> Floats:
    """Return values and, up to a count of them, the last one or another again."""
    found = np.array(values, np.float64)
    rest = np.repeat(found[-1:] if last is None else [last], count - len(found), axis=0)
    return np.concatenate((found, rest))
