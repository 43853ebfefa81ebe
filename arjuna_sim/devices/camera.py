"""The camera, colour and depth: drawn off-screen by MuJoCo, only when a picture is asked for."""

from __future__ import annotations

import importlib
import math
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np

from arjuna_core.arrays import Bytes, Singles
from arjuna_core.errors import ArjunaError
from arjuna_sim.devices.lens import Lens
from arjuna_sim.devices.sensors.camera import CameraSettings
from arjuna_sim.model.geometry.shapes import Group

_BACKENDS = ("egl", "osmesa")
_OF_COLOURS = (
    mujoco.mjtRndFlag.mjRND_SKYBOX,
    mujoco.mjtRndFlag.mjRND_SHADOW,
    mujoco.mjtRndFlag.mjRND_REFLECTION,
)
# MuJoCo's cameras look along -z with y up, links along x with z up.
_FROM_LINK = np.array([0.5, 0.5, -0.5, -0.5])


class CameraError(ArjunaError):
    """Pictures cannot be drawn on this machine."""


def add_camera(spec: Any, settings: CameraSettings) -> None:
    """Put a camera at its link's site."""
    site = spec.site(settings.site)
    rotation = np.zeros(4)
    mujoco.mju_mulQuat(rotation, site.quat, _FROM_LINK)
    camera = site.parent.add_camera(name=settings.name, pos=site.pos, quat=rotation)
    half = math.tan(settings.horizontal_fov / 2) * settings.height / settings.width
    camera.fovy = math.degrees(2 * math.atan(half))
    visual = spec.visual.global_
    drawn = lens_of(settings) or settings
    visual.offwidth = max(visual.offwidth, drawn.width)
    visual.offheight = max(visual.offheight, drawn.height)
    spec.visual.quality.offsamples = 0  # smooth edges cost most of the time without a GPU


def focal_length(settings: CameraSettings) -> float:
    """Return the focal length [pixels], the same along both axes."""
    return settings.width / 2 / math.tan(settings.horizontal_fov / 2)


def lens_of(settings: CameraSettings) -> Lens | None:
    """Return a camera's lens, None for an ideal one."""
    return Lens(settings, focal_length(settings)) if settings.distortion else None


def points(settings: CameraSettings, depth: Singles) -> Singles:
    """Return finite distances `(height, width)` as points in the optical frame, `(N, 3)` [m]."""
    f = focal_length(settings)
    rows, columns = np.nonzero(np.isfinite(depth))
    z = depth[rows, columns].astype(np.float64)
    x = (columns + 0.5 - settings.width / 2) * z / f
    y = (rows + 0.5 - settings.height / 2) * z / f
    return np.column_stack((x, y, z)).astype(np.float32)


@dataclass(frozen=True)
class Shot:
    """The picture of a camera at one instant, the top row first.

    Attributes:
        color: `(height, width, 3) uint8` RGB, where it was wanted.
        depth: Distance along the optical axis, +inf for none, -inf for what is too near,
            `(height, width) float32` [m], where it was wanted.
    """

    color: Bytes | None
    depth: Singles | None


class Camera:
    """Draws what the robot's camera sees, and follows the simulation from model to model.

    All calls must come from one thread, which OpenGL wants.

    Args:
        seed: Of its noise.
    """

    def __init__(self, settings: CameraSettings, seed: int = 0) -> None:
        self._settings, self._seed = settings, seed
        self._lens = lens_of(settings)
        self._view = mujoco.MjvCamera()
        self._view.type = mujoco.mjtCamera.mjCAMERA_FIXED
        self._option = mujoco.MjvOption()
        shown = (Group.WORLD_VISUAL.value, Group.ROBOT_VISUAL.value)
        self._option.geomgroup[:] = [group in shown for group in range(6)]
        self._option.sitegroup[:] = 0
        self._model: Any = None
        self._gl: Any = None

    def shoot(self, model: Any, data: Any, color: bool, depth: bool) -> Shot:
        """Draw what is wanted.

        Args:
            model: The compiled `mujoco.MjModel`, with a camera of `add_camera`.
            data: The `mujoco.MjData`, with positions up to date.

        Raises:
            CameraError: No off-screen OpenGL works here; the message has each one's reason.
        """
        if self._gl is None or model is not self._model:
            self._open(model)
        self._gl.make_current()
        mujoco.mj_camlight(model, data)
        every = mujoco.mjtCatBit.mjCAT_ALL
        mujoco.mjv_updateScene(model, data, self._option, None, self._view, every, self._scene)
        settings, lens = self._settings, self._lens
        ideal, buffer = None, None
        if depth:
            buffer = np.empty((settings.height, settings.width), np.float32)
            self._draw(None, buffer)
        if color:
            drawn = lens or settings
            self._widen(drawn.height / settings.height)
            image = np.empty((drawn.height, drawn.width, 3), np.uint8)
            self._draw(image, None)
            ideal = image[::-1] if lens is None else lens.picture(image[::-1])
        return Shot(
            None if ideal is None else self._noisy(ideal, float(data.time)),
            None if buffer is None else self._distances(buffer[::-1]),
        )

    def _widen(self, times: float) -> None:
        """Let the next picture show more of its plane by a factor, at the same focal length."""
        for camera in self._scene.camera if times != 1.0 else ():
            camera.frustum_top *= times
            camera.frustum_bottom *= times

    def _noisy(self, image: Bytes, time: float) -> Bytes:
        """Return a picture with the noise of a time [s], whatever was drawn before."""
        sigma = 255.0 * self._settings.noise
        if not sigma:
            return image
        rng = np.random.default_rng([self._seed, round(time * 1e6)])
        noise = rng.standard_normal(image.shape, np.float32) * np.float32(sigma)
        return np.asarray(np.clip(np.rint(image + noise), 0, 255), np.uint8)

    def _open(self, model: Any) -> None:
        self.close()
        settings = self._settings
        model.vis.map.znear = settings.near / model.stat.extent
        model.vis.map.zfar = settings.far / model.stat.extent
        drawn = self._lens or settings
        gl = _open_context(drawn.width, drawn.height)
        self._context = mujoco.MjrContext(model, mujoco.mjtFontScale.mjFONTSCALE_100)
        self._context.readDepthMap = mujoco.mjtDepthMap.mjDEPTH_ZEROFAR
        mujoco.mjr_setBuffer(mujoco.mjtFramebuffer.mjFB_OFFSCREEN, self._context)
        # MuJoCo's own viewer allows as many geoms.
        self._scene = mujoco.MjvScene(model, maxgeom=10_000)
        self._scene.flags[mujoco.mjtRndFlag.mjRND_FOG] = model.vis.rgba.fog[3] > 0.0
        self._view.fixedcamid = model.camera(self._settings.name).id
        self._gl, self._model = gl, model

    def _draw(self, image: Any, buffer: Any) -> None:
        """Draw into one of them; the sky has colour, but would have a distance too.

        Shadows and reflections change no distance, and take two thirds of the time.
        """
        height, width = (buffer if image is None else image).shape[:2]
        for flag in _OF_COLOURS:
            self._scene.flags[flag] = image is not None
        area = mujoco.MjrRect(0, 0, width, height)
        mujoco.mjr_render(area, self._scene, self._context)
        mujoco.mjr_readPixels(image, buffer, area, self._context)

    def _distances(self, buffer: Singles) -> Singles:
        """Turn a reversed depth buffer (1 near, 0 far) into metres along the optical axis."""
        near, far = self._settings.near, self._settings.far
        metres = near * far / (near + buffer.astype(np.float64) * (far - near))
        metres[(buffer <= 0.0) | (metres > self._settings.depth_far)] = np.inf  # nothing was hit
        metres[metres < self._settings.depth_near] = -np.inf
        return metres.astype(np.float32)

    def close(self) -> None:
        """Free the OpenGL context; the next picture opens another."""
        if self._gl is not None:
            self._gl.make_current()
            self._context.free()
            self._gl.free()
            self._gl = None


class CameraThread:
    """Draws one picture at a time in a thread of its own; what it is too slow for is left out."""

    def __init__(self, settings: CameraSettings, seed: int = 0) -> None:
        self._camera = Camera(settings, seed)
        self._thread = ThreadPoolExecutor(1, thread_name_prefix="camera")
        self._drawing: Future[Shot] | None = None
        self._stamp = 0.0
        self._data: Any = None  # the thread's own, of the last model
        self._model: Any = None

    def ask(self, model: Any, data: Any, stamp: float, color: bool, depth: bool) -> None:
        """Ask for a picture of the state as it is now, unless one is being drawn."""
        if self._drawing is not None:
            return
        if model is not self._model:
            self._model, self._data = model, mujoco.MjData(model)
        self._data.time = data.time
        self._data.qpos[:] = data.qpos  # copied, for the physics continues meanwhile
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


def gl_error() -> str:
    """Return why no picture can be drawn off-screen on this machine; empty where it can."""
    try:
        _open_context(16, 16).free()
    except CameraError as error:
        return str(error)
    return ""


def _open_context(width: int, height: int) -> Any:
    reasons = []
    for name in _BACKENDS:
        try:
            context = importlib.import_module(f"mujoco.{name}").GLContext(width, height)
            context.make_current()
        except (ImportError, AttributeError, RuntimeError, OSError) as error:
            reasons.append(f"{name}: {' '.join(str(error).split())}")
        else:
            return context
    raise CameraError(f"no off-screen OpenGL works: {'; '.join(reasons)}")
