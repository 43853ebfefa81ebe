"""Parameters of docking, by Nav2's names."""

from __future__ import annotations

from dataclasses import dataclass, field

from arjuna_core.config import param
from arjuna_nav.docking.control_law import ControlLawConfig


@dataclass(frozen=True)
class ApproachConfig(ControlLawConfig):
    """How the robot drives to a dock and away, and what it stops before."""

    use_collision_detection: bool = param(True, "Whether to stop before obstacles.")
    projection_time: float = param(5.0, "How far ahead to look.", unit="s", minimum=0.01)
    simulation_time_step: float = param(0.1, "Step of that look.", unit="s", minimum=0.01)
    dock_collision_threshold: float = param(
        0.3, "Distance to the dock within which nothing counts as obstacle.", unit="m", minimum=0.0
    )


@dataclass(frozen=True)
class DockingConfig:
    """When docking waits, tries again and gives up."""

    controller_frequency: float = param(
        50.0, "Commands a second.", unit="Hz", minimum=0.1, read_only=True
    )
    initial_perception_timeout: float = param(
        5.0, "How long to wait until the dock is seen.", unit="s", minimum=0.0
    )
    wait_charge_timeout: float = param(
        5.0, "How long to wait until the battery charges.", unit="s", minimum=0.0
    )
    dock_approach_timeout: float = param(
        30.0, "How long an approach may take.", unit="s", minimum=0.0
    )
    undock_linear_tolerance: float = param(
        0.05, "Distance to the staging pose that is good enough.", unit="m", minimum=0.0
    )
    undock_angular_tolerance: float = param(
        0.05, "Heading from the staging pose that is good enough.", unit="rad", minimum=0.0
    )
    max_retries: int = param(3, "Most retries.", minimum=0)
    dock_backwards: bool = param(False, "Whether the robot backs into docks.")
    dock_prestaging_tolerance: float = param(
        0.5, "Distance to the staging pose within which it is not driven to.", unit="m", minimum=0.0
    )
    controller: ApproachConfig = field(default_factory=ApproachConfig)
