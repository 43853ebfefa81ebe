"""A drive played back: SLAM and AMCL come to the same result as they did live."""

from __future__ import annotations

from contextlib import closing
from pathlib import Path
from typing import Any

import pytest
from geometry_msgs.msg import Twist
from rosgraph_msgs.msg import Clock

from arjuna_core.bags.decoder import Decoder
from arjuna_core.bags.file_writer import McapWriter
from arjuna_core.bags.reader import Bag
from arjuna_core.bags.topic import BagMessage
from arjuna_core.ros import qos
from arjuna_core.ros.convert import time_msg
from bringup.lockstep import LockStep
from bringup.parameters.files import merged, shipped_parameters
from bringup.recording.player import Player
from bringup.recording.recorder import TOPICS, Recorder
from bringup.stack import LOCALIZATION_GROUP, SLAM_GROUP, Group
from tests.helpers.processes import wait_until
from tests.helpers.robots import ROOM, Stack

pytestmark = [pytest.mark.ros, pytest.mark.system]
RESULTS = ("/map", "/amcl_pose")
SECONDS = 8.0
DECODER = Decoder()


def listen(robot: LockStep, path: Path, *topics: str) -> Recorder:
    recorder = Recorder(
        robot.process.make_node("recorder", spun=False), McapWriter(path), clock=lambda: robot.now
    )
    for topic in topics:
        type_name, offer = TOPICS[topic]
        recorder.listener.listen(topic, type_name, (offer,))
    return recorder


def drive(robot: LockStep, path: Path) -> Bag:
    """Drive a curve, recorded."""
    command = robot.client.create_publisher(Twist, "/cmd_vel", qos.DEFAULT)
    with closing(listen(robot, path, "/tf", "/tf_static", "/scan", "/odom", *RESULTS)) as recorder:

        def tick() -> None:
            recorder.poll()
            message = Twist()
            message.linear.x, message.angular.z = 0.3, 0.4
            command.publish(message)

        robot.on_tick = tick
        robot.run(SECONDS)
    return Bag(path)


def of_result(message: BagMessage) -> bool:
    """Return whether SLAM or AMCL said it, as its frame gives away in /tf."""
    return message.topic.name in RESULTS or b"map\0" in message.data[:32]


def said(bag: Bag, topic: str) -> list[str]:
    """Return what SLAM or AMCL said on a topic; what pads a message's bytes may be anything."""
    found = filter(of_result, bag.messages(lambda name: name == topic))
    return [repr(DECODER.decode(each.topic, each.data)) for each in found]


def cells(bag: Bag) -> list[bytes]:
    """Return the cells of each map."""
    found = bag.messages(lambda name: name == "/map")
    return [DECODER.decode(each.topic, each.data).data.tobytes() for each in found]


def play(bag: Bag, group: Group, parameters: dict[str, dict[str, Any]], path: Path) -> Bag:
    """Play what the robot said to a group of nodes alone, and record what these say."""
    values = merged(shipped_parameters(), parameters)
    with closing(LockStep(values, transport="dds")) as robot:  # the player is rclpy's
        recorder = listen(robot, path, "/tf", *RESULTS)
        robot.start(group)
        topics = [each for name, each in bag.topics.items() if name not in RESULTS]
        player = Player(robot.process.make_node("player", spun=False), topics)
        clock = robot.client.create_publisher(Clock, "/clock", qos.LATEST)
        with closing(recorder):
            _play_static(bag, player, robot)
            last = -1
            for message in bag.messages():
                if message.time != last:
                    robot.process.drain()
                    recorder.poll()
                    clock.publish(Clock(clock=time_msg(message.time / 1e9)))
                    last = message.time
                if not of_result(message):
                    player.publish(message)
            robot.process.drain()
    return Bag(path)


def _play_static(bag: Bag, player: Player, robot: LockStep) -> None:
    """Play the fixed transforms, and wait: a latched message comes at no fixed time."""
    for message in bag.messages(lambda name: name == "/tf_static"):
        player.publish(message)
    wait_until(
        lambda: robot.process.transforms.try_lookup("base_footprint", "lidar_link") is not None,
        lambda: robot.process.spin_once(0.02),
        "/tf_static",
    )


@pytest.mark.parametrize(
    ("group", "parameters"), [(SLAM_GROUP, {}), (LOCALIZATION_GROUP, ROOM)], ids=["slam", "amcl"]
)
def test_a_drive_played_back_gives_the_same_result(
    stack: Stack,
    tmp_path: Path,
    group: Group,
    parameters: dict[str, dict[str, Any]],
) -> None:
    live = drive(stack(group, parameters=parameters), tmp_path / "live.mcap")
    played = play(live, group, parameters, tmp_path / "played.mcap")
    for topic in ("/tf", "/amcl_pose"):
        first, second = said(live, topic), said(played, topic)
        # of the last scan one run may have drawn its conclusion, the other not yet
        both = min(len(first), len(second))
        assert both >= len(first) - 1
        assert second[:both] == first[:both]
    assert len(said(played, "/tf")) > 50
    maps = list(zip(cells(live), cells(played), strict=False))
    # a map that falls due with a scan may be published before or after that is entered
    assert sum(one == other for one, other in maps) >= len(maps) / 2
