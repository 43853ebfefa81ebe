"""Drawing beside the physics: in real time a picture must not hold the robot up."""

from __future__ import annotations

from concurrent.futures import Future, ThreadPoolExecutor
from typing import Any

import mujoco

from arjuna_sim.devices.camera import Camera, CameraError, Shot
from arjuna_sim.model.settings import CameraSettings


class CameraThread:
    """Draws one picture at a time in a thread of its own; what it is too slow for is left out.

    Args:
        settings: The camera.
    """

    def __init__(self, settings: CameraSettings) -> None:
        self._camera = Camera(settings)
        self._thread = ThreadPoolExecutor(1, thread_name_prefix="camera")
        self._drawing: Future[Shot] | None = None
        self._stamp = 0.0
        self._data: Any = None  # the thread's own, of the last model
        self._model: Any = None

    def ask(self, model: Any, data: Any, stamp: float, color: bool, depth: bool) -> None:
        """Ask for a picture of the state as it is now, unless one is being drawn.

        Args:
            model: The `mujoco.MjModel`.
            data: The `mujoco.MjData`.
            stamp: The time now [s].
            color: Whether the colours are wanted.
            depth: Whether the distances are wanted.
        """
        if self._drawing is not None:
            return
        if model is not self._model:
            self._model, self._data = model, mujoco.MjData(model)
        self._data.qpos[:] = data.qpos  # copied, for the physics goes on meanwhile
        self._data.mocap_pos[:], self._data.mocap_quat[:] = data.mocap_pos, data.mocap_quat
        self._stamp = stamp
        self._drawing = self._thread.submit(self._draw, model, self._data, color, depth)

    def take(self) -> tuple[float, Shot | CameraError] | None:
        """Return the time and the picture that was asked for, or what went wrong; None: not yet."""
        drawing = self._drawing
        if drawing is None or not drawing.done():
            return None
        self._drawing = None
        try:
            return self._stamp, drawing.result()
        except CameraError as error:
            return self._stamp, error

    def close(self) -> None:
        """Free the camera in its thread, and end the thread."""
        self._thread.submit(self._camera.close)
        self._thread.shutdown()

    def _draw(self, model: Any, data: Any, color: bool, depth: bool) -> Shot:
        mujoco.mj_kinematics(model, data)
        mujoco.mj_comPos(model, data)
        return self._camera.shoot(model, data, color, depth)
