"""Whether pictures can be drawn without a screen."""

from __future__ import annotations

from bringup.doctor.finding import Finding
from bringup.doctor.snapshot import Snapshot

_BACKENDS = ("", "egl", "glfw", "osmesa", "glx", "wgl", "disable", "disabled", "off", "false", "0")


def check(snapshot: Snapshot) -> list[Finding]:
    """Return what keeps the simulated camera off."""
    chosen = snapshot.machine.environment.get("MUJOCO_GL", "")
    if chosen.lower() not in _BACKENDS:
        what = f"MUJOCO_GL={chosen} is no backend, and MuJoCo does not start"
        return [Finding(what, "unset MUJOCO_GL, or set it to egl or osmesa")]
    if snapshot.machine.gl_error:
        what = f"no off-screen OpenGL, so no camera pictures ({snapshot.machine.gl_error})"
        return [Finding(what, "sudo apt-get install libegl1 libgl1-mesa-dri")]
    return []
