"""The commands of `ros2`, their verbs and arguments as tables."""

from __future__ import annotations

from bringup.ros2.tables.bag import BAG
from bringup.ros2.tables.control import CONTROL
from bringup.ros2.tables.graph import ACTION, LIFECYCLE, NODE, PARAM, SERVICE
from bringup.ros2.tables.others import DAEMON, DOCTOR, INTERFACE, LAUNCH, PKG, RUN, WTF
from bringup.ros2.tables.topic import TOPIC

COMMANDS = (
    *(ACTION, BAG, CONTROL, DAEMON, DOCTOR, INTERFACE, LAUNCH, LIFECYCLE, NODE),
    *(PARAM, PKG, RUN, SERVICE, TOPIC, WTF),
)
