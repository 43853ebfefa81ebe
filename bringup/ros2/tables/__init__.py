"""What each command of `ros2` takes: verbs and arguments as tables."""

from __future__ import annotations

from bringup.ros2.tables.graph import ACTION, LIFECYCLE, NODE, SERVICE
from bringup.ros2.tables.others import (
    BAG,
    DAEMON,
    DOCTOR,
    INTERFACE,
    LAUNCH,
    PARAM,
    PKG,
    RUN,
    WTF,
)
from bringup.ros2.tables.topic import TOPIC

COMMANDS = (
    *(ACTION, BAG, DAEMON, DOCTOR, INTERFACE, LAUNCH, LIFECYCLE, NODE),
    *(PARAM, PKG, RUN, SERVICE, TOPIC, WTF),
)
