"""The groups that a command runs, and their parameters from all sources."""

from __future__ import annotations

from argparse import Namespace
from pathlib import Path
from typing import Any

import pytest

from arjuna_core.config import flatten, load
from arjuna_nav.costmap.config import CostmapConfig
from arjuna_nav.costmap.layers.observations import sources_of
from arjuna_sim import inputs
from arjuna_sim.files.robots.robot_file import load_robot
from arjuna_slam.config import SlamConfig
from bringup.cli import parse
from bringup.parameters.files import for_node
from bringup.parameters.inputs import gather, groups_of
from bringup.parameters.sources import COSTMAPS, ROBOT_NAMES
from bringup.stack import (
    COLLISION_MONITOR,
    DEMO_GROUPS,
    NAVIGATION_GROUP,
    REAL_STACKS,
    SIM_GROUP,
    SLAM_GROUP,
    WORLD_GROUP,
    with_further,
)
from tests.helpers.files import changed, written
from tests.sim.drive_cases import car

pytestmark = pytest.mark.ros


@pytest.mark.parametrize("command", [["slam"], ["nav", "--slam"], ["explore"], ["robot", "--slam"]])
def test_a_base_frame_reaches_every_node_that_a_command_runs(command: list[str]) -> None:
    arguments = parse([*command, "--base-frame", "chassis"])
    parameters = gather(arguments)
    for spec in (spec for group in groups_of(arguments) for spec in group.nodes):
        key = ROBOT_NAMES["base_frame"].get(spec.name)
        assert key is None or parameters[spec.name][key] == "chassis"
        config = flatten(load(spec.config, for_node(parameters, spec.name)))
        frames = {name for name, value in config.items() if value == "base_footprint"}
        assert frames == set(), spec.name


def test_the_simulator_alone_leaves_odometry_to_the_robot_s_file() -> None:
    arguments = parse(["sim", "--without-description"])
    assert groups_of(arguments) == (WORLD_GROUP,)
    sim = gather(arguments)["sim"]
    assert sim["fused_odometry"] is False, "nothing would fuse it"
    assert sim["frames_of_file"] is True, "others publish the frames"
    assert gather(parse(["sim"]))["sim"]["fused_odometry"] is True
    one = gather(parse(["sim", "--without-description", "--namespace", "a"]))["sim"]
    assert one["namespaces"] == ["a"], "others may follow into the same world"


def test_time_is_the_system_s() -> None:
    parameters = gather(parse(["robot", "--slam"]))
    assert parameters["/**"]["use_sim_time"] is False


@pytest.mark.parametrize(
    ("given", "started"),
    [
        ([], set()),
        (["--robot", "urdf/arjuna.urdf"], {"description"}),
        (["--imu", "imu"], {"odometry"}),
    ],
)
def test_what_a_driver_brings_is_not_started(given: list[str], started: set[str]) -> None:
    names = {group.name for group in groups_of(parse(["robot", "--slam", *given]))}
    assert names == {"slam", "navigation"} | started
    assert names <= {group.name for group in REAL_STACKS["robot --slam"]}


def test_a_simulated_robot_s_own_names_and_outline_reach_the_demo(tmp_path: Path) -> None:
    robot = changed(tmp_path, "urdf/arjuna.urdf", ("base_footprint", "chassis"))
    file = written(
        tmp_path,
        "{amcl: {ros__parameters: {base_frame_id: lidar_link}},"
        " explorer: {ros__parameters: {costmap: {robot_radius: 0.4}}}}",
        "other.yaml",
    )
    parameters = gather(parse(["demo", "--robot", str(robot), "--params", str(file)]))
    assert parameters["slam_toolbox"]["base_frame"] == "chassis"
    assert parameters["explorer"]["robot_base_frame"] == "chassis"
    assert parameters["behavior_server"]["robot_base_frame"] == "chassis"
    assert parameters["amcl"]["base_frame_id"] == "lidar_link"
    assert parameters["local_costmap/local_costmap"]["footprint"].startswith("[[0.225, -0.15]")
    assert "costmap.footprint" not in parameters["explorer"]


def test_a_real_robots_file_gives_its_outline_and_bend_but_its_drivers_the_topics() -> None:
    words = ["robot", "--slam", "--scan-topic", "front", "--robot"]
    own, beside = gather(parse([*words, "urdf/arjuna.urdf"])), gather(parse(words[:-1]))
    assert own["local_costmap/local_costmap"].pop("body").startswith("[[0.225, -0.15]")
    assert own.pop("robot_state_publisher")
    assert {**own, "sim": {}} == {**beside, "sim": {}}
    car = gather(parse([*words, "tests/bench/car/car.urdf"]))
    assert car["planner_server"]["min_turning_radius"] > 0.3
    for costmap in ("local_costmap/local_costmap", "global_costmap/global_costmap"):
        assert "footprint" in car[costmap].keys() - beside[costmap].keys()
    assert car["slam_toolbox"] == beside["slam_toolbox"]


@pytest.mark.parametrize("command", [["slam"], ["nav", "--map", "maps/race_track.yaml"]])
def test_a_robots_file_reaches_the_nodes_beside_the_simulator(
    command: list[str],
) -> None:
    arguments = parse([*command, "--robot", "urdf/udacity_bot.xacro", "--odom-frame", "world"])
    parameters = gather(arguments)
    (node,) = {"slam_toolbox", "amcl"} & {s.name for g in groups_of(arguments) for s in g.nodes}
    assert parameters[node]["scan_topic"] == "/udacity_bot/laser/scan"
    assert "world" in parameters[node].values()


@pytest.mark.parametrize("command", ["demo", "sim"])
@pytest.mark.parametrize(
    ("imu", "odometry", "output"),
    [("imu", "odom", None), ("/bot/imu_data", "/bot/odom", "/bot/odom"), ("i", "wheel_odom", None)],
)
def test_the_filter_has_the_topics_of_the_robots_file(
    tmp_path: Path, command: str, imu: str, odometry: str, output: str | None
) -> None:
    """As TurtleBot3's, whose `imu` nobody heard: its odometry was the wheels' alone."""
    renamed = f"<ros><remapping>odom:={odometry}</remapping></ros><left_joint>"
    changes = ("~/out:=imu<", f"~/out:={imu}<"), ("<left_joint>", renamed)
    file = changed(tmp_path, "urdf/burger.urdf", *changes)
    given = gather(parse([command, "--robot", str(file)]))["ekf_filter_node"]
    assert (given["imu0"], given.get("odom_topic")) == (imu, output)


_DEPTH = """<gazebo reference="camera_link"><sensor name="{0}" type="depth">
<camera><image><width>64</width><height>48</height></image></camera>
<plugin filename="libgazebo_ros_camera.so" name="{0}_controller"/></sensor></gazebo></robot>"""


@pytest.mark.parametrize(
    ("cameras", "sources", "lowest"),
    [
        ((), {"cloud": "/points"}, 0.03),
        (("eye",), {"cloud": "eye/points", "cloud_2": "/points"}, 0.03),
        (("l", "r"), {"cloud": "l/points", "cloud_2": "r/points", "cloud_3": "/points"}, 0.03),
    ],
)
@pytest.mark.parametrize("ground", [0.0, -0.1])
def test_costmaps_take_what_a_robots_own_cameras_see_above_its_ground(
    tmp_path: Path, cameras: tuple[str, ...], sources: dict[str, str], lowest: float, ground: float
) -> None:
    changes = [("</robot>", _DEPTH.format(camera)) for camera in cameras]
    changes += [(":=depth/", ":=/"), ('xyz="0 0 0.08"', f'xyz="0 0 {0.08 + ground:.2f}"')]
    file = changed(tmp_path, "urdf/arjuna.urdf", *changes)
    found = gather(parse(["demo", "--robot", str(file)]))
    assert found["sim"]["cloud_rate"] == 10.0
    for node in COSTMAPS:
        layer = load(CostmapConfig, found[node]).voxel_layer  # type: ignore[attr-defined]
        seen = sources_of(layer)
        assert {name: one.topic for name, one in seen.items()} == sources
        assert {(one.data_type, one.clearing) for one in seen.values()} == {("PointCloud2", True)}
        heights = layer.min_obstacle_height, layer.max_obstacle_height, layer.origin_z
        assert heights == pytest.approx((ground + lowest, ground + 0.4, ground))


_LIDAR = """<link name="{0}"/><joint name="{0}_joint" type="fixed"><parent link="base_link"/>
<child link="{0}"/><origin xyz="0 0 0.2" rpy="0 {1} 0"/></joint><gazebo reference="{0}">
<sensor name="{0}" type="gpu_lidar"><topic>{0}</topic><lidar><scan><horizontal>
<samples>360</samples><min_angle>-3</min_angle><max_angle>3</max_angle></horizontal></scan>
<range><min>0.1</min><max>8</max></range></lidar></sensor></gazebo></robot>"""


def with_lidars(folder: Path, **pitches: float) -> Path:
    """Write the shipped robot with further lidars by their pitch [rad]."""
    further = (("</robot>", _LIDAR.format(name, pitch)) for name, pitch in pitches.items())
    front = ("<topicName>scan<", "<topicName>/front/scan<")
    return changed(folder, "urdf/arjuna.urdf", front, *further)


def lidars_of(found: Any) -> list[dict[str, str]]:
    """Return the sources of both costmaps' scans and of the collision monitor, and their topics."""
    layers = [load(CostmapConfig, found[each]).obstacle_layer for each in COSTMAPS]  # type: ignore[attr-defined]
    monitor = load(COLLISION_MONITOR.config, found[COLLISION_MONITOR.name])
    of = {name: getattr(monitor, name) for name in monitor.observation_sources}
    return [
        {name: one.topic for name, one in each.items()} for each in (*map(sources_of, layers), of)
    ]


@pytest.mark.parametrize("given", [[], ["--param", "sim:standard_topics:=true"]])
def test_costmaps_and_the_monitor_take_all_lidars_that_look_level(
    tmp_path: Path, given: list[str]
) -> None:
    file = with_lidars(tmp_path, down=0.8, rear=0.0, left=0.1)
    words = ["nav", "--map", "maps/office.yaml", "--robot", str(file), *given]
    first = "scan" if given else "/front/scan"
    found = gather(parse(words))
    assert lidars_of(found) == [{"scan": first, "scan_2": "rear", "scan_3": "left"}] * 3
    assert found["amcl"].get("scan_topic", "scan") == first
    assert found[COSTMAPS[0]]["obstacle_layer.scan_3.expected_update_rate"] == 0.5
    assert lidars_of(gather(parse([*words, "--scan-topic", "left"]))) == [{"scan": "left"}] * 3
    two = lidars_of(gather(parse([*words, "--scan-topic", "left rear"])))
    assert two == [{"scan": "left", "scan_2": "rear"}] * 3


@pytest.mark.parametrize("key", ["observation_sources", "scan.topic"])
def test_sources_that_a_file_names_stay(tmp_path: Path, key: str) -> None:
    file = with_lidars(tmp_path, rear=0.0)
    given = {"observation_sources": "other", "scan.topic": "/mine"}[key]
    words = [f"--param={node}:obstacle_layer.{key}:={given}" for node in COSTMAPS]
    words += [f"--param=collision_monitor:{key}:={'[other]' if given == 'other' else given}"]
    found = gather(parse(["demo", "--robot", str(file), *words]))
    own = {"scan": "/mine"} if given == "/mine" else {"other": "/front/scan"}
    assert lidars_of(found) == [own] * 3


def test_headings_of_wheels_alone_are_believed_less_than_a_gyros(tmp_path: Path) -> None:
    file = changed(tmp_path, "urdf/burger.urdf", ('type="imu"', 'type="none"'))
    given = written(tmp_path, "amcl: {ros__parameters: {alpha1: 0.5}}")
    gyro = gather(parse(["demo", "--robot", "urdf/burger.urdf"]))
    wheels = gather(parse(["demo", "--robot", str(file), "--params", str(given)]))
    assert wheels["amcl"]["alpha2"] > gyro["amcl"]["alpha2"]
    key = "odometry_heading_deviation"
    assert wheels["slam_toolbox"].get(key, SlamConfig().odometry_heading_deviation) == 0.2
    assert gyro["slam_toolbox"][key] == 0.02
    assert wheels["amcl"]["alpha1"] == 0.5  # as a file has it


def test_the_shipped_robot_keeps_its_shipped_parameters() -> None:
    named, plain = gather(parse(["demo", "--robot", "urdf/arjuna.urdf"])), gather(parse(["demo"]))
    assert named["amcl"] == plain["amcl"]
    assert named["local_costmap/local_costmap"] == plain["local_costmap/local_costmap"]


def test_a_local_costmap_holds_a_large_robot_where_no_file_says_otherwise(tmp_path: Path) -> None:
    text = Path("urdf/burger.urdf").read_text(encoding="utf-8")
    (robot := tmp_path / "long.urdf").write_text(text.replace("0.14 0.14 0.14", "2.4 0.14 0.14"))
    own = written(tmp_path, "local_costmap: {local_costmap: {ros__parameters: {width: 4}}}")
    for words, wanted in ([], (5, 5)), (["--params", str(own)], (4, 5)):
        given = gather(parse(["demo", "--robot", str(robot), *words]))
        costmap = given["local_costmap/local_costmap"]
        assert (costmap["width"], costmap["height"]) == wanted


def test_standard_topics_are_no_names_of_the_robot(tmp_path: Path) -> None:
    file = written(tmp_path, "sim: {ros__parameters: {standard_topics: true}}")
    given = ["demo", "--robot", "urdf/udacity_bot.xacro", "--params", str(file)]
    amcl = gather(parse(given))["amcl"]
    assert "scan_topic" not in amcl
    assert amcl["base_frame_id"] == "robot_footprint"


_RADII = ("planner_server", "controller_server", "behavior_server", "velocity_smoother")


def test_tightest_bends_reach_all_nodes(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    own = str(car("gz").write(tmp_path))
    given = gather(parse(["demo", "--robot", own]))
    assert {given[node]["min_turning_radius"] for node in _RADII} == {0.779}
    costmaps = given["local_costmap/local_costmap"], given["global_costmap/global_costmap"]
    assert [costmap["axle"] for costmap in costmaps] == [-0.16, -0.16]
    assert (costmaps[0]["width"], costmaps[0]["height"]) == (5, 5)  # it sees its bend's end
    lacks = "sim: robot: its file has no lidar"
    assert [lacks in line for line in capsys.readouterr().err.splitlines()] == [True]
    assert "min_turning_radius" not in gather(parse(["demo"]))["controller_server"]
    assert not capsys.readouterr().err


@pytest.mark.parametrize(
    ("given", "planner", "turns"),
    [
        ("", "nav2_smac_planner::SmacPlannerHybrid", False),
        (
            "controller_server: {ros__parameters: {FollowPath: {desired_linear_vel: 0.2}}}",
            "",
            False,
        ),
        (
            "controller_server: {ros__parameters: {FollowPath: {use_rotate_to_heading: true}}}\n"
            "planner_server: {ros__parameters: {GridBased: {use_astar: true}}}",
            "nav2_navfn_planner::NavfnPlanner",
            True,
        ),
    ],
)
def test_a_steered_robot_drives_in_bends_unless_a_file_says_otherwise(
    given: str, planner: str, turns: bool, tmp_path: Path
) -> None:
    file = written(tmp_path, given or "{}")
    command = ["demo", "--robot", "tests/bench/car/car.urdf", "--params", str(file)]
    found = gather(parse(command))
    drives, plans = found["controller_server"], found["planner_server"]
    assert plans["GridBased.plugin"] == planner or not planner
    bend = plans.get("GridBased.minimum_turning_radius")
    assert bend == (None if turns else plans["min_turning_radius"])
    assert drives["FollowPath.use_rotate_to_heading"] is turns
    assert drives.get("FollowPath.allow_reversing", False) is not turns


@pytest.mark.parametrize(
    ("robot", "word"),
    [
        ("tests/bench/car/car.urdf", "0.2 m is tighter than the robot's file allows"),
        ("urdf/udacity_bot.xacro", "0.2 m, but the robot's file has no steering"),
    ],
)
def test_a_file_that_says_otherwise_of_a_robots_steering_is_reported(
    robot: str, word: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = written(tmp_path, "behavior_server: {ros__parameters: {min_turning_radius: 0.2}}")
    given = gather(parse(["demo", "--robot", robot, "--params", str(file)]))
    assert given["behavior_server"]["min_turning_radius"] == 0.2
    assert word in capsys.readouterr().err


def test_options_are_checked_beside_a_filter_that_a_file_starts(tmp_path: Path) -> None:
    mask = [False] * 6 + [True] + [False] * 8
    values = f"frequency: 50.0, odom0: wheel/odometry, odom0_config: {mask}"
    file = written(tmp_path, f"ekf_filter_node: {{ros__parameters: {{{values}}}}}".lower())
    parameters = gather(parse(["demo", "--seed", "3", "--params", str(file)]))
    assert parameters["ekf_filter_node"]["frequency"] == 50.0
    assert parameters["sim"]["seed"] == 3


def test_a_node_of_a_file_that_another_runs_is_left_out(tmp_path: Path) -> None:
    keys = "{filter_info_topic: /lanes, mask_topic: /mask}"
    text = f"/r/lanes: {{ros__parameters: {keys}}}\nhalls: {{ros__parameters: {keys}}}"
    words = ["nav", "--map", "maps/arjuna_room.yaml", "--leave-out", "lanes"]
    given = gather(parse([*words, "--params", str(written(tmp_path, text))]))
    names = {spec.name for spec in with_further(NAVIGATION_GROUP, given).nodes}
    assert {"lanes", "halls"} & names == {"halls"}


def test_the_demo_has_all_its_groups_with_slam_too() -> None:
    assert groups_of(Namespace(command="demo", slam=True)) == DEMO_GROUPS


def test_a_simulator_of_several_robots_is_a_process_of_its_own() -> None:
    assert (
        groups_of(parse(["sim"])) == groups_of(parse(["sim", "--namespace", "a"])) == (SIM_GROUP,)
    )
    several = parse(["sim", "--namespace", "a", "--namespace", "b"])
    assert groups_of(several) == (WORLD_GROUP,)
    assert groups_of(parse(["nav", "--slam", "--namespace", "a"]))[0] == SLAM_GROUP


@pytest.mark.parametrize("command", ["sim", "nav --without-localization"])
def test_a_robots_file_is_read_once_a_start(command: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """It was read up to seven times, 60 to 150 ms each."""
    read: list[str] = []

    def counted(file: str, arguments: Any) -> Any:
        read.append(file)
        return load_robot(file, arguments=arguments)

    monkeypatch.setattr(inputs, "load_robot", counted)
    gather(parse([*command.split(), "--robot", "tests/bench/car/car.urdf"]))
    assert [Path(file).name for file in read] == ["car.urdf"]
