"""Everything about the simulation that is not in the robot's or the world's file."""

from __future__ import annotations

from dataclasses import dataclass, field

from arjuna_core.config import duration_param
from arjuna_core.errors import ConfigError
from arjuna_sim.devices.drive import DriveConfig
from arjuna_sim.devices.odometry import OdometryConfig
from arjuna_sim.devices.sensors.imu import ImuConfig
from arjuna_sim.devices.sensors.lidar import LidarConfig
from arjuna_sim.physics.wheels.servo import ServoConfig


@dataclass(frozen=True)
class SimulatorConfig:
    """Time steps, and what the robot's devices are like."""

    tick: float = duration_param(
        0.02,
        "Time that one step advances; by default one step of the physics where a robot balances or"
        " takes efforts of its joints, so that who holds it from outside is not late.",
        minimum=0.001,
        maximum=0.1,
        read_only=True,
    )
    physics_timestep: float = duration_param(
        0.004,
        "Time step of the physics; the tick must be a whole number of them.",
        minimum=0.0001,
        maximum=0.01,
        read_only=True,
    )
    drive: DriveConfig = field(default_factory=DriveConfig)
    odometry: OdometryConfig = field(default_factory=OdometryConfig)
    lidar: LidarConfig = field(default_factory=LidarConfig)
    imu: ImuConfig = field(default_factory=ImuConfig)
    servo: ServoConfig = field(default_factory=ServoConfig)

    def __post_init__(self) -> None:
        """Refuse a tick, in which the wheels are controlled, that physics steps do not divide."""
        ratio = self.tick / self.physics_timestep
        if round(ratio) < 1 or abs(ratio - round(ratio)) > 1e-6:
            raise ConfigError(
                f"'tick' {self.tick} s must be a whole number of 'physics_timestep'"
                f" {self.physics_timestep} s"
            )

    @property
    def substeps(self) -> int:
        """The number of physics steps in a tick."""
        return round(self.tick / self.physics_timestep)
