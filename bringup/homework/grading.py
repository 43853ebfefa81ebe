"""Grades a submission: the simulator and the judges here, the program in its sandbox."""

from __future__ import annotations

import math
from collections.abc import Callable
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from geometry_msgs.msg import Twist, Vector3
from numpy.typing import NDArray

from arjuna_core.config import dotted
from arjuna_core.errors import ArjunaError
from arjuna_core.files.maps import load_map
from arjuna_core.files.shipped import found_or_shipped
from arjuna_core.files.whole_file import own_folder
from arjuna_core.files.yaml_file import read_yaml
from arjuna_core.grid import OccupancyGrid
from arjuna_core.ros import qos
from arjuna_core.ros.context import class_of
from arjuna_core.se2 import SE2
from bringup.demo.measures import Samples
from bringup.homework.bridge import Bridge, Topic, topic_of
from bringup.homework.exercise import Exercise, ExerciseError, Mark, SubmissionError, files_of
from bringup.homework.program import LostError, Program, ProgramError
from bringup.lockstep import LockStep
from bringup.parameters.files import Parameters, load_parameters, merged, shipped_parameters
from bringup.scenarios.drive import Drive, believed_pose, placed
from bringup.stack import LOCALIZATION_GROUP, SIM_GROUP, SLAM_GROUP
from bringup.viewing.snapshot import Snapshot

_STACKS = {"localization": LOCALIZATION_GROUP, "slam": SLAM_GROUP}
_FIXED: Parameters = {"sim": {"publish_ground_truth": False}}
"""Where the robot truly is stays in the simulator: no topic has it."""


@dataclass(frozen=True)
class Grade:
    """A submission's points.

    Attributes:
        marks: By criterion.
        printed: What the program printed last.
        ended: Why it ended before its time, or could not be graded; "" where it did not.
        snapshot: Of the robot's path; None where nothing was driven.
    """

    exercise: Exercise
    marks: dict[str, Mark]
    ended: str
    printed: str = ""
    snapshot: Snapshot | None = None

    @property
    def points(self) -> float:
        """The points, to halves: what is rounded away is not the same on every machine."""
        return sum(self.points_of(name) for name in self.marks)

    def points_of(self, name: str) -> float:
        """Return a criterion's points."""
        most = next(one.points for one in self.exercise.criteria if one.name == name)
        return round(2.0 * most * self.marks[name].share) / 2.0


class Attempt:
    """A submission while it is graded: what the judges of a script look at.

    Args:
        files: The submission's, by name.
        folder: Has them too.
        robot: In lock-step, its simulator running.

    Attributes:
        samples: Truth and estimate, a row a tick.
        drive: Length and touches.
        received: By topic, the time [s] and message of all that the program published.
        finished_at: When the program came to its end [s]; None where it did not.
        ended: Why it ended otherwise; "" where it did not.
    """

    def __init__(
        self, exercise: Exercise, files: dict[str, bytes], folder: Path, robot: LockStep
    ) -> None:
        self.exercise, self.files, self.folder, self.robot = exercise, files, folder, robot
        self.samples, self.drive = Samples(), Drive(robot, self._sample)
        self.received: dict[str, list[tuple[float, Any]]] = {}
        self.finished_at: float | None = None
        self.ended = ""
        self._localizes = "localization" in exercise.stacks
        self._begin, self._until, self._waits = robot.now, math.inf, False
        self._program: Program | None = None

    @property
    def now(self) -> float:
        """Since the program's start [s]."""
        return self.robot.now - self._begin

    @property
    def path(self) -> NDArray[np.float64]:
        """The true path: time since the start, x, y, yaw, a row a tick [s, m, m, rad]."""
        return self.samples.table[:, :4] - [self._begin, 0.0, 0.0, 0.0]

    def nearest(
        self, x: float, y: float, after: float = 0.0, within: float = 0.0
    ) -> tuple[float, float]:
        """Return how near the robot came to a point [m], and when [s], from a time on [s].

        That is when it was first `within` a distance [m], or else when it was nearest.
        """
        path = self.path[self.path[:, 0] >= after]
        gaps = np.hypot(path[:, 1] - x, path[:, 2] - y)
        if not len(gaps):
            return math.inf, math.inf
        near = np.flatnonzero(gaps <= within)
        at = int(near[0]) if len(near) else int(np.argmin(gaps))
        return float(gaps.min()), float(path[at, 0])

    def numbers(self, name: str, count: int, *arguments: Any) -> list[float]:
        """Return the numbers that a function of the submission returns.

        Raises:
            ProgramError: It raises, takes too long or returns something else, or there is none.
        """
        if self._program is None or self.ended:
            raise ProgramError(self.ended)
        try:
            found = self._program.call(name, *arguments)
        except LostError as error:
            self._stopped(str(error))
            raise
        numbers = found if isinstance(found, list) else [found]
        plain = [v for v in numbers if isinstance(v, int | float) and math.isfinite(v)]
        if len(plain) != len(numbers) or len(numbers) != count:
            raise ProgramError(f"{name} returned {str(found)[:80]}, not {count} numbers")
        return [float(value) for value in plain]

    def map(self) -> OccupancyGrid:
        """Return the map that is handed in, its image too.

        Raises:
            ArjunaError: It cannot be read, or its image is not of the submission.
        """
        path = self.folder / self.exercise.submit[0]
        content = read_yaml(path)
        image = content.get("image") if isinstance(content, dict) else None
        if image not in self.files:
            raise SubmissionError(path, f"names the image {image!r}, which is not handed in")
        return load_map(path)

    def run(self) -> None:
        """Let the program start and drive.

        Raises:
            ProtectionError: This machine cannot confine it.
        """
        exercise, node = self.exercise, self.robot.process.make_node("program", spun=False)
        drive = self._driven()
        if not exercise.runs:
            self._watch(drive, lambda: None)
            return
        listen, publish = (
            [self._topic(name, node) for name in names]
            for names in (exercise.listen, exercise.publish)
        )
        bridge = Bridge(node, listen, publish)
        self._program = program = Program(
            self.files, exercise.submit[0], listen, publish, exercise.function
        )
        try:
            if not exercise.function:
                self._watch(drive, lambda: self._exchange(program, bridge))
            elif "loaded" not in (answer := program.receive(10.0)):
                raise ProgramError(answer.get("ended") or "it ended before it was called")
        except ProgramError as error:
            self._stopped(str(error))

    def close(self) -> str:
        """End the program; return what it printed."""
        if self._program is None:
            return ""
        printed = self._program.printed
        self._program.close()
        self._program = None
        return printed

    def _watch(self, drive: Callable[[], None], exchange: Callable[[], None]) -> None:
        """Let the robot's time pass, up to some seconds after the program's end."""
        end = self.exercise.duration
        while self.now < min(end, self._until) - 1e-9:
            if self._until == math.inf:
                try:
                    exchange()
                except ProgramError as error:
                    self._stopped(str(error))
            drive()
            self.robot.step()

    def _exchange(self, program: Program, bridge: Bridge) -> None:
        """Hand over what came to the program since its last tick, and take what it publishes."""
        if self._waits:
            program.send({"now": round(self.robot.now * 1e9), "in": bridge.take()})
        message = program.receive(10.0 if not self._waits else 2.0)
        self._waits = True
        try:
            found = bridge.give(message.get("out", []))
        except (ValueError, TypeError) as error:
            raise ProgramError(f"it sent what is no message: {error}") from error
        for topic, messages in found.items():
            self.received.setdefault(topic, []).extend((self.now, one) for one in messages)
        if "ended" in message:
            self._stopped(str(message["ended"]))

    def _stopped(self, reason: str) -> None:
        self.ended, self._until = reason, self.now + self.exercise.rest
        if not reason:
            self.finished_at = self.now

    def _sample(self) -> None:
        last = self.robot.sim.last
        estimate = believed_pose(self.robot) if self._localizes else None
        self.samples.add(
            self.robot.now, last.truth.pose, estimate, last.contacts, True, self.robot.now
        )

    def _driven(self, every: int = 5) -> Callable[[], None]:
        """Return what publishes the grader's own commands, when due: every few ticks."""
        given = self.exercise.drive
        if not given:
            return lambda: None
        rows = np.array(given["table"], float).reshape(-1, 3)
        out = self.robot.client.create_publisher(Twist, given["topic"], qos.DEFAULT)

        def drive() -> None:
            if round(self.now / 0.02) % every == 0:
                at = np.searchsorted(rows[:, 0], self.now + 1e-6) - 1
                v, w = rows[max(at, 0), 1:] if at >= 0 else (0.0, 0.0)
                out.publish(Twist(linear=Vector3(x=float(v)), angular=Vector3(z=float(w))))

        return drive

    def _topic(self, name: str, node: Any) -> Topic:
        """Return a topic as the robot has it, or of the type that the exercise says.

        Raises:
            ExerciseError: Neither knows it.
        """
        name, _, kind = name.partition(" ")
        found = [
            *node.get_publishers_info_by_topic(name),
            *node.get_subscriptions_info_by_topic(name),
        ]
        if found:
            return topic_of(name, found[0].topic_type, found[0].qos_profile)
        try:
            class_of(kind)
        except LookupError as error:
            problem = f"'{name}' is no topic of the robot; name its type behind it: {error}"
            raise ExerciseError(self.exercise.path, problem) from error
        return topic_of(name, kind, qos.DEFAULT)


def grade(exercise: Exercise, submission: Path) -> Grade:
    """Return a submission's grade; one that cannot be used has no points.

    Raises:
        ExerciseError: The exercise cannot be used.
        ProtectionError: This machine cannot confine a program.
    """
    judges = exercise.judges()
    try:
        files = files_of(exercise, submission)
    except SubmissionError as error:
        return _nothing(exercise, str(error))
    with own_folder("grade") as name:
        folder = Path(name)
        for file, data in files.items():
            (folder / file).write_bytes(data)
        try:
            parameters = _parameters(exercise, folder)
        except ArjunaError as error:
            return _nothing(exercise, str(error).replace(f"{folder}/", ""))
        with closing(LockStep(parameters)) as robot:
            try:
                robot.start(SIM_GROUP, *(_STACKS[stack] for stack in exercise.stacks))
            except ArjunaError as error:
                return _nothing(exercise, str(error))
            robot.run(1.0)  # the clock is at 0 until the first tick
            attempt = Attempt(exercise, files, folder, robot)
            try:
                attempt.run()
                marks = {name: _mark(judge, attempt) for name, judge in judges.items()}
            finally:
                printed = attempt.close()
            return Grade(exercise, marks, attempt.ended, printed, _snapshot(attempt))


def _nothing(exercise: Exercise, reason: str) -> Grade:
    return Grade(exercise, {one.name: Mark(0.0, "") for one in exercise.criteria}, reason)


def _parameters(exercise: Exercise, folder: Path) -> Parameters:
    """Return the nodes' parameters: the exercise's over the shipped, the submission's over all."""
    world = {"world": found_or_shipped(exercise.world), "seed": exercise.seed}
    if exercise.robot:
        world["robot"] = found_or_shipped(exercise.robot)
    start = placed(SE2(*exercise.start))
    own: Parameters = {node: dotted(values) for node, values in exercise.parameters.items()}
    if exercise.map:
        start["map_server"] = {"yaml_filename": found_or_shipped(exercise.map)}
    handed: Parameters = {}
    if exercise.parameters_of:
        given = load_parameters([folder / exercise.submit[0]])
        handed = {node: given.get(node, {}) for node in exercise.parameters_of}
        if not any(handed.values()):
            nodes = ", ".join(exercise.parameters_of)
            raise ArjunaError(f"{exercise.submit[0]} sets no parameter of {nodes}")
    return merged(shipped_parameters(), start, handed, {"sim": world}, own, _FIXED)


def _mark(judge: Callable[[Attempt], Mark], attempt: Attempt) -> Mark:
    """Return a judge's mark; what the submission makes impossible to judge has no points."""
    try:
        share, why = judge(attempt)
        return Mark(share, "" if share == 1.0 else why)
    except (ProgramError, ArjunaError) as error:
        return Mark(0.0, str(error).replace(f"{attempt.folder}/", ""))


def _snapshot(attempt: Attempt) -> Snapshot | None:
    if not attempt.exercise.duration:
        return None
    table, exercise = attempt.samples.table, attempt.exercise
    grid = load_map(Path(found_or_shipped(exercise.map))) if exercise.map else None
    goals = [SE2(*(*pose, 0.0)[:3]) for pose in exercise.goals]
    return Snapshot(
        attempt.now,
        grid,
        robot=attempt.drive.truth,
        true=[(x, y) for x, y in table[::5, 1:3].tolist()],
        believed=[(x, y) for x, y in table[::5, 4:6].tolist() if x == x],
        goals=goals,
        touches=attempt.drive.touched_at,
    )
