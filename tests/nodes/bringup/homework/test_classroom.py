"""A class: its seats, its robots and its grades."""

from __future__ import annotations

import csv
import re
import signal
import subprocess
import sys
import threading
from collections.abc import Callable
from pathlib import Path

import pytest
from nav_msgs.msg import Odometry
from rclpy.node import Node

from arjuna_core.errors import ArjunaError
from arjuna_core.files.maps import load_map
from arjuna_core.files.shipped import shipped_file
from bringup.cli import parse, run
from bringup.homework.classroom import Seat, Watcher, hand_out_seats, page, seats
from tests.nodes.bringup.homework.test_grading import handed_in

_FIRST = 70  # of the domains: other tests do not use those that follow


def soon(done: Callable[[], bool], within: float = 60.0, look: float = 0.1) -> bool:
    for _ in range(round(within / look)):
        if done():
            return True
        threading.Event().wait(look)
    return done()


def test_places_differ_and_are_written_down(tmp_path: Path) -> None:
    every = seats(10, tmp_path / "class", 1, 8101)
    hand_out_seats(every, tmp_path / "class")
    for column in ("name", "domain", "port", "folder"):
        assert len({getattr(seat, column) for seat in every}) == 10
    rows = list(csv.DictReader((tmp_path / "class" / "class.csv").open()))
    assert [Seat(r["name"], int(r["domain"]), int(r["port"]), r["folder"]) for r in rows] == every
    assert "export ROS_DOMAIN_ID=4\n" in (tmp_path / "class/student04/setup.sh").read_text()


@pytest.mark.parametrize(
    ("count", "domain", "port", "text"),
    [
        (0, 1, 8101, "0 students from domain 1; valid: 1 to 101"),
        (20, 90, 8101, "20 students from domain 90; valid: 1 to 12"),
        (2, 1, 80, "port 80 is no first port"),
    ],
)
def test_an_unfitting_class_is_refused(count: int, domain: int, port: int, text: str) -> None:
    with pytest.raises(ArjunaError, match=text):
        seats(count, Path("x"), domain, port)


def test_of_ten_robots_none_is_seen_by_another(tmp_path: Path) -> None:
    """Each watcher finds its own robot's node and hears it alone, once all have found theirs."""
    every = seats(10, tmp_path, _FIRST, 8101)
    watchers = [Watcher(seat) for seat in every]
    robots = [Node(f"robot_{one.seat.name}", context=one._context) for one in watchers]
    topics = [robot.create_publisher(Odometry, "ground_truth/odom", 10) for robot in robots]
    try:
        assert soon(lambda: all(one.get_subscription_count() == 1 for one in topics))
        for number, topic in enumerate(topics):
            message = Odometry()
            message.pose.pose.position.x = float(number)
            topic.publish(message)

        def seen() -> bool:
            for one in watchers:
                one.look()
            return all(one.path for one in watchers)

        assert soon(seen)
        for number, (one, robot) in enumerate(zip(watchers, robots, strict=True)):
            assert [x for x, _, _ in one.path] == [float(number)]
            assert sorted(robot.get_node_names()) == ["class_page", f"robot_{one.seat.name}"]
            assert robot.count_publishers("ground_truth/odom") == 1
        shown = page(watchers, load_map(shipped_file("maps/arjuna_room.yaml")))
        assert shown.count("<svg") == 10
        assert "stands at (7.00, 0.00), 0 s" in shown
    finally:
        for one, robot in zip(watchers, robots, strict=True):
            robot.destroy_node()
            one.close()


def test_the_command_runs_a_robot_for_each(tmp_path: Path) -> None:
    words = ["class", "--students", "2", "--first-domain", f"{_FIRST + 10}", "--rtf", "0.2"]
    words += ["--homework", "square", "--out", str(tmp_path / "class")]
    running = subprocess.Popen(
        [sys.executable, "-m", "bringup", *words], stdout=subprocess.PIPE, text=True
    )
    try:
        shown = tmp_path / "class" / "index.html"
        assert soon(lambda: shown.exists() and shown.read_text().count("stands at") == 2)
        assert re.findall(r"domain (\d+)", shown.read_text()) == ["80", "81"]
    finally:
        running.send_signal(signal.SIGINT)
        output, _ = running.communicate(timeout=60)
    assert "6 nodes active" in output
    assert running.returncode == 0
    assert (tmp_path / "class" / "student1" / "square" / "square.py").exists()
    assert (tmp_path / "class" / "map.png").exists()


def test_a_class_is_graded(tmp_path: Path) -> None:
    for kind in ("right", "wrong"):
        handed_in(tmp_path / "class" / kind, "kinematics", kind)
    (tmp_path / "class" / "=evil").mkdir()
    (tmp_path / "class" / "twin").symlink_to(tmp_path / "class" / "right")
    words = ["grade", "--students", str(tmp_path / "class"), "--exercise", "kinematics"]
    words += ["--out", str(tmp_path / "one"), "--jobs", "2"]
    assert run(parse(words)) == 0
    rows = list(csv.DictReader((tmp_path / "one" / "grades.csv").open()))
    assert {row["student"]: row["points"] for row in rows} == {
        "'=evil": "0", "right": "10", "wrong": "2",
    }  # fmt: skip
    assert "has no kinematics.py" in rows[0]["what went wrong"]
    page = (tmp_path / "one" / "right" / "index.html").read_text()
    assert "<td>10</td><td>10</td>" in page

    handed_in(tmp_path / "class" / "wrong", "kinematics", "right")
    outcomes = [tmp_path / "one" / name / "outcome.json" for name in ("=evil", "right")]
    kept = [path.stat().st_mtime_ns for path in outcomes]
    assert run(parse(words)) == 0
    rows = list(csv.DictReader((tmp_path / "one" / "grades.csv").open()))
    assert [row["points"] for row in rows] == ["0", "10", "10"]
    assert [path.stat().st_mtime_ns for path in outcomes] == kept


def test_the_exercise_is_found_by_what_is_handed_in(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    handed_in(tmp_path / "mine", "square", "right")
    out = "--out", str(tmp_path / "out")
    assert run(parse(["grade", str(tmp_path / "mine"), *out])) == 0
    assert "A square of one metre: 10 of 10 points" in capsys.readouterr().out
    assert (tmp_path / "out" / "path.png").stat().st_size > 10_000
    assert run(parse(["grade", str(tmp_path), *out])) == 2
    assert "no known homework; say --exercise" in capsys.readouterr().err
