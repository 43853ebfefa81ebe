"""Clients of a robot: waypoints, keys, avoidance."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from arjuna_core.errors import InputFileError
from arjuna_core.scan import Scan
from arjuna_core.se2 import SE2
from arjuna_core.twist import STILL, Velocity
from bringup.client.avoidance import Decision, decide
from bringup.client.keys import Driving
from bringup.client.waypoints import Progress, Tour, load_waypoints
from tests.helpers.files import written


@pytest.mark.parametrize(
    "text",
    [
        "waypoints: [[2.0, 2, 0.5], [1, -1]]",
        "- {x: 2.0, y: 2.0, yaw: 0.5}\n- {x: 1, y: -1}",
        "- [2, 2, 0.5]\n- [1, -1]",
    ],
)
def test_every_form_is_read(tmp_path: Path, text: str) -> None:
    assert load_waypoints(written(tmp_path, text)) == [(2.0, 2.0, 0.5), (1.0, -1.0, 0.0)]


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
        load_waypoints(written(tmp_path, text))


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
def test_a_moved_goal_is_reached_within_the_tolerance(tolerance: float, reached: bool) -> None:
    progress = Progress(lambda line: None)
    progress(_at(1.0, 0.5))
    end: Any = progress.judged(cast(Any, Ended(True)), 1.0, 1.0, tolerance)
    assert end.succeeded is reached
    said = "asked for (1.00, 1.00), reached (1.00, 0.50), 0.50 m off: "
    why = "as the planner's tolerance or the goal checker's" if reached else "the planner took a"
    assert end.reason.startswith(said + why)
    assert ("'--tolerance 0.51' takes that" in end.reason) is not reached


@pytest.mark.parametrize(
    ("end", "at"), [(Ended(True), (1.0, 0.95)), (Ended(False, "aborted"), (5.0, 5.0))]
)
def test_a_goal_that_was_reached_or_failed_stays_so(end: Ended, at: tuple[float, float]) -> None:
    progress = Progress(lambda line: None)
    progress(_at(*at))
    assert progress.judged(cast(Any, end), 1.0, 1.0, 0.3) == cast(Any, end)


@pytest.mark.parametrize(
    ("key", "velocity"),
    [("w", (0.3, 0.0)), ("s", (-0.3, 0.0)), ("a", (0.0, 0.5)), ("d", (0.0, -0.5)), ("x", (0, 0))],
)
def test_wasd_drives_as_the_first_guide_says(key: str, velocity: tuple[float, float]) -> None:
    assert Driving().pressed(key).velocity == Velocity(velocity[0], yaw_rate=velocity[1])


@pytest.mark.parametrize(
    ("keys", "forward", "aside"),
    [
        *[("uU", 1, (1, 1)), ("iI", 1, (0, 0)), ("oO", 1, (-1, -1)), ("jJ", 0, (1, 1))],
        *[("kK", 0, (0, 0)), ("lL", 0, (-1, -1)), ("mM", -1, (-1, 1)), (",<", -1, (0, 0))],
        (".>", -1, (1, -1)),
    ],
)
def test_the_twist_layout_is_teleop_twist_keyboards_with_shift_sideways(
    keys: str, forward: int, aside: tuple[int, int]
) -> None:
    driving = Driving("twist", 0.5, 1.0)
    turned = driving.pressed(keys[0]).velocity
    assert turned == Velocity(0.5 * forward, yaw_rate=1.0 * aside[0])
    shifted = driving.pressed("u").pressed(keys[1]).velocity
    assert shifted == Velocity(0.5 * forward, y=0.5 * aside[1])


@pytest.mark.parametrize(
    ("key", "speed", "turn"),
    [
        *[("q", 0.55, 1.1), ("z", 0.45, 0.9), ("w", 0.55, 1.0), ("x", 0.45, 1.0)],
        *[("e", 0.5, 1.1), ("c", 0.5, 0.9)],
    ],
)
def test_speed_keys_change_what_the_robot_does_now(key: str, speed: float, turn: float) -> None:
    forward = Driving("twist", 0.5, 1.0).pressed("u").pressed(key)
    assert forward.velocity.x == pytest.approx(speed)
    assert forward.velocity.yaw_rate == pytest.approx(turn)


@pytest.mark.parametrize("layout", ["wasd", "twist"])
def test_an_unknown_key_stops(layout: str) -> None:
    assert Driving(layout, shares=Velocity(1.0, yaw_rate=1.0)).pressed("7").velocity == STILL


@pytest.mark.parametrize(("layout", "key"), [("wasd", "q"), ("wasd", "\x03"), ("twist", "\x03")])
def test_quitting_asks_for_a_stop(layout: str, key: str) -> None:
    end = Driving(layout, shares=Velocity(1.0)).pressed(key)
    assert end.done
    assert end.velocity == STILL


def scan(near: dict[int, float], start_deg: int = -180, sensor: SE2 | None = None) -> Scan:
    """Return a scan of one beam a degree, 5 m but where something is near, by bearing [deg]."""
    ranges = np.full(360, 5.0)
    for bearing, distance in near.items():
        ranges[(bearing - start_deg) % 360] = distance
    step = math.radians(1.0)
    return Scan(
        ranges, math.radians(start_deg), step, 0.1, 12.0, T_base_sensor=sensor or SE2(0, 0, 0)
    )


def choose(seen: Scan) -> Decision:
    return decide(seen, distance=0.7, speed=0.3, turn=0.5)


@pytest.mark.parametrize("start_deg", [-180, 0])
@pytest.mark.parametrize(
    ("near", "word", "v", "w"),
    [
        ({}, "FORWARD", 0.3, 0.0),
        ({0: 0.71}, "FORWARD", 0.3, 0.0),
        ({20: 0.2, -20: 0.2, 180: 0.2}, "FORWARD", 0.3, 0.0),
        ({14: 0.5}, "TURN LEFT", 0.0, 0.5),
        ({0: 0.5, 60: 1.0}, "TURN RIGHT", 0.0, -0.5),
        ({-3: 0.5, -60: 1.0}, "TURN LEFT", 0.0, 0.5),
    ],
)
def test_it_turns_to_the_side_with_more_room(
    near: dict[int, float], word: str, v: float, w: float, start_deg: int
) -> None:
    decision = choose(scan(near, start_deg))
    assert (decision.word, decision.v, decision.w) == (word, v, w)


def test_what_is_no_range_is_passed_over() -> None:
    decision = choose(scan({0: math.nan, 1: math.inf, 2: 0.005, 3: 0.4}))
    assert decision.front == 0.4


def test_nothing_seen_is_clear() -> None:
    ahead = dict.fromkeys(range(-180, 180), math.inf)
    assert choose(scan(ahead)) == Decision("FORWARD", 0.3, 0.0, 10.0, 10.0, 10.0)


def test_a_lidar_that_looks_back_is_turned() -> None:
    assert choose(scan({180: 0.5}, sensor=SE2(0.0, 0.0, math.pi))).front == 0.5


def test_the_line_reads_as_in_the_guide() -> None:
    line = str(Decision("TURN RIGHT", 0.0, -0.5, 0.55, 1.2, 3.4))
    assert line == "[TURN RIGHT] Front: 0.55m Left: 1.20m Right: 3.40m"
    assert str(Decision("FORWARD", 0.3, 0.0, 3.45, 4.2, 3.8)).startswith("[FORWARD ] Front: 3.45m")
