"""Drives to goals in scenes that are made up, by the command that a campaign runs."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.ndimage import distance_transform_edt, label

from arjuna_core.errors import ArjunaError
from arjuna_core.files.maps import load_map
from arjuna_core.grid import FREE, GridFrame, OccupancyGrid
from arjuna_core.se2 import SE2
from bringup.scenarios import barn
from bringup.scenarios.furnished import make_room
from bringup.scenarios.space import FreeSpace

pytest.importorskip("rclpy", reason="no ROS here")

from bringup.cli import parse, run
from bringup.scenarios.course import Arrival, Course
from bringup.scenarios.drive import room_for
from bringup.scenarios.scenes import SCENES, Scene
from bringup.stack import LOCAL_COSTMAP


def drive(out: Path, *words: str) -> tuple[int, dict[str, Any]]:
    code = run(parse(["goals", "--log-level", "fatal", "--out", str(out), *words]))
    return code, json.loads((out / "result.json").read_text(encoding="utf-8"))


def arrival(succeeded: bool, touches: int) -> Arrival:
    return Arrival(succeeded, 0.0, 0.0, 0.0, 4.0, 3.0, 10.0, touches, 0, math.nan)


def test_only_a_goal_reached_without_a_touch_scores() -> None:
    scores = [arrival(*one).score for one in ((True, 0), (True, 1), (False, 0))]
    assert scores == [0.3, 0.0, 0.0]


@pytest.mark.parametrize("scene", [name for name in SCENES if name])
def test_a_seed_makes_one_scene_through_which_there_is_a_path(scene: str, tmp_path: Path) -> None:
    arguments = parse(["goals", "--scene", scene])
    made = []
    for name, seed in (("a", 1), ("b", 1), ("c", 2)):
        (tmp_path / name).mkdir()
        made.append(SCENES[scene](arguments, tmp_path / name, np.random.default_rng(seed)))
    one, same, other = (each.world.read_bytes() for each in made)
    assert one == same != other
    for each in made:
        space = FreeSpace(each.grid, radius=0.2)
        if each.start is not None:
            length = space.shortest(each.start, each.goals[0])
            assert 0.99 * each.start.distance(each.goals[0]) < length < 20.0  # of cells of 5 cm


@pytest.mark.parametrize("name", ["house", "shop", "hall"])
def test_a_wide_robot_reaches_all_of_a_building(name: str, tmp_path: Path) -> None:
    for seed in range(5):
        room = make_room(tmp_path, np.random.default_rng(seed), name)
        grid = load_map(room.whole)
        gaps = (distance_transform_edt(grid.free()) - 0.5) * grid.frame.resolution
        regions, count = label(gaps >= 0.4)
        sizes = np.sort(np.bincount(regions.ravel())[1:])
        assert sizes[-1] / sizes.sum() > 0.9, (seed, count)


def test_a_mission_drives_to_goals_on_its_own_map(tmp_path: Path) -> None:
    words = "demo --scene hall --goals 1 --explore-time 8 --no-kidnap --log-level fatal"
    code = run(parse([*words.split(), "--out", str(tmp_path)]))
    report = json.loads((tmp_path / "report.json").read_text(encoding="utf-8"))
    assert (code, report["success"], report["exploration_done"]) == (0, True, False)
    assert (report["waypoints_reached"], report["missed"], report["touched"]) == (1, [], [])
    assert 0.01 < report["explored_fraction"] < 1.0
    with pytest.raises(ArjunaError, match="the map has no goals 99 m"):
        FreeSpace(load_map(tmp_path / "map.yaml"), 0.2).draw_beyond(
            SE2(), np.random.default_rng(0), shortest=99.0, tries=3
        )


def test_a_field_s_map_is_occupied_where_its_cylinders_stand(tmp_path: Path) -> None:
    world, grid = barn.make_world(tmp_path, 0, barn.KINDS[0], np.random.default_rng(0))
    text = world.read_text(encoding="ascii")
    poses = [part.split()[:2] for part in text.split("<pose>")[1:]]
    cells = grid.frame.to_cells(np.array(poses, dtype=float))
    assert grid.occupied()[tuple(cells.T)].all()
    assert grid.occupied().sum() == 9 * len(poses)  # of 5 cm in one of 15


def test_goals_are_far_enough_from_each_other_or_refused() -> None:
    frame = GridFrame(0.05, 100, 100, SE2())
    grid = OccupancyGrid(frame, np.full(frame.shape, FREE, np.int8))
    rng, start = np.random.default_rng(0), SE2(1.0, 1.0)
    course = Course(None, FreeSpace(grid, radius=0.2), Scene(Path(), Path(), grid), None)
    course.before = start
    goals = [course.draw(rng, shortest=2.0) for _ in range(20)]
    steps = [a.distance(b) for a, b in zip((start, *goals), goals, strict=False)]
    assert min(steps) >= 2.0
    with pytest.raises(ArjunaError, match="the map has no goals 90 m from each other"):
        course.draw(rng, shortest=90.0, tries=3)
    with pytest.raises(ArjunaError, match="the map has no pose that lies 9 m from walls"):
        FreeSpace(OccupancyGrid(frame, np.full(frame.shape, 100, np.int8)), 0.2, clearance=9.0)


@pytest.mark.parametrize(
    ("outline", "axle", "room"),
    [
        ("[]", 0.0, 0.5),
        ("[[0.2, 0.2], [0.2, -0.2], [-0.2, 0.0]]", 0.0, 0.5),
        ("[[0.9, 0.4], [0.9, -0.4], [-0.3, -0.4], [-0.3, 0.4]]", 0.0, 0.985),
        ("[[0.6, 0.4], [0.6, -0.4], [-0.6, -0.4], [-0.6, 0.4]]", -0.5, 1.170),
    ],
)
def test_a_robot_has_room_to_turn_at_its_goals(outline: str, axle: float, room: float) -> None:
    """A car of 1.25 m stood across a wall at its start, and reached none of three goals."""
    values = {"footprint": outline, "robot_radius": 0.25, "axle": axle}
    assert room_for({LOCAL_COSTMAP.name: values}) == pytest.approx(room, abs=1e-3)


@pytest.mark.parametrize(("wall", "most"), [(True, 1.5), (False, 5.0)])
def test_goals_are_within_sight_of_a_wall_where_there_is_one(wall: bool, most: float) -> None:
    frame = GridFrame(0.05, 100, 100, SE2())
    grid = OccupancyGrid(frame, np.full(frame.shape, FREE, np.int8))
    grid.data[:, 0] = 100 if wall else FREE
    space, rng = FreeSpace(grid, 0.2, 0.5, sight=1.5), np.random.default_rng(0)
    goals = [space.draw(rng).x for _ in range(50)]
    assert 0.5 * most < max(goals) <= most + 0.05


@pytest.mark.ros
@pytest.mark.system
def test_a_failed_drive_keeps_its_evidence_and_a_good_one_nothing(
    tmp_path: Path,
) -> None:
    code, result = drive(tmp_path, "--scene", "door", "--width", "0.3", "--seed", "1")
    assert (code, result["missed"], result["score"]) == (1, 1, 0.0)
    recording, picture = tmp_path / "goal_1.mcap", tmp_path / "goal_1.png"
    assert 10_000 < recording.stat().st_size < 2_000_000
    assert picture.read_bytes().startswith(b"\x89PNG")
    code, result = drive(tmp_path, "--scene", "door", "--seed", "1")
    assert (code, result["missed"], result["touches"]) == (0, 0, 0)
    assert 0.2 < result["score"] < 0.4
    assert [path.name for path in tmp_path.iterdir()] == ["result.json"]


@pytest.mark.ros
@pytest.mark.system
def test_a_field_is_crossed_without_a_map(tmp_path: Path) -> None:
    code, result = drive(tmp_path, "--scene", "field", "--seed", "3")
    assert (code, result["count"], result["touches"]) == (0, 1, 0)
    assert result["path_ratio"] < 1.2


def test_a_world_without_a_map_asks_for_one(tmp_path: Path) -> None:
    arguments = parse(["goals", "--world", str(tmp_path / "hall.sdf")])
    with pytest.raises(
        ArjunaError, match=r"hall\.sdf: no map of it is here; --map FILE, as .*demo"
    ):
        SCENES[None](arguments, tmp_path, np.random.default_rng(0))
