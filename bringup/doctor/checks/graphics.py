"""Drawing without a screen."""

from __future__ import annotations

from collections.abc import Iterator

from bringup.doctor.snapshot import Finding, Snapshot

RANK = 1
_BACKENDS = ("", "egl", "glfw", "osmesa", "glx", "wgl", "disable", "disabled", "off", "false", "0")


def check(snapshot: Snapshot) -> Iterator[Finding]:
    """Yield faults that keep the simulated camera off."""
    chosen = snapshot.machine.environment.get("MUJOCO_GL", "")
    if chosen.lower() not in _BACKENDS:
        what = f"MUJOCO_GL={chosen} is no backend, and MuJoCo does not start"
        yield Finding(what, "unset MUJOCO_GL, or set it to egl or osmesa")
    elif snapshot.machine.gl_error:
        what = f"no off-screen OpenGL, so no camera pictures ({snapshot.machine.gl_error})"
        yield Finding(what, "sudo apt-get install libegl1 libgl1-mesa-dri")
