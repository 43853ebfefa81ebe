"""The checks, one subject a file: each a function of the snapshot that returns findings."""

from __future__ import annotations

from collections.abc import Callable

from bringup.doctor.checks import (
    body,
    clock,
    discovery,
    graphics,
    installation,
    lidar,
    lifecycle,
    localization,
    parameters,
    qos,
    rates,
    resources,
    transforms,
    velocity,
)
from bringup.doctor.finding import Finding
from bringup.doctor.snapshot import Snapshot

CHECKS: dict[str, Callable[[Snapshot], list[Finding]]] = {
    "installation": installation.check,
    "graphics": graphics.check,
    "resources": resources.check,
    "discovery": discovery.check,
    "clock": clock.check,
    "lifecycle": lifecycle.check,
    "qos": qos.check,
    "rates": rates.check,
    "transforms": transforms.check,
    "lidar": lidar.check,
    "localization": localization.check,
    "velocity": velocity.check,
    "body": body.check,
    "parameters": parameters.check,
}
"""Every check by its name, in the order in which causes come before what follows from them."""
