"""Claims: `info` prints what `ros2 bag info` prints, and what was lost."""

from __future__ import annotations

from pathlib import Path

from arjuna_core.bags.reader import Bag
from bringup.recording import summary
from tests.core.bags.recordings import write_numbers


def test_lost_messages_are_listed(tmp_path: Path) -> None:
    write_numbers(tmp_path / "bag").close({"/number": 7})
    bag = Bag(tmp_path / "bag")
    assert list(summary.missing(bag)) == [
        "/number: 7 messages were published and never reached the recorder"
    ]


def test_the_summary_is_that_of_ros2_bag_info(tmp_path: Path) -> None:
    write_numbers(tmp_path / "bag").close()
    lines = list(summary.lines(Bag(tmp_path / "bag")))
    assert lines[0] == "Files:             bag_0.mcap"
    assert "Duration:          0.099000000s" in lines
    assert "ROS Distro:        jazzy" in lines
    assert lines[-4] == (
        "Topic information: Topic: /number | Type: std_msgs/msg/Int32 | Count: 90 | "
        "Serialization Format: cdr"
    )
    assert lines[-2:] == ["Service:           0", "Service information:"]
