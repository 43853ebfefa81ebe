"""Parameters beside the file of the robot that drives by them: its outline."""

from __future__ import annotations

import shlex
from pathlib import Path
from typing import Any

import pytest
import yaml

from arjuna_core.config import load
from arjuna_core.files.shipped import shipped_file
from arjuna_nav.exploration.frontiers import ExplorationConfig
from bringup.cli import parse
from bringup.parameters.checking import check_file
from bringup.parameters.files import SAFETY, for_node, shipped_parameters
from bringup.parameters.inputs import gather
from bringup.parameters.remarks import Kind
from bringup.parameters.sources import keys_by_name
from bringup.stack import DEMO_GROUPS, EKF, LOCAL_COSTMAP
from tests.helpers.files import changed, written
from tests.helpers.nav.stock_files import FILES
from tests.sim.drive_cases import mecanum

pytestmark = pytest.mark.ros
SMALL = "robot_radius: 0.22 m, but the robot's body reaches 0.276 m from base_link"


def of_radius(tmp_path: Path, outline: str, costmaps: tuple[str, ...] = ("local", "global")) -> str:
    node = "{0}_costmap: {{{0}_costmap: {{ros__parameters: {{{1}}}}}}}\n"
    return str(written(tmp_path, "".join(node.format(each, outline) for each in costmaps)))


def body_of(words: list[str]) -> str:
    return str(for_node(gather(parse(words)), LOCAL_COSTMAP.name).get("body", ""))


def test_small_outlines_are_reported(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    words = ["demo", "--params", of_radius(tmp_path, "robot_radius: 0.22")]
    body = body_of(words)
    assert body.startswith("[[0.225, ")
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith(f"unlike the robot (SAFETY): {LOCAL_COSTMAP.name}: {SMALL}")
    assert "(global_costmap too)" in line
    advice = line.rpartition("--param ")[2].strip("'")
    assert body_of([*words, "--param", advice]) == ""
    assert not capsys.readouterr().err
    own = "[[0.3, 0.2], [0.3, -0.2], [-0.3, 0.0]]"
    assert body_of([*words, "--param", f"{LOCAL_COSTMAP.name}:body:={own}"]) == own


@pytest.mark.parametrize(
    ("source", "told"),
    [
        ("topic: depth/points", True),
        ("topic: /depth/points, min_obstacle_height: 0.05", False),
        ("topic: depth/points, marking: false", False),
        ("topic: points_without_ground", False),
    ],
)
def test_ground_that_marks_is_told(source: str, told: bool, tmp_path: Path) -> None:
    layer = f"observation_sources: eye, eye: {{data_type: PointCloud2, {source}}}"
    layer = f"{{plugin: 'nav2_costmap_2d::VoxelLayer', {layer}}}"
    path = of_radius(tmp_path, f"robot_radius: 0.28, plugins: [v], v: {layer}", ("local",))
    found = [one.reason for one in check_file(Path(path)).remarks]
    assert any("sees the ground up to 0.03 m" in reason for reason in found) is told


@pytest.mark.parametrize(
    "outline",
    [
        "robot_radius: 0.28",
        "footprint: '[[0.23, 0.2], [0.23, -0.2], [-0.23, -0.2], [-0.23, 0.2]]'",
        "inflation_layer.inflation_radius: 0.4",  # Arjuna's circle holds it by its padding alone
    ],
)
def test_an_outline_that_holds_the_body_is_left_alone(
    outline: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    words = ["demo", "--params", of_radius(tmp_path, outline)]
    assert bool(body_of(words)) is outline.startswith("inflation")
    assert not capsys.readouterr().err


def test_a_radius_fits_its_own_robot(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = of_radius(tmp_path, "robot_radius: 0.12")
    parameters = gather(parse(["demo", "--robot", "urdf/burger.urdf", "--params", file]))
    assert not capsys.readouterr().err
    values = parameters[LOCAL_COSTMAP.name]
    assert (values["robot_radius"], values.get("footprint", "[]")) == (0.12, "[]")
    assert "[-0.102, 0.07]" in values["body"], "the radius holds it with its padding"


def test_another_robot_has_its_own_outline_as_its_body_too() -> None:
    """Beside a wall it stood for good: the cells below its padding were free, and so the wall."""
    words = ["demo", "--robot", "urdf/burger.urdf"]
    values = gather(parse(words))[LOCAL_COSTMAP.name]
    assert values["body"] == values["footprint"] != "[]"
    wide = "[[0.3, 0.2], [0.3, -0.2], [-0.3, -0.2], [-0.3, 0.2]]"
    assert body_of([*words, "--param", f"footprint:={wide}"]) == ""


@pytest.mark.parametrize(("sight", "most"), [(3.5, 3.5), (10.0, 10.0), (30.0, 12.0)])
def test_a_robot_explores_as_far_from_things_as_its_lidar_sees(
    tmp_path: Path, sight: float, most: float
) -> None:
    """Sent to 15 m from all there was, one whose lidar saw 3.5 m no longer knew where it was."""
    file = changed(tmp_path, "urdf/burger.urdf", ("<max>3.5</max>", f"<max>{sight}</max>"))
    key, words = "exploration.max_open_distance", ["demo", "--robot", str(file)]
    given = gather(parse(words))["explorer"]
    assert given.get(key, ExplorationConfig.max_open_distance) == most
    own = gather(parse([*words, "--param", f"explorer:{key}:=7.0"]))["explorer"]
    assert own[key] == 7.0


@pytest.mark.parametrize(
    ("limit", "braking"), [(0.0, (2.5, 2.5)), (0.1, (0.1, 1.25)), (9.0, (2.5, 2.5))]
)
def test_a_robot_that_brakes_slowly_is_reckoned_with(
    tmp_path: Path, limit: float, braking: tuple[float, float]
) -> None:
    """One of 0.2 m/s^2, driven as the shipped one, stood in walls."""
    end = "</max_linear_velocity>"
    tag = f"<max_wheel_acceleration>{limit}</max_wheel_acceleration>"
    file = changed(tmp_path, "urdf/burger.urdf", (end, f"{end}{tag}"))
    words, shipped = ["demo", "--robot", str(file)], shipped_parameters()

    def value(node: str, key: str, *more: str) -> Any:
        given = gather(parse([*words, *more])).get(node, {})
        return given.get(key, shipped[node][key])

    zone, turn = "FootprintApproach.deceleration", "tracker.angular_deceleration"
    assert value("collision_monitor", zone) == braking[0]
    ramps = [limit, limit, 12.5 * limit] if limit else [1000.0, 1000.0, 1000.0]
    assert value("velocity_smoother", "max_accel") == pytest.approx(ramps, rel=1e-3)
    assert value("velocity_smoother", "max_decel") == pytest.approx([-a for a in ramps], rel=1e-3)
    assert value("controller_server", turn) == pytest.approx(braking[1])
    assert value("controller_server", turn, "--param", f"controller_server:{turn}:=0.7") == 0.7


def test_polygons_and_parts_beyond_them(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    square = "[[0.18, 0.2], [0.18, -0.2], [-0.18, -0.2], [-0.18, 0.2]]"
    body_of(["demo", "--params", of_radius(tmp_path, f"footprint: '{square}'", ("global",))])
    (line,) = capsys.readouterr().err.splitlines()
    assert f"global_costmap: footprint: {square}, but the robot's body stands out of it" in line
    assert body_of(["demo", "--params", of_radius(tmp_path, f"footprint: '{square}'")])


def test_a_real_robot_s_file_is_held_against_parameters_too(tmp_path: Path) -> None:
    file = of_radius(tmp_path, "robot_radius: 0.22")
    words = ["robot", "--slam", "--params", file]
    assert not gather(parse(words))[SAFETY]
    (line,) = gather(parse([*words, "--robot", "urdf/arjuna.urdf"]))[SAFETY].values()
    assert SMALL in line[0]


def test_a_check_names_the_line_and_asks_for_the_robot(tmp_path: Path) -> None:
    path = Path(of_radius(tmp_path, "robot_radius: 0.12"))
    (remark,) = check_file(path).remarks
    assert (remark.kind, remark.safety, remark.location) == (Kind.UNLIKE, True, f"{path}:1")
    assert check_file(path, str(shipped_file("urdf/burger.urdf"))).remarks == []


def test_the_body_is_a_valid_outline_of_the_follower(tmp_path: Path) -> None:
    body = body_of(["demo", "--params", of_radius(tmp_path, "robot_radius: 0.1")])
    assert load(LOCAL_COSTMAP.config, {"body": body}).body == body


MPPI = "plugin: nav2_mppi_controller::MPPIController, motion_model"
SMOOTHER = "velocity_smoother: {ros__parameters"
DWB = "plugin: dwb_core::DWBLocalPlanner, max_vel_y"


@pytest.mark.parametrize(
    ("given", "said"),
    [
        (f"{MPPI}: Omni", "FollowPath.motion_model: Omni, but the robot's wheels do not"),
        (f"{MPPI}: Ackermann", ""),
        (f"{DWB}: 0.3", "FollowPath.max_vel_y: 0.3 m/s, but the robot's wheels do not"),
        (f"{DWB}: 0.0", ""),
    ],
)
def test_a_controller_that_drives_sideways_is_held_against_the_drive(
    given: str, said: str, tmp_path: Path
) -> None:
    controller = f"controller_plugins: [FollowPath], FollowPath: {{{given}}}"
    file = written(tmp_path, f"controller_server: {{ros__parameters: {{{controller}}}}}")
    assert said in "".join(str(each) for each in check_file(file).remarks)
    robot = str(mecanum().write(tmp_path))
    assert check_file(file, robot).remarks == []
    limits = "max_velocity: [0.3, 0.0, 1.0], min_velocity: [-0.3, 0.0, -1.0]"
    smoothed = written(tmp_path, f"{file.read_text()}\n{SMOOTHER}: {{{limits}}}}}", "smoothed.yaml")
    remarks = "".join(str(each) for each in check_file(smoothed, robot).remarks)
    assert ("[0.3, 0.0, 1.0]: none sideways, where 'FollowPath' drives so" in remarks) is bool(said)


@pytest.mark.parametrize(
    ("flag", "given", "is_said"),
    [
        ("False", [], True),
        ("true", [], False),
        ("False", ["--param", "sim:standard_topics:=true"], False),
    ],
)
def test_a_transform_that_nobody_publishes_is_told(
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    flag: str,
    given: list[str],
    is_said: bool,
) -> None:
    """The maps stayed empty of a robot whose file leaves it to a filter and has no IMU."""
    own = ("<left_joint>", f"<publish_odom_tf>{flag}</publish_odom_tf><left_joint>")
    file = changed(tmp_path, "urdf/burger.urdf", ('type="imu"', 'type="-"'), own)
    gather(parse(["demo", "--robot", str(file), *given]))
    said = "publishes no transform odom -> base_footprint" in capsys.readouterr().err
    assert said is is_said


NAMES = ["scan_topic", "cloud_topic", "odom_topic", "base_frame", "odom_frame"]
UNHEARD = {"velocity_smoother: odom_topic"}  # as long as it does not close the loop


def with_names(folder: Path, what: str, name: str, **further: Any) -> tuple[str, set[str]]:
    """Write a file with a name of the robot's at every node that has one, as others' files do."""
    given, wanted = dict[str, Any](), set()
    shipped = shipped_parameters()
    for spec in (each for group in DEMO_GROUPS for each in group.nodes if each != EKF):
        for key in keys_by_name(spec, shipped.get(spec.name, {}))[what]:
            given.setdefault(f"/{spec.name}", {"ros__parameters": {}})["ros__parameters"][key] = (
                name
            )
            wanted |= {f"{spec.name}: {key}"} - UNHEARD
    file = written(folder, yaml.safe_dump({**given, **further}), "names.yaml")
    return str(file), wanted


def said_of(words: list[str], capsys: pytest.CaptureFixture[str]) -> list[str]:
    gather(parse(words))
    return [line for line in capsys.readouterr().err.splitlines() if "robot's own is" in line]


@pytest.mark.parametrize(("what", "slash"), [*((name, "") for name in NAMES), (NAMES[0], "/")])
def test_names_that_nothing_gives_are_told_with_the_robot_s(
    what: str, slash: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Files of robots with odom_combined or scan_filtered ended in a lacking transform alone."""
    file, wanted = with_names(tmp_path, what, f"{slash}other")
    words = ["demo", "--params", file]
    (line,) = said_of(words, capsys)
    assert wanted
    assert all(each in line for each in ("unlike the robot: ", *wanted))
    advice = shlex.split(line[line.index("--param") :])
    assert said_of([*words, *advice], capsys) == []
    (remark,) = check_file(Path(file), str(shipped_file("urdf/arjuna.urdf"))).remarks
    assert (remark.kind, bool(remark.location)) == (Kind.UNLIKE, True)
    assert check_file(Path(file)).remarks == [], "it may be of a robot that is not here"


@pytest.mark.parametrize(("topic", "is_said"), [("/a/scan", False), ("/b/scan", True)])
def test_topics_of_a_namespaced_robot_are_its_own(
    topic: str, is_said: bool, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A robot's file that says its namespace in its topics was told that nothing gives them."""
    robot = changed(tmp_path, "urdf/burger.urdf", ("~/out:=scan", "~/out:=/a/scan"))
    file, _ = with_names(tmp_path, "scan_topic", topic)
    words = ["nav", "--slam", "--params", file, "--robot", str(robot), "--namespace", "a"]
    assert bool(said_of(words, capsys)) is is_said


@pytest.mark.parametrize(("what", "is_said"), [("odom_topic", False), ("scan_topic", True)])
def test_robot_localization_may_give_the_odometry(
    what: str, is_said: bool, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    fused = {"ros__parameters": {"odom0": "odom", "odom0_config": [True] * 15}}
    file, _ = with_names(tmp_path, what, "other", ekf_filter_node=fused)
    assert bool(said_of(["demo", "--params", file], capsys)) is is_said


@pytest.mark.parametrize(
    ("node", "text", "is_said"),
    [
        ("local_costmap: {local_costmap", "global_frame: map}", False),
        ("collision_monitor", "cmd_vel_in_topic: cmd_vel_nav, cmd_vel_out_topic: between", False),
        ("velocity_smoother", "odom_topic: other", False),
        ("velocity_smoother", "odom_topic: other, feedback: CLOSED_LOOP", True),
    ],
)
def test_names_that_are_valid_or_not_heard(
    node: str, text: str, is_said: bool, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = written(tmp_path, f"{node}: {{ros__parameters: {{{text}}}}}", "names.yaml")
    assert bool(said_of(["demo", "--params", str(file)], capsys)) is is_said


@pytest.mark.parametrize(
    ("text", "kind"),
    [
        ("cmd_vel_out_topic: /demo/cmd_vel", "unlike the robot: "),
        ("cmd_vel_in_topic: raw, cmd_vel_out_topic: safe", "unlike the robot: "),
        ("cmd_vel_in_topic: cmd_vel, cmd_vel_out_topic: safe", "unlike the robot (SAFETY): "),
    ],
)
def test_commands_that_do_not_reach_the_robot_are_told(
    text: str, kind: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """It stood without a word, or drove past a monitor whose output nobody takes."""
    monitor = f"collision_monitor: {{ros__parameters: {{{text}}}}}"
    words = ["demo", "--params", str(written(tmp_path, monitor, "chain.yaml"))]
    (line,) = said_of(words, capsys)
    assert kind in line
    assert "cmd_vel_out_topic" in line
    advice = shlex.split(line[line.index("--param") :])
    assert said_of([*words, *advice], capsys) == []


def test_a_map_that_nothing_places_is_told(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Files of robots with GPS, whose filters lie in other files: each goal was aborted."""
    text = "amcl: {ros__parameters: {tf_broadcast: false}}"
    told = "unlike the robot: amcl: tf_broadcast: false, and nothing gives map -> odom"
    words = ["nav", "--map", "maps/arjuna_room.yaml", "--params"]
    gather(parse([*words, str(written(tmp_path, text, "amcl.yaml"))]))
    said = capsys.readouterr().err
    assert told in said
    advice = shlex.split(said[said.index("--param ") :].splitlines()[0])
    gather(parse([*words, str(tmp_path / "amcl.yaml"), *advice]))
    assert told not in capsys.readouterr().err
    fused = f"{text}\nekf_map: {{ros__parameters: {{odom0: odom, odom0_config: {[True] * 15}}}}}"
    gather(parse([*words, str(written(tmp_path, fused, "fused.yaml"))]))
    assert told not in capsys.readouterr().err


@pytest.mark.parametrize("file", FILES)
def test_stock_files_have_the_robot_s_names(
    file: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = written(tmp_path, FILES[file], "stock.yaml")
    assert said_of(["demo", "--params", str(path)], capsys) == []
