"""Every controller, made for the robot that the tests of controllers play."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from arjuna_core.config import load, plugin_names
from arjuna_nav.controllers import Controller
from arjuna_nav.controllers.plugins import CONTROLLERS
from arjuna_nav.costmap.footprint import Footprint

V_MAX, W_MAX = 0.4, 0.8
XY_TOLERANCE, YAW_TOLERANCE = 0.20, 0.15
SHIM = "nav2_rotation_shim_controller::RotationShimController"
OWN: dict[str, dict[str, Any]] = {
    "pure pursuit": {
        "plugin": "nav2_regulated_pure_pursuit_controller::RegulatedPurePursuitController",
        "desired_linear_vel": V_MAX,
        "rotate_to_heading_angular_vel": W_MAX,
        "max_angular_accel": 1.5,
    },
    "graceful": {
        "plugin": "nav2_graceful_controller::GracefulController",
        "v_linear_max": V_MAX,
        "slowdown_radius": 0.9,
        "v_angular_max": W_MAX,
        "max_angular_accel": 1.5,
    },
    "mppi": {
        "plugin": "nav2_mppi_controller::MPPIController",
        "vx_max": V_MAX,
        "wz_max": W_MAX,
        "ax_max": 1.0,
        "ax_min": -1.0,
        "az_max": 1.5,
    },
    "dwb": {
        "plugin": "dwb_core::DWBLocalPlanner",
        "max_vel_x": V_MAX,
        "max_speed_xy": V_MAX,
        "max_vel_theta": W_MAX,
        "acc_lim_x": 1.0,
        "decel_lim_x": -1.0,
        "acc_lim_theta": 1.5,
        "decel_lim_theta": -1.5,
        "linear_granularity": 0.05,
    },
}


def under_shim(values: dict[str, Any]) -> dict[str, Any]:
    """Return the parameters of a controller under the rotation shim."""
    shim = {"rotate_to_heading_angular_vel": W_MAX, "max_angular_accel": 1.5}
    return {**shim, **values, "plugin": SHIM, "primary_controller": values["plugin"]}


PARAMETERS = OWN | {f"{name} under the shim": under_shim(values) for name, values in OWN.items()}


@dataclass(frozen=True)
class _Server:
    names: tuple[str, ...] = plugin_names(("it",), "The controllers.", CONTROLLERS)


def make(
    name: str, footprint: Footprint | None = None, period: float = 0.05, **values: Any
) -> Controller:
    """Return a controller for a robot with a radius of 0.25 m, with some other parameters."""
    config: Any = load(_Server, {"it": {**PARAMETERS[name], **values}})
    outline = footprint or Footprint.circle(0.25)
    made: Controller = CONTROLLERS.make(config.it, outline, XY_TOLERANCE, period)
    return made
