"""Inertial measurement units."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

from arjuna_core.config import angle_param, fixed, yaw_rate_param
from arjuna_sim.files.sensor_tag import SensorTag
from arjuna_sim.files.tag_text import flag, is_true
from arjuna_sim.model.settings import SensorSettings, chooses, reads
from arjuna_sim.model.urdf import Urdf

_AS_FIRST = "initialorientationasreference"


@dataclass(frozen=True)
class ImuConfig:
    """Errors of a low-cost MEMS unit."""

    gyro_noise: float = yaw_rate_param(0.002, "Standard deviation of a turn rate.", read_only=True)
    gyro_bias_walk: float = fixed(
        1e-5, "Growth of the gyros' bias.", unit="rad/s/sqrt(s)", minimum=0.0
    )
    accel_noise: float = fixed(
        0.02, "Standard deviation of an acceleration.", unit="m/s^2", minimum=0.0
    )
    accel_bias_walk: float = fixed(
        1e-4, "Growth of the accelerometers' bias.", unit="m/s^2/sqrt(s)", minimum=0.0
    )
    tilt_noise: float = angle_param(0.002, "Standard deviation of roll and pitch.", read_only=True)


@dataclass(frozen=True, kw_only=True)
class ImuSettings(SensorSettings):
    """An IMU.

    Attributes:
        gyro_noise: Standard deviation of a turn rate; None where the file names none [rad/s].
        accel_noise: Of an acceleration; None where the file names none [m/s^2].
        gyro_bias: Mean and standard deviation of the turn rates' bias at the start [rad/s].
        accel_bias: The same of the accelerations [m/s^2].
        gyro_drift: Growth of that bias [rad/s/sqrt(s)], and the time in which it is forgotten [s];
            None where the file names none.
        accel_drift: The same of the accelerations [m/s^2/sqrt(s)].
    """

    TITLE: ClassVar[str] = "imu"
    IS_PRIMARY: ClassVar[bool] = True
    TOPIC: ClassVar[str] = "imu/data"
    topic: str = TOPIC
    gyro_noise: float | None = None
    accel_noise: float | None = None
    gyro_bias: tuple[float, float] = (0.0, 0.0)
    accel_bias: tuple[float, float] = (0.0, 0.0)
    gyro_drift: tuple[float, float] | None = None
    accel_drift: tuple[float, float] | None = None


@reads("imu")
def read(tag: SensorTag) -> list[ImuSettings]:
    """Read an IMU, or a ROS 1 plugin that is one without a sensor.

    Raises:
        RobotError: A value is invalid.
    """
    if tag.element.tag == "plugin":
        return [_of_plugin(tag)]
    _note_orientation(tag)
    gyro = (_noise(tag, "angular_velocity"), "imu/noise/rate", "imu/noise/rates")
    accel = (_noise(tag, "linear_acceleration"), "imu/noise/accel")
    return [
        ImuSettings(
            **tag.mount(50.0, ImuSettings.TOPIC),
            gyro_noise=tag.deviation(*gyro),
            accel_noise=tag.deviation(*accel),
            gyro_bias=tag.bias(gyro[0]),
            accel_bias=tag.bias(accel[0]),
            gyro_drift=tag.drift(gyro[0]),
            accel_drift=tag.drift(accel[0]),
        )
    ]


def _note_orientation(tag: SensorTag) -> None:
    """Note an orientation that is not to be the world's, or not to be there."""
    enabled = tag.element.findtext("imu/enable_orientation") or "true"
    path = "imu/orientation_reference_frame/localization"
    frame = (tag.element.findtext(path) or "ENU").strip()
    asked = (
        ("enable_orientation", enabled, not is_true(enabled)),
        ("localization", frame, frame != "ENU"),
        ("initial_orientation_as_reference", "true", flag(tag.element, False, _AS_FIRST)),
    )
    for name, text, is_other in asked:
        if is_other:
            tag.note(f"<{name}> {text}: its orientation is the world's all the same")


def _noise(tag: SensorTag, part: str) -> str:
    """Return the path of the noise of the first axis that has some, which is that of all."""
    paths = [f"imu/{part}/{axis}/noise" for axis in "xyz"]
    return next((path for path in paths if tag.first(path) is not None), paths[0])


@chooses(2)
def first_imu(sensors: Sequence[SensorSettings], urdf: Urdf) -> ImuSettings | None:
    """Return the first IMU."""
    return next((s for s in sensors if isinstance(s, ImuSettings)), None)


def _of_plugin(tag: SensorTag) -> ImuSettings:
    gyro, accel = (tag.deviation(named=f"{part}gaussiannoise") for part in ("rate", "accel"))
    every = tag.deviation()  # libgazebo_ros_imu.so has one of all
    return ImuSettings(
        **tag.mount(50.0, ImuSettings.TOPIC),
        gyro_noise=every if gyro is None else gyro,
        accel_noise=every if accel is None else accel,
    )
