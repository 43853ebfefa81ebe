"""Controllers' and plug-ins' types, and what a ros2_control file says of its drive."""

from __future__ import annotations

import itertools
import math
import random
from collections.abc import Iterator
from pathlib import Path
from typing import Any
from xml.etree.ElementTree import Element

import pytest
import yaml

from arjuna_sim.files.robots.plugins import controller_kind, drive_kind, is_control
from arjuna_sim.files.robots.robot_file import load_robot
from arjuna_sim.files.search_path import SearchPath
from arjuna_sim.model.settings import DriveKind, DriveSettings
from tests.sim.builders import texts
from tests.sim.drive_cases import Robot, control, four, tricycle

_JOINTS = {
    f"{side}_wheel_names": [f"{end}_{side}_wheel_joint" for end in ("front", "rear")]
    for side in ("left", "right")
}
_LIMITS: dict[str, Any] = {
    "linear": {"x": {"max_velocity": 0.7, "min_velocity": -0.3, "max_acceleration": 1.5}},
    "angular": {"z": {"max_velocity": 1.25, "max_acceleration": 2.5}},
}
_FORMS = ("name", "/name", "/**/name", "**/name", "/ns/name", "/**", "ns", "ros1")
_TYPE = "diff_drive_controller/DiffDriveController"


def _dotted(values: dict[str, Any], prefix: str = "") -> dict[str, Any]:
    """Return nested parameters as dotted ones."""
    flat: dict[str, Any] = {}
    for key, value in values.items():
        inner = isinstance(value, dict)
        flat |= _dotted(value, f"{prefix}{key}.") if inner else {prefix + key: value}
    return flat


def _file(form: str, values: dict[str, Any], dotted: bool) -> dict[str, Any]:
    """Return the content of a file that names a controller `name` in a form."""
    values = _dotted(values) if dotted else values
    if form == "ros1":
        return {"name": {"type": _TYPE, **values}}
    types: dict[str, Any] = {"name.type": _TYPE} if dotted else {"name": {"type": _TYPE}}
    manager = {"controller_manager": {"ros__parameters": {"update_rate": 50, **types}}}
    if form == "ns":
        return {"ns": {**manager, "name": {"ros__parameters": values}}}
    return {**manager, form.replace("name", "name"): {"ros__parameters": values}}


def _drive(folder: Path, content: dict[str, Any], name: str = "made") -> DriveSettings:
    tag, files = control(yaml.safe_dump(content, sort_keys=False))
    return load_robot(
        Robot(four(), tag, files=files).write(folder, f"{name}.urdf"), SearchPath()
    ).drive


@pytest.mark.parametrize(("form", "dotted"), list(itertools.product(_FORMS, (False, True))))
def test_limits_and_timeouts_in_every_form(tmp_path: Path, form: str, dotted: bool) -> None:
    values = {**_JOINTS, **_LIMITS, "wheel_radius": 0.06, "cmd_vel_timeout": 0.25}
    drive = _drive(tmp_path, _file(form, values, dotted))
    assert drive.kind is DriveKind.SIDES
    assert (drive.max_velocity, drive.max_reverse, drive.max_turn) == (0.7, 0.3, 1.25)
    assert (drive.max_acceleration, drive.max_turn_acceleration) == (1.5, 2.5)
    assert drive.command_timeout == 0.25
    assert drive.command_topic == ("/ns/name/cmd_vel" if form == "/ns/name" else "/name/cmd_vel")


def test_wheels_that_are_driven_through_a_pid_controller_are_the_drives(tmp_path: Path) -> None:
    pids = {f"{side}_pid": {"type": "pid_controller/PidController"} for side in ("left", "right")}
    chained = {
        key: [f"{key[: key.index('_')]}_pid/{name}" for name in names]
        for key, names in _JOINTS.items()
    }
    content = _file("name", {**chained, "wheel_radius": 0.06}, dotted=False)
    content["controller_manager"]["ros__parameters"] |= pids
    drive = _drive(tmp_path, content)
    assert drive.rolling == tuple(name for names in _JOINTS.values() for name in names)
    notes = texts(load_robot(tmp_path / "made.urdf", SearchPath()).notes)
    assert len([text for text in notes if "PidController is not simulated; wheels" in text]) == 2


def test_the_separation_of_wheels_that_roll_along_contradicts_nothing(tmp_path: Path) -> None:
    robot = load_robot(tricycle(classic=True).write(tmp_path, "t.urdf"), SearchPath())
    assert not [text for text in texts(robot.notes) if "wheel_separation" in text]


@pytest.mark.parametrize(
    ("node", "tags", "topic"),
    [
        ("name", "", "/bot/name/cmd_vel"),
        ("/bot/name", "", "/bot/name/cmd_vel"),
        ("name", "<remapping>/name/cmd_vel:=/drive</remapping>", "/drive"),
        ("name", "<remapping>/bot/name/cmd_vel:=drive</remapping>", "/bot/drive"),
    ],
)
def test_topics_are_in_the_plugins_namespace(
    tmp_path: Path, node: str, tags: str, topic: str
) -> None:
    content = _file("name", _JOINTS, dotted=False)
    content[node] = content.pop("name")
    tag, files = control(yaml.safe_dump(content, sort_keys=False))
    space = f"<ros><namespace>/bot</namespace>{tags}</ros></plugin>"
    robot = Robot(four(), tag.replace("</plugin>", space), files=files)
    drive = load_robot(robot.write(tmp_path), SearchPath()).drive
    assert (drive.command_topic, drive.odometry_topic) == (topic, "/bot/name/odom")


@pytest.mark.parametrize(
    ("name", "kind"),
    [
        ("platform_velocity_controller", DriveKind.SIDES),
        ("omni_base", DriveKind.SIDES),
        ("mecanum_lookalike", DriveKind.SIDES),
        ("planar_move_controller", DriveKind.SIDES),
    ],
)
def test_a_controllers_name_makes_no_drive(tmp_path: Path, name: str, kind: DriveKind) -> None:
    manager = {"controller_manager": {"ros__parameters": {name: {"type": _TYPE}}}}
    drive = _drive(tmp_path, {**manager, name: {"ros__parameters": _JOINTS}})
    assert drive.kind is kind
    assert drive.command_topic == f"/{name}/cmd_vel"


@pytest.mark.parametrize(
    ("changed", "expected"),
    [
        ({"has_velocity_limits": False}, (0.0, 0.0, 1.5)),
        ({"has_acceleration_limits": False}, (0.7, 0.3, 0.0)),
        ({"has_velocity_limits": True}, (0.7, 0.3, 1.5)),
        ({"max_velocity": float("nan"), "min_velocity": float("-inf")}, (0.0, 0.0, 1.5)),
        ({"max_velocity": "fast"}, (0.0, 0.3, 1.5)),
    ],
)
def test_limits_that_are_switched_off_or_none_do_not_count(
    tmp_path: Path, changed: dict[str, Any], expected: tuple[float, ...]
) -> None:
    linear = {"x": {**_LIMITS["linear"]["x"], **changed}}
    drive = _drive(tmp_path, _file("name", {**_JOINTS, "linear": linear}, dotted=False))
    assert (drive.max_velocity, drive.max_reverse, drive.max_acceleration) == expected
    assert drive.command_timeout is None


@pytest.mark.parametrize(("space", "named"), [("", "unit"), ("/a", "unit"), ("", "other")])
def test_an_imu_broadcaster_publishes_beside_its_sensor(
    tmp_path: Path, space: str, named: str
) -> None:
    kind = {"type": "imu_sensor_broadcaster/IMUSensorBroadcaster"}
    own = {"ros__parameters": {"sensor_name": named, "frame_id": "eye"}}
    tag, files = control(
        yaml.safe_dump({"controller_manager": {"ros__parameters": {"wit": kind}}, "wit": own})
    )
    tag = tag.replace("</plugin>", f"<ros><namespace>{space}</namespace></ros></plugin>")
    tag += "<gazebo reference='base'><sensor name='unit' type='imu'><topic>raw</topic></sensor>"
    path = Robot(four(), f"{tag}</gazebo>", files=files).write(tmp_path)
    found = [(s.topic, s.frame) for s in load_robot(path, SearchPath()).settings.sensors]
    broadcast = [(f"{space}/wit/imu", "eye")] if named == "unit" else []
    assert found == [*broadcast, ("raw", "base")]


@pytest.mark.parametrize(
    ("space", "given", "before"),
    [
        ("", {}, ""),
        ("/a/b", {}, "a/b/"),
        ("/a", {"tf_frame_prefix": "c"}, "c/"),
        ("", {"tf_frame_prefix": "/c/"}, "c/"),
        ("/a", {"tf_frame_prefix_enable": False, "tf_frame_prefix": "c"}, ""),
        ("/a", {"type": "mecanum_drive_controller/MecanumDriveController"}, ""),
    ],
)
def test_a_diff_drive_controller_puts_its_namespace_before_its_frames(
    tmp_path: Path, space: str, given: dict[str, Any], before: str
) -> None:
    manager = {"ros__parameters": {"base": {"type": given.get("type", _TYPE)}}}
    own = {"ros__parameters": {**_JOINTS, "base_frame_id": "base", **given}}
    tag, files = control(yaml.safe_dump({"controller_manager": manager, "base": own}))
    tag = tag.replace("</plugin>", f"<ros><namespace>{space}</namespace></ros></plugin>")
    drive = load_robot(Robot(four(), tag, files=files).write(tmp_path), SearchPath()).drive
    assert (drive.odometry_frame, drive.base_frame) == (f"{before}odom", f"{before}base")


def test_a_tricycle_controller_has_no_transform_of_odometry_by_default(tmp_path: Path) -> None:
    drive = load_robot(tricycle().write(tmp_path, "three.urdf"), SearchPath()).drive
    assert drive.publishes == ("odom",)
    assert _drive(tmp_path, _file("name", _JOINTS, False)).publishes == ("odom", "odom_tf")


@pytest.mark.parametrize(
    ("given", "seconds"),
    [
        ({"cmd_vel_timeout": 0.0}, 0.0),
        ({"reference_timeout": 1}, 1.0),
        ({"cmd_vel_timeout_seconds": 5.0}, 5.0),
        ({"cmd_vel_timeout": ""}, None),
    ],
)
def test_time_outs(tmp_path: Path, given: dict[str, Any], seconds: float | None) -> None:
    assert _drive(tmp_path, _file("name", {**_JOINTS, **given}, False)).command_timeout == seconds


@pytest.mark.parametrize(
    ("form", "topics"),
    [
        ("{}_wheel_command_joint_name", ("/name/reference", "/name/odometry")),
        ("{}_joint_name", ("/name/cmd_vel", "/name/odom")),
        ("{}_wheel_names", ("/name/cmd_vel", "/name/odom")),
    ],
)
@pytest.mark.parametrize(
    ("rear", "radius"),
    [("rear", {"wheel_radius": 0.07}), ("back", {"kinematics": {"wheels_radius": 0.07}})],
)
@pytest.mark.parametrize("space", ["", "/robot1"])
def test_mecanum_wheels_by_any_of_their_parameters(
    tmp_path: Path,
    form: str,
    topics: tuple[str, str],
    rear: str,
    radius: dict[str, Any],
    space: str,
) -> None:
    names = {
        form.format(f"{end}_{side}"): f"{wheel}_{side}_wheel_joint"
        for end, wheel in (("front", "front"), (rear, "rear"))
        for side in ("left", "right")
    }
    kind = "mecanum_drive_controller/MecanumDriveController"
    manager = {f"{space}/controller_manager": {"ros__parameters": {"name": {"type": kind}}}}
    values = {**names, "wheel_base": 0.28, "wheel_separation": 0.28, **radius}
    drive = _drive(tmp_path, {**manager, f"{space}/name": {"ros__parameters": values}})
    assert (drive.kind, drive.radius) == (DriveKind.MECANUM, 0.07)
    assert (drive.command_topic, drive.odometry_topic) == tuple(space + each for each in topics)


def test_limits_that_no_drive_has_are_noted(tmp_path: Path) -> None:
    mirrored = {"max_acceleration": 1.5, "min_acceleration": -1.5, "has_jerk_limits": True}
    limits = {
        "linear": {"x": {**mirrored, "max_jerk": 5.0, "max_deceleration": -2.0}},
        "angular": {"z": {"max_velocity": 1.0, "min_velocity": -0.5, "max_jerk": math.nan}},
    }
    content = _file("name", {**_JOINTS, **limits}, dotted=True)
    tag, files = control(yaml.safe_dump(content, sort_keys=False))
    robot = load_robot(Robot(four(), tag, files=files).write(tmp_path, "made.urdf"), SearchPath())
    expected = "linear.x.max_deceleration, angular.z.min_velocity"
    assert f"controller 'name': not simulated: {expected}" in texts(robot.notes)
    assert (robot.drive.max_jerk, robot.drive.max_turn_jerk) == (5.0, 0.0)


_GZ = {
    "diff-drive": DriveKind.SIDES,
    "mecanum-drive": DriveKind.MECANUM,
    "velocity-control": DriveKind.PLANAR,
    "ackermann-steering": DriveKind.STEERED,
}
_CLASSIC = {
    "diff_drive": DriveKind.SIDES,
    "skid_steer_drive": DriveKind.SIDES,
    "planar_move": DriveKind.PLANAR,
    "force_based_move": DriveKind.PLANAR,
    "ackermann_drive": DriveKind.STEERED,
    "ackerman": DriveKind.STEERED,
    "tricycle_drive": DriveKind.STEERED,
    "omni_drive": DriveKind.OMNI,
}
_CONTROLLERS = {
    "diff_drive_controller/DiffDriveController": DriveKind.SIDES,
    "mecanum_drive_controller/MecanumDriveController": DriveKind.MECANUM,
    "omni_wheel_drive_controller/OmniWheelDriveController": DriveKind.OMNI,
    "tricycle_controller/TricycleController": DriveKind.STEERED,
    "ackermann_steering_controller/AckermannSteeringController": DriveKind.STEERED,
    "bicycle_steering_controller/BicycleSteeringController": DriveKind.STEERED,
    "tricycle_steering_controller/TricycleSteeringController": DriveKind.STEERED,
    "four_wheel_steering_controller/FourWheelSteeringController": DriveKind.STEERED,
    "diff_drive_controller::DiffDriveController": DriveKind.SIDES,
    "joint_state_broadcaster/JointStateBroadcaster": None,
    "velocity_controllers/JointGroupVelocityController": None,
    "imu_sensor_broadcaster/IMUSensorBroadcaster": None,
}
_CONTROLS = (
    *("libgazebo_ros_control.so", "libgazebo_ros2_control.so", "gz_ros2_control-system"),
    *("libgz_ros2_control-system.so", "ign_ros2_control-system", "libign_ros2_control-system.so"),
)


def _spelled() -> Iterator[tuple[str, str, DriveKind]]:
    """Yield file names and names of plugins in the spellings of all versions, and their kinds."""
    rng = random.Random(4)
    names = ("drive", "base_control", "omni", "planar_move", "platform_velocity_controller")
    for core, kind in _GZ.items():
        named = "".join(part.title() for part in core.split("-"))
        for head in ("gz-sim", "ignition-gazebo", "gz-sim8", "ignition-gazebo6"):
            for text in (f"{head}-{core}-system", f"lib{head}-{core}-system.so"):
                yield text, rng.choice(names), kind
        for space in ("gz::sim", "ignition::gazebo"):
            yield "my_own_build.so", f"{space}::systems::{named}", kind
    for core, kind in _CLASSIC.items():
        for text in (
            f"libgazebo_ros_{core}.so",
            f"gazebo_ros_{core}",
            f"/opt/l/libgazebo_ros_{core}.so",
            f"libridgeback_ros_{core}.so",
            f"libhector_gazebo_ros_{core}.so",
        ):
            yield text, rng.choice(names), kind


def test_every_spelling_is_its_drive_whatever_it_is_called() -> None:
    for file, name, kind in _spelled():
        plugin = Element("plugin", filename=file, name=name)
        assert drive_kind(plugin) is kind, (file, name)
        assert not is_control(plugin)


@pytest.mark.parametrize(
    ("file", "name"),
    [
        ("libir_omni_plugin.so", "ir_omni_plugin"),
        ("libgazebo_ros_imu_sensor.so", "planar_move"),
        ("libgazebo_ros_camera.so", "ackermann_camera"),
        ("gz-sim-odometry-publisher-system", "gz::sim::systems::OdometryPublisher"),
        ("gz-sim-joint-position-controller-system", "steering"),
        ("libmecanum_wheel_visuals.so", ""),
        ("", ""),
    ],
)
def test_letters_of_a_name_make_no_drive(file: str, name: str) -> None:
    plugin = Element("plugin", filename=file, name=name)
    assert drive_kind(plugin) is None
    assert not is_control(plugin)


@pytest.mark.parametrize("file", _CONTROLS)
def test_what_runs_controllers_is_known(file: str) -> None:
    assert is_control(Element("plugin", filename=file, name="base"))
    assert drive_kind(Element("plugin", filename=file, name="base")) is None
    named = "gz_ros2_control::GazeboSimROS2ControlPlugin"
    assert is_control(Element("plugin", filename="own.so", name=named))
    assert not is_control(Element("plugin", filename="libremote_control.so", name="ros2_control"))


@pytest.mark.parametrize(("kind", "drive"), _CONTROLLERS.items())
def test_controllers_are_known_by_their_class(kind: str, drive: DriveKind | None) -> None:
    assert controller_kind(kind) is drive


@pytest.mark.parametrize(
    ("values", "expected"),
    [
        ({"open_loop": True, "left_wheel_radius_multiplier": 0.98}, "open_loop, left_wheel_"),
        (
            {"twist_covariance_diagonal": [0.1, 0.0, 0.0, 0.0, 0.0, 0.2]},
            "twist_covariance_diagonal",
        ),
        ({"open_loop": False, "pose_covariance_diagonal": [0, 0, 0, 0, 0, 0]}, ""),
    ],
)
def test_what_a_drive_s_controller_asks_for_in_vain_is_noted(
    tmp_path: Path, values: dict[str, Any], expected: str
) -> None:
    tag, files = control(yaml.safe_dump(_file("name", {**_JOINTS, **values}, dotted=False)))
    path = Robot(four(), tag, files=files).write(tmp_path, "made.urdf")
    noted = [each for each in texts(load_robot(path, SearchPath()).notes) if "'name'" in each]
    assert [f"controller 'name': not simulated: {expected}" in each for each in noted] == (
        [True] if expected else []
    )
