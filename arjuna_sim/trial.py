"""A trial of a robot on level ground: whether it stands, drives, stops and turns as commanded."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from arjuna_core.twist import Velocity
from arjuna_sim.config import SimulatorConfig
from arjuna_sim.model.robot import RobotModel
from arjuna_sim.model.settings import DriveKind
from arjuna_sim.model.world import World
from arjuna_sim.physics.robot_motion import Truth
from arjuna_sim.simulation import Simulation, solo

_LEAN = 3.0  # that no robot on all its wheels comes to [deg]
_SHARE = 0.7  # of what it is commanded that a robot drives or turns, at least


class Trial:
    """Deviations of a robot from its commands, in order.

    Attributes:
        leans: How it does not stay upright; empty for one that does.
        lags: What it does less of than commanded.
    """

    def __init__(self, robot: RobotModel, empty: World) -> None:
        """Drive a robot in a world without anything."""
        self._sim = Simulation(solo(robot), empty, SimulatorConfig(), np.random.default_rng(0))
        self._lean, self._ahead = 0.0, 1.0
        self.leans: tuple[str, ...] = tuple(self._standing())
        self.lags: tuple[str, ...] = ()
        if not self.leans and robot.drive.wheels and not robot.anchored:
            self.leans, self.lags = tuple(self._stopping()), tuple(self._lagging(robot))

    def _run(self, command: Velocity, seconds: float) -> tuple[float, float]:
        """Drive, and return by how much it should have [m or rad] and has."""
        along, turned, last = 0.0, 0.0, self._sim.robot.truth()
        meant, self._lean = 0.0, 0.0
        for _ in range(round(seconds / self._sim.config.tick)):
            truth = self._sim.drive(command).truth
            step = last.pose.inverse() @ truth.pose
            along, turned, last = along + step.x, turned + step.theta, truth
            setpoint = self._sim.robot.setpoint
            meant += (setpoint.yaw_rate if command.yaw_rate else setpoint.x) * self._sim.config.tick
            self._lean = max(self._lean, _lean(truth))
        return meant, turned if command.yaw_rate else along

    def _standing(self) -> Iterator[str]:
        # A robot that tips over does so within 2 s.
        self._run(Velocity(0.1), 2.0)
        lean = _lean(self._sim.robot.truth())
        if lean > _LEAN:
            yield f"leans by {lean:.0f} degrees soon: it tips over, or would have to balance"

    def _stopping(self) -> Iterator[str]:
        still = _lean(self._sim.robot.truth())
        self._ahead = _share(*self._run(Velocity(0.5), 2.0))
        pulling = self._lean
        self._run(Velocity(), 1.0)
        for lean, when in ((pulling, "pulls away"), (self._lean, "stops")):
            if lean - still > _LEAN:
                reason = "its weight is too high, or too near its axle"
                yield f"leans by {lean:.0f} degrees as it {when}: {reason}"

    def _lagging(self, robot: RobotModel) -> Iterator[str]:
        holds = "what it stands on besides its driven wheels holds it, or these slip"
        if self._ahead < _SHARE:
            yield f"drives {100.0 * self._ahead:.0f} % of the way commanded: {holds}"
        elif robot.drive.kind is DriveKind.SIDES:
            share = _share(*self._run(Velocity(yaw_rate=1.0), 3.0))
            if share < _SHARE:
                yield f"turns {90.0 * share:.0f} of 90 degrees on the spot: {holds}"


def _share(meant: float, done: float) -> float:
    return max(0.0, done / meant) if meant > 0.0 else 1.0


def _lean(truth: Truth) -> float:
    """Return how far a robot is from upright [deg]."""
    return math.degrees(math.hypot(truth.roll, truth.pitch))
