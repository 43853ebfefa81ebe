"""Actors and their trajectories."""

from __future__ import annotations

import math
import re
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from arjuna_core.errors import ConfigError
from arjuna_core.se2 import SE2
from arjuna_sim.files.world_file import load_world
from arjuna_sim.model.geometry.shapes import Kind
from arjuna_sim.model.notes import NoteKind
from arjuna_sim.model.world import PERSON, Trajectory

SQUARE = np.array([[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [0.0, 1.0]])
ACTOR = """<sdf version="1.7"><world name="w"><actor name="walker">{pose}
<skin><filename>walk.dae</filename></skin>
<script>{script}</script></actor></world></sdf>"""
WALK = """<loop>{loop}</loop><delay_start>1.0</delay_start><trajectory id="0" type="walk">
<waypoint><time>0</time><pose>1 2 1.1 0 0 0</pose></waypoint>
<waypoint><time>4</time><pose>3 2 1.1 0 0 3.0</pose></waypoint>
<waypoint><time>6</time><pose>3 3 1.1 0 0 -3.0</pose></waypoint></trajectory>"""


def _read(folder: Path, script: str, pose: str = "") -> Path:
    path = folder / "actor.world"
    path.write_text(ACTOR.format(script=script, pose=pose))
    return path


def _trajectory(folder: Path, loop: str = "true") -> Trajectory:
    (actor,) = load_world(_read(folder, WALK.format(loop=loop))).actors
    assert actor.trajectory is not None
    return actor.trajectory


def test_world_file_gives_waypoints_and_a_cylinder_for_the_person(tmp_path: Path) -> None:
    world = load_world(_read(tmp_path, WALK.format(loop="true")))
    (actor,) = world.actors
    assert (actor.name, actor.start) == ("walker", SE2(1.0, 2.0, 0.0))
    (part,) = actor.parts
    assert (part.shape.kind, part.shape.size) == (Kind.CYLINDER, PERSON)
    assert part.pose.position[2] == pytest.approx(PERSON[1] / 2)  # it stands on the ground
    assert any("walker" in note.text and "cylinder" in note.text for note in world.notes)


def test_actor_waits_walks_straight_and_turns_by_the_lesser_angle(tmp_path: Path) -> None:
    walk = _trajectory(tmp_path)
    assert walk.pose(0.5) == SE2(1.0, 2.0, 0.0)
    half = walk.pose(3.0)
    assert (half.x, half.y, half.theta) == pytest.approx((2.0, 2.0, 1.5))
    across = walk.pose(6.0)  # from 3.0 to -3.0 rad by way of pi
    assert abs(across.theta) == pytest.approx(math.pi, abs=1e-9)
    assert walk.velocity(3.0) == pytest.approx((0.5, 0.0, 0.75), abs=1e-6)


def test_loop_starts_again_and_its_absence_stays_at_the_end(tmp_path: Path) -> None:
    assert _trajectory(tmp_path).pose(7.0 + 3.0).x == pytest.approx(2.0)
    assert _trajectory(tmp_path, "false").pose(100.0) == SE2(3.0, 3.0, -3.0)


def test_actor_without_a_script_stands_at_its_pose(tmp_path: Path) -> None:
    (actor,) = load_world(_read(tmp_path, "", "<pose>1 -1 0 0 0 0.5</pose>")).actors
    assert actor.trajectory is None
    assert (actor.start.x, actor.start.y, actor.start.theta) == pytest.approx((1.0, -1.0, 0.5))


@pytest.mark.parametrize(
    ("old", "new", "problem"),
    [
        ("<time>4</time>", "", "lacks <time>"),
        ("<time>4</time>", "<time>-1</time>", "<time> is -1.0; valid: 0 or more"),
        ("<time>4</time>", "<time>nan</time>", "must be finite"),
        ("3 2 1.1 0 0 3.0", "3 2", "has 2 numbers"),
        ("1.0</delay_start>", "-1</delay_start>", "<delay_start> is -1.0"),
    ],
)
def test_broken_actors_are_left_out(tmp_path: Path, old: str, new: str, problem: str) -> None:
    script = WALK.format(loop="true").replace(old, new, 1)
    world = load_world(_read(tmp_path, script))
    assert world.actors == ()
    (note,) = (note.text for note in world.notes if note.kind is NoteKind.BROKEN)
    assert re.match(f"actor 'walker' is left out: .*{problem}", note)


@pytest.mark.parametrize("speed", [0.3, 1.5])
def test_path_is_followed_at_its_speed_facing_ahead(speed: float) -> None:
    walk = Trajectory.along(SQUARE, speed)
    times = np.arange(0.0, 12.0 / speed, 0.05)
    poses = [walk.pose(float(t)).array() for t in times]
    steps = np.hypot(*np.diff(poses, axis=0)[:, :2].T) / 0.05
    assert steps.max() == pytest.approx(speed, rel=1e-6)
    assert np.median(steps) == pytest.approx(speed, rel=1e-6)
    back = walk.pose(5.5 / speed)
    assert (back.x, back.y, back.theta) == pytest.approx((0.0, 0.5, -math.pi / 2))
    assert walk.pose(6.0 / speed).distance(SE2(0.0, 0.0)) < 1e-9


@pytest.mark.parametrize(
    ("points", "speed", "problem"),
    [
        (SQUARE[:1], 1.0, "two or more finite points, got 1"),
        (SQUARE * math.nan, 1.0, "finite points"),
        (SQUARE, 0.0, "speed is 0.0"),
        (SQUARE, math.inf, "speed is inf"),
    ],
)
def test_bad_paths_are_refused(points: NDArray[np.float64], speed: float, problem: str) -> None:
    with pytest.raises(ConfigError, match=problem):
        Trajectory.along(points, speed)
