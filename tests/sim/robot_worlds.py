"""A generator of worlds that hold their robots, as gz-sim's examples and courses write them."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from pathlib import Path

from arjuna_core.se2 import SE2
from tests.sim import drive_cases as cases
from tests.sim.robot_files.tags import sides

_SIDES = sides("front", "rear")
_PLUGIN = re.compile(r"<plugin.*?</plugin>")
_TRACK = """<link name='{side}_track'><pose>0 {y} 0 0 0 0</pose><inertial><mass>4</mass></inertial>
<collision name='c'><geometry><box><size>0.4 0.06 0.1</size></box></geometry></collision></link>
<joint name='{side}_track_joint' type='fixed'><parent>base</parent><child>{side}_track</child>
</joint><plugin filename='gz-sim-track-controller-system' name='t'><link>{side}_track</link>
</plugin>"""
_TRACKED = "".join(_TRACK.format(side=side, y=y) for side, y in (("left", 0.15), ("right", -0.15)))
_TRACKED += cases.plugin(
    "gz-sim-tracked-vehicle-system",
    "".join(f"<{s}_track><link>{s}_track</link></{s}_track>" for s in ("left", "right")),
)
_CONTROL, _FILES = cases.control(
    "diff_drive_controller:\n  ros__parameters:\n"
    "    left_wheel_names: [front_left_wheel_joint, rear_left_wheel_joint]\n"
    "    right_wheel_names: [front_right_wheel_joint, rear_right_wheel_joint]\n"
    "    wheel_separation: 0.28\n    wheel_radius: 0.06\n"
)
DRIVES = {
    "DiffDrive": cases.Robot(cases.four(), cases.plugin("gz-sim-diff-drive-system", _SIDES)),
    "classic DiffDrive": cases.Robot(
        cases.four(), cases.plugin("libgazebo_ros_diff_drive.so", _SIDES)
    ),
    "AckermannSteering": cases.car("gz"),
    "MecanumDrive": cases.mecanum(),
    "VelocityControl": cases.planar_on(*cases.four()),
    "planar_move": cases.planar(),
    "TrackedVehicle": cases.Robot((), _TRACKED),
    "TrackedVehicle on its side": cases.Robot((), _TRACKED, rolled=math.pi / 2),
    "diff_drive_controller": cases.Robot(cases.four(), _CONTROL, files=_FILES),
}
"""Robots that face +x, with their base in their model's frame, by what drives them."""
LIDAR = """<link name='mast'><pose>0 0 0.1 0 0 0</pose><sensor name='scanner' type='gpu_lidar'>
<topic>scan</topic><lidar><scan><horizontal><samples>90</samples><min_angle>-3</min_angle>
<max_angle>3</max_angle></horizontal></scan><range><min>0.2</min><max>20</max></range></lidar>
</sensor></link><joint name='mast_joint' type='fixed'><parent>base</parent><child>mast</child>
</joint>"""
_BOX = "<geometry><box><size>0.5 0.5 0.5</size></box></geometry>"
BESIDE = f"""<plugin filename='gz-sim-physics-system' name='gz::sim::systems::Physics'/>
<include><uri>model://ground_plane</uri></include>
<model name='wall'><static>true</static><pose>0 8 0.25 0 0 0</pose>
<link name='l'><collision name='c'>{_BOX}</collision></link></model>
<model name='crate'><pose>0 -8 0.25 0 0 0</pose>
<link name='l'><collision name='c'>{_BOX}</collision></link></model>
<model name='exhibit'><static>1</static><pose>8 0 0.25 0 0 0</pose>
<link name='l'><collision name='c'>{_BOX}</collision></link>
<plugin filename='gz-sim-diff-drive-system' name='gz::sim::systems::DiffDrive'/></model>"""
"""What is no robot: the ground, a wall, a crate, and a robot that is static."""
START = SE2(2.0, -1.0, 0.7)
FORMS = ("inline", "included", "driven by its include", "nested", "relative", "placed by a frame")


@dataclass(frozen=True)
class Held:
    """A robot of a world.

    Attributes:
        name: Of its model.
        drive: A key of `DRIVES`.
        form: One of `FORMS`, how the world holds it.
        pose: Where its base stands.
    """

    name: str = "vehicle"
    drive: str = "DiffDrive"
    form: str = "inline"
    pose: SE2 = START

    def write(self, folder: Path) -> str:
        """Write the files that it needs; return its element of a world."""
        robot, name, at = DRIVES[self.drive], self.name, f"<pose>{_numbers(self.pose)}</pose>"
        for other, text in robot.files.items():
            (folder / other).write_text(text, encoding="utf-8")
        if self.form == "inline":
            return robot.sdf_model(name, at + LIDAR)
        if self.form == "nested":
            T = SE2(0.4, 0.3, 1.1)
            outer, inner = _numbers(self.pose @ T.inverse()), f"<pose>{_numbers(T)}</pose>"
            own = robot.sdf_model("inner", inner + LIDAR)
            return f"<model name='{name}'><pose>{outer}</pose>{own}</model>"
        if self.form == "relative":
            T = SE2(-1.0, 0.5, 2.0)
            at = f"<pose relative_to='{name}_dock'>{_numbers(T)}</pose>"
            dock = f"<pose>{_numbers(self.pose @ T.inverse())}</pose>"
            frame = f"<frame name='{name}_dock'>{dock}</frame>"
            return frame + robot.sdf_model(name, at + LIDAR)
        if self.form == "placed by a frame":
            T = SE2(0.3, 0.0, 0.5)
            frame = f"<frame name='tip'><pose>{_numbers(T, 0.0)}</pose></frame>"
            at = f"<pose>{_numbers(self.pose @ T)}</pose>"
            own = robot.sdf_model(name, at + frame + LIDAR)
            return own.replace(">", " placement_frame='tip'>", 1)
        return self._included(folder, robot.sdf_model("of_file", LIDAR), at)

    def _included(self, folder: Path, model: str, at: str) -> str:
        plugins = ""
        if self.form == "driven by its include":
            plugins, model = "".join(_PLUGIN.findall(model)), _PLUGIN.sub("", model)
        (folder / self.name).mkdir()
        text = f"<sdf version='1.8'>{model}</sdf>"
        (folder / self.name / "model.sdf").write_text(text, encoding="utf-8")
        uri = f"<uri>model://{self.name}</uri>"
        return f"<include>{uri}<name>{self.name}</name>{at}{plugins}</include>"


def _numbers(pose: SE2, height: float = 0.06) -> str:
    return f"{pose.x!r} {pose.y!r} {height} 0 0 {pose.theta!r}"


def write(folder: Path, *robots: Held, beside: str = BESIDE) -> Path:
    """Write a world with some robots, and what is none; return its file."""
    inside = "".join(robot.write(folder) for robot in robots)
    path = folder / "held.sdf"
    text = f"<sdf version='1.8'><world name='held'>{beside}{inside}</world></sdf>"
    path.write_text(text, encoding="utf-8")
    return path
