"""MPPI over flat arrays in C, compiled here, as a peer to measure by."""

from __future__ import annotations

import ctypes
import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arjuna_core.se2 import SE2
from arjuna_core.twist import Velocity
from arjuna_nav.controllers.mppi.config import MppiConfig
from arjuna_nav.controllers.mppi.rollouts import correlated
from arjuna_nav.costmap import Costmap
from tests.helpers import c_peer


class _Limits(ctypes.Structure):
    _fields_ = tuple(
        (name, ctypes.c_float) for name in ("v_min", "v_max", "w_max", "accel", "accel_w", "keep")
    )


class _Grid(ctypes.Structure):
    _fields_ = (
        ("data", ctypes.c_void_p),
        *((name, ctypes.c_int) for name in ("width", "height")),
        *((name, ctypes.c_double) for name in ("resolution", "x", "y")),
    )


class ArrayMppi:
    """A controller with the stock critics, the noise of ours, and a period of one step.

    Args:
        library: Of `compiled`.
        config: Size, limits of the drive and noise; all else has its default.
    """

    def __init__(self, library: ctypes.CDLL, config: MppiConfig) -> None:
        shape = (2, config.time_steps, config.batch_size)
        white = np.random.default_rng(config.seed).standard_normal(shape, dtype=np.float32)
        keep = math.exp(-config.model_dt / config.noise_time)
        stds = config.vx_std, config.wz_std
        noise = np.array(
            [correlated(each, keep, std) for each, std in zip(white, stds, strict=True)]
        )
        limits = config.vx_min, config.vx_max, config.wz_max, config.ax_max, config.az_max, keep
        self._library = library
        self._it = ctypes.c_void_p(
            library.mppi_make(
                config.batch_size, config.time_steps, _address(noise), _Limits(*limits)
            )
        )

    def close(self) -> None:
        """Free the arrays."""
        self._library.mppi_free(self._it)

    def set_path(self, path: NDArray[np.float64]) -> None:
        """Take a path `(N, 3) float64`."""
        self._path = path
        self._library.mppi_restart(self._it)

    def compute(self, pose: SE2, velocity: Velocity, costmap: Costmap) -> Velocity | None:
        """Return the command from a pose; None where all rollouts collide."""
        data, frame, command = costmap.data, costmap.frame, np.empty(2, np.float32)
        height, width = data.shape
        at = frame.resolution, frame.origin.x, frame.origin.y
        found = self._library.mppi_command(
            *(self._it, _address(self._path), len(self._path), _address(pose.array())),
            *(ctypes.c_float(velocity.x), ctypes.c_float(velocity.yaw_rate)),
            *(_Grid(_address(data), width, height, *at), _address(command)),
        )
        return Velocity(float(command[0]), yaw_rate=float(command[1])) if found else None


def _address(array: NDArray[Any]) -> ctypes.c_void_p:
    return array.ctypes.data_as(ctypes.c_void_p)


def compiled() -> ctypes.CDLL | None:
    """Return the peer's library, optimised as nav2_mppi_controller is; None without a compiler."""
    library = c_peer.compiled("mppi_array", "-O3", "-ffast-math", "-march=native")
    if library is not None:
        library.mppi_make.restype = ctypes.c_void_p
        library.mppi_command.restype = ctypes.c_bool
    return library
