"""Sills that a robot crosses, found by driving it across some."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass

import numpy as np

from arjuna_core.pose3 import Pose3
from arjuna_core.se2 import SE2
from arjuna_core.twist import Velocity
from arjuna_sim.config import SimulatorConfig
from arjuna_sim.model.entities import Entity
from arjuna_sim.model.geometry.shapes import Kind, Part, Shape
from arjuna_sim.model.robot import RobotModel, footprint
from arjuna_sim.model.world import World
from arjuna_sim.simulation import Simulation, solo

_SPEED, _RUN_UP = 0.3, 0.3  # of the robot [m/s], and its distance to the sill at the start [m]
_LADDER = (0.1, 0.2, 0.3, 0.45, 0.7, 1.0)  # heights that are tried first, by the wheels' radius
_FINE = 1e-3  # to which the height is found [m]
_STARTS = (0.0, -0.03, -0.07, -0.01, -0.05)
"""Where it starts [m]: how it rocks as it meets the sill decides over some millimetres."""


@dataclass(frozen=True)
class CrossedSill:
    """The highest sill that a robot crosses.

    Attributes:
        height: [m].
        speed: With which it does, ahead [m/s].
        stopped: Names of the links that a higher one stops, sorted; none where it crosses one as
            high as its wheels' radius.
    """

    height: float
    speed: float
    stopped: tuple[str, ...] = ()

    def text(self) -> str:
        """Return it as a sentence."""
        stops = f"; a higher one stops {', '.join(self.stopped)}" if self.stopped else ""
        return f"crosses sills of {1e3 * self.height:.0f} mm at {self.speed:.2g} m/s{stops}"


def crossed_sill(
    robot: RobotModel, empty: World, config: SimulatorConfig | None = None
) -> CrossedSill | None:
    """Drive a robot across sills as deep as its wheels' radius; None where it does not drive.

    Args:
        empty: Level ground.
    """
    drive, outline = robot.drive, footprint(robot, robot.urdf.root)
    if not drive.wheels or robot.anchored or not len(outline):
        return None
    blind = dataclasses.replace(robot, settings=dataclasses.replace(robot.settings, sensors=()))
    sim = Simulation(solo(blind), empty, config or SimulatorConfig(), np.random.default_rng(0))
    course = _Course(sim, drive.radius, float(outline[:, 0].min()), float(outline[:, 0].max()))
    low, high = 0.0, 0.0
    stopped: tuple[str, ...] = ()
    for height in (share * drive.radius for share in _LADDER):
        if stopped := course.stopped_at(height):
            high = height
            break
        low = height
    while stopped and high - low > _FINE:
        middle = (low + high) / 2
        if again := course.stopped_at(middle):
            high, stopped = middle, again
        else:
            low = middle
    return CrossedSill(low, course.speed, stopped)


class _Course:
    """Level ground with a sill that rises out of it.

    Args:
        radius: Of the wheels [m].
        rear: Where the robot ends [m].
        front: Where it begins [m].
    """

    def __init__(self, sim: Simulation, radius: float, rear: float, front: float) -> None:
        self._sim, self.radius, self._height = sim, radius, 1.5 * radius
        self._edge = front + _RUN_UP
        self._goal = self._edge + radius - rear
        box = Part(Shape(Kind.BOX, (radius, 20.0, self._height)))
        sim.stage.spawn(Entity("sill", (box,), start=self._pose(0.0)))
        self.speed = min(_SPEED, sim.robot.limits.forward.value)

    def _pose(self, height: float) -> Pose3:
        return Pose3((self._edge + self.radius / 2, 0.0, height - self._height / 2))

    def stopped_at(self, height: float) -> tuple[str, ...]:
        """Return the links that a sill of a height stops from most starts; none where it does not.

        The robot tries until most starts have ended in one way.
        """
        tries: list[tuple[str, ...]] = []
        for start in _STARTS:
            tries.append(self._stopped(height, start))
            stops = sum(map(bool, tries))
            if 2 * max(stops, len(tries) - stops) > len(_STARTS):
                return tries[-1]
        return ()

    def _stopped(self, height: float, start: float) -> tuple[str, ...]:
        sim = self._sim
        sim.robot.set_pose(SE2(start, 0.0, 0.0))
        sim.stage.move("sill", self._pose(-_FINE))
        for _ in range(round(0.5 / sim.config.tick)):
            sim.drive(Velocity())
        sim.stage.move("sill", self._pose(height))
        seen, second = start, round(1.0 / sim.config.tick)
        while True:
            touched: set[str] = set()
            for _ in range(second):
                truth = sim.drive(Velocity(self.speed)).truth
                if truth.pose.x > self._goal:
                    return ()
                if math.hypot(truth.roll, truth.pitch) > 1.0:
                    return ("the robot, which falls",)
                touched |= self._touching()
            if truth.pose.x < seen + 0.05 * self.speed:
                return tuple(sorted(touched)) or ("the robot, which has no grip",)
            seen = truth.pose.x

    def _touching(self) -> set[str]:
        """Return the links that touch the sill."""
        scene, pairs = self._sim.stage.scene, self._sim.stage.data.contact.geom
        touching = pairs[scene.is_obstacle[pairs].any(axis=1)].ravel().tolist()
        return {scene.model.geom(geom).name.rpartition("//")[0] for geom in touching} - {""}
