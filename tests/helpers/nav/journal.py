"""A journal of many goals, from which the next process continues, and what a day of them shows."""

from __future__ import annotations

import io
import json
import resource
import time
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arjuna_core.errors import InputFileError
from arjuna_core.files.input_file import read_text
from arjuna_core.files.whole_file import write_atomically
from arjuna_core.se2 import SE2
from arjuna_sim.model.robot import SOLO
from bringup.parameters.files import Parameters
from bringup.scenarios.drive import believed_pose

_HOUR = 3600.0
_LARGEST = 2**28


class Journal:
    """Goals, a line of JSON each; a process that is killed leaves all that were whole.

    Args:
        file: Keeps them; None: they are only remembered.
        setting: The options, which a process that continues must share.

    Attributes:
        rows: Those of the processes before, up to the last from which one can continue, and ours.
        piece: How many processes there were before.
        began: When, in simulated time, ours did [s].
        resume: What the next process begins with, empty at the start.

    Raises:
        InputFileError: The file is no journal, or one of other options.
    """

    def __init__(self, file: Path | None, setting: dict[str, Any]) -> None:
        self._file, self.rows = file, list[dict[str, Any]]()
        if file is not None and file.exists():
            self.rows = _rows(file, setting)
        while self.rows and not self.resume:
            self.rows.pop()
        self.piece: int = self.rows[-1]["piece"] + 1 if self.rows else 0
        self.began: float = self.rows[-1]["now"] if self.rows else 0.0
        if file is not None:
            lines = (json.dumps(one) + "\n" for one in (setting, *self.rows))
            write_atomically(file, "".join(lines).encode())

    @property
    def resume(self) -> dict[str, Any]:
        found: dict[str, Any] = self.rows[-1]["resume"] if self.rows else {}
        return found

    def parameters(self, folder: Path) -> Parameters:
        """Return those of a simulator that continues; what it reads is in a folder then."""
        if not self.resume:
            return {}
        memory = folder / "sim"
        memory.write_text(json.dumps(self.resume["sim"]), encoding="utf-8")
        return {"sim": {"resume_file": str(memory)}}

    def append(
        self, robot: Any, rng: np.random.Generator, goal: SE2, **figures: dict[str, Any]
    ) -> None:
        """Add a goal that has ended, its figures, and where the robot is in lock-step."""
        row = {"piece": self.piece, "now": robot.now, "goal": goal.array().tolist(), **figures}
        self.rows.append({**row, "resume": _resume(robot, rng)})
        if self._file is not None:
            with self._file.open("a", encoding="utf-8") as out:
                out.write(json.dumps(self.rows[-1]) + "\n")


def _rows(file: Path, setting: dict[str, Any]) -> list[dict[str, Any]]:
    try:
        text = read_text(file, _LARGEST)
        head, *rows = map(json.loads, text[: text.rfind("\n") + 1].splitlines())
        differs = [key for key in setting if head.get(key) != setting[key]]
    except (ValueError, AttributeError) as error:
        raise InputFileError(file, f"is no journal of goals: {error}") from error
    if differs:
        raise InputFileError(file, f"was begun with another {', '.join(differs)}: {head}")
    return rows


def _resume(robot: Any, rng: np.random.Generator) -> dict[str, Any]:
    """Return what the next process begins with; nothing while something touches the robot."""
    last, stage, believed = robot.sim.last, robot.sim.simulator.stage, believed_pose(robot)
    if last.contacts or believed is None:
        return {}
    poses = [last.truth.pose, last.odometry.T_odom_base]
    walkers = [one.name for one in stage.entities if one.trajectory is not None]
    return {
        "sim": {"time": robot.now, "poses": {SOLO: [pose.array().tolist() for pose in poses]}},
        "believed": believed.array().tolist(),
        "walked": {name: stage.walking_time(name) for name in walkers},
        "rng": rng.bit_generator.state,
    }


class Ticks:
    """Measures what the ticks of a robot take, and the memory.

    Args:
        robot: In lock-step; its `step` is wrapped.
    """

    def __init__(self, robot: Any) -> None:
        self._step, self._spent = robot.step, list[float]()
        robot.step = self._timed

    def _timed(self) -> None:
        start = time.process_time()
        self._step()
        self._spent.append(1e3 * (time.process_time() - start))

    def taken(self) -> dict[str, float]:
        """Return the CPU time of the ticks since the last call [ms], and the memory [MB].

        What is mapped from files is left out: the system takes it away and brings it back.
        """
        spent, self._spent = self._spent, []
        resident, shared = map(int, Path("/proc/self/statm").read_text("ascii").split()[1:3])
        return {
            "tick_p95_ms": float(np.percentile(spent, 95)),
            "tick_max_ms": max(spent),
            "memory_mb": (resident - shared) * resource.getpagesize() / 1e6,
        }


def steadiness(rows: list[dict[str, Any]], warm_up: float = _HOUR) -> dict[str, float]:
    """Return how steady a long run was, of each process without its first hour.

    Returns:
        `hours` simulated, in how many `pieces`; `memory_growth`, the greatest of a process, from
        the first to the last tenth of its goals; of the first and the last tenth of all goals
        the median of the 95th percentile of a goal's ticks, `tick_first_ms` and `tick_last_ms`,
        and the 95th percentile of the errors where nobody met the robot, `arrival_first_m` and
        `arrival_last_m`.
    """
    table = _table(rows)
    ends = [0, *(np.flatnonzero(np.diff(table["piece"])) + 1), len(rows)]
    growth = []
    for first, last in pairwise(ends):
        hours, memory = table["hours"][first:last], table["memory_mb"][first:last]
        warm = memory[hours - hours[0] >= min(warm_up / _HOUR, 0.5 * (hours[-1] - hours[0]))]
        before, after = _tenths(warm)
        growth.append(np.median(after) / np.median(before) - 1.0)
    alone = table["met"] == 0
    ticks, errors = _tenths(table["tick_p95_ms"]), _tenths(table["off_m"][alone])
    result = {"hours": float(table["hours"][-1]), "pieces": len(growth)}
    result["memory_growth"] = float(max(growth))
    for name, tick, error in zip(("first", "last"), ticks, errors, strict=True):
        result[f"tick_{name}_ms"] = float(np.median(tick))
        result[f"arrival_{name}_m"] = float(np.percentile(error, 95))
    return result


def _tenths(values: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    count = max(len(values) // 10, 1)
    return values[:count], values[-count:]


def _table(rows: list[dict[str, Any]]) -> dict[str, NDArray[np.float64]]:
    flat = [{**one, **one["arrival"], **one["cost"], "hours": one["now"] / _HOUR} for one in rows]
    names = ("hours", "piece", "met", "off_m", "off_rad", "succeeded", "touches")
    costs = ("memory_mb", "tick_p95_ms", "tick_max_ms")
    return {name: np.array([float(one[name]) for one in flat]) for name in (*names, *costs)}


def draw(rows: list[dict[str, Any]], picture: Path) -> None:
    """Draw memory, ticks and errors over the hours, a dot a goal, a line where a process began.

    Raises:
        OSError: It cannot be written.
    """
    from matplotlib.figure import Figure

    table, figure = _table(rows), Figure(figsize=(11.0, 10.0), layout="constrained")
    hours, alone = table["hours"], table["met"] == 0
    axes = figure.subplots(4, 1, sharex=True)
    axes[0].plot(hours, table["memory_mb"], color="tab:blue")
    axes[0].set(ylabel="memory [MB]", ylim=(0.0, None))
    for ax, name, of in (
        (axes[1], "tick_p95_ms", hours > 0.0),
        (axes[2], "tick_max_ms", hours > 0.0),
        (axes[3], "off_m", alone),
    ):
        ax.plot(hours[of], table[name][of], ".", ms=2.0, color="tab:gray", label="a goal")
        ax.plot(hours[of], _running(table[name][of]), color="tab:blue", label="median of 101")
        ax.legend(fontsize="small", loc="upper right")
    axes[1].set(ylabel="a tick's CPU, 95 % of a goal's [ms]", ylim=(0.0, None))
    axes[2].set(ylabel="the longest of a goal [ms]", ylim=(0.0, None))
    axes[3].set(ylabel="arrival error, nobody met [m]", yscale="log", xlabel="simulated time [h]")
    for ax in axes:
        for start in np.flatnonzero(np.diff(table["piece"])):
            ax.axvline(hours[start], color="tab:orange", lw=0.8)
    goals, failed = len(rows), int((table["succeeded"] == 0.0).sum())
    touches, met = int(table["touches"].sum()), int(table["met"].sum())
    figure.suptitle(
        f"{goals} goals, {failed} failed, {touches} own touches, people met {met} times"
        " (orange: a new process)"
    )
    buffer = io.BytesIO()
    figure.savefig(buffer, format="png", dpi=90)
    write_atomically(picture, buffer.getvalue())


def _running(values: NDArray[np.float64], width: int = 50) -> NDArray[np.float64]:
    return np.array(
        [np.median(values[max(k - width, 0) : k + width + 1]) for k in range(len(values))]
    )
