"""A small drive as a recording, made without ROS."""

from __future__ import annotations

import io
import math
from pathlib import Path
from typing import Any

import numpy as np
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
    """Return a message; fields that are not given are those of an empty message."""
    return _STORE.types[f"{kind}"](**fields)


def header(frame: str) -> Any:
    stamp = make("builtin_interfaces/msg/Time", sec=0, nanosec=0)
    return make("std_msgs/msg/Header", stamp=stamp, frame_id=frame)


def pose(x: float, y: float = 0.0, yaw: float = 0.0) -> Any:
    point = make("geometry_msgs/msg/Point", x=x, y=y, z=0.0)
    turn = make(
        "geometry_msgs/msg/Quaternion", x=0.0, y=0.0, z=math.sin(yaw / 2), w=math.cos(yaw / 2)
    )
    return make("geometry_msgs/msg/Pose", position=point, orientation=turn)


def transform(parent: str, child: str, x: float) -> Any:
    zero = pose(x)
    shift = make("geometry_msgs/msg/Vector3", x=x, y=0.0, z=0.0)
    moved = make("geometry_msgs/msg/Transform", translation=shift, rotation=zero.orientation)
    return make(
        "geometry_msgs/msg/TransformStamped",
        header=header(parent),
        child_frame_id=child,
        transform=moved,
    )


def twist(speed: float) -> Any:
    zero = make("geometry_msgs/msg/Vector3", x=0.0, y=0.0, z=0.0)
    forward = make("geometry_msgs/msg/Vector3", x=speed, y=0.0, z=0.0)
    return make("geometry_msgs/msg/Twist", linear=forward, angular=zero)


def odometry(x: float, speed: float) -> Any:
    where = make("geometry_msgs/msg/PoseWithCovariance", pose=pose(x), covariance=np.zeros(36))
    moving = make(
        "geometry_msgs/msg/TwistWithCovariance", twist=twist(speed), covariance=np.zeros(36)
    )
    return make(
        "nav_msgs/msg/Odometry",
        header=header("odom"),
        child_frame_id="base_link",
        pose=where,
        twist=moving,
    )


def scan(x: float) -> Any:
    """Return four beams, of which the one ahead meets the wall and one meets nothing."""
    return make(
        "sensor_msgs/msg/LaserScan",
        header=header("base_link"),
        angle_min=0.0,
        angle_max=1.5 * math.pi,
        angle_increment=0.5 * math.pi,
        time_increment=0.0,
        scan_time=0.1,
        range_min=0.1,
        range_max=10.0,
        ranges=np.array([WALL - x, 1.0, math.inf, 1.0], dtype=np.float32),
        intensities=np.array([], dtype=np.float32),
    )


def grid(frame: str = "map") -> Any:
    """Return a map of 4 m x 2 m, x from -1 m, whose last column is the wall."""
    zero = make("builtin_interfaces/msg/Time", sec=0, nanosec=0)
    info = make(
        "nav_msgs/msg/MapMetaData",
        map_load_time=zero,
        resolution=0.1,
        width=31,
        height=20,
        origin=pose(-1.05, -1.0),
    )
    data = np.zeros((20, 31), dtype=np.int8)
    data[:, 30] = 100
    return make(
        "nav_msgs/msg/OccupancyGrid", header=header(frame), info=info, data=data.reshape(-1)
    )


def image(level: int) -> Any:
    return make(
        "sensor_msgs/msg/Image",
        header=header("camera"),
        height=4,
        width=6,
        encoding="rgb8",
        is_bigendian=0,
        step=18,
        data=np.full(72, level, dtype=np.uint8),
    )


def path_of(*xs: float) -> Any:
    poses = [make("geometry_msgs/msg/PoseStamped", header=header("map"), pose=pose(x)) for x in xs]
    return make("nav_msgs/msg/Path", header=header("map"), poses=poses)


def particles(*xs: float) -> Any:
    found = [make("nav2_msgs/msg/Particle", pose=pose(x), weight=0.5) for x in xs]
    return make("nav2_msgs/msg/ParticleCloud", header=header("map"), particles=found)


def status(*codes: int) -> Any:
    rows = []
    for number, code in enumerate(codes):
        stamp = make("builtin_interfaces/msg/Time", sec=number, nanosec=0)
        name = make("unique_identifier_msgs/msg/UUID", uuid=np.full(16, number, dtype=np.uint8))
        info = make("action_msgs/msg/GoalInfo", goal_id=name, stamp=stamp)
        rows.append(make("action_msgs/msg/GoalStatus", goal_info=info, status=code))
    return make("action_msgs/msg/GoalStatusArray", status_list=rows)


class Drive:
    """Writes a recording, message by message.

    Args:
        folder: Where to.
    """

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._writer = BagFolder(folder)

    def say(self, time: float, topic: str, message: Any, damaged: bool = False) -> None:
        """Record a message at a time [s]."""
        kind = message.__msgtype__
        definition = _STORE.generate_msgdef(kind, ros_version=2)[0]
        data = bytes(_STORE.serialize_cdr(message, kind))
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
