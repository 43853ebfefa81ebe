"""MuJoCo's own viewer: a window that follows the simulation, and cannot touch it."""

from __future__ import annotations

import copy
import os
import sys
import warnings
from typing import Any

import mujoco

from arjuna_core.errors import ArjunaError
from arjuna_sim.model.geometry.shapes import Group

_DISTANCE, _ELEVATION = 5.0, -40.0  # of the eye that a window opens with: a room's corner [m, deg]
_SHOWN = (Group.WORLD_VISUAL.value, Group.ROBOT_VISUAL.value)
_REMEDY = "'python -m bringup view' shows the robot in a browser"


class ViewerError(ArjunaError):
    """No window can be opened on this machine."""


def need_screen() -> None:
    """Refuse where there is no screen: MuJoCo's viewer would wait for one for ever.

    Raises:
        ViewerError: There is none; the message has the reason and what to do instead.
    """
    reason = _screen_error()
    if reason:
        raise ViewerError(f"MuJoCo's viewer needs a screen: {reason}; {_REMEDY}")


def _screen_error() -> str:
    if sys.platform == "linux" and not any(map(os.environ.get, ("DISPLAY", "WAYLAND_DISPLAY"))):
        return "neither DISPLAY nor WAYLAND_DISPLAY is set"
    if sys.platform == "darwin":
        return "on macOS only a program that mjpython runs can open one"
    return "" if _opens_window() else "no window with OpenGL opens there"


def _opens_window() -> bool:
    import glfw

    with warnings.catch_warnings():
        warnings.simplefilter("ignore", glfw.GLFWError)
        if not glfw.init():
            return False
        glfw.window_hint(glfw.VISIBLE, glfw.FALSE)
        window = glfw.create_window(16, 16, "", None, None)
        glfw.terminate()
    return bool(window)


def _launch(model: Any, data: Any) -> Any:
    import mujoco.viewer as viewer

    return viewer.launch_passive(model, data, show_left_ui=False, show_right_ui=False)


class Viewer:
    """Shows a stage in a window, from copies: what is done there changes no physics.

    The window opens with the first picture, and again when the model was compiled again; once a
    person has closed it, it stays closed.

    Raises:
        ViewerError: There is no screen.
    """

    def __init__(self) -> None:
        need_screen()
        self._handle: Any = None
        self._model: Any = None  # the simulation's
        self._own: tuple[Any, Any] = None, None  # the window's copy, and its data
        self._due = 0.0

    def show(self, model: Any, data: Any, wall_now: float) -> None:
        """Show how things are, if a picture is due on any steady clock [s]."""
        is_closed = self._handle is not None and not self._handle.is_running()
        if wall_now < self._due or is_closed:
            return
        # [s] 30 pictures a second of real time.
        self._due = wall_now + 1.0 / 30.0
        if model is not self._model:
            self._open(model)
        copied, own = self._own
        own.qpos[:], own.time = data.qpos, data.time
        own.mocap_pos[:], own.mocap_quat[:] = data.mocap_pos, data.mocap_quat
        mujoco.mj_kinematics(copied, own)
        mujoco.mj_comPos(copied, own)
        mujoco.mj_camlight(copied, own)
        self._handle.sync()

    def _open(self, model: Any) -> None:
        self.close()
        copied = copy.deepcopy(model)
        self._model, self._own = model, (copied, mujoco.MjData(copied))
        self._handle = _launch(*self._own)
        self._handle.cam.distance, self._handle.cam.elevation = _DISTANCE, _ELEVATION
        self._handle.opt.geomgroup[:] = [group in _SHOWN for group in range(6)]

    def close(self) -> None:
        """Close the window."""
        if self._handle is not None:
            self._handle.close()
        self._handle = self._model = None
