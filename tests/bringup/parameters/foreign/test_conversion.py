"""ROS 1's parameter files by our names: what comes out loads, what has no meaning is listed."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
import yaml

from bringup import cli
from bringup.cli import parse
from bringup.parameters.checking import check_file
from bringup.parameters.files import load_parameters, merged, shipped_parameters
from bringup.parameters.foreign.conversion import Conversion, converted
from bringup.parameters.foreign.ros1_names import TABLES, targets
from bringup.parameters.sources import ROBOT_NAMES
from tests.helpers.files import written
from tests.helpers.nav.stock_files import FILES

pytestmark = pytest.mark.ros

FOLDER = Path(__file__).parent
ROS1: dict[str, Any] = yaml.safe_load((FOLDER / "ros1_files.yaml").read_text(encoding="utf-8"))
PROGRAMS = {
    "hector_mapping": "{map_frame: map, map_resolution: 0.05, map_size: 512}",
    "cartographer": "{map_builder: {}, map_frame: map, tracking_frame: imu, num_laser_scans: 1}",
    "robot_localization": "{frequency: 30, odom_frame: odom, imu0: imu, imu0_config: [true]}",
    "teb_local_planner": "{teb_autosize: true, max_vel_x: 0.4, dt_ref: 0.3, weight_obstacle: 50}",
}


def checked(folder: Path, text: str) -> Conversion:
    result = converted(written(folder, text))
    assert (result.unknown, result.problems) == ([], [])
    return result


@pytest.mark.parametrize("name", ROS1)
def test_a_ros1_file_becomes_one_that_loads(name: str, tmp_path: Path) -> None:
    result = checked(tmp_path, ROS1[name]["text"])
    ours = written(tmp_path, result.text, "ours.yaml")
    assert check_file(ours).refused_by(strict=True) == []
    loaded = load_parameters([ours])
    for one in ROS1[name]["becomes"]:
        assert loaded[one["node"]][one["name"]] == one["value"]
        note = one.get("note", "")
        assert any(note in each for each in result.notes) or not note


def _base_frames(text: str, folder: Path) -> set[str]:
    """Return the base frames that a file leads to, over the shipped parameters."""
    loaded = load_parameters([written(folder, checked(folder, text).text)])
    whole = merged(shipped_parameters(), loaded)
    return {f for n, k in ROBOT_NAMES["base_frame"].items() if (f := whole.get(n, {}).get(k))}


@pytest.mark.parametrize(
    "text",
    [
        "amcl: {base_frame_id: robot_footprint}",
        "{amcl: {base_frame_id: /robot_footprint},"
        " local_costmap: {robot_base_frame: robot_footprint}}",
        "bt_navigator: {ros__parameters: {robot_base_frame: robot_footprint}}",
        "{base_frame: robot_footprint, delta: 0.1}",
    ],
)
def test_a_robot_has_one_base_frame(text: str, tmp_path: Path) -> None:
    assert _base_frames(text, tmp_path) == {"robot_footprint"}


def test_two_base_frames_stay_two(tmp_path: Path) -> None:
    text = "{amcl: {base_frame_id: foot}, global_costmap: {robot_base_frame: body}}"
    assert {"foot", "body"} <= _base_frames(text, tmp_path)


def test_a_controller_s_accelerations_are_the_velocity_smoother_s(tmp_path: Path) -> None:
    def smoother(text: str) -> dict[str, Any]:
        ours = written(tmp_path, checked(tmp_path, text).text)
        return load_parameters([ours])["velocity_smoother"]

    limits = "FollowPath: {max_linear_accel: 1.5, max_linear_decel: 2.0}"
    text = f"controller_server: {{ros__parameters: {{controller_plugins: [FollowPath], {limits}}}}}"
    found = smoother(text)
    assert (found["max_accel"][0], found["max_decel"][0]) == (1.5, -2.0)
    own = "velocity_smoother: {ros__parameters: {max_accel: [0.7, 0.0, 1.0]}}"
    assert smoother(f"{text}\n{own}")["max_accel"] == [0.7, 0.0, 1.0]


@pytest.mark.parametrize("name", FILES)
def test_a_nav2_file_keeps_only_what_is_used(name: str, tmp_path: Path) -> None:
    ours = written(tmp_path, checked(tmp_path, FILES[name]).text, "ours.yaml")
    assert checked(tmp_path, ours.read_text()).notes == []


def test_all_unknown_names_come_at_once(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = written(tmp_path, "amcl: {kid_err: 0.1, max_particles: 800, laser_z_hti: 0.3}")
    assert cli.run(parse(["params", "convert", str(path)])) == 0  # it wrote what it knows
    written_lines = capsys.readouterr()
    assert "amcl: nobody knows 'kid_err'; did you mean 'kld_err'?" in written_lines.err
    assert "'laser_z_hti'; did you mean 'laser_z_hit'?" in written_lines.err
    assert "max_particles: 800" in written_lines.out


def test_a_file_of_no_known_node_is_named_once(tmp_path: Path) -> None:
    result = converted(written(tmp_path, "{speed_lim_v: 0.8, accel_lim_w: 2.0}"))
    assert len(result.unknown) == 1
    assert (
        "of no node that is known: 'speed_lim_v', 'accel_lim_w'; valid: amcl, gmapping"
        in (result.unknown[0])
    )
    assert result.problems == ["nothing in it has a meaning here"]


def test_the_page_has_every_name() -> None:
    page = (Path(__file__).parents[4] / "docs" / "coming-from-ros1.md").read_text(encoding="utf-8")
    for section in (name for name in TABLES if name not in ("local_costmap", "slam_toolbox")):
        for old, ours in targets(section).items():
            row = ", ".join(f"`{node}` `{name}`" for node, name in ours) or "-"
            assert f"| `{old}` | {row} |\n" in page, f"{section}: {old}"


def test_a_launch_file_becomes_one_that_loads(tmp_path: Path) -> None:
    path = written(
        tmp_path,
        """<launch><node pkg="amcl" type="amcl" name="amcl">
          <remap from="scan" to="robot/laser/scan"/><remap from="map" to="plan"/>
          <param name="odom_alpha1" value="0.02"/><param name="gui_publish_rate" value="10"/>
        </node><node pkg="move_base" type="move_base" name="move_base">
          <remap from="cmd_vel" to="robot/cmd_vel"/>
          <rosparam>TrajectoryPlannerROS: {max_vel_x: 0.45}</rosparam>
        </node></launch>""",
        "amcl.launch",
    )
    result = converted(path)
    assert (result.unknown, result.problems) == ([], [])
    assert result.notes == ["amcl: gui_publish_rate", "amcl: remap from map to plan"]
    ours = written(tmp_path, result.text, "ours.yaml")
    assert check_file(ours).refused_by(strict=True) == []
    loaded = load_parameters([ours])
    assert loaded["amcl"] == {"alpha1": 0.02, "scan_topic": "robot/laser/scan"}
    assert loaded["collision_monitor"] == {"cmd_vel_out_topic": "robot/cmd_vel"}
    assert loaded["controller_server"]["FollowPath.max_vel_x"] == 0.45


@pytest.mark.parametrize("name", PROGRAMS)
def test_another_program_s_file_is_named_in_a_sentence(name: str, tmp_path: Path) -> None:
    result = converted(written(tmp_path, PROGRAMS[name]))
    (problem,) = result.unknown
    assert problem.startswith(f"of {name}, which is not here: ")
    assert result.text.strip() == "{}"


def test_a_file_without_a_meaning_is_named(tmp_path: Path) -> None:
    result = converted(written(tmp_path, "TebLocalPlannerROS: {max_vel_x: 0.4}"))
    assert result.problems == ["nothing in it has a meaning here"]


def test_names_that_are_near_none_are_named_together(tmp_path: Path) -> None:
    text = "amcl: {min_particels: 9, zebra: 1, quokka: 2, kld_err: 0.1}"
    result = converted(written(tmp_path, text))
    near, far = result.unknown
    assert near == "amcl: nobody knows 'min_particels'; did you mean 'min_particles'?"
    assert far.startswith("amcl: nobody knows 'zebra', 'quokka'; valid: min_particles, ")


@pytest.mark.parametrize(
    "text",
    [
        "move_base: {planner_frequency: often, recovery_behaviors: [reset]}",
        "DWAPlannerROS: {acc_lim_x: fast}",
        "local_costmap: {width: wide, plugins: [obstacle_layer, 3]}",
        "{1: 2, amcl: {kld_err: none}}",
    ],
)
def test_values_of_the_wrong_kind_are_named(text: str, tmp_path: Path) -> None:
    assert converted(written(tmp_path, text)).problems
