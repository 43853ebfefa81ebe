"""ROS 2's `launch_ros`: nodes, their namespaces and parameters in launch files."""

from launch.by_file import import_by_file

from launch_ros import (
    actions,
    descriptions,
    event_handlers,
    events,
    parameter_descriptions,
    substitutions,
)

import_by_file(
    {
        actions: ("ROSTimer", "RosTimer"),
        descriptions: ("Parameter", "ParameterFile", "ParameterValue"),
        **dict.fromkeys((event_handlers, events.lifecycle, substitutions), ()),
    }
)
