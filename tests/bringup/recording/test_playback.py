"""Recordings: topics chosen, recorded, played and summed up."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

import pytest

from arjuna_core.bags.reader import Bag
from arjuna_core.bags.topic import TopicInfo
from arjuna_core.bags.writer import BagFolder
from bringup.recording import summary
from bringup.recording.listener import LossCounter
from bringup.recording.playback import Playback, PlayOptions
from bringup.recording.selection import PlayFilter, add_options, selection_of
from tests.core.bags.recordings import write_numbers

pytestmark = pytest.mark.ros
TOPIC = TopicInfo("/number", "std_msgs/msg/Int32", "int32 data\n")
SECOND = 1_000_000_000


@pytest.fixture
def bag(tmp_path: Path) -> Bag:
    writer = BagFolder(tmp_path / "bag")
    for number in range(4):
        stamp = (100 + number) * SECOND
        writer.write(TOPIC, stamp, bytes([0, 1, 0, 0, number]), stamp)
    writer.close()
    return Bag(tmp_path / "bag")


def playback(bag: Bag, **options: Any) -> Playback:
    result = Playback([bag], PlayOptions(**options))
    result.advance(0.0)
    return result


def due(playback: Playback, wall: float) -> list[int]:
    playback.advance(wall)
    found = []
    while (message := playback.due()) is not None:
        found.append(message.data[4])
    return found


def test_messages_are_due_at_their_time(bag: Bag) -> None:
    played = playback(bag)
    assert [due(played, wall) for wall in (0.0, 0.9, 1.1, 3.5)] == [[0], [], [1], [2, 3]]
    assert played.finished


def test_a_rate_makes_time_run_faster(bag: Bag) -> None:
    played = playback(bag, rate=2.0)
    assert [due(played, wall) for wall in (0.0, 0.51)] == [[0], [1]]
    assert played.wait() == pytest.approx(0.49)


def test_a_pause_takes_no_recorded_time(bag: Bag) -> None:
    played = playback(bag)
    assert due(played, 0.5) == [0]
    played.paused = True
    assert due(played, 10.0) == []
    played.paused = False
    assert [due(played, wall) for wall in (10.4, 10.6)] == [[], [1]]


def test_it_begins_at_its_offset(bag: Bag) -> None:
    assert due(playback(bag, offset=1.5), 0.6) == [2]
    assert playback(bag, offset=9.0).finished


def test_a_loop_begins_again(bag: Bag) -> None:
    played = playback(bag, loop=True)
    assert due(played, 3.1) == [0, 1, 2, 3]
    assert not played.finished
    assert due(played, 4.2) == [0, 1]
    assert played.time == pytest.approx(101.1 * SECOND)


def test_a_recording_of_one_moment_is_due_once_a_turn(tmp_path: Path) -> None:
    writer = BagFolder(tmp_path / "one")
    writer.write(TOPIC, SECOND, bytes([0, 1, 0, 0, 7]), SECOND)
    writer.close()
    played = playback(Bag(tmp_path / "one"), loop=True)
    assert due(played, 0.1) == [7]
    assert due(played, 0.2) == [7]


def test_each_turn_waits_and_the_first_one_longer(bag: Bag) -> None:
    played = playback(bag, loop=True, delay=1.0, settling=0.5)
    assert [due(played, wall) for wall in (1.4, 1.6, 4.6)] == [[], [0], [1, 2, 3]]
    assert [due(played, wall) for wall in (5.5, 5.7)] == [[], [0]]


def test_it_is_stepped_and_sent_back_while_it_stands(bag: Bag) -> None:
    played = playback(bag, until=102 * SECOND)
    assert played.play_next() is None
    played.paused = True
    stepped = [played.play_next() for _ in range(4)]
    assert [each and each.data[4] for each in stepped] == [0, 1, 2, None]
    assert (played.time, played.finished) == (102 * SECOND, True)
    played.seek(0)
    assert (played.time, played.finished) == (100 * SECOND, False)


@pytest.mark.parametrize(
    ("numbers", "publishers", "lost"),
    [
        ([1, 2, 3], 1, 0),
        ([7, 8, 9], 1, 0),  # joined late
        ([1, 2, 5, 6], 1, 2),
        ([1, 50, 2, 51, 3], 2, 0),  # two publishers
        ([1, 50, 2, 53], 2, 2),
        ([8, 9, 1, 2], 1, 0),  # the publisher began again
        ([8, 9, 1, 2, 4], 1, 1),
    ],
)
def test_gaps_are_counted(numbers: list[int], publishers: int, lost: int) -> None:
    counter = LossCounter()
    for number in numbers:
        counter.take(number, publishers)
    assert counter.lost == lost


def chosen(*words: str, hidden: bool = False) -> PlayFilter:
    parser = argparse.ArgumentParser()
    add_options(parser)
    return selection_of(parser.parse_args(words), hidden)


@pytest.mark.parametrize(
    ("words", "topic", "taken"),
    [
        ([], "/scan", True),
        ([], "/x/_hidden", False),
        ([], "/navigate_to_pose/_action/status", True),
        (["--topics", "/scan", "odom"], "/odom", True),
        (["--topics", "/scan"], "/scan_filtered", False),
        (["--topics", "/camera/.*"], "/camera/image_raw", True),
        (["--topics", "/x/_hidden"], "/x/_hidden", True),
        (["--exclude", "/camera/.*"], "/camera/image_raw", False),
        (["--topics", "/camera/.*", "--exclude", ".*/image_raw"], "/camera/image_raw", False),
        (["-e", "/camera/.*", "-x", ".*/image_raw"], "/camera/camera_info", True),
    ],
)
def test_topics_are_chosen(words: list[str], topic: str, taken: bool) -> None:
    assert chosen(*words).takes(topic) == taken


def test_a_bad_expression_is_refused(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit, match="2"):
        chosen("--topics", "/a(")
    assert "is no regular expression" in capsys.readouterr().err


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
