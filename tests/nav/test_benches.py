"""The judgements of the navigation benchmarks, on worlds and maps that are made up."""

from __future__ import annotations

import json
import lzma
import math
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from arjuna_core.errors import InputFileError
from arjuna_core.files.maps import load_map
from arjuna_core.grid import OCCUPIED
from arjuna_core.se2 import SE2
from bringup.scenarios.barn import CELL, START, make_worlds
from bringup.scenarios.course import Course
from bringup.scenarios.furnished import make_room
from bringup.scenarios.space import FreeSpace
from tests.bench import barn, goals, planner, pressed, run
from tests.helpers.nav.barn import load_worlds
from tests.helpers.nav.journal import draw, steadiness
from tests.helpers.nav.navfn_maps import COURSES
from tests.nav.worlds import block, grid_of

_CYLINDER = (
    "<model name='c{i}'><static>1</static><pose>{x} {y} 0.5 0 0 0</pose><link name='l'>"
    "<collision name='c'><geometry><cylinder><radius>0.075</radius><length>1</length></cylinder>"
    "</geometry></collision></link></model>"
)
_MAP = "type octile\nheight 3\nwidth 5\nmap\n.....\n.@@@.\n....T\n"


def barn_world(folder: Path, cylinders: list[tuple[float, float]]) -> Path:
    """Write one world like BARN's, packed, with the straight path as its path."""
    models = "".join(_CYLINDER.format(i=i, x=x, y=y) for i, (x, y) in enumerate(cylinders))
    text = "<sdf version='1.6'><world name='w'><include><uri>model://ground_plane</uri></include>"
    (folder / "worlds").mkdir(parents=True)
    packed = lzma.compress(f"{text}{models}</world></sdf>".encode())
    (folder / "worlds" / "world_7.world.xz").write_bytes(packed)
    (folder / "path_files").mkdir()
    cells = np.array([[16, row] for row in range(30)])
    np.save(folder / "path_files" / "path_7.npy", cells)
    return folder


def test_the_shortest_path_is_pulled_tight_round_what_is_in_it() -> None:
    grid = grid_of(10.0, 6.0, (4.0, 0.0, 0.5, 4.0))
    space = FreeSpace(grid, radius=0.2, clearance=0.4)
    straight = space.shortest(SE2(1.0, 1.0), SE2(3.0, 5.0))
    assert straight == pytest.approx(math.hypot(2.0, 4.0), rel=0.02)
    x0, x1, top = 4.0 - 0.2, 4.5 + 0.2, 4.0 + 0.2
    round_it = 2 * math.hypot(x0 - 1.0, top - 1.0) + x1 - x0
    assert space.shortest(SE2(1.0, 1.0), SE2(7.5, 1.0)) == pytest.approx(round_it, rel=0.02)
    block(grid, 4.0, 4.0, 0.5, 2.0)
    closed = FreeSpace(grid, radius=0.2, clearance=0.4)
    assert math.isnan(closed.shortest(SE2(1.0, 1.0), SE2(7.5, 1.0)))


def test_goals_are_drawn_where_there_is_room() -> None:
    space = FreeSpace(grid_of(6.0, 4.0, (2.0, 1.0, 1.0, 3.0)), radius=0.2, clearance=0.5)
    rng = np.random.default_rng(0)
    for _ in range(50):
        goal = space.draw(rng)
        x = max(2.0 - goal.x, goal.x - 3.0, 0.0)
        assert math.hypot(x, max(1.0 - goal.y, 0.0)) >= 0.5 - 0.05


def test_a_score_is_half_up_to_twice_the_best_time_and_a_failure_none(tmp_path: Path) -> None:
    world = load_worlds(barn_world(tmp_path, []), tmp_path)[0]
    assert world.name == "world_7"
    assert world.optimal == pytest.approx(10.0, abs=0.1)
    best = world.optimal / 2.0
    assert world.score(best) == world.score(2.0 * best) == 0.5
    assert world.score(4.0 * best) == pytest.approx(0.25)
    assert world.score(100.0) == 0.125
    assert world.score(None) == 0.0


def test_made_worlds_have_cylinders_and_a_path_between_them(tmp_path: Path) -> None:
    folders = [tmp_path / name for name in ("one", "same", "other")]
    for folder, seed in zip(folders, (3, 3, 4), strict=True):
        folder.mkdir()
        make_worlds(folder, 3, np.random.default_rng(seed))
    texts = [[world.world.read_text() for world in load_worlds(f, f)] for f in folders]
    assert texts[0] == texts[1] != texts[2]
    points = [
        [float(v) for v in p.split()[:2]] for p in re.findall("<pose>(.*?)</pose>", texts[0][2])
    ]
    cells = np.load(folders[0] / "path_2.npy")
    path = cells * CELL + (-4.575, 5.075)
    gaps = np.hypot(*(path[:, None] - np.array(points)[None]).transpose(2, 0, 1))
    assert 0.05 < (np.array(points)[:, 1] > 5.1).sum() / 900 < 0.4
    assert gaps.min() > 0.35  # a Jackal with room beside it
    assert np.abs(np.diff(cells, axis=0)).max() <= 1
    assert all(9.9 < world.optimal < 20.0 for world in load_worlds(folders[0], tmp_path))


def test_a_folder_without_worlds_or_paths_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputFileError, match=r"holds no world; valid: world_\*\.world or"):
        load_worlds(tmp_path, tmp_path)
    folder = barn_world(tmp_path, [])
    (folder / "path_files" / "path_7.npy").unlink()
    with pytest.raises(InputFileError, match=r"has no path_7\.npy"):
        load_worlds(folder, tmp_path)


def test_scenarios_of_movingai_are_solved(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(planner, "PLANNERS", {"NavFn": planner.PLANNERS["NavFn"]})
    (tmp_path / "u.map").write_text(_MAP, encoding="ascii")
    scenario = "version 1\n0\tu.map\t5\t3\t0\t0\t3\t2\t5.0\n"
    (tmp_path / "u.map.scen").write_text(scenario, encoding="ascii")
    assert planner.read_map(tmp_path / "u.map").sum() == 11
    result = run(
        planner, "--sizes", "--arrays", "0", "--queries", "0", "--scenarios", str(tmp_path)
    )
    for found in result.values():
        assert (found["solved"], found["scenarios"]) == (1, 1)
        assert 0.9 < found["octile_ratio"] < 1.05


def test_navfn_is_timed_beside_its_arrays_in_c(monkeypatch: pytest.MonkeyPatch) -> None:
    courses = {name: COURSES[name] for name in ("rooms 500, far", "maze 500, 1.2 m")}
    monkeypatch.setattr(planner, "COURSES", courses)
    found = run(planner, "--sizes", "--arrays", "1").get("arrays", {})
    if not found:
        pytest.skip("no C compiler here")
    assert list(found) == list(courses)
    for row in found.values():
        assert row["m"] == pytest.approx(row["arrays_m"], rel=0.02)


def test_one_seed_makes_one_furnished_room_of_which_the_lidar_sees_a_part(tmp_path: Path) -> None:
    rooms = []
    for name in ("a", "b"):
        folder = tmp_path / name
        folder.mkdir()
        rooms.append(make_room(folder, np.random.default_rng(3)))
    assert rooms[0].world.read_bytes() == rooms[1].world.read_bytes()
    seen = load_map(rooms[0].seen).data == OCCUPIED
    whole = load_map(rooms[0].whole).data == OCCUPIED
    assert not (seen & ~whole).any()
    assert whole.sum() > 1.3 * seen.sum()


def test_a_furnished_rooms_map_lies_where_the_room_does(tmp_path: Path) -> None:
    grid = load_map(make_room(tmp_path, np.random.default_rng(3)).seen)
    walls = np.flatnonzero((grid.data == OCCUPIED).mean(axis=0) > 0.5)
    x = grid.frame.to_points(np.column_stack((walls, walls)))[:, 0]
    np.testing.assert_allclose(x, (-5.025, -4.975, 4.975, 5.025))


@pytest.mark.ros
@pytest.mark.system
def test_a_jackal_crosses_a_world(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("rclpy", reason="no ROS here")
    free = barn_world(tmp_path / "free", [(-2.0, 6.0)])
    result = run(barn, "--worlds", str(free))
    assert (result["success"], result["touches"], result["runs"]) == (1.0, 0, 1)
    assert result["score"] > 0.4
    monkeypatch.setattr(barn, "TIME_LIMIT", 5.0)  # of 100
    angles = np.linspace(0.0, 2.0 * math.pi, 24, endpoint=False).tolist()
    ring = [(START.x + 0.8 * math.cos(a), START.y + 0.8 * math.sin(a)) for a in angles]
    result = run(barn, "--worlds", str(barn_world(tmp_path / "closed", ring)))
    assert (result["success"], result["score"]) == (0.0, 0.0)


@pytest.mark.ros
@pytest.mark.system
def test_goals_in_pieces_continue_where_a_process_ended_the_same_every_time(tmp_path: Path) -> None:
    pytest.importorskip("rclpy", reason="no ROS here")

    def drive(name: str, *piece: str) -> dict[str, Any]:
        state = ("--people", "2", "--count", "2", "--state", str(tmp_path / name))
        return run(goals, "--seed", "1", *state, *piece)

    def rows(name: str) -> list[dict[str, Any]]:
        found = map(json.loads, (tmp_path / name).read_text(encoding="utf-8").splitlines())
        return [{key: value for key, value in one.items() if key != "cost"} for one in found][1:]

    drive("whole")
    setting, goal, _ = (tmp_path / "whole").read_text(encoding="utf-8").splitlines(keepends=True)
    (tmp_path / "a").write_text(setting + goal + '{"piece": 0, "now"', encoding="utf-8")  # killed
    (tmp_path / "b").write_text(setting + goal, encoding="utf-8")
    result = drive("a")
    assert drive("b", "--count", "3", "--piece", "0.001")["count"] == 2
    assert rows("a") == rows("b")
    first, second = rows("a")
    assert [first["piece"], second["piece"]] == [0, 1]
    assert (result["succeeded"], result["touches"], result["pieces"]) == (2, 0, 2)
    assert 0.9 < result["path_ratio"] < 1.2  # from where it stood
    walked = second["resume"]["walked"]["person_0"] - first["resume"]["walked"]["person_0"]
    assert walked == pytest.approx(second["now"] - first["now"] - 1.0, abs=1e-6)
    assert [one["goal"] for one in rows("whole")] == [first["goal"], second["goal"]]
    with pytest.raises(InputFileError, match="was begun with another seed, people"):
        run(goals, "--state", str(tmp_path / "a"))


@pytest.mark.ros
@pytest.mark.system
def test_two_people_close_in_on_the_robot_from_both_sides(monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("rclpy", reason="no ROS here")

    def near(driver: Course, rng: np.random.Generator) -> SE2:
        goals = iter(lambda: driver.space.draw(rng), None)
        return next(one for one in goals if one.distance(driver.robot.sim.last.truth.pose) < 1.2)

    monkeypatch.setattr(Course, "draw", near)
    result = run(pressed, "--seed", "1", "--meetings", "2")
    assert result["meetings"] >= 2
    assert result["met"] > 0
    assert 0 <= result["touches"] <= result["met"]


def test_memory_that_grows_in_one_of_two_processes_shows(tmp_path: Path) -> None:
    def row(piece: int, minute: int) -> dict[str, Any]:
        arrival = {"met": minute % 2, "off_m": 0.01, "off_rad": 0.0, "succeeded": 1, "touches": 0}
        memory = 300.0 + 0.5 * piece * minute
        cost = {"memory_mb": memory, "tick_p95_ms": 2.0 + piece, "tick_max_ms": 9.0}
        return {"piece": piece, "now": 60.0 * minute, "arrival": arrival, "cost": cost}

    found = [row(0, minute) for minute in range(200)] + [row(1, m) for m in range(200, 400)]
    result = steadiness(found)
    assert (result["pieces"], result["tick_first_ms"], result["tick_last_ms"]) == (2, 2.0, 3.0)
    assert result["memory_growth"] == pytest.approx(63.0 / 433.25, abs=0.01)
    assert result["arrival_last_m"] == 0.01
    assert steadiness(found[:200])["memory_growth"] == 0.0
    draw(found, tmp_path / "day.png")
    assert (tmp_path / "day.png").read_bytes().startswith(b"\x89PNG")


@pytest.mark.ros
@pytest.mark.system
def test_a_car_arrives_at_goals_on_bends_that_it_can_drive() -> None:
    pytest.importorskip("rclpy", reason="no ROS here")
    car = Path(goals.__file__).parent / "car"
    given = ("--robot", str(car / "car.urdf"), "--params", str(car / "car.yaml"))
    result = run(goals, *given, "--count", "1", "--seed", "3")
    assert (result["succeeded"], result["count"], result["touches"]) == (1, 1, 0)
    assert result["arrival_p95_m"] < 0.05
    assert 1.0 < result["curvature_max"] <= 1.02 / 0.6
