"""The demo: explore, map, localize, drive the waypoints, be carried off, drive home."""

from __future__ import annotations

from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from arjuna_interfaces.msg import LocalizationQuality
from geometry_msgs.msg import PoseWithCovarianceStamped
from nav2_msgs.srv import SaveMap
from numpy.typing import NDArray
from std_msgs.msg import String

from arjuna_core.errors import ArjunaError
from arjuna_core.files.maps import load_map
from arjuna_core.grid import OccupancyGrid
from arjuna_core.ros import qos
from arjuna_core.se2 import SE2
from arjuna_sim.model.robot import footprint, inscribed_radius
from bringup.client.goals import Goals, initial_pose_msg
from bringup.demo.measures import (
    REACHED_WITHIN,
    Report,
    Samples,
    distance_to_surfaces,
    segments_from,
    write_report,
)
from bringup.lockstep import LockStep, LockStepError
from bringup.parameters.files import Parameters, merged
from bringup.recording.recorder import demo_recorder
from bringup.scenarios.space import FreeSpace
from bringup.stack import (
    EXPLORER_GROUP,
    LOCALIZATION_GROUP,
    NAVIGATION_GROUP,
    SIM_GROUP,
    SLAM_GROUP,
)
from bringup.terminal import Progress
from bringup.viewing.pictures import draw_snapshot
from bringup.viewing.snapshot import Snapshot

WAYPOINTS = (
    SE2(2.0, 2.0, 0.0),
    SE2(2.0, -2.0, 0.0),
    SE2(-2.0, -2.0, 3.14),
    SE2(-2.0, 2.0, 3.14),
    SE2(0.0, 0.0, 0.0),
)
HOME = SE2(0.0, 0.0, 0.0)
KNOWS = 0.5  # localization quality from which the robot's word counts


@dataclass(frozen=True)
class DemoOptions:
    """Options of a demo run.

    Attributes:
        goals: How many goals are drawn on the map that was made, in place of waypoints; 0 for none.
        map_time: For the first scan to be mapped [s].
        explore_time: After which what is mapped so far is the map [s]; None to map it all.
        explore_limit: After which mapping it all is given up [s].
        goal_time: For a goal [s].
        notice_time: For the robot to notice that it was carried off [s].
        recover_time: For it to know again where it is [s].
        clearance: Of where it is carried off to [m].
        margin: About the robot as it turns on a goal that is drawn [m].
        sight: From such a goal to the nearest wall at most [m].
    """

    seed: int
    out: Path
    parameters: Parameters
    waypoints: tuple[SE2, ...] = WAYPOINTS
    goals: int = 0
    kidnap: bool = True
    map_time: float = 60.0
    explore_time: float | None = None
    explore_limit: float = 1800.0
    goal_time: float = 300.0
    notice_time: float = 10.0
    recover_time: float = 60.0
    clearance: float = 0.6
    margin: float = 0.15
    sight: float = 3.0


class Demo:
    """One run of the demo, in lock-step."""

    def __init__(self, options: DemoOptions, progress: Progress) -> None:
        self._options = options
        self._progress = progress
        self._samples = Samples()
        self._rng = np.random.default_rng([options.seed, 1])
        self._quality = 0.0
        self._exploration = ""
        self._explored = False
        self._judge = False
        self._recovery_s: float | None = None

    def run(self) -> Report:
        """Run everything and write the artifacts.

        Raises:
            LockStepError: A phase did not end in time.
        """
        maps: Parameters = {"map_saver": {"maps_folder": str(self._options.out)}}
        robot = self._robot = LockStep(merged(self._options.parameters, maps))
        robot.on_tick = self._sample
        self._goals = Goals(robot)
        self._listen()
        path = self._options.out / "run.mcap"
        try:
            with closing(demo_recorder(robot.process, path)) as self._recorder:
                robot.start(SIM_GROUP)
                self._explore()
                self._restart_on_saved_map()
                self._drive_waypoints()
                recovered = None
                if self._options.kidnap:
                    self._kidnap()
                    self._progress.phase("driving home", robot.now)
                    recovered = self._go(HOME) and self._recovery_s is not None
            self._progress.finish(robot.now)
            return self._report(recovered)
        finally:
            robot.close()

    def _listen(self) -> None:
        client = self._robot.client

        def on_quality(message: Any) -> None:
            self._quality = message.quality

        def on_status(message: Any) -> None:
            self._exploration = message.data

        topic = "amcl/localization_quality"
        client.create_subscription(LocalizationQuality, topic, on_quality, qos.DEFAULT)
        client.create_subscription(String, "explorer/status", on_status, qos.LATCHED)
        self._initial_pose = client.create_publisher(
            PoseWithCovarianceStamped, "initialpose", qos.DEFAULT
        )

    def _origin(self) -> SE2:
        """Return where in the world the map begins: where the robot does."""
        start: SE2 = self._robot.sim.simulator.robot.spawn
        return start

    def _truth(self) -> SE2:
        pose: SE2 = self._origin().inverse() @ self._robot.sim.last.truth.pose
        return pose

    def _surfaces(self) -> NDArray[np.float64]:
        return segments_from(self._origin(), self._robot.sim.simulator.robot.surfaces())

    @property
    def _frames(self) -> tuple[str, str]:
        return "map", self._robot.sim.simulator.robot.model.urdf.root

    def _estimate(self) -> SE2 | None:
        return self._robot.process.transforms.try_lookup(*self._frames)

    def _sample(self) -> None:
        robot = self._robot
        self._recorder.poll()
        contacts = robot.sim.last.contacts
        estimate = self._estimate()
        known = self._robot.process.transforms
        stamp = None if estimate is None else known.latest_common(*self._frames)
        self._samples.add(robot.now, self._truth(), estimate, contacts, self._judge, stamp)
        self._progress.update(robot.now, self._exploration if not self._judge else "")

    def _explore(self) -> None:
        robot = self._robot
        self._progress.phase("exploring and mapping", robot.now)
        robot.start(SLAM_GROUP, NAVIGATION_GROUP, EXPLORER_GROUP)
        time, begun = self._options.explore_time, robot.now
        robot.run_until(
            lambda: self._estimate() is not None,
            self._options.map_time,
            "a scan that shows where the robot is",
        )
        self._explored = robot.run_until(
            lambda: self._exploration.startswith("done"),
            (time or self._options.explore_limit) - (robot.now - begun),
            "exploration",
            required=time is None,
        )
        robot.stop(EXPLORER_GROUP)

    def _restart_on_saved_map(self) -> None:
        robot = self._robot
        self._progress.phase("saving the map, restarting on it with AMCL", robot.now)
        robot.run(1.0)
        last = self._estimate()
        stem = self._options.out / "map"
        request = SaveMap.Request(map_topic="map", map_url=str(stem), image_format="pgm")
        if not robot.call(SaveMap, "map_saver/save_map", request).result:
            raise LockStepError(f"map_saver could not save {stem}; see its log above")
        robot.stop(SLAM_GROUP, NAVIGATION_GROUP)
        robot.process.transforms.clear()
        on_map: Parameters = {"map_server": {"yaml_filename": str(stem.with_suffix(".yaml"))}}
        values = merged(self._options.parameters, on_map)
        robot.start(LOCALIZATION_GROUP, NAVIGATION_GROUP, parameters=values)
        assert last is not None
        self._initial_pose.publish(initial_pose_msg(last, 0.05, 0.05, robot.now))
        robot.run_until(lambda: self._estimate() is not None, 10.0, "a first AMCL pose")
        robot.run(1.0)
        self._judge = True

    def _go(self, goal: SE2) -> bool:
        end = self._goals.navigate(goal, self._options.goal_time)
        off = self._truth().distance(goal)
        reached = end.succeeded and off <= REACHED_WITHIN
        if not reached:
            reason = end.reason or f"{off:.2f} m off by the truth"
            self._samples.missed.append(f"({goal.x:.2f}, {goal.y:.2f}): {reason}")
        return reached

    def _drawn(self) -> tuple[SE2, ...]:
        """Draw goals on the map that was made; the truth serves only to ask for no impossible one.

        Raises:
            ArjunaError: The map has no room for them.
        """
        robot, origin = self._robot.sim.simulator.robot, self._origin()
        outline = footprint(robot.model, robot.model.urdf.root)
        reach = float(np.hypot(*outline.T).max()) + self._options.margin
        radius, sight = inscribed_radius(robot.model), self._options.sight
        space = FreeSpace(self._map(), radius, reach, sight)

        def is_clear(pose: SE2) -> bool:
            turns = (SE2(0.0, 0.0, 2.0 * np.pi * k / 8) for k in range(8))
            return not any(robot.obstacles_at(origin @ pose @ turn) for turn in turns)

        goals = [self._truth()]
        for _ in range(self._options.goals):
            goals.append(space.draw_beyond(goals[-1], self._rng, is_clear=is_clear))
        return tuple(goals[1:])

    def _map(self) -> OccupancyGrid:
        return load_map(self._options.out / "map.yaml")

    def _drive_waypoints(self) -> None:
        try:
            waypoints = self._drawn() if self._options.goals else self._options.waypoints
        except ArjunaError as error:
            self._samples.missed.append(str(error))
            return
        for number, goal in enumerate(waypoints, 1):
            name = f"waypoint {number} of {len(waypoints)}: ({goal.x:.1f}, {goal.y:.1f})"
            self._progress.phase(name, self._robot.now)
            self._samples.goals.append((goal.x, goal.y, goal.theta, self._go(goal)))

    def _elsewhere(self) -> SE2:
        """Draw a free pose at least 2 m away; the truth serves only not to drop it into a box."""
        surfaces = self._surfaces()
        while True:
            x, y = self._rng.uniform(-4.3, 4.3, size=2)
            pose = SE2(float(x), float(y), float(self._rng.uniform(-np.pi, np.pi)))
            gap = distance_to_surfaces(np.array([[x, y]]), surfaces)[0]
            if gap > self._options.clearance and pose.distance(self._truth()) > 2.0:
                return pose

    def _kidnap(self) -> None:
        """Carry the robot off; it has to notice, then to find itself, looking round if need be."""
        robot = self._robot
        pose = self._elsewhere()
        self._progress.phase(f"kidnapped to ({pose.x:.1f}, {pose.y:.1f})", robot.now)
        self._judge = False
        robot.sim.simulator.robot.set_pose(self._origin() @ pose)
        start = robot.now
        robot.run_until(lambda: self._quality < KNOWS, self._options.notice_time, required=False)
        found = robot.run_until(self._knows_itself, 3.0, required=False)
        while not found and robot.now - start < self._options.recover_time:
            self._goals.spin(np.pi / 2.0, 15.0)
            found = robot.run_until(self._knows_itself, 1.0, required=False)
        if found:
            self._recovery_s = robot.now - start
            self._judge = True

    def _knows_itself(self) -> bool:
        """Return whether the robot says that it knows its pose, and is right."""
        estimate = self._estimate()
        near = estimate is not None and estimate.distance(self._truth()) < REACHED_WITHIN
        return self._quality >= KNOWS and near

    def _report(self, recovered: bool | None) -> Report:
        out = self._options.out
        grid = self._map()
        draw_snapshot(out / "map.png", Snapshot(grid=grid), "Map", 7.0)
        samples = self._samples
        draw_snapshot(out / "trajectory.png", samples.snapshot(grid), "The robot's path", 7.5)
        report = Report.of(
            *(samples, grid, self._surfaces(), self._progress.wall_time),
            seed=self._options.seed,
            exploration_done=self._explored,
            kidnap_recovered=recovered,
            kidnap_recovery_s=self._recovery_s,
        )
        write_report(out, report)
        return report
