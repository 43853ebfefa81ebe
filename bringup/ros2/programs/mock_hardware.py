"""`ros2 run controller_manager ros2_control_node`: mock hardware, as the simulator of its robot."""

from __future__ import annotations

import re
import signal
from collections import ChainMap
from pathlib import Path
from xml.sax.saxutils import escape  # nothing is parsed here

from std_msgs.msg import String

from arjuna_core.files.shipped import shipped_file
from arjuna_core.files.whole_file import own_folder
from arjuna_core.ros import qos
from bringup.parameters.files import load_parameters
from bringup.ros2.client import Client
from bringup.ros2.verbs.forward import arjuna, ros_arguments

_HARDWARE = re.compile(r"<hardware>.*?<plugin>\s*([^<]*?)\s*</plugin>", re.DOTALL)
_MOCKS = ("mock_components/GenericSystem", "fake_components/GenericSystem")  # before Humble
_CONTROL = '<gazebo><plugin filename="gz_ros2_control-system" name="gz_ros2_control">'


def main(words: list[str]) -> None:
    """Simulate a robot whose hardware is mock, on an empty floor; else say who drives its joints.

    The controllers are those of the parameter files, as a robot of Gazebo's has them.
    """
    given = ros_arguments(words)
    values = ChainMap(given.parameters, *reversed(load_parameters(given.files).values()))
    text = str(values.get("robot_description", "")) or _published()
    others = [name for name in _HARDWARE.findall(text) if name not in _MOCKS]
    if others or not _HARDWARE.search(text):
        named = f": {', '.join(others)}" if others else ""
        drives = "the simulator drives the joints itself, as the robot's file says"
        print(f"nothing to do: {drives}; hardware is ROS's{named}", flush=True)
        signal.pause()
        return
    files = "".join(
        f"<parameters>{escape(str(Path(f).resolve()))}</parameters>" for f in given.files
    )
    head, end, _ = text.rpartition("</robot>")
    folder = own_folder("robot")  # as long as the simulator that this process becomes
    path = Path(folder.name, "robot.urdf")
    path.write_text(f"{head}{_CONTROL}{files}</plugin></gazebo>{end}", encoding="utf-8")
    space = ["--namespace", given.remapped["__ns"]] if "__ns" in given.remapped else []
    world = str(shipped_file("worlds/empty.world"))
    arjuna("sim", ["--world", world, "--robot", str(path), "--without-description", *space])


def _published() -> str:
    """Return the robot's description from its topic; empty where none comes within a minute."""
    received: list[str] = []
    with Client(name="ros2_control_node") as client:
        client.node.create_subscription(
            String, "robot_description", lambda message: received.append(message.data), qos.LATCHED
        )
        client.run_until(lambda: bool(received), 60.0, required=False)
    return "".join(received[:1])
