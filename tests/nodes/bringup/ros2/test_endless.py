"""Commands that run until they are interrupted, each a process of its own."""

from __future__ import annotations

import re
import signal

import pytest

from tests.helpers.processes import Lines
from tests.nodes.bringup.ros2.conftest import ENVIRONMENT

pytestmark = [pytest.mark.ros, pytest.mark.usefixtures("stand_in")]

LINES = {
    "run tf2_ros static_transform_publisher 1 0 0 0 0 0 a b --ros-args -r __node:=fixed": (
        r"translation: \('1.000000', '0.000000', '0.000000'\)"
    ),
    "topic hz /chatter --window 20": r"average rate: \d+\.\d{3}",
    "topic bw /chatter": r"\d+ B/s from \d+ messages",
    "topic delay /point": r"average delay: 0\.\d{3}",
    "topic echo /chatter": r"data: hello \d+",
    "topic pub -r 20 /cmd_vel geometry_msgs/msg/Twist": (
        r"publishing #3: geometry_msgs.msg.Twist\(.*"
    ),
}


@pytest.mark.parametrize("line", LINES)
def test_runs_until_interrupted(line: str, monkeypatch: pytest.MonkeyPatch) -> None:
    for name, value in ENVIRONMENT.items():
        monkeypatch.setenv(name, value)
    with Lines("-m", "bringup.ros2.main", *line.split()) as process:
        (first, *_) = process.wait_for(LINES[line].split("\\", maxsplit=1)[0] or "/s from")
        assert re.fullmatch(LINES[line], first)
        process.process.send_signal(signal.SIGINT)
        of_a_node = line.startswith("run ")  # `launch` calls any other end of one a death
        assert process.read_to_end() == (0 if of_a_node else signal.SIGINT)
        assert not [text for text in process.seen if "Traceback" in text]
