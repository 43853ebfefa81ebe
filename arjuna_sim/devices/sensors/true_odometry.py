"""True motion on a topic: p3d of Gazebo classic, and gz-sim's OdometryPublisher."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar, NamedTuple

import mujoco
import numpy as np

from arjuna_core.arrays import Floats
from arjuna_core.pose3 import Pose3
from arjuna_sim.devices.device import StaticDevice, simulates
from arjuna_sim.files.sensor_tag import RATE_MAX, SensorTag
from arjuna_sim.files.tag_text import topic, value
from arjuna_sim.model.settings import SensorSettings, reads


@dataclass(frozen=True, kw_only=True)
class TrueOdometrySettings(SensorSettings):
    """True motion of a link.

    Attributes:
        world_frame: The name of the world's frame in its messages.
        noise: Standard deviation of each position and velocity [m, m/s and rad/s].
        in_world: Whether velocities are along the world's axes rather than the link's.
        planar: Whether height, roll and pitch are left out.
    """

    TITLE: ClassVar[str] = "true odometry"
    world_frame: str = "world"
    noise: float = 0.0
    in_world: bool = True
    planar: bool = False


class TrueMotion(NamedTuple):
    """A link's pose in the world, and its velocity and turn rates `(6,)` [m/s, rad/s]."""

    pose: Pose3
    twist: Floats


@reads("p3d")
def read_p3d(tag: SensorTag) -> list[TrueOdometrySettings]:
    """Read a plugin of p3d, whose tag stands for a sensor's."""
    own = topic(tag.element, "odom", "odom", "topicname")
    return [
        TrueOdometrySettings(
            **{**_mount(tag, "updaterate"), "topic": own, "frame": tag.link},
            world_frame=tag.text("framename", default="world"),
            noise=tag.deviation() or 0.0,
        )
    ]


@reads("odometrypublisher")
def read_publisher(tag: SensorTag) -> list[TrueOdometrySettings]:
    """Read a plugin of OdometryPublisher; it publishes in the plane unless it says otherwise."""
    own, base = tag.text("odomtopic", default="odometry"), tag.text("robotbaseframe")
    return [
        TrueOdometrySettings(
            **{**_mount(tag, "odompublishfrequency"), "topic": own, "frame": base or tag.link},
            world_frame=tag.text("odomframe", default="odom"),
            noise=tag.deviation() or 0.0,
            in_world=False,
            planar=tag.count("dimensions", 2) == 2,
        )
    ]


def _mount(tag: SensorTag, rate: str) -> dict[str, Any]:
    """Return the settings that all sensors have; without a rate, or with 0, it is 50 Hz."""
    given = value(tag.xml, tag.element, tag.label, 50.0, rate)
    return {**tag.mount(50.0, ""), "rate": min(given, RATE_MAX)}


@simulates(TrueOdometrySettings)
class TrueOdometry(StaticDevice):
    """Measures a link's true motion, with noise where the file names one."""

    def read(self, data: Any, now: float) -> TrueMotion:
        """Return where the link is and how it moves."""
        settings, found, quaternion = self._settings, np.zeros(6), np.zeros(4)
        kind, is_local = mujoco.mjtObj.mjOBJ_SITE, not settings.in_world
        mujoco.mj_objectVelocity(self._model, data, kind, self._site, found, int(is_local))
        mujoco.mju_mat2Quat(quaternion, data.site_xmat[self._site])
        place, twist = data.site_xpos[self._site].copy(), np.concatenate((found[3:], found[:3]))
        if settings.noise > 0.0:
            place += settings.noise * self._rng.standard_normal(3)
            twist += settings.noise * self._rng.standard_normal(6)
        (x, y, z), (a, b, c, d) = place.tolist(), quaternion.tolist()
        pose = Pose3((x, y, z), (a, b, c, d))
        if settings.planar:
            pose, twist[[2, 3, 4]] = Pose3.from_se2(pose.planar()), 0.0
        return TrueMotion(pose, twist)
