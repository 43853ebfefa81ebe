"""Parameters of robot_localization's filters, of any number of sensors."""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np

from arjuna_core.arrays import Bools, Floats
from arjuna_core.config import duration_param, fixed, param
from arjuna_core.errors import ConfigError
from arjuna_sim.fusion.estimator import Control
from arjuna_sim.fusion.filters import Noise
from arjuna_sim.fusion.kinematics import SIZE
from arjuna_sim.fusion.sensors import Part

_SENSOR = re.compile(r"((odom|pose|twist|imu)\d+)(_\w+)?")
# The variances of robot_localization's defaults
_NOISE = (
    *(0.05, 0.05, 0.06, 0.03, 0.03, 0.06, 0.025, 0.025, 0.04),
    *(0.01, 0.01, 0.02, 0.01, 0.01, 0.015),
)


def _threshold(what: str) -> Any:
    text = f"Mahalanobis distance beyond which {what} is an outlier; 0 for none."
    return param(0.0, text, minimum=0.0)


_DIFFERENTIAL = {
    "differential": (bool, param(False, "Whether differences of poses count, as velocities.")),
    "relative": (bool, param(False, "Whether poses count from the first one on.")),
}
_OF_KIND: dict[str, dict[str, tuple[Any, Any]]] = {
    "odom": {
        **_DIFFERENTIAL,
        "pose_use_child_frame": (
            bool,
            param(False, "Whether the pose is that of the message's child frame, not the base's."),
        ),
        "pose_rejection_threshold": (float, _threshold("a pose")),
        "twist_rejection_threshold": (float, _threshold("a twist")),
    },
    "pose": {**_DIFFERENTIAL, "rejection_threshold": (float, _threshold("a pose"))},
    "twist": {"rejection_threshold": (float, _threshold("a twist"))},
    "imu": {
        **_DIFFERENTIAL,
        "remove_gravitational_acceleration": (
            bool,
            param(False, "Whether gravity is in its accelerations and is to be taken out."),
        ),
        "pose_rejection_threshold": (float, _threshold("an orientation")),
        "twist_rejection_threshold": (float, _threshold("a turn rate")),
        "linear_acceleration_rejection_threshold": (float, _threshold("an acceleration")),
    },
}


@dataclass(frozen=True)
class Sensor:
    """One sensor's parameters: kind, name, topic, mask and what else its kind has."""

    kind: str
    name: str
    topic: str
    mask: Bools
    queue_size: int
    options: Mapping[str, Any]

    def part(self, what: str, states: slice, planar: bool) -> Part | None:
        """Return the use of a part that measures some states; None where none is to be used."""
        mask = np.zeros(SIZE, bool)
        mask[states] = self.mask[states]
        if self.kind == "imu":
            mask[0:3] = mask[6:9] = False  # no IMU measures position or velocity
        if not mask.any():
            return None
        key = f"{what}_rejection_threshold"
        limit = self.options.get(key, self.options.get("rejection_threshold", 0.0))
        return Part(f"{self.name}_{what}", mask, limit or np.inf, planar)


@dataclass(frozen=True)
class FilterConfig:
    """Parameters of `ekf_node`; each sensor adds its own, as `odom0` and `odom0_config`."""

    frequency: float = param(30.0, "Rate of the output.", unit="Hz", minimum=0.1, maximum=1000.0)
    sensor_timeout: float = duration_param(
        0.0, "Silence after which the state is predicted on; 0 for one period."
    )
    two_d_mode: bool = fixed(False, "Whether the robot stays in the plane.")
    map_frame: str = fixed("map", "Frame of the map.")
    odom_frame: str = fixed("odom", "Frame of odometry.")
    base_link_frame: str = fixed("base_link", "Frame of the robot.")
    base_link_frame_output: str = fixed(
        "", "Frame of the robot in the output; empty for base_link_frame."
    )
    world_frame: str = fixed(
        "", "map_frame or odom_frame, in which the state is; empty for odom_frame."
    )
    odom_topic: str = fixed("odometry/filtered", "Topic of the output.")
    publish_tf: bool = param(True, "Whether the transform into the world frame is published.")
    publish_acceleration: bool = fixed(
        False, "Whether accelerations are published on accel/filtered."
    )
    permit_corrected_publication: bool = param(
        False, "Whether a time's output may be published once more, corrected."
    )
    transform_time_offset: float = param(
        0.0, "What is added to the transform's stamp.", unit="s", minimum=-10.0, maximum=10.0
    )
    reset_on_time_jump: bool = param(False, "Whether a clock that is set back resets the filter.")
    predict_to_current_time: bool = fixed(
        False, "Whether the output is predicted up to its time of publication."
    )
    smooth_lagged_data: bool = fixed(
        False, "Whether measurements that come late count at their own time."
    )
    history_length: float = duration_param(
        0.0, "How late they may come.", maximum=600.0, read_only=True
    )
    disabled_at_startup: bool = fixed(False, "Whether the filter waits for the service enable.")
    gravitational_acceleration: float = param(
        9.80665, "Gravity.", unit="m/s^2", minimum=0.0, maximum=100.0
    )
    use_control: bool = fixed(False, "Whether velocity commands predict.")
    stamped_control: bool = fixed(False, "Whether they are TwistStamped.")
    control_timeout: float = duration_param(
        0.0, "Age at which a command counts as 0.", read_only=True
    )
    control_config: tuple[bool, ...] = fixed((False,) * 6, "Which velocities are commanded.")
    acceleration_limits: tuple[float, ...] = fixed(
        (1.0,) * 6, "Greatest accelerations.", unit="m/s^2, rad/s^2"
    )
    deceleration_limits: tuple[float, ...] = fixed(
        (), "Greatest decelerations; empty for those.", unit="m/s^2, rad/s^2"
    )
    acceleration_gains: tuple[float, ...] = fixed(
        (1.0,) * 6, "Acceleration per difference of velocity.", unit="1/s"
    )
    deceleration_gains: tuple[float, ...] = fixed(
        (), "The same when slowing down; empty for those.", unit="1/s"
    )
    initial_state: tuple[float, ...] = fixed((0.0,) * SIZE, "The first state.")
    initial_estimate_covariance: tuple[float, ...] = fixed(
        (1e-9,) * SIZE, "Its covariance: 15 variances, or 225 numbers."
    )
    process_noise_covariance: tuple[float, ...] = fixed(
        _NOISE, "What is added to it in a second, likewise."
    )
    dynamic_process_noise_covariance: bool = fixed(
        False, "Whether that of the pose grows with the velocity."
    )

    @classmethod
    def config_for(cls, values: Mapping[str, Any]) -> type[FilterConfig]:
        """Return the class with the parameters of each sensor that values name."""
        found = (_SENSOR.fullmatch(key) for key in values)
        names = {(match[1], match[2]) for match in found if match}
        base: Any = cls
        made: type[FilterConfig] = _with_sensors(base, tuple(sorted(names - set(cls._names()))))
        return made

    @classmethod
    def _names(cls) -> Iterable[tuple[str, str]]:
        found = (_SENSOR.fullmatch(item.name) for item in dataclasses.fields(cls))
        return ((match[1], match[2]) for match in found if match)

    def __post_init__(self) -> None:
        six = ("control_config", "acceleration_limits", "acceleration_gains")
        lengths: dict[str, tuple[int, ...]] = {"initial_state": (SIZE,)}
        lengths.update(dict.fromkeys(six, (6,)))
        lengths |= dict.fromkeys(("deceleration_limits", "deceleration_gains"), (0, 6))
        covariances = ("initial_estimate_covariance", "process_noise_covariance")
        lengths |= dict.fromkeys(covariances, (SIZE, SIZE * SIZE))
        masks = {f"{name}_config" for name, _ in self._names()}
        lengths |= dict.fromkeys(sorted(masks), (SIZE,))
        problems = [
            f"'{key}' has {len(getattr(self, key))} values; valid: {' or '.join(map(str, valid))}"
            for key, valid in lengths.items()
            if len(getattr(self, key)) not in valid
        ]
        if self.world_frame not in ("", self.odom_frame, self.map_frame):
            problems.append(
                f"'world_frame' is {self.world_frame!r};"
                f" valid: map_frame '{self.map_frame}', odom_frame '{self.odom_frame}'"
            )
        if problems:
            raise ConfigError(*problems)

    @property
    def world(self) -> str:
        """The frame of the state."""
        return self.world_frame or self.odom_frame

    @property
    def output(self) -> str:
        """The robot's frame in the output."""
        return self.base_link_frame_output or self.base_link_frame

    @property
    def silence(self) -> float:
        """The sensors' silence [s] after which the state is predicted on."""
        return self.sensor_timeout or 1.0 / self.frequency

    def noise(self) -> Noise:
        """Return the process's noise."""
        return Noise(square(self.process_noise_covariance), self.dynamic_process_noise_covariance)

    def control(self) -> Control | None:
        """Return how commands accelerate the robot; None where they do not count."""
        if not self.use_control:
            return None
        limits = self.acceleration_limits, self.deceleration_limits or self.acceleration_limits
        gains = self.acceleration_gains, self.deceleration_gains or self.acceleration_gains
        mask = np.array(self.control_config)
        return Control(mask, np.array(limits), np.array(gains), self.control_timeout)

    def sensors(self) -> list[Sensor]:
        """Return the sensors that have a topic."""
        found = []
        for name, kind in self._names():
            keys = _OF_KIND[kind]
            options = {key: getattr(self, f"{name}_{key}") for key in keys}
            topic, size = getattr(self, name), getattr(self, f"{name}_queue_size")
            mask = np.array(getattr(self, f"{name}_config"))
            found += [Sensor(kind, name, topic, mask, size, options)] if topic else []
        return list({sensor.name: sensor for sensor in found}.values())


def square(values: tuple[float, ...]) -> Floats:
    """Return a covariance of its 15 variances or its 225 numbers."""
    given = np.array(values)
    return np.diag(given) if len(given) == SIZE else given.reshape(SIZE, SIZE)


@cache
def _with_sensors(cls: Any, sensors: tuple[tuple[str, str], ...]) -> Any:
    fields: list[tuple[str, Any, Any]] = []
    for name, kind in sensors:
        mask = fixed((False,) * SIZE, "Which of the 15 states it measures.")
        size = fixed(10, "Messages that may wait.", minimum=0, maximum=10000)
        own = {"config": (tuple[bool, ...], mask), "queue_size": (int, size), **_OF_KIND[kind]}
        topic = fixed("", f"Topic of the {kind} messages.")
        fields.append((name, str, topic))
        for key, (hint, item) in own.items():  # a field is of one class
            fresh = dataclasses.field(default=item.default, metadata=item.metadata)
            fields.append((f"{name}_{key}", hint, fresh))
    if not fields:
        return cls
    made = dataclasses.make_dataclass(cls.__name__, fields, bases=(cls,), frozen=True)
    made.__module__ = cls.__module__
    return made


@dataclass(frozen=True)
class UnscentedConfig(FilterConfig):
    """Parameters of `ukf_node`."""

    alpha: float = fixed(1e-3, "Spread of the sigma points.", minimum=1e-6, maximum=10.0)
    kappa: float = fixed(0.0, "Second scale of the sigma points.", minimum=0.0, maximum=100.0)
    beta: float = fixed(2.0, "What is known of the distribution; 2 of a Gaussian one.", minimum=0.0)
