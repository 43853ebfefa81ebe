"""The worlds that launch files name."""

from __future__ import annotations

from pathlib import Path

import pytest

from arjuna_core.files.shipped import shipped_file
from bringup.ros2.errors import Ros2Error
from bringup.ros2.worlds import world_of

BURGER = shipped_file("urdf/burger.urdf")


@pytest.mark.parametrize("name", ["empty.world", "office", "turtlebot3_world.world", str(BURGER)])
def test_a_world_is_found_by_path_or_name(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    world = tmp_path / "share" / "turtlebot3_gazebo" / "worlds" / "turtlebot3_world.world"
    world.parent.mkdir(parents=True)
    world.touch()
    monkeypatch.setenv("AMENT_PREFIX_PATH", str(tmp_path))
    assert world_of(name).name.partition(".")[0] == Path(name).stem


def test_a_world_is_found_where_gazebo_looks(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    world = tmp_path / "worlds" / "low" / "empty.sdf"
    world.parent.mkdir(parents=True)
    world.touch()
    for variable in ("GAZEBO_RESOURCE_PATH", "GZ_SIM_RESOURCE_PATH"):
        monkeypatch.setenv(variable, f"/nowhere:{tmp_path}")
        assert world_of("worlds/low/empty.sdf") == world_of("low/empty.sdf") == world
        monkeypatch.delenv(variable)


@pytest.mark.parametrize(
    ("name", "named"),
    [("wearhouse.world", "did you mean 'warehouse.world'?"), ("maze", "valid: apriltag, ")],
)
def test_an_unknown_world_names_the_valid_ones(name: str, named: str) -> None:
    with pytest.raises(Ros2Error, match=f"no world '{name}'; ") as problem:
        world_of(name)
    assert named in str(problem.value)
