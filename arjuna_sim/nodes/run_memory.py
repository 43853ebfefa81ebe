"""The time and the robots' poses in a file: what replaces a killed simulator continues there."""

from __future__ import annotations

import json
from collections.abc import Mapping
from io import RawIOBase
from pathlib import Path

from arjuna_core.errors import InputFileError
from arjuna_core.files.input_file import read_json
from arjuna_core.se2 import SE2
from arjuna_core.timing import Periodic
from arjuna_sim.driven_robot import Observation
from arjuna_sim.simulation import Simulation


class RunMemory:
    """Keeps a run's time and poses.

    Args:
        file: Keeps them; empty: none are kept.
        period: How often [s]. Time continues so much later, so that it is never set back.
    """

    def __init__(self, file: str, period: float = 0.1) -> None:
        self._file = Path(file) if file else None
        self._open: RawIOBase | None = None
        self._size = 0
        self._period, self._due = period, Periodic(period)

    def keep(self, now: float, seen: Mapping[str, Observation]) -> None:
        """Write the time [s] and what was observed then, if that is due."""
        if self._file is None or not self._due.due(now):
            return
        poses = {
            name: [each.truth.pose.array().tolist(), each.odometry.T_odom_base.array().tolist()]
            for name, each in seen.items()
        }
        if self._open is None:
            self._open = self._file.open("wb", buffering=0)
        # One write, as long as the longest before: who kills the process never halves it.
        data = json.dumps({"time": now, "poses": poses}).encode().ljust(self._size)
        self._open.seek(0)
        self._size = self._open.write(data)

    def forget(self) -> None:
        """Keep nothing: the run has ended."""
        if self._open is not None:
            self._open.close()
            self._open = None
        if self._file is not None:
            self._file.unlink(missing_ok=True)

    def resume(self, simulation: Simulation) -> str:
        """Continue a simulation from what was kept; return a note, empty if nothing was."""
        if self._file is None or not self._file.is_file():
            return ""
        try:
            kept = read_json(self._file)
            time = float(kept["time"]) + self._period
            poses = {
                name: (SE2(*map(float, pose)), SE2(*map(float, odometry)))
                for name, (pose, odometry) in kept["poses"].items()
            }
        except (InputFileError, ValueError, KeyError, TypeError, AttributeError) as error:
            return f"the run before cannot be continued: {error}"
        simulation.resume(time, poses)
        return (
            f"continues at {time:.2f} s, where the simulator before it ended: speeds, what was"
            " moved, spawned or loaded, and the contacts counted are lost"
        )
