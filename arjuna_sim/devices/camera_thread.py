"""Drawing beside the physics: in real time a picture must not hold the robot up."""

from __future__ import annotations

import queue
import threading
from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from arjuna_sim.devices.camera import CameraError, Photographer, Shot
from arjuna_sim.model.settings import CameraSettings

_JOIN_TIMEOUT = 5.0


@dataclass(frozen=True)
class _Job:
    """A state to draw, copied, for the physics goes on meanwhile."""

    stamp: float
    model: Any
    positions: NDArray[np.float64]
    mocap: tuple[NDArray[np.float64], NDArray[np.float64]]
    color: bool
    depth: bool


class CameraThread:
    """Draws one picture at a time in a thread of its own; what it is too slow for is left out.

    Args:
        settings: The camera.
    """

    def __init__(self, settings: CameraSettings) -> None:
        self._photographer = Photographer(settings)
        self._jobs: queue.Queue[_Job | None] = queue.Queue(1)
        self._done: queue.Queue[tuple[float, Shot | CameraError]] = queue.Queue()
        self._busy = False
        self._thread = threading.Thread(target=self._run, name="camera", daemon=True)
        self._thread.start()

    def ask(self, model: Any, data: Any, stamp: float, color: bool, depth: bool) -> None:
        """Ask for a picture of the state as it is now, unless one is being drawn.

        Args:
            model: The `mujoco.MjModel`.
            data: The `mujoco.MjData`.
            stamp: The time now [s].
            color: Whether the colours are wanted.
            depth: Whether the distances are wanted.
        """
        if self._busy:
            return
        self._busy = True
        mocap = (data.mocap_pos.copy(), data.mocap_quat.copy())
        self._jobs.put(_Job(stamp, model, data.qpos.copy(), mocap, color, depth))

    def take(self) -> tuple[float, Shot | CameraError] | None:
        """Return the time and the picture that was asked for, or what went wrong; None: not yet."""
        try:
            done = self._done.get_nowait()
        except queue.Empty:
            return None
        self._busy = False
        return done

    def close(self) -> None:
        """End the thread."""
        self._jobs.put(None)
        self._thread.join(_JOIN_TIMEOUT)

    def _run(self) -> None:
        model, data = None, None
        while (job := self._jobs.get()) is not None:
            if job.model is not model:
                model, data = job.model, mujoco.MjData(job.model)
            self._done.put((job.stamp, self._draw(job, data)))
        self._photographer.close()

    def _draw(self, job: _Job, data: Any) -> Shot | CameraError:
        data.qpos[:] = job.positions
        data.mocap_pos[:], data.mocap_quat[:] = job.mocap
        mujoco.mj_kinematics(job.model, data)
        mujoco.mj_comPos(job.model, data)
        try:
            return self._photographer.shoot(job.model, data, job.color, job.depth)
        except CameraError as error:
            return error
