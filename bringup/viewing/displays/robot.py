"""The robot's body, the tree of frames, and who stands around."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

import numpy as np

from arjuna_core.param import param
from bringup.viewing.displays.base import Display, Moment
from bringup.viewing.drawing.values import Axes as AxesDrawing
from bringup.viewing.drawing.values import Drawing, Label, Line, Model, Parts


class RobotModel(Display):
    """A URDF's links, each in its frame.

    Attributes:
        base: The frame of its root link, once its description has come.
        joints: Limits of the joints that move by themselves [rad or m].
    """

    types = ("std_msgs/msg/String",)
    topic, latched, property = "robot_description", True, "Description Topic"
    base = robot = ""
    joints: Mapping[str, tuple[float, float]] = MappingProxyType({})

    def take(self, message: Any) -> Parts:
        from bringup.viewing.drawing.visual_model import read

        model = read(message.data)
        self.base, self.robot, self.joints = model.root, model.name, model.joints
        if model.notes:
            self.notes = model.notes
        return {link: Model(frame=link, glb=glb) for link, glb in model.glbs.items()}

    notes: tuple[str, ...] = ()


class TF(Display):
    """The frames' axes and names."""

    @dataclass(frozen=True)
    class Config:
        show_names: bool = param(True, "Show the frames' names.")
        show_axes: bool = param(True, "Show the frames' axes.")
        show_arrows: bool = param(False, "Show a line from each frame to its parent.")
        marker_scale: float = param(1.0, "Size; axes of 0.25 m at 1.", minimum=0.01, maximum=100.0)
        frames: str = param("", "Frames to hide, with semicolons between them.")

    def tick(self, moment: Moment) -> Parts | None:
        config, frames = self.config, moment.frames
        parents, hidden = frames.parents, config.frames.split(";")
        poses = {
            name: pose
            for name in dict.fromkeys((*parents.values(), *parents))
            if name not in hidden and (pose := frames.pose(name)) is not None
        }
        parts: dict[str, Drawing] = {}
        if config.show_axes and poses:
            positions = np.array([pose.position for pose in poses.values()], np.float32)
            wxyzs = np.array([pose.quaternion for pose in poses.values()], np.float32)
            length = 0.25 * config.marker_scale
            parts["axes"] = AxesDrawing(positions=positions, wxyzs=wxyzs, length=length)
        if config.show_names:
            parts |= {f"name {n}": Label(pose=pose, text=n) for n, pose in poses.items()}
        if config.show_arrows:
            for child, parent in parents.items():
                if child in poses and parent in poses:
                    ends = np.array([poses[child].position, poses[parent].position], np.float32)
                    parts[f"arrow {child}"] = Line(points=ends, colour=(255, 200, 0), width=2.0)
        return parts


class Axes(Display):
    """The axes of one frame."""

    @dataclass(frozen=True)
    class Config:
        reference_frame: str = param("<Fixed Frame>", "The frame.")
        length: float = param(1.0, "Their length.", unit="m", minimum=0.001, maximum=100.0)

    def tick(self, moment: Moment) -> Parts | None:
        named = self.config.reference_frame.lstrip("/")
        frame = moment.frames.fixed if named.startswith("<") else named
        origin, wxyz = np.zeros((1, 3), np.float32), np.array([[1.0, 0, 0, 0]], np.float32)
        axes = AxesDrawing(
            frame=frame or "", positions=origin, wxyzs=wxyz, length=self.config.length
        )
        return {"axes": axes}


class People(Display):
    """The people and boxes of a simulator's world."""

    def tick(self, moment: Moment) -> Parts | None:
        return moment.people
