"""Waypoints: the files they come from, and what a tour says."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import pytest

from arjuna_core.errors import InputFileError
from bringup.client.waypoints import Progress, Tour, load_waypoints


def _file(folder: Path, text: str) -> Path:
    path = folder / "tour.yaml"
    path.write_text(text, encoding="utf-8")
    return path


@pytest.mark.parametrize(
    "text",
    [
        "waypoints: [[2.0, 2, 0.5], [1, -1]]",
        "- {x: 2.0, y: 2.0, yaw: 0.5}\n- {x: 1, y: -1}",
        "- [2, 2, 0.5]\n- [1, -1]",
    ],
)
def test_every_form_is_read(tmp_path: Path, text: str) -> None:
    assert load_waypoints(_file(tmp_path, text)) == [(2.0, 2.0, 0.5), (1.0, -1.0, 0.0)]


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ("", "holds no waypoints; valid: 'waypoints: "),
        ("points: [[1, 2]]", "holds no waypoints"),
        ("- [1]", "waypoint 1"),
        ("- [1, 2]\n- [1, .nan]", "waypoint 2"),
        ("- [1, true]", "is no pose"),
        ("- {x: 1, z: 2}", "is no pose"),
        ("- [1, 2", "is no YAML"),
    ],
)
def test_what_is_no_tour_is_refused(tmp_path: Path, text: str, problem: str) -> None:
    with pytest.raises(InputFileError, match=problem):
        load_waypoints(_file(tmp_path, text))


def _at(x: float, y: float, left: float = 0.0) -> Any:
    """Return the feedback of a robot at a position [m] with some distance left [m]."""
    position, upright = SimpleNamespace(x=x, y=y), SimpleNamespace(x=0.0, y=0.0, z=0.0, w=1.0)
    pose = SimpleNamespace(pose=SimpleNamespace(position=position, orientation=upright))
    return SimpleNamespace(distance_remaining=left, current_pose=pose)


class Driven:
    """A robot that reaches all but the waypoints with a negative x."""

    session = SimpleNamespace(pause=lambda duration: None)

    def goto(self, x: float, y: float, yaw: float, timeout: float, progress: Any) -> Any:
        progress(_at(x, y, 1.5))
        return SimpleNamespace(succeeded=x >= 0.0, reason="aborted: no way (308)")


def test_a_tour_skips_what_fails_and_sums_up() -> None:
    lines: list[str] = []
    robot: Any = Driven()
    reached = Tour(robot, lines.append).drive([(1, 1, 0), (-1, 0, 0), (0, 0, 0)], 1.0, 0.1, 0.3)
    assert reached == 2
    text = "\n".join(lines)
    assert "Waypoint 2 / 3 → X: -1.00 Y: 0.00 Yaw: 0.00" in text
    assert "✗ Waypoint 2 FAILED: aborted: no way (308)" in text
    assert text.endswith("Waypoints reached : 2\nWaypoints failed : 1\nTotal waypoints : 3")


def test_progress_is_said_each_half_metre() -> None:
    lines: list[str] = []
    say = Progress(lines.append)
    for left in (0.0, 2.0, 1.8, 1.45, 1.4, 0.9):
        say(SimpleNamespace(distance_remaining=left))
    assert lines == [f"  Distance remaining: {left:.2f}m" for left in (2.0, 1.45, 0.9)]


def test_arrival_is_where_the_robot_was_at_last() -> None:
    progress = Progress(lambda line: None)
    assert progress.arrival == ""
    pose = SimpleNamespace(
        position=SimpleNamespace(x=1.0, y=-2.0), orientation=SimpleNamespace(x=0, y=0, z=1, w=1)
    )
    for at in (None, SimpleNamespace(pose=pose)):
        progress(SimpleNamespace(distance_remaining=0.0, current_pose=at))
    assert progress.arrival == " - arrived at (1.00, -2.00), yaw 1.57"


@dataclass(frozen=True)
class Ended:
    """The end of a goal, as `GoalEnd`."""

    succeeded: bool
    reason: str = ""


@pytest.mark.parametrize(("tolerance", "reached"), [(0.3, False), (0.6, True)])
def test_a_goal_that_was_moved_is_reached_within_the_tolerance(
    tolerance: float, reached: bool
) -> None:
    progress = Progress(lambda line: None)
    progress(_at(1.0, 0.5))
    end: Any = progress.judged(cast(Any, Ended(True)), 1.0, 1.0, tolerance)
    assert end.succeeded is reached
    said = "asked for (1.00, 1.00), reached (1.00, 0.50), 0.50 m off: "
    why = "as the planner's tolerance or the goal checker's" if reached else "the planner took a"
    assert end.reason.startswith(said + why)
    assert ("'--tolerance 0.51' takes that" in end.reason) is not reached


def test_a_goal_that_was_reached_needs_no_words() -> None:
    progress = Progress(lambda line: None)
    progress(_at(1.0, 0.95))
    end: Any = progress.judged(cast(Any, Ended(True)), 1.0, 1.0, 0.3)
    assert (end.succeeded, end.reason) == (True, "")


def test_a_goal_that_failed_stays_so() -> None:
    progress = Progress(lambda line: None)
    progress(_at(5.0, 5.0))
    end: Any = progress.judged(cast(Any, Ended(False, "aborted")), 1.0, 1.0, 0.3)
    assert end.reason == "aborted"
