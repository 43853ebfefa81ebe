"""Drives are found by their type, in all spellings, and by no letters of a name."""

from __future__ import annotations

import random
from collections.abc import Iterator
from xml.etree.ElementTree import Element  # built here, not parsed

import pytest

from arjuna_sim.files.robots.plugins import controller_kind, drive_kind, is_control
from arjuna_sim.model.settings import DriveKind

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
        ):
            yield text, rng.choice(names), kind


@pytest.mark.parametrize(("file", "name", "kind"), list(_spelled()))
def test_every_spelling_is_its_drive_whatever_it_is_called(
    file: str, name: str, kind: DriveKind
) -> None:
    plugin = Element("plugin", filename=file, name=name)
    assert drive_kind(plugin) is kind
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
