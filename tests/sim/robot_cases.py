"""A generator of robots with any sensors, mounted anyhow, whose truth is known."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from arjuna_core.pose3 import ORIGIN, Pose3
from tests.sim.builders import ROBOT


@dataclass(frozen=True)
class Mounted:
    """A sensor that a robot was given.

    Attributes:
        name: Its name.
        T_base: Its true pose in the robot's root at `base_link`'s height.
    """

    name: str
    T_base: Pose3


class RobotMaker:
    """Writes the shipped robot with other sensors.

    Args:
        folder: Where robots go.
        seed: Of all that is random.
    """

    def __init__(self, folder: Path, seed: int = 0) -> None:
        self._folder = folder
        self._rng = np.random.default_rng(seed)
        self._tags: list[str] = []
        self.mounted: list[Mounted] = []

    def random_pose(self, upright: bool = False) -> Pose3:
        """Return a pose near the robot's middle."""
        x, y, z = self._rng.uniform((-0.1, -0.1, 0.1), (0.1, 0.1, 0.4)).tolist()
        roll, pitch, yaw = self._rng.uniform(-3.0, 3.0, 3).tolist()
        rpy = (0.0, 0.0, yaw) if upright else (roll, pitch / 2.2, yaw)
        return Pose3.from_rpy((x, y, z), rpy)

    def add(
        self,
        kind: str,
        name: str,
        inside: str = "",
        T_link: Pose3 = ORIGIN,
        pose: Pose3 = ORIGIN,
        rate: float = 10,
    ) -> None:
        """Put a sensor with a `<pose>` of its own on a link of its own of `base_link`."""
        self.mounted.append(Mounted(name, T_link @ pose))
        xyz, rpy = (" ".join(map(repr, v)) for v in (T_link.position, T_link.rpy()))
        own = " ".join(map(repr, (*pose.position, *pose.rpy())))
        tag = f"<pose>{own}</pose>" if pose != ORIGIN else ""
        self._tags.append(
            f"<link name='{name}_link'/><joint name='{name}_joint' type='fixed'>"
            f"<parent link='base_link'/><child link='{name}_link'/>"
            f"<origin xyz='{xyz}' rpy='{rpy}'/></joint>"
            f"<gazebo reference='{name}_link'><sensor name='{name}' type='{kind}'>"
            f"<update_rate>{rate}</update_rate>{tag}{inside}</sensor></gazebo>"
        )

    def write(self, bare: bool = True) -> Path:
        """Write the robot; return its file.

        Args:
            bare: Whether the shipped robot's own sensors are left out.
        """
        text = ROBOT.read_text(encoding="utf-8")
        if bare:
            for name in ("lidar_link", "camera_link", "imu_link"):
                start = text.index(f'<gazebo reference="{name}">')
                text = text[:start] + text[text.index("</gazebo>", start) + len("</gazebo>") :]
        path = self._folder / "made.urdf"
        path.write_text(text.replace("</robot>", "".join(self._tags) + "</robot>"), "utf-8")
        return path
