"""A small drive as a recording, made without ROS."""

from __future__ import annotations

import io
import math
from pathlib import Path
from typing import Any

import numpy as np
from rosbags.interfaces import Nodetype
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from arjuna_core.bags.reader import Bag
from arjuna_core.bags.topic import TopicInfo
from arjuna_core.bags.writer import BagFolder

SECOND = 1_000_000_000
WALL = 2.0  # [m] from the map's origin in x
_STORE = get_typestore(Stores.ROS2_JAZZY)
_STORE.register(
    get_types_from_msg("geometry_msgs/Pose pose\nfloat64 weight\n", "nav2_msgs/msg/Particle")
)
_STORE.register(
    get_types_from_msg(
        "std_msgs/Header header\nnav2_msgs/Particle[] particles\n", "nav2_msgs/msg/ParticleCloud"
    )
)
URDF = """<robot name="r">
<link name="base_link"><visual><geometry><box size="0.4 0.3 0.1"/></geometry></visual></link>
<link name="wheel"><visual><geometry><sphere radius="0.1"/></geometry></visual></link>
<joint name="j" type="continuous"><parent link="base_link"/><child link="wheel"/></joint>
</robot>"""


def make(kind: str, **fields: Any) -> Any:
    """Return a message; fields that are not given, those of messages within too, are zero."""
    given = (
        fields[name] if name in fields else _zero(node, of)
        for name, (node, of) in _STORE.fielddefs[kind][1]
    )
    return _STORE.types[kind](*given)


def _zero(node: Nodetype, of: Any) -> Any:
    if node is Nodetype.NAME:
        return make(of)
    if node is Nodetype.BASE:
        return "" if of[0] == "string" else 0
    (item, kind), count = of
    return [] if item is Nodetype.NAME or kind[0] == "string" else np.zeros(count, kind[0])


def header(frame: str) -> Any:
    return make("std_msgs/msg/Header", frame_id=frame)


def pose(x: float, y: float = 0.0, yaw: float = 0.0) -> Any:
    return make(
        "geometry_msgs/msg/Pose",
        position=make("geometry_msgs/msg/Point", x=x, y=y),
        orientation=make("geometry_msgs/msg/Quaternion", z=math.sin(yaw / 2), w=math.cos(yaw / 2)),
    )


def transform(parent: str, child: str, x: float) -> Any:
    shift, turn = make("geometry_msgs/msg/Vector3", x=x), pose(x).orientation
    moved = make("geometry_msgs/msg/Transform", translation=shift, rotation=turn)
    kind = "geometry_msgs/msg/TransformStamped"
    return make(kind, header=header(parent), child_frame_id=child, transform=moved)


def twist(speed: float) -> Any:
    return make("geometry_msgs/msg/Twist", linear=make("geometry_msgs/msg/Vector3", x=speed))


def odometry(x: float, speed: float) -> Any:
    return make(
        "nav_msgs/msg/Odometry",
        header=header("odom"),
        child_frame_id="base_link",
        pose=make("geometry_msgs/msg/PoseWithCovariance", pose=pose(x)),
        twist=make("geometry_msgs/msg/TwistWithCovariance", twist=twist(speed)),
    )


def scan(x: float) -> Any:
    """Return four beams, of which the one ahead meets the wall and one meets nothing."""
    return make(
        "sensor_msgs/msg/LaserScan",
        header=header("base_link"),
        angle_max=1.5 * math.pi,
        angle_increment=0.5 * math.pi,
        scan_time=0.1,
        range_min=0.1,
        range_max=10.0,
        ranges=np.array([WALL - x, 1.0, math.inf, 1.0], dtype=np.float32),
    )


def grid(frame: str = "map") -> Any:
    """Return a map of 4 m x 2 m, x from -1 m, whose last column is the wall."""
    size = {"resolution": 0.1, "width": 31, "height": 20}
    info = make("nav_msgs/msg/MapMetaData", **size, origin=pose(-1.05, -1.0))
    data = np.zeros((20, 31), dtype=np.int8)
    data[:, 30] = 100
    return make("nav_msgs/msg/OccupancyGrid", header=header(frame), info=info, data=data.ravel())


def image(level: int) -> Any:
    size = {"height": 4, "width": 6, "encoding": "rgb8", "step": 18}
    data = np.full(72, level, dtype=np.uint8)
    return make("sensor_msgs/msg/Image", header=header("camera"), **size, data=data)


def path_of(*xs: float) -> Any:
    poses = [make("geometry_msgs/msg/PoseStamped", header=header("map"), pose=pose(x)) for x in xs]
    return make("nav_msgs/msg/Path", header=header("map"), poses=poses)


def particles(*xs: float) -> Any:
    found = [make("nav2_msgs/msg/Particle", pose=pose(x), weight=0.5) for x in xs]
    return make("nav2_msgs/msg/ParticleCloud", header=header("map"), particles=found)


def status(*codes: int) -> Any:
    rows = []
    for number, code in enumerate(codes):
        name = make("unique_identifier_msgs/msg/UUID", uuid=np.full(16, number, dtype=np.uint8))
        stamp = make("builtin_interfaces/msg/Time", sec=number)
        info = make("action_msgs/msg/GoalInfo", goal_id=name, stamp=stamp)
        rows.append(make("action_msgs/msg/GoalStatus", goal_info=info, status=code))
    return make("action_msgs/msg/GoalStatusArray", status_list=rows)


def serialized(message: Any) -> bytes:
    return bytes(_STORE.serialize_cdr(message, message.__msgtype__))


class Drive:
    """Writes a recording into a folder, message by message."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._writer = BagFolder(folder)

    def say(self, time: float, topic: str, message: Any, damaged: bool = False) -> None:
        """Record a message at a time [s]."""
        kind = message.__msgtype__
        definition = _STORE.generate_msgdef(kind, ros_version=2)[0]
        data = serialized(message)
        info = TopicInfo(topic, kind, definition)
        stamp = round(time * SECOND)
        self._writer.write(info, stamp, data[:10] if damaged else data, stamp)

    def close(self) -> Bag:
        """End the recording and return it."""
        self._writer.close()
        return Bag(self._folder)


def drive(folder: Path, seconds: int = 2) -> Bag:
    """Return a drive straight ahead at 0.5 m/s, from 0, ten steps a second."""
    recording = Drive(folder)
    static = make("tf2_msgs/msg/TFMessage", transforms=[transform("base_link", "wheel", 0.1)])
    recording.say(0.0, "/tf_static", static)
    recording.say(0.0, "/robot_description", make("std_msgs/msg/String", data=URDF))
    recording.say(0.0, "/map", grid())
    goal = make("geometry_msgs/msg/PoseStamped", header=header("map"), pose=pose(1.0))
    recording.say(0.0, "/goal_pose", goal)
    for step in range(10 * seconds):
        now, x = step / 10.0, 0.05 * step
        frames = [transform("map", "odom", 0.0), transform("odom", "base_link", x)]
        recording.say(now, "/tf", make("tf2_msgs/msg/TFMessage", transforms=frames))
        recording.say(now, "/scan", scan(x))
        recording.say(now, "/ground_truth/odom", odometry(x + 0.02, 0.5))
        recording.say(now, "/cmd_vel", twist(0.5))
        recording.say(now, "/camera/image_raw", image(step))
        recording.say(now, "/particle_cloud", particles(x - 0.1, x + 0.1))
    recording.say(float(seconds), "/plan", path_of(0.5, 0.8, 1.0))
    recording.say(float(seconds), "/navigate_to_pose/_action/status", status(4, 2))
    return recording.close()


def png_size(path: Path) -> tuple[int, int]:
    """Return the size of a picture [pixels]."""
    from PIL import Image

    with Image.open(io.BytesIO(path.read_bytes())) as picture:
        width, height = picture.size
    return width, height
